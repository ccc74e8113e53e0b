"""The staggered grid of a tank: sizes, where things lie in the flat arrays, which faces are open, coordinates.

All fields share one layout: flat float64, stride s = nx + 2, cell (i, j) at (j + 2)·s + i + 1, so that one ghost column lies
between rows and two ghost rows at each end. u at index k is on the east face of cell k, v on its north face.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..tank.liquid import Tank
from .ribs import Rib, faces, segments

Array = NDArray[np.float64]


class GridError(ValueError):
    """Cells or baffles that no tank can have; the text names the parameter and the remedy."""


@dataclass(frozen=True)
class Baffles:
    """Thin vertical plates at equal distances across the tank, from `bottom` to `top` (shares of the tank's height)."""

    count: int = 0
    bottom: float = 0.0
    top: float = 0.5


@dataclass(frozen=True)
class Grid:
    """nx by ny equal cells in a tank; coordinates [m] in wing axes from the elastic axis.

    Raises GridError for fewer than 4 cells a side, and for baffles less than 4 cells apart, less than a cell high or from floor
    to roof, or on the face of a rib; RibError (`ribs`) for ribs that do not fit.
    """

    tank: Tank
    nx: int
    ny: int
    baffles: Baffles = Baffles()
    ribs: tuple[Rib, ...] = ()

    def __post_init__(self) -> None:
        if min(self.nx, self.ny) < 4:
            raise GridError(f"{self.nx} x {self.ny} cells. Remedy: at least 4 each way, 16 for a flow worth looking at")
        b = self.baffles
        if b.count and self.nx < 4 * (b.count + 1):
            raise GridError(f"{b.count} baffles in {self.nx} cells. Remedy: at least {4 * (b.count + 1)} cells along the tank")
        for _, first, last in self.plates:
            if last <= first:
                raise GridError(
                    f"baffles from {b.bottom:g} to {b.top:g} of the height are less than one of {self.ny} cells high. "
                    "Remedy: a tip above the foot, or more cells over the height"
                )
            if last - first == self.ny:
                raise GridError(
                    "baffles from floor to roof make tanks of their own. Remedy: leave a cell open, or model one of them"
                )
        taken = {column for column, _, _ in self.plates} & {column for column, _ in self._rib_faces}
        if taken:
            x = (min(taken) + 1) * self.dx - 0.5 * self.tank.length
            raise GridError(f"a baffle and a rib on one cell face, x={x:g} m. Remedy: another place of the rib, or no baffles")

    @property
    def stride(self) -> int:
        """Distance of cells above each other in a flat array."""
        return self.nx + 2

    @property
    def size(self) -> int:
        """Length of a flat array."""
        return (self.ny + 4) * self.stride

    @property
    def dx(self) -> float:
        """[m]"""
        return self.tank.length / self.nx

    @property
    def dy(self) -> float:
        """[m]"""
        return self.tank.height / self.ny

    def zeros(self) -> Array:
        """A field of zeros."""
        return np.zeros(self.size)

    def inner(self, field: Array) -> Array:
        """View of the cells proper, shape (ny, nx); rows from the floor up."""
        return field.reshape(self.ny + 4, self.stride)[2:-2, 1:-1]

    @cached_property
    def x(self) -> Array:
        """x of cell centres [m], flat."""
        columns = self.tank.x - 0.5 * self.tank.length + (np.arange(self.stride) - 0.5) * self.dx
        return np.tile(columns, self.ny + 4)

    @cached_property
    def y(self) -> Array:
        """y of cell centres [m], flat."""
        rows = self.tank.y - 0.5 * self.tank.height + (np.arange(self.ny + 4) - 1.5) * self.dy
        return np.repeat(rows, self.stride)

    @cached_property
    def open_x(self) -> Array:
        """1 on vertical faces that liquid can pass, 0 on walls, baffles and outside; flat."""
        face = self.zeros()
        self.inner(face)[:, :-1] = 1.0
        for column, first, last in self.plates:
            self.inner(face)[first:last, column] = 0.0
        for column, first, last in self.ribs_stand:
            self.inner(face)[first:last, column] = 0.0
        return face

    @cached_property
    def open_y(self) -> Array:
        """The same on horizontal faces."""
        face = self.zeros()
        self.inner(face)[:-1] = 1.0
        return face

    @cached_property
    def plates(self) -> list[tuple[int, int, int]]:
        """Baffles: (column of cells on whose east side it stands, first row, row after the last)."""
        b = self.baffles
        first, last = round(b.bottom * self.ny), round(b.top * self.ny)
        columns = [round((n + 1) * self.nx / (b.count + 1)) - 1 for n in range(b.count)]
        return [(column, first, last) for column in columns]

    @cached_property
    def _rib_faces(self) -> list[tuple[int, NDArray[np.bool_]]]:
        return faces(self.ribs, self.tank, self.nx, self.ny)

    @cached_property
    def ribs_stand(self) -> list[tuple[int, int, int]]:
        """Closed pieces of ribs, as `plates`; none of a rib that is open from floor to roof."""
        return [(column, first, last) for column, closed in self._rib_faces for first, last in segments(closed)]

    @cached_property
    def bays(self) -> list[tuple[int, int]]:
        """First column and column after the last between neighbouring ribs or walls, from west to east."""
        return self._between([column for column, closed in self._rib_faces if closed.any()])

    @cached_property
    def rooms(self) -> list[tuple[int, int]]:
        """The same of compartments, between ribs without openings."""
        return self._between([column for column, closed in self._rib_faces if closed.all()])

    def _between(self, columns: list[int]) -> list[tuple[int, int]]:
        edges = [0, *(column + 1 for column in columns), self.nx]
        return list(pairwise(edges))
