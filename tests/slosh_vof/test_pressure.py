"""The pressure solver against a sparse direct solution, on any grid, with density ratios to 10,000."""

from __future__ import annotations

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg

from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.multigrid import plan, set_up, v_cycle
from aeroslosh.fmus.slosh_vof.pressure import solve
from aeroslosh.fmus.slosh_vof.ribs import parse
from aeroslosh.fmus.tank.liquid import Tank


def conductances(grid: Grid, ratio: float, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Those of a liquid with a wavy surface and drops and bubbles of one cell."""
    rng = np.random.default_rng(seed)
    c = grid.zeros()
    rows, columns = np.mgrid[: grid.ny, : grid.nx]
    inside = (rows + 0.5) / grid.ny < 0.5 + 0.2 * np.cos(7.0 * columns / grid.nx)
    shares = inside.astype(float)
    spots = rng.integers(0, grid.nx * grid.ny, 12)
    shares.flat[spots] = 1.0 - shares.flat[spots]
    grid.inner(c)[:] = shares
    rho = 1.0 / ratio + (1.0 - 1.0 / ratio) * c
    s = grid.stride
    kx, ky = grid.zeros(), grid.zeros()
    kx[:-1] = 2.0 / (rho[:-1] + rho[1:]) * grid.dy / grid.dx
    ky[:-s] = 2.0 / (rho[:-s] + rho[s:]) * grid.dx / grid.dy
    return kx * grid.open_x, ky * grid.open_y


def matrix(grid: Grid, kx: np.ndarray, ky: np.ndarray) -> scipy.sparse.csr_matrix:
    index = np.arange(grid.nx * grid.ny).reshape(grid.ny, grid.nx)
    pairs = [(index[:, :-1], index[:, 1:], grid.inner(kx)[:, :-1]), (index[:-1], index[1:], grid.inner(ky)[:-1])]
    rows = np.concatenate([np.r_[a.ravel(), b.ravel()] for a, b, _ in pairs])
    columns = np.concatenate([np.r_[b.ravel(), a.ravel()] for a, b, _ in pairs])
    values = np.concatenate([np.r_[k.ravel(), k.ravel()] for _, _, k in pairs])
    off = scipy.sparse.csr_matrix((values, (rows, columns)), shape=(index.size, index.size))
    return (scipy.sparse.diags(np.asarray(off.sum(axis=1)).ravel()) - off).tocsr()


@pytest.mark.parametrize(
    ("nx", "ny", "length", "height", "ratio", "most"),
    [
        (64, 32, 0.5, 0.25, 1.0, 15),
        (100, 30, 0.5, 0.15, 833.0, 25),
        (37, 61, 0.3, 0.5, 1e4, 35),
        (16, 16, 0.5, 0.15, 833.0, 25),
        (128, 16, 0.1, 0.4, 833.0, 40),  # cells 32 times higher than wide
        (17, 90, 1.0, 0.1, 833.0, 40),  # and the other way
    ],
)
def test_against_a_direct_solution(nx: int, ny: int, length: float, height: float, ratio: float, most: int) -> None:
    grid = Grid(Tank(length, height), nx, ny)
    kx, ky = conductances(grid, ratio, 1)
    rng = np.random.default_rng(2)
    wanted = np.cumsum(rng.standard_normal((ny, nx)), axis=0)
    a = matrix(grid, kx, ky)
    rhs, q = grid.zeros(), grid.zeros()
    grid.inner(rhs)[:] = (a @ wanted.ravel()).reshape(ny, nx)
    levels, length_of_levels = plan(nx, ny, grid.dx, grid.dy)
    limit = 1e-10 * np.abs(rhs).max()
    iterations, left = solve(
        q, rhs, kx, ky, limit, 200, levels, np.zeros((7, length_of_levels), dtype=np.float32), np.zeros((3, grid.size))
    )
    print(nx, ny, ratio, iterations)
    assert left <= 1.0
    assert iterations <= most
    difference = grid.inner(q) - wanted
    difference -= difference.mean()
    assert np.abs(difference).max() < 1e-6 * np.abs(wanted).max()


@pytest.mark.parametrize(
    ("ribs", "most"), [("x=0", 25), ("x=-0.115; x=0.065", 40), ("x=0.065 open=0:0.02,0.13:0.15; x=-0.105 open=0.05:0.06", 40)]
)
def test_ribs_against_a_direct_solution(ribs: str, most: int) -> None:
    """On faces that coarse levels join cells across, too; each compartment up to a constant of its own."""
    grid = Grid(Tank(0.5, 0.15), 100, 30, ribs=parse(ribs))
    kx, ky = conductances(grid, 833.0, 1)
    wanted = np.cumsum(np.random.default_rng(2).standard_normal((30, 100)), axis=0)
    rhs, q = grid.zeros(), grid.zeros()
    grid.inner(rhs)[:] = (matrix(grid, kx, ky) @ wanted.ravel()).reshape(30, 100)
    levels, length = plan(100, 30, grid.dx, grid.dy)
    coarse = np.zeros((7, length), dtype=np.float32)
    iterations, left = solve(q, rhs, kx, ky, 1e-10 * np.abs(rhs).max(), 200, levels, coarse, np.zeros((3, grid.size)))
    print(ribs, iterations)
    assert left <= 1.0 and iterations <= most
    for first, last in grid.rooms:
        difference = grid.inner(q)[:, first:last] - wanted[:, first:last]
        assert np.abs(difference - difference.mean()).max() < 1e-6 * np.abs(wanted).max()


def test_the_preconditioner_is_symmetric_and_positive() -> None:
    """What conjugate gradients ask of it."""
    grid = Grid(Tank(0.5, 0.15), 45, 22)
    kx, ky = conductances(grid, 833.0, 4)
    levels, length = plan(45, 22, grid.dx, grid.dy)
    ke, kn, d, di, b, x, t = np.zeros((7, length), dtype=np.float32)
    first, n, fine = levels[0, 3] + levels[0, 2], 22 * levels[0, 2], 2 * grid.stride
    ke[first : first + n] = kx[fine : fine + n]
    kn[first : first + n] = ky[fine : fine + n]
    set_up(levels, ke, kn, d, di)
    inside = np.zeros((22, 47), dtype=bool)
    inside[:, 1:-1] = True
    rng = np.random.default_rng(5)

    def apply(vector: np.ndarray) -> np.ndarray:
        b[:] = 0.0
        b[first : first + n][inside.ravel()] = vector
        v_cycle(levels, ke, kn, d, di, b, x, t)
        return x[first : first + n][inside.ravel()].astype(float)

    for _ in range(5):
        one, two = rng.standard_normal((2, 45 * 22))
        left, right = one @ apply(two), two @ apply(one)
        assert left == pytest.approx(right, rel=1e-3, abs=1e-3 * abs(one @ apply(one)))
        assert one @ apply(one) > 0.0
