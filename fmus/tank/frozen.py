"""The load of a liquid carried frozen, and the split of a slosh load into what a structure carries and the rest.

A load is (force_x aft, force_y up, moment nose-up about the elastic axis), of the liquid on the tank, in inertial axes, weight
included: at rest (0, −m g, m g x). Two frozen liquids are to be kept apart:

- `frozen_load`: the liquid as a rigid body that moves with the tank, exact at any angle and rate. A curve of its own ("what if
  the fuel did not slosh") and the base of a surrogate.
- `carried_load`: the same to first order in the motion. In force_y and moment these are, term by term, what a section with
  `liquid_mass` m, `liquid_static_moment` S, `liquid_inertia` I, `liquid_stiffness` k has on its left side, and the static load:

      force_y = −m g + m h'' + S alpha''        moment = m g x − S h'' − I alpha'' − k alpha

  A section has no surge: the moment of x'' is not carried. In force_x, which no section takes, surge is: −m x'' − m y alpha''.

The residual is the whole load less the carried one. So a section that carries the frozen liquid and takes the residual has the
same equations of motion as a dry section that takes the whole load less the static one, at any amplitude: whatever the linear
terms of the left side leave out of the exact rigid motion is in the residual. At rest the residual is nothing.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from .liquid import Tank
from .motion import SectionMotion, body_force


class Load(NamedTuple):
    """Load of liquid on tank: forces [N] aft and up in inertial axes, moment [N m] nose-up about the elastic axis."""

    force_x: float
    force_y: float
    moment: float


def to_inertial(along: float, up: float, moment: float, alpha: float) -> Load:
    """Load from forces along the wing axes x' and y' at pitch alpha [rad]."""
    s, c = math.sin(alpha), math.cos(alpha)
    return Load(along * c + up * s, up * c - along * s, moment)


def static_load(tank: Tank) -> Load:
    """Load at rest, level."""
    return Load(0.0, -tank.mass * tank.gravity, tank.static_moment * tank.gravity)


def frozen_load(tank: Tank, motion: SectionMotion) -> Load:
    """Load of the liquid as a rigid body that moves with the tank, exact at any angle."""
    x, y = tank.x, tank.centre_y
    along, up = (tank.mass * force for force in body_force(motion, x, y, tank.gravity))
    own = tank.inertia - tank.mass * (x**2 + y**2)
    return to_inertial(along, up, y * along - x * up - own * motion.alpha_ddot, motion.alpha)


def carried_load(tank: Tank, motion: SectionMotion) -> Load:
    """Static load and what a section with the frozen liquid carries on its left side (see the module's text)."""
    m, S, rest = tank.mass, tank.static_moment, static_load(tank)
    a = motion.alpha_ddot
    return Load(
        -m * (motion.x_ddot + tank.centre_y * a),
        rest.force_y + m * motion.h_ddot + S * a,
        rest.moment - S * motion.h_ddot - tank.inertia * a - tank.stiffness * motion.alpha,
    )


def residual_load(whole: Load, tank: Tank, motion: SectionMotion) -> Load:
    """Whole load less the carried one."""
    carried = carried_load(tank, motion)
    return Load(whole.force_x - carried.force_x, whole.force_y - carried.force_y, whole.moment - carried.moment)


def power(load: Load, motion: SectionMotion) -> float:
    """Of a load on the tank in its motion [W], moment and pitch about the elastic axis."""
    return load.force_x * motion.x_dot - load.force_y * motion.h_dot + load.moment * motion.alpha_dot


def constants(tank: Tank) -> dict[str, float]:
    """What every slosh FMU tells of its liquid, by the names of the outputs."""
    rest = static_load(tank)
    return {
        "static_force_y": rest.force_y,
        "static_moment": rest.moment,
        "liquid_mass": tank.mass,
        "liquid_static_moment": tank.static_moment,
        "liquid_inertia": tank.inertia,
        "liquid_stiffness": tank.stiffness,
    }
