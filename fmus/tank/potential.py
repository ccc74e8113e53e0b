"""Linear potential flow in a rectangular tank: loads of harmonic surge and pitch in closed form.

The steady response about the liquid's centre of mass, theta anticlockwise, D_n = omega_n² − Omega²; derived as modal sums and
identical to Graham and Rodriguez (1952) once their misprinted forms are corrected.
"""

from __future__ import annotations

import numpy as np

from .liquid import Tank
from .modes import modes

_TERMS = 400


def surge_mass(tank: Tank, omega: float) -> float:
    """Apparent mass [kg] in surge at frequency omega [rad/s]: force on the tank = −mass · acceleration."""
    m = modes(tank, _TERMS, "high")
    return m.fixed_mass + float(np.sum(m.mass * m.omega**2 / (m.omega**2 - omega**2)))


def pitch_force(tank: Tank, omega: float) -> float:
    """Lateral force per angular acceleration [kg m], inertial axes: F_X = value · d²theta/dt², theta anticlockwise."""
    m = modes(tank, _TERMS, "high")
    lever = m.height + tank.gravity / m.omega**2
    return m.fixed_mass * m.fixed_height + float(np.sum(m.mass * lever * m.omega**2 / (m.omega**2 - omega**2)))


def pitch_inertia(tank: Tank, omega: float) -> float:
    """Apparent moment of inertia [kg m2] in pitch about the liquid's centre of mass: M = value · omega² · theta."""
    m = modes(tank, _TERMS, "high")
    lever = m.height + tank.gravity / m.omega**2
    modal = float(np.sum(m.mass * lever**2 * m.omega**2 / (m.omega**2 - omega**2)))
    weight = tank.gravity / omega**2 * tank.mass * tank.length**2 / (12 * tank.depth)
    return m.fixed_inertia + m.fixed_mass * m.fixed_height**2 + modal + weight
