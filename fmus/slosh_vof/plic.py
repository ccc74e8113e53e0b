"""Piecewise-linear interface: normal, intercept and cut areas in a unit cell.

The liquid of a cell fills nx·x + ny·y <= d with x, y from 0 to 1 and |nx| + |ny| = 1; n points out of the liquid. Areas and
intercepts are the closed forms of Scardovelli and Zaleski, J. Comput. Phys. 164 (2000) 228, doi:10.1006/jcph.2000.6567.

Fields are flat arrays as in `grid`.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import argument
from ..kit.compiled import inline, jit
from .partition import MINI, copy

MIXED = 1e-6
"""Cells within this of empty or full count as such: the divergence that the pressure leaves shows in full cells."""


@argument
class Surface(NamedTuple):
    """The lines of all mixed cells.

    cells (n,): flat indices; lines (n, 3): nx, ny, d; at (size,): number of a cell's line plus one, 0 for none; found (1,):
    how many; doubts (n,): scratch; kappa (n,): curvatures [1/m].
    """

    cells: NDArray[np.int64]
    lines: NDArray[np.float64]
    at: NDArray[np.int64]
    found: NDArray[np.int64]
    doubts: NDArray[np.int64]
    kappa: NDArray[np.float64]


def surface(nx: int, ny: int) -> Surface:
    """An empty one for a grid of nx by ny cells."""
    n = nx * ny
    whole = np.zeros((nx + 2) * (ny + 4), dtype=np.int64)
    index = [np.zeros(n, dtype=np.int64) for _ in range(2)]
    return Surface(index[0], np.zeros((n, 3)), whole, np.zeros(1, dtype=np.int64), index[1], np.zeros(n))


@jit
def area(nx: float, ny: float, d: float) -> float:
    """Share of the unit cell below the line nx·x + ny·y = d, any signs, |nx| + |ny| > 0."""
    if nx < 0.0:
        d -= nx
        nx = -nx
    if ny < 0.0:
        d -= ny
        ny = -ny
    size = nx + ny
    a = d / size
    if a <= 0.0:
        return 0.0
    if a >= 1.0:
        return 1.0
    m = min(nx, ny) / size
    r = min(a, 1.0 - a)
    if r < m:
        small = r * r / (2.0 * m * (1.0 - m))
    else:
        small = (r - 0.5 * m) / (1.0 - m)
    return small if a <= 0.5 else 1.0 - small


@jit
def intercept(c: float, nx: float, ny: float) -> float:
    """d of the line nx·x + ny·y = d with share c of the cell below it, |nx| + |ny| = 1."""
    ax, ay = abs(nx), abs(ny)
    m = min(ax, ay)
    f = min(c, 1.0 - c)
    if f * 2.0 * (1.0 - m) < m:
        r = (2.0 * m * (1.0 - m) * f) ** 0.5
    else:
        r = f * (1.0 - m) + 0.5 * m
    d = r if c <= 0.5 else 1.0 - r
    return d + min(nx, 0.0) + min(ny, 0.0)


@jit
def _stays_inside(c: float, slope: float, low: float, high: float) -> bool:
    """Whether a line of this slope through a cell with share c stays between low and high over three columns.

    In cells from its floor. Only then do the sums of three cells tell its heights.
    """
    s = abs(slope)
    # height of the line at the middle of the cell, by area; a corner cut is nearer the edge still
    middle = c if s <= 2.0 * min(c, 1.0 - c) else intercept(c, s / (1.0 + s), 1.0 / (1.0 + s)) * (1.0 + s) - 0.5 * s
    return middle - 1.5 * s >= low and middle + 1.5 * s <= high


@inline
def _youngs(c: Any, k: int, s: int) -> tuple[float, float]:
    """Youngs' weighted differences (LLNL report UCRL-85690, 1982), not normalised."""
    gx = (c[k - s - 1] - c[k - s + 1]) + 2.0 * (c[k - 1] - c[k + 1]) + (c[k + s - 1] - c[k + s + 1])
    gy = (c[k - s - 1] - c[k + s - 1]) + 2.0 * (c[k - s] - c[k + s]) + (c[k - s + 1] - c[k + s + 1])
    return gx, gy


@inline
def _column(c: Any, k: int, step: int, before: bool, after: bool) -> float:
    """Sum of three cells along step; those beyond a wall left out."""
    return c[k] + (c[k - step] if before else 0.0) + (c[k + step] if after else 0.0)


