"""Motion of the section frame: the body force that liquid feels at a point fixed to the wing.

h plunge (down), x surge (aft), alpha pitch (nose-up) of the elastic axis; wing axes x' aft along the chord, y' up. Derived from
the position of the point X = x + x' cos(a) + y' sin(a), Y = −h − x' sin(a) + y' cos(a).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import jit

Array = NDArray[np.float64]


class SectionMotion(NamedTuple):
    """Plunge, pitch and surge of the elastic axis with rates and accelerations [m, rad, s]."""

    h: float = 0.0
    h_dot: float = 0.0
    h_ddot: float = 0.0
    alpha: float = 0.0
    alpha_dot: float = 0.0
    alpha_ddot: float = 0.0
    x: float = 0.0
    x_dot: float = 0.0
    x_ddot: float = 0.0


def body_force(motion: SectionMotion, x: float, y: float, gravity: float) -> tuple[float, float]:
    """Gravity less the acceleration of the wing-fixed point (x, y), in wing axes [m/s2]: (along x', along y').

    At rest (0, −gravity). The effective gravity that holds the liquid down is minus the second component.
    """
    m = motion
    s, c = math.sin(m.alpha), math.cos(m.alpha)
    down = gravity - m.h_ddot
    along = down * s - m.x_ddot * c - y * m.alpha_ddot + x * m.alpha_dot**2
    up = -down * c - m.x_ddot * s + x * m.alpha_ddot + y * m.alpha_dot**2
    return along, up


AGREEMENT = 0.3
"""Largest gap between the mean acceleration and what the rates say, as a share of the larger end value: four points a period."""


def course(start: SectionMotion, end: SectionMotion, duration: float) -> Array:
    """Motion between two instants as polynomials of s = (t − start)/duration [s]: coefficients, constant first, shape (9, 6).

    Rows in the order of SectionMotion. Where positions, rates and accelerations belong together each coordinate is the quintic
    through all six of its values, so that long steps lose no accuracy; where they do not (a table that gives accelerations alone)
    accelerations are linear and positions cubic.
    """
    table = np.zeros((9, 6))
    course_into(np.array(start, dtype=float), np.array(end, dtype=float), duration, table)
    return table


@jit
def course_into(start: Array, end: Array, duration: float, table: Array) -> None:
    """`course` between two rows of nine values, into `table` (9, 6); for kernels."""
    for row in (0, 3, 6):
        _coordinate(start, end, row, duration, table)


def at(table: Array, share: float) -> SectionMotion:
    """Motion at start + share·duration of a course."""
    return SectionMotion(*(table @ share ** np.arange(6.0)).tolist())


@jit
def _coordinate(start: Array, end: Array, row: int, d: float, table: Array) -> None:
    """The polynomials of one coordinate: rows `row` to `row` + 2 of the table."""
    x0, v0, a0 = start[row], start[row + 1], start[row + 2]
    x1, v1, a1 = end[row], end[row + 1], end[row + 2]
    d2 = d**2
    largest = max(abs(a0), abs(a1))
    gap_rate = abs((v1 - v0) / d - 0.5 * (a0 + a1))
    gap_position = abs((x1 - x0) - 0.5 * d * (v0 + v1) - d2 * (a0 - a1) / 12)
    # rounding of positions and rates must not count as a contradiction
    rounding = 1e-12 * (abs(x0) + abs(x1) + d * (abs(v0) + abs(v1)))
    table[row : row + 3] = 0.0
    x = table[row]
    x[0], x[1] = x0, d * v0
    if gap_rate * d <= AGREEMENT * largest * d + rounding and gap_position <= 0.1 * AGREEMENT * largest * d2 + rounding:
        first = x1 - x0 - d * v0 - 0.5 * d2 * a0
        second = d * (v1 - v0 - d * a0)
        third = d2 * (a1 - a0)
        x[2] = 0.5 * d2 * a0
        x[3] = 10 * first - 4 * second + 0.5 * third
        x[4] = -15 * first + 7 * second - third
        x[5] = 6 * first - 3 * second + 0.5 * third
        for k in range(1, 6):
            table[row + 1, k - 1] = x[k] * k / d
        for k in range(2, 6):
            table[row + 2, k - 2] = x[k] * k * (k - 1) / d2
    else:
        x[2] = 3 * (x1 - x0) - d * (2 * v0 + v1)
        x[3] = 2 * (x0 - x1) + d * (v0 + v1)
        for k in range(1, 4):
            table[row + 1, k - 1] = x[k] * k / d
        table[row + 2, 0], table[row + 2, 1] = a0, a1 - a0
