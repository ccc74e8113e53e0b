"""Linear potential flow in a rectangular tank: loads of harmonic surge and pitch in closed form.

The steady response about the liquid's centre of mass, theta anticlockwise, D_n = omega_n² − Omega²; derived as modal sums and
identical to Graham and Rodriguez (1952) once their misprinted forms are corrected.
"""

from __future__ import annotations

import numpy as np

from .liquid import Tank
from .modes import modes

_TERMS = 2000
"""Modes in the sums; the rest moves with the tank: 1e-11 of the mass goes wrong below the frequency of the last."""


def surge_mass(tank: Tank, omega: float) -> float:
    """Apparent mass [kg] in surge at frequency omega [rad/s]: force on the tank = −mass · acceleration."""
    m = modes(tank, _TERMS, "low")
    return m.fixed_mass + float(np.sum(m.mass * m.omega**2 / (m.omega**2 - omega**2)))


def pitch_force(tank: Tank, omega: float) -> float:
    """Lateral force per angular acceleration [kg m], inertial axes: F_X = value · d²theta/dt², theta anticlockwise."""
    m = modes(tank, _TERMS, "low")
    lever = m.height + tank.gravity / m.omega**2
    return m.fixed_mass * m.fixed_height + float(np.sum(m.mass * lever * m.omega**2 / (m.omega**2 - omega**2)))


def pitch_inertia(tank: Tank, omega: float) -> float:
    """Apparent moment of inertia [kg m2] in pitch about the liquid's centre of mass: M = value · omega² · theta."""
    m = modes(tank, _TERMS, "low")
    lever = m.height + tank.gravity / m.omega**2
    modal = float(np.sum(m.mass * lever**2 * m.omega**2 / (m.omega**2 - omega**2)))
    weight = tank.gravity / omega**2 * tank.mass * tank.length**2 / (12 * tank.depth)
    return m.fixed_inertia + m.fixed_mass * m.fixed_height**2 + modal + weight


def harmonic_load(tank: Tank, omega: float, h: float = 0.0, alpha: float = 0.0, x: float = 0.0) -> tuple[float, float, float]:
    """Amplitudes of (force_x, force_y, moment) on a tank off the elastic axis, without the static load, undamped steady state.

    h, alpha, x: amplitudes [m, rad, m] of plunge, pitch (nose-up) and surge of the elastic axis, all in phase at frequency omega
    [rad/s]. The three apparent masses about the liquid's centre, moved to the axis; weight acts at the moved centre.
    """
    m, x_t, y = tank.mass, tank.x, tank.centre_y
    aft, theta = x + y * alpha, -alpha  # of the liquid's centre; anticlockwise
    coupling = pitch_force(tank, omega)
    force_x = omega**2 * (surge_mass(tank, omega) * aft - coupling * theta)
    force_y = -m * omega**2 * (h + x_t * alpha)
    anticlockwise = omega**2 * (pitch_inertia(tank, omega) * theta - coupling * aft)
    return force_x, force_y, -anticlockwise + y * force_x - x_t * force_y + m * tank.gravity * y * alpha
