"""Loads of the remembered waves: the bilinear equivalent mechanical system that a network corrects.

In tank axes about the liquid's centre of mass, over m_T g and m_T g l (l the tank's length): modal springs and dampers, with the
springs of s stiffened by gamma and those of S on top (slosh_rbf.memory), the mass that does not slosh, the weight of the liquid
under the gravity of the moment, its shift with the waves, and the weight and inertia of the gas across the surface (along it the
gas is free to stay behind). Nothing in it is trained. Without S and
gamma's products it is the linear equivalent mechanical system of slosh_ems, at any angle.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from ..tank.liquid import Tank
from .memory import FX, GAMMA, MODES, SECOND, SPIN, Array, Complex, Memory


@argument
class Body(NamedTuple):
    """Masses over m_T and lengths over l; shapes (MODES,) where not a number.

    spring, damper: reaction over m_T g per displacement [1/m] and velocity [s/m] of a mode; shift: moment of its weight over
    m_T g l per displacement [1/m]; place, decay: from w to displacement and velocity (tank.oscillators)."""

    spring: Array
    damper: Array
    shift: Array
    height: Array
    place: Array
    decay: Array
    fixed_mass: float
    fixed_height: float
    fixed_inertia: float
    gas_mass: float


def body(memory: Memory, gas_density: float) -> Body:
    """The constants of a tank with gas of `gas_density` [kg/m3] above the liquid."""
    tank, m = memory.tank, memory.modes
    weight = tank.mass * tank.gravity
    rate = memory.oscillators.rate
    gas = gas_density * tank.length * (tank.height - tank.depth) * tank.width
    return Body(
        m.mass * m.omega**2 / weight,
        2.0 * m.mass * memory.damping * m.omega / weight,
        m.mass / (tank.mass * tank.length),
        m.height / tank.length,
        1.0 / rate.imag,
        rate.real / rate.imag,
        m.fixed_mass / tank.mass,
        m.fixed_height / tank.length,
        m.fixed_inertia / (tank.mass * tank.length**2),
        gas / tank.mass,
    )


@jit
def base_load(w: Complex, rows: Array, body: Body, bilinear: bool, out: Array) -> None:
    """Load (3,): along and up the tank's axes over m_T g, moment about the liquid's centre over m_T g l; rows: a drive."""
    a, gamma, turn = rows[FX], rows[GAMMA], rows[SPIN]
    if not bilinear:
        gamma = 0.0
    along, moment, shift = 0.0, 0.0, 0.0
    for n in range(MODES):
        s = w[n].imag * body.place[n]
        v = w[n].real + body.decay[n] * w[n].imag
        force = body.spring[n] * s + body.damper[n] * v
        if bilinear and n < SECOND:
            z = w[MODES + n]
            more = z.imag * body.place[n]
            force += body.spring[n] * (gamma * s + more) + body.damper[n] * (z.real + body.decay[n] * z.imag)
            s += more
        along += force
        moment += body.height[n] * force
        shift += body.shift[n] * s
    fixed = body.fixed_mass * (a - 2.0 * body.fixed_height * turn)
    out[0] = along + fixed
    out[1] = -(1.0 + rows[GAMMA]) * (1.0 + body.gas_mass)
    out[2] = moment + body.fixed_height * fixed - 2.0 * body.fixed_inertia * turn + (1.0 + gamma) * shift


def to_load(load: Array, tank: Tank, tilt: float) -> tuple[float, float, float]:
    """(force_x, force_y [N], moment about the elastic axis [N m]) in inertial axes, of a load in the tank's (`base_load`)."""
    weight = tank.mass * tank.gravity
    along, up = weight * float(load[0]), weight * float(load[1])
    moment = weight * tank.length * float(load[2]) + tank.centre_y * along - tank.x * up
    s, c = math.sin(tilt), math.cos(tilt)
    return along * c + up * s, up * c - along * s, moment


def from_load(force_x: Array, force_y: Array, moment: Array, tank: Tank, tilt: Array) -> Array:
    """The inverse, for many samples (n,) of loads in inertial axes. Shape: (n, 3)."""
    weight = tank.mass * tank.gravity
    s, c = np.sin(tilt), np.cos(tilt)
    along, up = force_x * c - force_y * s, force_y * c + force_x * s
    about = moment - tank.centre_y * along + tank.x * up
    return np.stack([along / weight, up / weight, about / (weight * tank.length)], axis=1)
