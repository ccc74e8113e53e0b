"""The least-squares problem of a quasi-Newton iteration, with its columns filtered."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def least_squares(
    columns: Sequence[tuple[np.ndarray, np.ndarray]], r: np.ndarray, size: np.ndarray, filter: float
) -> tuple[np.ndarray, int]:
    """W c with c minimising |V c + r|, entries compared in units of `size`, and the number of columns left out.

    `columns`: pairs (column of V, column of W), the newest first; all of shape (n,). A column is left out when less than `filter`
    of its length remains after Gram–Schmidt against those before it: it says nothing new, but would be divided by that remainder.
    """
    n = r.size
    Q: list[np.ndarray] = []
    R: list[np.ndarray] = []
    kept: list[np.ndarray] = []
    dropped = 0
    for v, w in columns:
        if len(Q) == n:  # the directions are all there
            dropped += 1
            continue
        rest = v / size
        length = float(np.linalg.norm(rest))
        coefficients = np.zeros(n + 1)
        for _ in range(2):  # once more for orthogonality to rounding
            for k, q in enumerate(Q):
                share = float(q @ rest)
                coefficients[k] += share
                rest = rest - share * q
        left = float(np.linalg.norm(rest))
        if not left > filter * length:
            dropped += 1
            continue
        coefficients[len(Q)] = left
        Q.append(rest / left)
        R.append(coefficients)
        kept.append(w)
    if not Q:
        return np.zeros(n), dropped
    m = len(Q)
    triangle = np.array(R)[:, :m].T
    c = np.linalg.solve(triangle, -(np.array(Q) @ (r / size)))
    return np.array(kept).T @ c, dropped
