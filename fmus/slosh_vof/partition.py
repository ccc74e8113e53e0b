"""What the kernels know of ribs: closed faces, the cells beside them, the compartments.

A run without ribs has no partition (None): numba then compiles kernels without it, whose results are to the bit those they had
before there were ribs.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from .grid import Grid

WEST, EAST = 1, 2
MINI = 3
"""Cells a side of the small tank in which a cell beside a rib finds its line."""
_SOME = 1e-3  # of a compartment's cells: less gas than that tells no pressure


@argument
class Partition(NamedTuple):
    """plates (n, 3): column on whose east side a closed piece stands, first row, row after the last; beside (size,): WEST and
    EAST bits of cells where one of the three faces that the cell and its upper and lower neighbour have there is closed; rooms
    (m, 2): first column and column after the last of each compartment; block, at: scratch, values and numbers of lines in a tank
    of MINI by MINI cells."""

    plates: Any
    beside: Any
    rooms: Any
    block: Any
    at: Any


def partition(grid: Grid) -> Partition | None:
    """Return that of a grid, None where it has no rib."""
    if not grid.ribs_stand:
        return None
    beside = np.zeros(grid.size, dtype=np.int64)
    view = beside.reshape(grid.ny + 4, grid.stride)[2:-2, 1:-1]
    for column, first, last in grid.ribs_stand:
        low, high = max(first - 1, 0), min(last + 1, grid.ny)
        view[low:high, column] |= EAST
        view[low:high, column + 1] |= WEST
    size = (MINI + 2) * (MINI + 4)
    return Partition(
        np.array(grid.ribs_stand, dtype=np.int64), beside, np.array(grid.rooms, dtype=np.int64), np.zeros(size),
        np.zeros(size, dtype=np.int64)    )  # fmt: skip


@jit
def copy(c: Any, k: int, nx: int, ny: int, ribs: Any) -> int:
    """Copy the three by three values about cell k into the small tank `ribs.block`, where a rib beside k is a wall; returns
    where k lies there. Beyond the rib values go on linearly, as beyond a wall."""
    s, sides = nx + 2, ribs.beside[k]
    row, column = k // s - 2, k % s - 1
    i = 0 if column == 0 or sides & 1 else (MINI - 1 if column == nx - 1 or sides & 2 else 1)
    j = 0 if row == 0 else (MINI - 1 if row == ny - 1 else 1)
    centre = (j + 2) * (MINI + 2) + i + 1
    for up in range(-1, 2):
        m, here = k + up * s, centre + up * (MINI + 2)
        ribs.block[here] = c[m]
        ribs.block[here - 1] = 2.0 * c[m] - c[m + 1] if sides & 1 else c[m - 1]
        ribs.block[here + 1] = 2.0 * c[m] - c[m - 1] if sides & 2 else c[m + 1]
    return centre


@jit
def room_before_rib(beside: Any, k: int, step: int, most: int) -> int:
    """Cells from k along x (step 1 or -1) that no rib cuts off, at most `most`."""
    bit = 2 if step > 0 else 1
    count = 0
    while count < most and beside[k] & bit == 0:
        k += step
        count += 1
    return count


@jit
def settle(q: Any, c: Any, ribs: Any, nx: int, ny: int, diagonal: Any = None) -> None:
    """Take a constant from the pressure of each compartment: the mean over its gas is 0 (over its roof where it has none).

    Nothing passes between compartments, so the pressure equation leaves each its constant; vented ones share the gas's pressure.
    Where gas can be compressed (diagonal, flat: above 0) it has the pressure of its mass, and nothing is taken.
    """
    s = nx + 2
    if ribs.rooms.shape[0] < 2:
        return
    for m in range(ribs.rooms.shape[0]):
        first, last = ribs.rooms[m, 0], ribs.rooms[m, 1]
        gas, total, roof = 0.0, 0.0, 0.0
        if diagonal is not None and _any(diagonal, first, last, s, ny):
            continue
        for j in range(2, ny + 2):
            for i in range(first, last):
                share = 1.0 - min(max(c[j * s + i + 1], 0.0), 1.0)
                gas += share
                total += share * q[j * s + i + 1]
        for i in range(first, last):
            roof += q[(ny + 1) * s + i + 1]
        level = total / gas if gas > _SOME * (last - first) * ny else roof / (last - first)
        for j in range(2, ny + 2):
            for i in range(first, last):
                q[j * s + i + 1] -= level


@jit
def _any(diagonal: Any, first: int, last: int, s: int, ny: int) -> bool:
    for j in range(2, ny + 2):
        for i in range(first, last):
            if diagonal[j * s + i + 1] > 0.0:
                return True
    return False


@jit
def slip(tau: Any, open_x: Any, ribs: Any, nx: int, ny: int) -> None:
    """No shear stress across ribs; half of it at the edge of an opening, which is a cell high and more: no node is met twice."""
    s = nx + 2
    for m in range(ribs.plates.shape[0]):
        for j in range(max(ribs.plates[m, 1] - 1, 0), min(ribs.plates[m, 2], ny - 1)):
            k = (j + 2) * s + ribs.plates[m, 0] + 1
            tau[k] *= 0.5 * (open_x[k] + open_x[k + s])