@jit
def normal(c: Any, k: int, nx: int, ny: int) -> tuple[float, float, bool]:
    """Normal (nx, ny) of the interface in cell k, |nx| + |ny| = 1, out of the liquid; and whether it is exact for a line.

    Differences of column (or row) sums where the line they give stays within the three-by-three block, Youngs' elsewhere.
    """
    s = nx + 2
    gx, gy = _youngs(c, k, s)
    sure = False
    row, column = k // s - 2, k % s - 1
    under, over, left, right = row > 0, row < ny - 1, column > 0, column < nx - 1
    if abs(gy) >= abs(gx):
        slope = 0.5 * (_column(c, k - 1, s, under, over) - _column(c, k + 1, s, under, over))
        below, above = (-1.0 if under else 0.0), (2.0 if over else 1.0)
        # seen from the liquid's side
        low, high = (below, above) if gy >= 0.0 else (1.0 - above, 1.0 - below)
        if _stays_inside(c[k], slope, low, high):
            gx, gy, sure = slope, (1.0 if gy >= 0.0 else -1.0), left and right  # ghosts may mislead
    else:
        slope = 0.5 * (_column(c, k - s, 1, left, right) - _column(c, k + s, 1, left, right))
        below, above = (-1.0 if left else 0.0), (2.0 if right else 1.0)
        low, high = (below, above) if gx >= 0.0 else (1.0 - above, 1.0 - below)
        if _stays_inside(c[k], slope, low, high):
            gx, gy, sure = (1.0 if gx >= 0.0 else -1.0), slope, under and over
    size = abs(gx) + abs(gy)
    if size < 1e-12:  # a cell among equals: any line will do
        return 0.0, 1.0, False
    return gx / size, gy / size, sure


@jit
def _misfit(c: Any, k: int, s: int, gx: float, gy: float, left: int, right: int, low: int, high: int) -> float:
    """Squared difference of the neighbours' shares to those below the line of direction (gx, gy) that fits cell k."""
    size = abs(gx) + abs(gy)
    if size < 1e-12:
        return 1e9
    nx, ny = gx / size, gy / size
    d = intercept(c[k], nx, ny)
    total = 0.0
    for j in range(low, high + 1):
        for i in range(left, right + 1):
            difference = area(nx, ny, d - nx * i - ny * j) - c[k + j * s + i]
            total += difference * difference
    return total


@jit
def _best_fit(c: Any, k: int, s: int, nx: int, ny: int, cells_at: Any, lines: Any) -> tuple[float, float]:
    """Of one-sided and central differences, Youngs' and sure neighbours' normals that which fits the neighbours best.

    Pilliod and Puckett, J. Comput. Phys. 199 (2004) 465, doi:10.1016/j.jcp.2003.12.023, neighbours added: where a line leaves
    the block through a wall only they know its slope.
    """
    i, j = k % s - 1, k // s - 2
    left, right = (-1 if i > 0 else 0), (1 if i < nx - 1 else 0)
    low, high = (-1 if j > 0 else 0), (1 if j < ny - 1 else 0)
    best_x, best_y = _youngs(c, k, s)
    sign_x, sign_y = (1.0 if best_x >= 0.0 else -1.0), (1.0 if best_y >= 0.0 else -1.0)
    least = _misfit(c, k, s, best_x, best_y, left, right, low, high)
    under, over = low < 0, high > 0
    west, middle, east = _column(c, k - 1, s, under, over), _column(c, k, s, under, over), _column(c, k + 1, s, under, over)
    under, over = left < 0, right > 0
    south, centre, north = _column(c, k - s, 1, under, over), _column(c, k, 1, under, over), _column(c, k + s, 1, under, over)
    for option in range(6):
        if option == 0:
            gx, gy = west - middle, sign_y
        elif option == 1:
            gx, gy = middle - east, sign_y
        elif option == 2:
            gx, gy = 0.5 * (west - east), sign_y
        elif option == 3:
            gx, gy = sign_x, south - centre
        elif option == 4:
            gx, gy = sign_x, centre - north
        else:
            gx, gy = sign_x, 0.5 * (south - north)
        misfit = _misfit(c, k, s, gx, gy, left, right, low, high)
        if misfit < least:
            least, best_x, best_y = misfit, gx, gy
    for row in range(low, high + 1):
        for column in range(left, right + 1):
            m = cells_at[k + row * s + column]
            if m > 0:
                misfit = _misfit(c, k, s, lines[m - 1, 0], lines[m - 1, 1], left, right, low, high)
                if misfit < least:
                    least, best_x, best_y = misfit, lines[m - 1, 0], lines[m - 1, 1]
    size = abs(best_x) + abs(best_y)
    return (best_x / size, best_y / size) if size > 1e-12 else (0.0, 1.0)


