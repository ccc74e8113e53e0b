"""Root loci of a system matrix over a parameter: every eigenvalue followed, and every place where an oscillation turns unstable
or stable.

Eigenvalues are matched as sets (least total distance, scipy's linear assignment) to where the last two steps point; where one
misses by more than half the distance to its neighbour the interval is halved, so that modes which come close are not exchanged.
A change of sign of a followed real part is then narrowed down by Brent's method on that eigenvalue.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, linear_sum_assignment

DEPTH = 4  # an interval of the grid is halved this often at most
Matrix = Callable[[float], np.ndarray]  # parameter → square real matrix


@dataclass(frozen=True)
class Neutral:
    """A parameter value at which the eigenvalue ±i `frequency` lies on the imaginary axis.

    direction  "onset" (unstable above), "recovery" (stable above)
    slope      d Re(eigenvalue) / d parameter
    branch     index of the locus
    """

    value: float
    frequency: float
    direction: str
    slope: float
    branch: int


@dataclass(frozen=True)
class Loci:
    """`eigenvalues` (n_parameters, n) along `parameters` (n_parameters,): each column follows one eigenvalue."""

    parameters: np.ndarray
    eigenvalues: np.ndarray
    neutral: list[Neutral]

    def real(self, limit: np.ndarray | float = np.inf) -> np.ndarray:
        """The largest real eigenvalue up to `limit` (n_parameters,) at each parameter; nan where there is none. Same shape."""
        e = self.eigenvalues
        wanted = (np.abs(e.imag) <= 1e-9) & (np.abs(e.real) <= np.reshape(limit, (-1, 1)))
        real = np.where(wanted, e.real, -np.inf).max(axis=1)
        return np.where(np.isfinite(real), real, np.nan)

    def upper(self) -> list[int]:
        """Columns that are oscillations somewhere (positive imaginary part), one of each pair."""
        return [j for j in range(self.eigenvalues.shape[1]) if np.max(self.eigenvalues[:, j].imag) > 1e-9]


def follow(matrix: Matrix, grid: np.ndarray) -> Loci:
    """Loci of `matrix` over the rising `grid` (n,), refined where it must be, and all neutral values in it."""
    parameters, rows = [float(grid[0])], [np.linalg.eigvals(matrix(float(grid[0]))).astype(complex)]
    for target in grid[1:]:
        _advance(matrix, parameters, rows, float(target), DEPTH)
    p, e = np.array(parameters), np.array(rows)
    found = []
    for j in range(e.shape[1]):
        signs = e[:, j].real >= 0.0
        for i in np.flatnonzero(signs[1:] != signs[:-1]):
            if not e[i, j].imag + e[i + 1, j].imag > 0.0:
                continue  # its conjugate is counted; a real eigenvalue crosses where the matrix is singular: statics tell
            found.append(_neutral(matrix, p[i : i + 2], e[i : i + 2, j], j))
    return Loci(p, e, sorted(found, key=lambda n: n.value))


def _advance(matrix: Matrix, parameters: list[float], rows: list[np.ndarray], target: float, depth: int) -> None:
    """Append the eigenvalues at `target`, matched to the last row; halve the way there when the match is in doubt."""
    old, new = rows[-1], np.linalg.eigvals(matrix(target)).astype(complex)
    expected = old
    if len(rows) > 1:
        expected = old + (old - rows[-2]) * (target - parameters[-1]) / (parameters[-1] - parameters[-2])
    order = linear_sum_assignment(np.abs(expected[:, None] - new[None, :]))[1]
    missed = np.abs(new[order] - expected)
    apart = np.abs(new[order, None] - new[None, order]) + np.where(np.eye(old.size, dtype=bool), np.inf, 0.0)
    # an oscillation that misses by more than half the way to its neighbour may have been taken for it
    doubtful = (missed > 0.5 * apart.min(axis=1)) & (old.imag > 0.0)
    if depth and np.any(doubtful):
        _advance(matrix, parameters, rows, 0.5 * (parameters[-1] + target), depth - 1)
        _advance(matrix, parameters, rows, target, depth - 1)
        return
    parameters.append(target)
    rows.append(new[order])


def _neutral(matrix: Matrix, ends: np.ndarray, values: np.ndarray, branch: int) -> Neutral:
    """The zero of the real part between two neighbouring parameters, on the eigenvalue nearest to the straight way between."""

    def at(p: float) -> complex:
        guess = values[0] + (values[1] - values[0]) * (p - ends[0]) / (ends[1] - ends[0])
        e = np.linalg.eigvals(matrix(p))
        return complex(e[np.argmin(np.abs(e - guess))])

    root = float(brentq(lambda p: at(p).real, ends[0], ends[1], xtol=1e-10 * ends[1], rtol=1e-12))
    step = 1e-4 * (ends[1] - ends[0])
    slope = (at(root + step).real - at(root - step).real) / (2.0 * step)
    rising = values[1].real > values[0].real
    return Neutral(root, abs(at(root).imag), "onset" if rising else "recovery", float(slope), branch)
