"""Curvature of the interface from heights of columns (or rows), for surface tension.

Height functions over seven cells (Cummins, Francois and Kothe, Comput. Struct. 83 (2005) 425,
doi:10.1016/j.compstruc.2004.08.017) where three neighbouring columns hold the interface; where they do not, the divergence of the
normals of the three-by-three block.
At a wall and at a rib heights are mirrored: the contact angle is 90 degrees.
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import jit
from .partition import room_before_rib
from .plic import normal_at

_REACH = 3
_PURE = 1e-4


@jit
def _clip(value: float) -> float:
    return min(max(value, 0.0), 1.0)


@jit
def _height(c: Any, k: int, step: int, down: int, up: int, sign: float) -> tuple[float, bool]:
    """Height of liquid along `step` through cell k in cells from its middle, and whether full and empty ends were met."""
    total = _clip(c[k]) - 0.5
    ends = 0
    position = k
    for _ in range(down if sign > 0.0 else up):
        position -= int(sign) * step
        value = _clip(c[position])
        total += value - 1.0
        if value > 1.0 - _PURE:
            ends += 1
            break
    position = k
    for _ in range(up if sign > 0.0 else down):
        position += int(sign) * step
        value = _clip(c[position])
        total += value
        if value < _PURE:
            ends += 1
            break
    return total, ends == 2


@jit
def curvature(c: Any, surface: Any, dx: float, dy: float, nx: int, ny: int, ribs: Any = None) -> None:
    """Set the curvature [1/m] of each mixed cell, positive where the liquid bulges; ghosts of c must be filled.

    ribs: `partition.Partition`, or None.
    """
    s = nx + 2
    cells, lines, kappa = surface.cells, surface.lines, surface.kappa
    for m in range(surface.found[0]):
        k = cells[m]
        i, j = k % s - 1, k // s - 2
        n_x, n_y = lines[m, 0], lines[m, 1]
        upright = abs(n_y) / dy >= abs(n_x) / dx
        # cells to the walls both ways along the heights, the ghost included
        if upright:
            step, side, h, w = s, 1, dy, dx
            down, up, sign = min(_REACH, j + 1), min(_REACH, ny - j), 1.0 if n_y > 0.0 else -1.0
        else:
            step, side, h, w = 1, s, dx, dy
            down, up, sign = min(_REACH, i + 1), min(_REACH, nx - i), 1.0 if n_x > 0.0 else -1.0
        place, last = (i, nx - 1) if upright else (j, ny - 1)
        before, after = place > 0, place < last
        if ribs is not None:
            if upright:
                before, after = before and ribs.beside[k] & 1 == 0, after and ribs.beside[k] & 2 == 0
            else:
                down, up = room_before_rib(ribs.beside, k, -1, down), room_before_rib(ribs.beside, k, 1, up)
        middle, good_m = _height(c, k, step, down, up, sign)
        left, good_l = _height(c, k - side, step, down, up, sign) if before else (middle, good_m)
        right, good_r = _height(c, k + side, step, down, up, sign) if after else (middle, good_m)
        if good_l and good_m and good_r:
            slope = 0.5 * (right - left) * h / w
            kappa[m] = -(right - 2.0 * middle + left) * h / (w * w) / (1.0 + slope * slope) ** 1.5
        else:
            kappa[m] = _from_normals(c, k, nx, ny, dx, dy, i, j, ribs)


@jit
def _unit(c: Any, k: int, nx: int, ny: int, dx: float, dy: float, ribs: Any) -> tuple[float, float]:
    n_x, n_y, _ = normal_at(c, k, nx, ny, ribs)
    n_x, n_y = n_x / dx, n_y / dy
    size = (n_x * n_x + n_y * n_y) ** 0.5
    return n_x / size, n_y / size


@jit
def _from_normals(c: Any, k: int, nx: int, ny: int, dx: float, dy: float, i: int, j: int, ribs: Any) -> float:
    """Divergence of unit normals of the mixed neighbours, no finer than a cell."""
    s = nx + 2
    west, east = i == 0, i == nx - 1
    if ribs is not None:
        west, east = west or ribs.beside[k] & 1 != 0, east or ribs.beside[k] & 2 != 0
    e, _ = _unit(c, k if east else k + 1, nx, ny, dx, dy, ribs)
    w, _ = _unit(c, k if west else k - 1, nx, ny, dx, dy, ribs)
    _, n = _unit(c, k if j == ny - 1 else k + s, nx, ny, dx, dy, ribs)
    _, b = _unit(c, k if j == 0 else k - s, nx, ny, dx, dy, ribs)
    value = 0.5 * ((e - w) / dx + (n - b) / dy)
    most = 1.0 / min(dx, dy)
    return min(max(value, -most), most)
