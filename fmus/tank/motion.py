"""Motion of the section frame: the body force that liquid feels at a point fixed to the wing.

h plunge (down), x surge (aft), alpha pitch (nose-up) of the elastic axis; wing axes x' aft along the chord, y' up. Derived from
the position of the point X = x + x' cos(a) + y' sin(a), Y = −h − x' sin(a) + y' cos(a).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
    for row in (0, 3, 6):
        x0, v0, a0 = start[row : row + 3]
        x1, v1, a1 = end[row : row + 3]
        table[row : row + 3] = _coordinate(x0, v0, a0, x1, v1, a1, duration)
    return table


def at(table: Array, share: float) -> SectionMotion:
    """Motion at start + share·duration of a course."""
    return SectionMotion(*(table @ share ** np.arange(6.0)).tolist())


def _coordinate(x0: float, v0: float, a0: float, x1: float, v1: float, a1: float, duration: float) -> Array:
    d, d2 = duration, duration**2
    rows = np.zeros((3, 6))
    largest = max(abs(a0), abs(a1))
    gap_rate = abs((v1 - v0) / d - 0.5 * (a0 + a1))
    gap_position = abs((x1 - x0) - 0.5 * d * (v0 + v1) - d2 * (a0 - a1) / 12)
    # rounding of positions and rates must not count as a contradiction
    rounding = 1e-12 * (abs(x0) + abs(x1) + d * (abs(v0) + abs(v1)))
    cubic = [x0, d * v0, 3 * (x1 - x0) - d * (2 * v0 + v1), 2 * (x0 - x1) + d * (v0 + v1)]
    if gap_rate * d <= AGREEMENT * largest * d + rounding and gap_position <= 0.1 * AGREEMENT * largest * d2 + rounding:
        first = x1 - x0 - d * v0 - 0.5 * d2 * a0
        second = d * (v1 - v0 - d * a0)
        third = d2 * (a1 - a0)
        x = np.array([x0, d * v0, 0.5 * d2 * a0, 10 * first - 4 * second + 0.5 * third,
                      -15 * first + 7 * second - third, 6 * first - 3 * second + 0.5 * third])  # fmt: skip
        rows[0] = x
        rows[1, :5] = x[1:] * np.arange(1, 6) / d
        rows[2, :4] = x[2:] * np.arange(1, 5) * np.arange(2, 6) / d2
    else:
        rows[0, :4] = cubic
        rows[1, :3] = np.array(cubic[1:]) * np.arange(1, 4) / d
        rows[2, :2] = a0, a1 - a0
    return rows
