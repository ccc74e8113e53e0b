"""Volume fractions carried by divergence-free flows: volume to round-off, bounds, order of accuracy of a full turn."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.advection import advect
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.plic import fill_ghosts, reconstruct, surface
from aeroslosh.fmus.tank.liquid import Tank


def disc(grid: Grid, x0: float, y0: float, radius: float) -> np.ndarray:
    """Shares of a disc by 16 x 16 points a cell."""
    points = (np.arange(16) + 0.5) / 16 - 0.5
    x = grid.inner(grid.x)[..., None, None] + points[:, None] * grid.dx
    y = grid.inner(grid.y)[..., None, None] + points[None, :] * grid.dy
    return np.asarray(((x - x0) ** 2 + (y - y0) ** 2 < radius**2).mean(axis=(-2, -1)))


def vortex(grid: Grid, turns_a_second: float) -> tuple[np.ndarray, np.ndarray]:
    """Face velocities of a stream function that vanishes on the walls: free of divergence to round-off."""
    x = grid.x + 0.5 * grid.dx
    y = grid.y + 0.5 * grid.dy
    psi = turns_a_second * np.cos(np.pi * x) ** 2 * np.cos(np.pi * y) ** 2
    s = grid.stride
    u, v = grid.zeros(), grid.zeros()
    u[s:] = (psi[s:] - psi[:-s]) / grid.dy
    v[1:] = -(psi[1:] - psi[:-1]) / grid.dx
    return u * grid.open_x, v * grid.open_y


def there_and_back(n: int) -> tuple[float, float, float, float]:
    """A disc in a single vortex that turns back at half time (Rider and Kothe, J. Comput. Phys. 141 (1998) 112)."""
    grid = Grid(Tank(1.0, 1.0), n, n)
    u, v = vortex(grid, 1.0 / np.pi)
    c = grid.zeros()
    grid.inner(c)[:] = disc(grid, 0.0, 0.25, 0.15)
    first = grid.inner(c).copy()
    new, middle, fx, fy = (grid.zeros() for _ in range(4))
    fill_ghosts(c, n, n)
    found = surface(n, n)
    reconstruct(c, n, n, found)
    steps = 4 * n
    dt = 1.0 / steps
    low, high = 0.0, 1.0
    for k in range(steps):
        strength = np.cos(np.pi * (k + 0.5) * dt)
        advect(c, new, middle, strength * u * dt / grid.dx, strength * v * dt / grid.dy, fx, fy, found, n, n, k % 2 == 1)
        c[:] = new
        low, high = min(low, grid.inner(c).min()), max(high, grid.inner(c).max())
    last = grid.inner(c)
    return float(np.abs(last - first).mean()), float(last.sum() / first.sum() - 1), low, high


def test_a_disc_comes_back() -> None:
    rows = [there_and_back(n) for n in (32, 64, 128)]
    errors = np.array([row[0] for row in rows])
    for _, volume, low, high in rows:
        assert abs(volume) < 1e-13
        assert low > -1e-12
        assert high < 1 + 1e-12
    order = np.log2(errors[:-1] / errors[1:])
    assert (order > 1.5).all(), errors
    assert errors[-1] < 2e-4


def test_columns_move_by_the_exact_distance() -> None:
    """A vertical front in uniform flow along a tank whose walls are far: to round-off."""
    grid = Grid(Tank(1.0, 0.2), 40, 8)
    c, new, middle, fx, fy = (grid.zeros() for _ in range(5))
    grid.inner(c)[:, 4:10] = 1.0
    fill_ghosts(c, 40, 8)
    found = surface(40, 8)
    reconstruct(c, 40, 8, found)
    nu = grid.zeros()
    grid.inner(nu)[:, 1:-2] = 0.37
    for k in range(20):
        advect(c, new, middle, nu, np.zeros_like(nu), fx, fy, found, 40, 8, k % 2 == 0)
        c[:] = new
    centre = (grid.inner(c) * (np.arange(40) + 0.5)).sum() / grid.inner(c).sum()
    assert centre == pytest.approx(7.0 + 20 * 0.37, abs=1e-9)
    assert grid.inner(c)[0].sum() == pytest.approx(6.0, abs=1e-12)
    np.testing.assert_allclose(grid.inner(c)[0, 15:17], [1.0, 1.0], atol=1e-12)
