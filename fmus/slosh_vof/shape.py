"""The liquid's shape at the start: level, a wave, a seeded spectrum of waves, a column at a wall, or heights from a file.

A spectrum is the sum of the first MODES standing waves with random amplitudes of equal standard deviation, scaled so that its
largest rise is the amplitude asked for: one seed gives one surface, on any mesh and with any numpy (PCG64's raw stream).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from .grid import Grid
from .surface import flat, from_heights

Array = NDArray[np.float64]
MODES = 12
NEAR = 0.02
"""A file's volume may differ from that of the fill level by this part; it is scaled."""


class ShapeError(ValueError):
    """A shape that the tank or its fill does not allow; the text names the parameter or the file and the remedy."""


@dataclass(frozen=True)
class Shape:
    """wave, spectrum: amplitudes [m] of the first standing wave (crest at the west wall) and of waves made from `seed`, on the
    level surface; column: width [m] of a column at the west wall that holds all liquid; file: of x [m] from the west wall and
    heights [m] above the floor."""

    wave: float = 0.0
    spectrum: float = 0.0
    seed: int = 0
    column: float = 0.0
    file: str = ""


def fractions(shape: Shape, grid: Grid, alpha: float) -> Array:
    """Volume fractions (ny, nx) of the shape in a tank pitched nose-up by alpha [rad]; column and file keep to the tank's axes.

    Level surface and waves leave each compartment its fill; column and file count as they are given, whatever compartments.

    Raises ShapeError for a shape that leaves the tank, for two shapes at once and for a file that cannot be used.
    """
    if bool(shape.column) + bool(shape.file) + bool(shape.wave or shape.spectrum) > 1:
        raise ShapeError(
            f"initial_column = {shape.column:g}, initial_file = '{shape.file}', initial_wave = {shape.wave:g}, "
            f"initial_spectrum = {shape.spectrum:g}: more than one shape. Remedy: a column, a file or waves"
        )
    if shape.column:
        return _column(grid, shape.column)
    if shape.file:
        return _from_file(grid, Path(shape.file))
    if not (shape.wave or shape.spectrum):
        return flat(grid, alpha)
    tank = grid.tank
    most = 1 if len(grid.rooms) == 1 else 2  # the mean over a compartment is taken off
    names = {"initial_wave": shape.wave, "initial_spectrum": shape.spectrum}
    given = " and ".join(f"{name} = {value} m" for name, value in names.items() if value)
    if most * (abs(shape.wave) + abs(shape.spectrum)) > min(tank.depth, tank.height - tank.depth):
        raise ShapeError(
            f"{given} leaves the tank of height {tank.height} m filled to {tank.depth:.6g} m. "
            "Remedy: give an amplitude that touches neither floor nor roof" + (", in compartments half of it" if most > 1 else "")
        )
    sizes = np.zeros(MODES) if shape.spectrum == 0.0 else shape.spectrum * spectrum(shape.seed)

    def rise(x: Array) -> Array:
        wave = shape.wave * np.cos(np.pi * x / tank.length)
        return wave if shape.spectrum == 0.0 else wave + _sum(sizes, x / tank.length)

    return from_heights(grid, rise, alpha, settled=True)


def spectrum(seed: int) -> Array:
    """Amplitudes (MODES,) of the standing waves of `seed`, whose sum rises to 1 at most."""
    raw = np.random.PCG64(seed).random_raw(2 * MODES)
    uniform = ((raw >> np.uint64(11)).astype(float) + 0.5) / 2.0**53
    sizes = np.sqrt(-2.0 * np.log(uniform[:MODES])) * np.cos(2.0 * math.pi * uniform[MODES:])  # normal, Box and Muller
    return np.asarray(sizes / np.abs(_sum(sizes, np.linspace(0.0, 1.0, 2001))).max())


def _sum(sizes: Array, x: Array) -> Array:
    """Standing waves at x over the length."""
    return np.asarray(sum(size * np.cos((n + 1) * np.pi * x) for n, size in enumerate(sizes)))


def _column(grid: Grid, width: float) -> Array:
    tank = grid.tank
    height = tank.fill_level * tank.length * tank.height / width
    if not (width <= tank.length and height <= tank.height):
        raise ShapeError(
            f"initial_column = {width:g} m: the liquid of fill_level {tank.fill_level:g} would stand {height:.6g} m high in a "
            f"tank of {tank.length:g} x {tank.height:g} m. Remedy: from {tank.fill_level * tank.length:.6g} to {tank.length:g} m"
        )
    across = np.clip(width / grid.dx - np.arange(grid.nx), 0.0, 1.0)
    up = np.clip(height / grid.dy - np.arange(grid.ny), 0.0, 1.0)
    return np.asarray(up[:, None] * across)


def _from_file(grid: Grid, path: Path) -> Array:
    tank = grid.tank
    x, height = _read(path)
    if x[0] > 1e-6 * tank.length or x[-1] < (1.0 - 1e-6) * tank.length:
        raise ShapeError(f"{path}: x from {x[0]:g} to {x[-1]:g} m. Remedy: from 0 (west wall) to tank_length = {tank.length:g} m")
    if height.min() < 0.0 or height.max() > tank.height:
        raise ShapeError(f"{path}: heights from {height.min():g} to {height.max():g} m. Remedy: from 0 to {tank.height:g} m")

    def shares(scale: float) -> Array:
        return from_heights(grid, lambda at: scale * np.interp(at, x, height) - tank.depth)

    volume = float(shares(1.0).mean())
    if abs(volume / tank.fill_level - 1.0) > NEAR:
        raise ShapeError(
            f"{path}: its liquid fills {volume:.6g} of the tank, fill_level is {tank.fill_level:g}. "
            f"Remedy: fill_level = {volume:.6g}"
        )
    if float(shares(1.0 + 2.0 * NEAR).mean()) <= tank.fill_level:  # the roof is in the way
        raise ShapeError(f"{path}: cannot be scaled to fill_level = {tank.fill_level:g}. Remedy: fill_level = {volume:.6g}")
    return shares(
        brentq(lambda scale: float(shares(scale).mean()) - tank.fill_level, 1.0 - 2.0 * NEAR, 1.0 + 2.0 * NEAR, xtol=1e-15)
    )


def _read(path: Path) -> tuple[Array, Array]:
    """Columns x and height of a CSV file; lines that start with # and one line of names are passed over."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise ShapeError(
            f"{path} cannot be read: {error}. Remedy: initial_file = a CSV file of x and height in metres"
        ) from error
    rows: list[list[float]] = []
    named = False
    for number, line in enumerate(lines, 1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        try:
            values = [float(word) for word in line.split(",")]
        except ValueError:
            values = []
        if len(values) == 2 and all(map(math.isfinite, values)):
            rows.append(values)
        elif rows or named:
            raise ShapeError(f"{path}, line {number}: '{line.strip()}'. Remedy: two numbers, x and height in metres")
        else:
            named = True
    table = np.array(rows).reshape(-1, 2)
    if len(table) < 2 or (np.diff(table[:, 0]) <= 0.0).any():
        raise ShapeError(f"{path}: {len(table)} rows. Remedy: at least two, x rising")
    return table[:, 0], table[:, 1]
