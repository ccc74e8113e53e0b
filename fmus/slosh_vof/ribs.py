"""Ribs across the tank: how a text describes them, and on which cell faces they stand.

    x=0.10 open=0.00:0.02,0.13:0.15; x=-0.1

One rib a semicolon: `x` [m] aft of the tank's centre, `open` its openings as heights above the floor [m], from:to, several with
commas; none: the rib is closed and parts the tank. Spaces and line breaks count for nothing but between words.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..tank.liquid import Tank

LEAST = 4
"""Cells between a rib and its neighbour or a wall."""
_FORM = (
    'Remedy: ribs = "x=0.10 open=0.00:0.02,0.13:0.15; x=-0.1", x in metres aft of the tank\'s centre, '
    "open in metres above the floor"
)


class RibError(ValueError):
    """A text that describes no ribs, or ribs that this tank or its cells cannot hold; names the rib, the value and the remedy."""


@dataclass(frozen=True)
class Rib:
    """A thin plate across the tank at x [m] aft of its centre; openings: (from, to) [m] above the floor."""

    x: float
    openings: tuple[tuple[float, float], ...] = ()


def parse(text: str) -> tuple[Rib, ...]:
    """Return the ribs of a text, "" for none. Raises RibError for what is no such text."""
    return tuple(_rib(part.strip()) for part in text.split(";") if part.strip())


def _rib(part: str) -> Rib:
    values: dict[str, str] = {}
    for word in part.split():
        key, equals, value = word.partition("=")
        if key not in ("x", "open") or not equals or key in values:
            raise RibError(f"ribs: '{word}' in '{part}'. {_FORM}")
        values[key] = value
    if "x" not in values:
        raise RibError(f"ribs: '{part}' has no x. {_FORM}")
    pieces = values["open"].split(",") if "open" in values else []
    openings = []
    for piece in pieces:
        ends = piece.split(":")
        if len(ends) != 2:
            raise RibError(f"ribs: open={piece} in '{part}' is no from:to. {_FORM}")
        openings.append((_number(ends[0], part), _number(ends[1], part)))
    return Rib(_number(values["x"], part), tuple(openings))


def _number(word: str, part: str) -> float:
    try:
        value = float(word)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise RibError(f"ribs: '{word}' in '{part}' is no number. {_FORM}")
    return value


def faces(ribs: tuple[Rib, ...], tank: Tank, nx: int, ny: int) -> list[tuple[int, NDArray[np.bool_]]]:
    """Return for each rib, from west to east, the column on whose east side it stands and which rows it closes (ny,).

    Position and openings go to the nearest cell faces. Raises RibError for a rib outside the tank, nearer than LEAST cells to a
    wall or another rib, and for an opening outside the tank's height or lower than a cell.
    """
    dx, dy = tank.length / nx, tank.height / ny
    found: dict[int, tuple[Rib, NDArray[np.bool_]]] = {}
    for rib in ribs:
        if not abs(rib.x) < 0.5 * tank.length:
            raise RibError(
                f"ribs: x={rib.x:g} m lies outside the tank. Remedy: between {-0.5 * tank.length:g} and {0.5 * tank.length:g} m "
                "(from the tank's centre, aft)"
            )
        cells = math.floor((rib.x + 0.5 * tank.length) / dx + 0.5)
        if cells in found:
            raise RibError(
                f"ribs: x={found[cells][0].x:g} and x={rib.x:g} m stand on one cell face. "
                f"Remedy: {LEAST} cells = {LEAST * dx:g} m apart, or more cells_x"
            )
        if min(cells, nx - cells) < LEAST:
            raise RibError(
                f"ribs: x={rib.x:g} m stands {min(cells, nx - cells)} cells from a wall. "
                f"Remedy: {LEAST} cells = {LEAST * dx:g} m, or more cells_x"
            )
        found[cells] = (rib, _closed(rib, tank, ny, dy))
    places = sorted(found)
    for west, east in itertools.pairwise(places):
        if east - west < LEAST:
            raise RibError(
                f"ribs: x={found[west][0].x:g} and x={found[east][0].x:g} m stand {east - west} cells apart. "
                f"Remedy: {LEAST} cells = {LEAST * dx:g} m, or more cells_x"
            )
    return [(cells - 1, found[cells][1]) for cells in places]


def _closed(rib: Rib, tank: Tank, ny: int, dy: float) -> NDArray[np.bool_]:
    closed = np.ones(ny, dtype=bool)
    for low, high in rib.openings:
        if not (low >= 0.0 and high <= tank.height * (1.0 + 1e-12)):
            raise RibError(
                f"ribs: open={low:g}:{high:g} of x={rib.x:g} m leaves the tank. "
                f"Remedy: from 0 to {tank.height:g} m above the floor"
            )
        if high - low < dy * (1.0 - 1e-9):
            finer = f", or cells_y = {math.ceil(tank.height / (high - low) - 1e-9)}" if high > low else ""
            raise RibError(
                f"ribs: open={low:g}:{high:g} of x={rib.x:g} m is lower than a cell. "
                f"Remedy: the finest opening of cells_y = {ny} is {dy:g} m{finer}"
            )
        closed[math.floor(low / dy + 0.5) : math.floor(high / dy + 0.5)] = False
    return closed


def segments(closed: NDArray[np.bool_]) -> list[tuple[int, int]]:
    """Return the closed pieces of a rib: (first row, row after the last)."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], closed.astype(int), [0]])))
    return [(int(a), int(b)) for a, b in edges.reshape(-1, 2)]
