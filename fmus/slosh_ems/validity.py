"""Does linear slosh hold? Unevenness of gravity, wave height at the walls, parametric resonance.

`validity` is the largest since the start of
- D/D_edge, D = |g_n/g − 1| + (l/2) |alpha''|/g with the effective gravity g_n at the liquid's centre: how uneven gravity is along
  the surface. Linear slosh leaves its changes out: D_edge = 0.3. With them (parametric) it holds until gravity may vanish
  somewhere on the surface: D_edge = 1. Towards 1.5 surfaces break.
- the wave height at a wall over 0.2 of the depth, or over the way to the roof where that is shorter;
- what friction does beyond damping waves, over a quarter of the load (fmus/tank/friction.py).
It never falls: a surface once broken stays so.

`parametric_resonance` is the largest |Y_j| of the waves j = 1 … WAVES (j half waves in the tank, of both symmetries), with

    Y_j' = (−2 zeta_j + 2 i) omega_j Y_j + omega_j gamma(t),    gamma = −(h'' + x_T alpha'')/g

the part of the gravity's change at twice the wave's frequency, over a bandwidth of 2 zeta_j omega_j. Under gamma = a cos(Omega t)
it tends to (a/(4 zeta))/sqrt(1 + ((Omega − 2 omega)/(2 zeta omega))²), and 1 is the edge of the principal tongue of the damped
Mathieu equation to first order (Nayfeh and Mook, Nonlinear Oscillations (1979), chapter 5): above it the wave grows by itself,
however small. Shorter waves than WAVES carry about a thousandth of the liquid each, or less, and are not watched.
"""

from __future__ import annotations

import numpy as np

from ..tank.liquid import Tank
from ..tank.motion import SectionMotion, body_force
from ..tank.oscillators import Array, Complex, Oscillators

WAVES = 12
EVEN = {False: 0.3, True: 1.0}
"""D_edge of the linear and of the parametric equations."""
STEEP = 0.2
"""Edge of the wave height over the depth."""


class Gate:
    """Watches a tank. omega [rad/s] and damping ratios of the waves, shape (WAVES,)."""

    def __init__(self, tank: Tank, parametric: bool, omega: Array, damping: Array) -> None:
        self.tank = tank
        self.even = EVEN[parametric]
        self.highest = min(STEEP * tank.depth, tank.height - tank.depth)
        # oscillators of twice the frequency: their complex amplitudes follow the same equation
        self._filter = Oscillators(2.0 * omega, damping)
        self._gain = omega * (tank.fill_level < 1.0)  # a full tank has no waves

    def start(self) -> Complex:
        """Y at the start: steady gravity. Shape: (WAVES,)."""
        return np.zeros(len(self._gain), dtype=complex)

    def advance(self, Y: Complex, course: Array, duration: float) -> Complex:
        """Y after `duration` [s] of a course."""
        gamma = (course[2] + self.tank.x * course[5]) / -self.tank.gravity
        return self._filter.advance(Y, gamma[:, None] * self._gain, duration)

    def effective_gravity(self, motion: SectionMotion) -> float:
        """What holds the liquid down at its centre, along the tank's y' [m/s2]."""
        return -body_force(motion, self.tank.x, self.tank.centre_y, self.tank.gravity)[1]

    def measure(self, motion: SectionMotion, wave_height: float) -> float:
        """Distance to the edge at this moment: 0 fine, 1 at the edge."""
        g = self.tank.gravity
        if self.tank.fill_level >= 1.0:  # no surface to be uneven
            return 0.0
        uneven = abs(self.effective_gravity(motion) / g - 1.0) + 0.5 * self.tank.length * abs(motion.alpha_ddot) / g
        steep = abs(wave_height) / self.highest if self.highest > 0.0 else 0.0
        return max(uneven / self.even, steep)
