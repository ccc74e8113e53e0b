"""From a dimensionless case to SI: fixed air, so that V_f changes the structure alone.

m = mu pi rho b^2, S = x_alpha m b, I = r2_alpha m b^2, omega_alpha = U / (V_f b sqrt(mu)), omega_h =
ratio omega_alpha. With pressure, temperature and Mach number given, the stream and the masses do not
depend on V_f: one steady flow serves every V_f of a Mach number.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .case import Case

GAMMA = 1.4
GAS_CONSTANT = 287.05  # J/(kg K), dry air


@dataclass(frozen=True)
class Scales:
    """Dimensional quantities of one march."""

    mach: float
    V_f: float
    speed: float  # U [m/s]
    density: float  # rho [kg/m3]
    half_chord: float  # b [m]
    mass: float  # m [kg/m]
    static_imbalance: float  # S [kg]
    inertia: float  # I about the elastic axis [kg m]
    omega_h: float  # [rad/s]
    omega_alpha: float  # [rad/s]
    steps_per_cycle: int

    @property
    def period(self) -> float:
        """2 pi / omega_alpha [s]."""
        return 2.0 * math.pi / self.omega_alpha

    @property
    def dt(self) -> float:
        """Communication step [s], in whole nanoseconds: other tools count in them, and march what we march (docs/ssp.md)."""
        return whole_nanoseconds(self.period / self.steps_per_cycle)


def whole_nanoseconds(dt: float) -> float:
    """The nearest step [s] that is a whole number of them, correctly rounded as a tool that counts them has it."""
    return round(1e9 * dt) / 1e9


def scales(case: Case, mach: float, V_f: float) -> Scales:
    """The dimensional numbers of `case` at `mach` and `V_f`."""
    s, f = case.section, case.flow
    b = 0.5 * s.chord
    density = f.static_pressure / (GAS_CONSTANT * f.static_temperature)
    speed = mach * math.sqrt(GAMMA * GAS_CONSTANT * f.static_temperature)
    mass = s.mass_ratio * math.pi * density * b**2
    omega_alpha = speed / (V_f * b * math.sqrt(s.mass_ratio))
    return Scales(
        mach=mach,
        V_f=V_f,
        speed=speed,
        density=density,
        half_chord=b,
        mass=mass,
        static_imbalance=s.x_alpha * mass * b,
        inertia=s.r2_alpha * mass * b**2,
        omega_h=s.frequency_ratio * omega_alpha,
        omega_alpha=omega_alpha,
        steps_per_cycle=_steps(case, 2.0 * math.pi / omega_alpha, speed),
    )


def _steps(case: Case, period: float, speed: float) -> int:
    """Steps a period: the case's, or a step in which the stream travels 0.2 chords, at least 72.

    At these the damping ratio is within 1e-4 of its limit (tests/validation/test_flutter.py).
    """
    wanted = case.flutter.steps_per_cycle
    if isinstance(wanted, int):
        return wanted
    return max(72, math.ceil(period / (0.2 * case.section.chord / speed)))
