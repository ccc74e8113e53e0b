"""Lines in cells: areas a person can check, intercepts as their inverse, normals exact for straight lines also at walls."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.plic import area, fill_ghosts, intercept, reconstruct, surface
from aeroslosh.fmus.slosh_vof.surface import flat, from_heights
from aeroslosh.fmus.tank.liquid import Tank


@pytest.mark.parametrize(
    ("line", "share"),
    [
        ((0.0, 1.0, 0.25), 0.25),
        ((1.0, 0.0, 0.75), 0.75),
        ((0.5, 0.5, 0.5), 0.5),  # the diagonal
        ((0.5, 0.5, 0.25), 0.125),  # a corner triangle with sides of a half
        ((-0.5, 0.5, 0.0), 0.5),
        ((0.0, -1.0, -0.75), 0.25),  # liquid hangs from the top
        ((0.3, 0.7, -0.1), 0.0),
        ((0.3, 0.7, 1.1), 1.0),
        ((0.25, 0.75, 0.25), 1 / 6),  # a triangle of sides 1 and 1/3
    ],
)
def test_areas(line: tuple[float, float, float], share: float) -> None:
    assert area(*line) == pytest.approx(share, abs=1e-15)


def test_intercept_inverts_area() -> None:
    rng = np.random.default_rng(3)
    for c, angle in zip(rng.uniform(1e-9, 1.0, 500), rng.uniform(0, 2 * math.pi, 500), strict=True):
        nx, ny = math.cos(angle), math.sin(angle)
        size = abs(nx) + abs(ny)
        nx, ny = nx / size, ny / size
        assert area(nx, ny, intercept(c, nx, ny)) == pytest.approx(c, abs=1e-14)


@pytest.mark.parametrize("degrees", [0.0, 3.0, 12.0, 20.0, 33.7, 45.0, 58.0, 80.0, 90.0, -25.0, 140.0, 180.0])
def test_lines_of_a_level_surface_are_exact_in_every_cell(degrees: float) -> None:
    """At any tilt, also in the wedges where the surface meets floor, roof and walls."""
    grid = Grid(Tank(0.5, 0.15), 50, 20)
    c = grid.zeros()
    grid.inner(c)[:] = flat(grid, math.radians(degrees))
    assert grid.inner(c).mean() == pytest.approx(0.5, abs=1e-12)
    fill_ghosts(c, grid.nx, grid.ny)
    found = surface(grid.nx, grid.ny)
    count = reconstruct(c, grid.nx, grid.ny, found)
    assert count > 15 or degrees % 90 == 0
    normal = np.array([-math.sin(math.radians(degrees)) * grid.dx, math.cos(math.radians(degrees)) * grid.dy])
    normal /= np.abs(normal).sum()
    np.testing.assert_allclose(found.lines[:count, :2], np.tile(normal, (count, 1)), atol=1e-7)


def test_a_wave_is_found_to_second_order() -> None:
    """Heights of lines in the middle of cells against the wave: four times better on twice the cells."""
    worst = []
    for n in (25, 50, 100):
        grid = Grid(Tank(0.5, 0.5), n, n)
        c = grid.zeros()
        grid.inner(c)[:] = from_heights(grid, lambda x: 0.03 * np.cos(2 * np.pi * x / 0.5 + 0.4))
        fill_ghosts(c, n, n)
        found = surface(n, n)
        errors = []
        for m in range(reconstruct(c, n, n, found)):
            nx, ny, d = found.lines[m]
            height = (d - 0.5 * nx) / ny
            if 0.0 < height < 1.0:
                k = found.cells[m]
                there = 0.03 * math.cos(2 * math.pi * (grid.x[k] + 0.25) / 0.5 + 0.4)
                errors.append(abs(grid.y[k] + (height - 0.5) * grid.dy - there))
        worst.append(max(errors))
    order = np.log2(np.array(worst[:-1]) / worst[1:])
    assert (order > 1.7).all(), worst
