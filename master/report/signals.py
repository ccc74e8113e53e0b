"""What a history looks like on a page: thinned without losing its peaks, its envelope from the poles that were found."""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from typing import Any

import numpy as np


def thinned(x: np.ndarray, y: np.ndarray, most: int) -> tuple[np.ndarray, np.ndarray]:
    """At most `most` of the samples (n,), lowest and highest of equal stretches among them, the ends too; the order stays."""
    n = x.size
    if n <= most:
        return x, y
    edges = np.linspace(0, n, max(1, (most - 2) // 2) + 1).astype(int)
    kept = {0, n - 1}
    for begin, end in itertools.pairwise(edges):
        part = y[begin:end]
        if part.size and np.isfinite(part).any():
            kept |= {begin + int(np.nanargmin(part)), begin + int(np.nanargmax(part))}
    order = sorted(kept)
    return x[order], y[order]


def envelope(tau: np.ndarray, values: np.ndarray, result: dict[str, Any]) -> tuple[np.ndarray, np.ndarray] | None:
    """Middle ± size of the critical mode in `values` (n,) over `tau` (n,), which begins at the release: (lower, upper), (n,).

    The poles are the result's (`modes`, `real_poles`); their amplitudes are found again by least squares. None where the
    result has no oscillation, or the history is too short for its poles."""
    rate, frequency = result.get("growth_rate"), result.get("frequency")
    if rate is None or not frequency:
        return None
    waves: Sequence[dict[str, Any]] = [m for m in result.get("modes", []) if m["frequency"]] or [
        {"growth_rate": rate, "frequency": frequency}
    ]
    critical = min(range(len(waves)), key=lambda i: abs(waves[i]["frequency"] - frequency) + abs(waves[i]["growth_rate"] - rate))
    t = tau - tau[0]
    columns = [np.ones_like(t)] + [np.exp(m["growth_rate"] * t) for m in result.get("real_poles", [])]
    first = len(columns)
    for m in waves:
        grown = np.exp(m["growth_rate"] * t)
        columns += [grown * np.cos(m["frequency"] * t), grown * np.sin(m["frequency"] * t)]
    basis = np.stack(columns, axis=1)
    if t.size < 2 * basis.shape[1] or not (np.isfinite(basis).all() and np.isfinite(values).all()):
        return None
    amplitudes = np.linalg.lstsq(basis, values, rcond=None)[0]
    size = np.hypot(*amplitudes[first + 2 * critical : first + 2 * critical + 2]) * np.exp(rate * t)
    return amplitudes[0] - size, amplitudes[0] + size
