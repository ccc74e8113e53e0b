"""Motion of the section frame: the body force that liquid feels at a point fixed to the wing.

h plunge (down), x surge (aft), alpha pitch (nose-up) of the elastic axis; wing axes x' aft along the chord, y' up. Derived from
the position of the point X = x + x' cos(a) + y' sin(a), Y = −h − x' sin(a) + y' cos(a).
"""

from __future__ import annotations

import math
from typing import NamedTuple


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