@jit
def normal_at(c: Any, k: int, nx: int, ny: int, ribs: Any) -> tuple[float, float, bool]:
    """`normal`, to which ribs (`partition.Partition`, or None) are walls."""
    if ribs is not None and ribs.beside[k] != 0:
        return normal(ribs.block, copy(c, k, nx, ny, ribs), MINI, MINI)
    return normal(c, k, nx, ny)


@jit
def _best_fit_at(c: Any, k: int, nx: int, ny: int, surface: Any, ribs: Any) -> tuple[float, float]:
    """`_best_fit`, likewise."""
    s, at, lines = nx + 2, surface.at, surface.lines
    if ribs is not None and ribs.beside[k] != 0:
        centre = copy(c, k, nx, ny, ribs)
        for row in range(-1, 2):
            for column in range(-1, 2):
                ribs.at[centre + row * (MINI + 2) + column] = at[k + row * s + column]
        return _best_fit(ribs.block, centre, MINI + 2, MINI, MINI, ribs.at, lines)
    return _best_fit(c, k, s, nx, ny, at, lines)


@jit
def fill_ghosts(c: Any, nx: int, ny: int) -> None:
    """Continue volume fractions linearly beyond the walls, in place: a straight interface meets a wall at any angle."""
    s = nx + 2
    for j in range(2, ny + 2):
        row = j * s
        c[row] = 2.0 * c[row + 1] - c[row + 2]
        c[row + nx + 1] = 2.0 * c[row + nx] - c[row + nx - 1]
    floor, top = 2 * s, (ny + 1) * s
    for i in range(s):
        c[floor - s + i] = 2.0 * c[floor + i] - c[floor + s + i]
        c[top + s + i] = 2.0 * c[top + i] - c[top - s + i]


@jit
def reconstruct(c: Any, nx: int, ny: int, surface: Any, ribs: Any = None) -> int:
    """Find the mixed cells and their lines, into `surface`; ghosts of c must be filled. Returns how many there are.

    ribs: `partition.Partition`, or None.
    """
    s = nx + 2
    cells, lines, at, doubts = surface.cells, surface.lines, surface.at, surface.doubts
    for m in range(surface.found[0]):
        at[cells[m]] = 0
    count = 0
    for j in range(2, ny + 2):
        row = c[j * s + 1 : j * s + 1 + nx]
        for i in range(nx):
            if row[i] > MIXED and row[i] < 1.0 - MIXED:
                cells[count] = j * s + 1 + i
                count += 1
    surface.found[0] = count
    doubtful = 0
    for m in range(count):
        k = cells[m]
        n_x, n_y, sure = normal_at(c, k, nx, ny, ribs)
        lines[m, 0], lines[m, 1], lines[m, 2] = n_x, n_y, intercept(c[k], n_x, n_y)
        if sure:
            at[k] = m + 1
        else:
            doubts[doubtful] = m
            doubtful += 1
    for n in range(doubtful):
        m = doubts[n]
        k = cells[m]
        n_x, n_y = _best_fit_at(c, k, nx, ny, surface, ribs)
        lines[m, 0], lines[m, 1], lines[m, 2] = n_x, n_y, intercept(c[k], n_x, n_y)
    for n in range(doubtful):
        at[cells[doubts[n]]] = doubts[n] + 1
    for n in range(doubtful):  # the tip of a wedge at a wall learns from cells that have just been settled
        m = doubts[n]
        k = cells[m]
        row, column = k // s - 2, k % s - 1
        beside = False
        if ribs is not None:
            beside = ribs.beside[k] != 0
        if row == 0 or row == ny - 1 or column == 0 or column == nx - 1 or beside:
            n_x, n_y = _best_fit_at(c, k, nx, ny, surface, ribs)
            lines[m, 0], lines[m, 1], lines[m, 2] = n_x, n_y, intercept(c[k], n_x, n_y)
    return count
