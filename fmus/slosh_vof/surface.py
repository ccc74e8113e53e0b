"""Volume fractions of a given surface: a level one in a tilted tank, or any height over the tank's length."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from ..kit.compiled import jit
from .grid import Grid
from .plic import area

Array = NDArray[np.float64]


@jit
def _below(nx: float, ny: float, level: float, columns: Array, rows: Array) -> Array:
    out = np.empty((rows.size, columns.size))
    for j in range(rows.size):
        for i in range(columns.size):
            out[j, i] = area(nx, ny, level - nx * columns[i] - ny * rows[j])
    return out


def flat(grid: Grid, alpha: float) -> Array:
    """Shares (ny, nx) of liquid whose surface is level while the tank is pitched nose-up by alpha [rad].

    Compartments have the same fill, each its own level.
    """
    return np.concatenate([_level(grid, last - first, alpha) for first, last in grid.rooms], axis=1)


def _level(grid: Grid, width: int, alpha: float) -> Array:
    """Shares of `width` columns of cells with a level surface."""
    # outward normal of the liquid: against gravity, in tank axes
    nx, ny = -np.sin(alpha) * grid.dx, np.cos(alpha) * grid.dy
    columns, rows = np.arange(width) - 0.5 * width, np.arange(grid.ny) - 0.5 * grid.ny

    def shares(level: float) -> Array:
        return np.asarray(_below(nx, ny, level, columns, rows))

    corners = [nx * i + ny * j for i in (-0.5 * width, 0.5 * width) for j in (-0.5 * grid.ny, 0.5 * grid.ny)]
    fill = grid.tank.fill_level
    if fill >= 1.0:
        return np.ones((grid.ny, width))
    level = brentq(lambda z: float(shares(z).mean()) - fill, min(corners), max(corners), xtol=1e-15, rtol=1e-15)
    return shares(float(level))


def from_heights(grid: Grid, rise: Callable[[Array], Array], alpha: float = 0.0, *, settled: bool = False) -> Array:
    """Shares (ny, nx) of liquid below the still level raised by rise(x) [m], x [m] from the west wall, pitched by alpha [rad].

    Averages over each cell by 16 Gauss points; the volume is that of the averages. settled: each of several compartments keeps
    its fill, its mean rise is taken off.
    """
    points, weights = np.polynomial.legendre.leggauss(16)
    x = (np.arange(grid.nx)[:, None] + 0.5 + 0.5 * points) * grid.dx
    height = grid.tank.depth + rise(x) + np.tan(alpha) * (x - 0.5 * grid.tank.length)
    for first, last in grid.rooms if settled and len(grid.rooms) > 1 else []:
        height[first:last] -= (height[first:last] @ (0.5 * weights)).mean() - grid.tank.depth
    bottoms = np.arange(grid.ny)[:, None, None] * grid.dy
    return np.asarray(np.clip((height - bottoms) / grid.dy, 0.0, 1.0) @ (0.5 * weights))
