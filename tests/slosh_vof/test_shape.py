"""The liquid's shape at the start: volumes, one seed one surface, files and what is wrong with them, a collapsing column."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.shape import Shape, ShapeError, fractions, spectrum
from aeroslosh.fmus.slosh_vof.surface import flat, from_heights
from aeroslosh.fmus.tank.liquid import Tank
from support.motions import REST

TANK = Tank(0.5, 0.15)
GRID = Grid(TANK, 50, 20)


def columns(shares: np.ndarray, grid: Grid = GRID) -> np.ndarray:
    """Heights of the columns [m]."""
    return np.asarray(shares.sum(axis=0) * grid.dy)


def written(folder: Path, text: str) -> str:
    path = folder / "surface.csv"
    path.write_text(text, encoding="utf-8")
    return str(path)


@pytest.mark.parametrize("alpha", [0.0, 0.03])
def test_no_shape_and_a_wave_are_what_they_were(alpha: float) -> None:
    np.testing.assert_array_equal(fractions(Shape(), GRID, alpha), flat(GRID, alpha))
    wave = from_heights(GRID, lambda x: 0.01 * np.cos(np.pi * x / 0.5), alpha)
    np.testing.assert_array_equal(fractions(Shape(wave=0.01), GRID, alpha), wave)


def test_a_spectrum_is_one_surface_a_seed_with_the_asked_rise() -> None:
    surfaces = [columns(fractions(Shape(spectrum=0.004, seed=seed), GRID, 0.0)) - 0.075 for seed in (1, 1, 2)]
    np.testing.assert_array_equal(surfaces[0], surfaces[1])
    assert np.abs(surfaces[0] - surfaces[2]).max() > 1e-3
    assert surfaces[0].mean() == pytest.approx(0.0, abs=1e-12)
    x = np.linspace(0.0, 1.0, 4001)
    for seed in range(20):
        rise = sum(size * np.cos((n + 1) * np.pi * x) for n, size in enumerate(spectrum(seed)))
        assert np.abs(rise).max() == pytest.approx(1.0, rel=1e-3)
    # equal shares on the whole, and no favourite sign
    many = np.array([spectrum(seed) for seed in range(2000)])
    np.testing.assert_allclose(many.std(axis=0) / many.std(), 1.0, atol=0.12)
    assert np.abs(many.mean(axis=0)).max() < 0.1 * many.std()
    # the same on another mesh
    fine = Grid(TANK, 100, 40)
    halves = columns(fractions(Shape(spectrum=0.004, seed=1), fine, 0.0), fine).reshape(50, 2).mean(axis=1) - 0.075
    np.testing.assert_allclose(halves, surfaces[0], atol=1e-12)


def test_a_spectrum_of_known_seed_is_kept() -> None:
    """The stream behind a seed must not change: members of an ensemble are named by it."""
    seven = [-0.004354877255357266, -0.0643632679167706, -0.10462556768221527, -0.23937607145977022]
    np.testing.assert_allclose(spectrum(7)[:4], seven, rtol=1e-12)


def test_waves_add_up() -> None:
    both = columns(fractions(Shape(wave=0.01, spectrum=0.002, seed=3), GRID, 0.0))
    one, other = (columns(fractions(shape, GRID, 0.0)) for shape in (Shape(wave=0.01), Shape(spectrum=0.002, seed=3)))
    np.testing.assert_allclose(both - 0.075, one + other - 0.15, atol=1e-12)


@pytest.mark.parametrize("width", [0.25, 0.313, 0.5])
def test_a_column_holds_all_liquid(width: float) -> None:
    shares = fractions(Shape(column=width), GRID, 0.2)
    assert shares.mean() == pytest.approx(0.5, rel=1e-12)
    height = 0.5 * 0.5 * 0.15 / width
    assert columns(shares)[0] == pytest.approx(height, rel=1e-12)
    assert shares[0].sum() * GRID.dx == pytest.approx(width, rel=1e-12)


def test_a_column_collapses_and_reaches_the_other_wall() -> None:
    """Twice as high as wide, in a tank of four widths: the front accelerates to some 2 sqrt(g h) at most (Ritter)."""
    a = 0.146
    tank = Tank(4 * a, 4 * a, fill_level=2 * a * a / (16 * a * a))
    flow = Flow(Grid(tank, 64, 64))
    flow.start_from(fractions(Shape(column=a), flow.grid, 0.0), REST)
    volume, front = flow.volume, []
    for _ in range(30):
        flow.advance(REST, REST, 0.01)
        wet = np.flatnonzero(flow.fractions[0] > 0.5)
        front.append((wet[-1] + 1) * flow.grid.dx)
    assert flow.volume == pytest.approx(volume, rel=1e-12)
    assert np.diff(front).min() >= 0.0
    assert 2.0 * a < front[19] < a + 2.0 * np.sqrt(9.81 * 2 * a) * 0.2
    assert front[29] > 3.0 * a


def test_a_file_gives_heights_scaled_to_the_fill(tmp_path: Path) -> None:
    x = np.linspace(0.0, 0.5, 11)
    height = 0.0751 + 0.02 * (x - 0.25) / 0.25
    text = "# a ramp\nx,height\n" + "\n".join(f"{a:.6f},{b:.6f}" for a, b in zip(x, height, strict=True)) + "\n\n"
    shares = fractions(Shape(file=written(tmp_path, text)), GRID, 0.3)
    assert shares.mean() == pytest.approx(0.5, rel=1e-12)
    middle = (np.arange(50) + 0.5) * 0.01
    np.testing.assert_allclose(columns(shares), np.interp(middle, x, height) * 0.075 / 0.0751, atol=1e-6)


def test_a_file_may_leave_the_floor_dry(tmp_path: Path) -> None:
    """A dam of 0.25 m: the steep side is one cell wide, the floor beyond stays dry."""
    text = "0,0.15\n0.249,0.15\n0.251,0\n0.5,0"
    shares = fractions(Shape(file=written(tmp_path, text)), GRID, 0.0)
    assert shares.mean() == pytest.approx(0.5, rel=1e-12)
    assert shares[:, 27:].max() == 0.0


@pytest.mark.parametrize(
    ("shape", "words"),
    [
        (Shape(wave=0.1), ["initial_wave = 0.1 m leaves the tank", "Remedy"]),
        (Shape(wave=0.05, spectrum=0.05), ["initial_wave = 0.05 m and initial_spectrum = 0.05 m leaves the tank"]),
        (Shape(column=0.2), ["initial_column = 0.2 m", "0.1875 m high", "from 0.25 to 0.5 m"]),
        (Shape(column=0.6), ["initial_column = 0.6 m", "from 0.25 to 0.5 m"]),
        (Shape(column=0.3, wave=0.01), ["more than one shape", "Remedy: a column, a file or waves"]),
        (Shape(file="nowhere.csv"), ["nowhere.csv cannot be read", "Remedy: initial_file"]),
    ],
)
def test_bad_shapes_are_clear_errors(shape: Shape, words: list[str]) -> None:
    with pytest.raises(ShapeError) as raised:
        fractions(shape, GRID, 0.0)
    for word in words:
        assert word in str(raised.value)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("0,0.075\n0.4,0.075", ["x from 0 to 0.4 m", "tank_length = 0.5 m"]),
        ("0,0.075\n0.5,0.2", ["heights from 0.075 to 0.2 m", "from 0 to 0.15 m"]),
        ("0,0.05\n0.5,0.05", ["fills 0.333333 of the tank", "fill_level = 0.333333"]),
        ("0,0.075\nx,y\n0.5,0.075", ["line 2", "two numbers"]),
        ("x,h\nm,m\n0,0.075\n0.5,0.075", ["line 2", "two numbers"]),
        ("0,0.075\n0.5,nan", ["line 2", "two numbers"]),
        ("0.5,0.075\n0,0.075", ["x rising"]),
        ("0,0.075", ["1 rows", "at least two"]),
        ("0,0.15\n0.2474,0.15\n0.2476,0\n0.5,0", ["cannot be scaled", "Remedy: fill_level"]),
    ],
)
def test_bad_files_are_clear_errors(tmp_path: Path, text: str, words: list[str]) -> None:
    path = written(tmp_path, text)
    with pytest.raises(ShapeError) as raised:
        fractions(Shape(file=path), GRID, 0.0)
    for word in (path, *words):
        assert word in str(raised.value)
