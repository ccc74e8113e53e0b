"""Piecewise-linear interface: normal, intercept and cut areas in a unit cell.

The liquid of a cell fills nx·x + ny·y <= d with x, y from 0 to 1 and |nx| + |ny| = 1; n points out of the liquid. Areas and
intercepts are the closed forms of Scardovelli and Zaleski, J. Comput. Phys. 164 (2000) 228, doi:10.1006/jcph.2000.6567.

Fields are flat arrays as in `grid`.
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import jit

MIXED = 1e-6
"""Cells within this of empty or full count as such: the divergence that the pressure leaves shows in full cells."""


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
def _stays_inside(c: float, slope: float) -> bool:
    """Whether a line of this slope through a cell with share c stays within one cell above and below over three columns."""
    s = abs(slope)
    # height of the line at the middle of the cell, by area; a corner cut is nearer the edge still
    middle = c if s <= 2.0 * min(c, 1.0 - c) else intercept(c, s / (1.0 + s), 1.0 / (1.0 + s)) * (1.0 + s) - 0.5 * s
    return middle - 1.5 * s >= -1.0 and middle + 1.5 * s <= 2.0


@jit
def normal(c: Any, k: int, s: int) -> tuple[float, float]:
    """Normal (nx, ny) of the interface in cell k, |nx| + |ny| = 1, pointing out of the liquid.

    Differences of column (or row) sums where the line they give stays within the three-by-three block: exact for straight
    lines. Elsewhere Youngs' weighted differences (LLNL report UCRL-85690, 1982).
    """
    sw, so, se = c[k - s - 1], c[k - s], c[k - s + 1]
    we, ea = c[k - 1], c[k + 1]
    nw, no, ne = c[k + s - 1], c[k + s], c[k + s + 1]
    gx = (sw - se) + 2.0 * (we - ea) + (nw - ne)
    gy = (sw - nw) + 2.0 * (so - no) + (se - ne)
    if abs(gy) >= abs(gx):
        slope = 0.5 * ((sw + we + nw) - (se + ea + ne))
        if _stays_inside(c[k], slope):
            gx, gy = slope, (1.0 if gy >= 0.0 else -1.0)
    else:
        slope = 0.5 * ((sw + so + se) - (nw + no + ne))
        if _stays_inside(c[k], slope):
            gx, gy = (1.0 if gx >= 0.0 else -1.0), slope
    size = abs(gx) + abs(gy)
    if size < 1e-12:  # a cell among equals: any line will do
        return 0.0, 1.0
    return gx / size, gy / size


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
def reconstruct(c: Any, nx: int, ny: int, cells: Any, lines: Any) -> int:
    """Find the mixed cells and their lines; ghosts must be filled.

    cells (n,) receives flat indices, lines (n, 3) nx, ny, d. Returns how many there are.
    """
    s = nx + 2
    count = 0
    for j in range(2, ny + 2):
        row = c[j * s + 1 : j * s + 1 + nx]
        for i in range(nx):
            if row[i] > MIXED and row[i] < 1.0 - MIXED:
                cells[count] = j * s + 1 + i
                count += 1
    for m in range(count):
        k = cells[m]
        n_x, n_y = normal(c, k, s)
        lines[m, 0], lines[m, 1] = n_x, n_y
        lines[m, 2] = intercept(c[k], n_x, n_y)
    return count
