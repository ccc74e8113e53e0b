"""Linear slosh: modal masses on springs, exact over any step, loads to first order in the motion.

    s_n'' + 2 zeta_n omega_n s_n' + omega_n² s_n = g alpha − x'' − y_n alpha'',     y_n = y_L + H_n

s_n [m] is the displacement of modal mass n aft along the chord, y_L the height of the liquid's centre of mass above the elastic
axis, H_n that of the mode above it. Plunge does not move a level tank's surface at first order, nor does the tank's place aft of
the axis. With d_n = s_n − g alpha/omega_n², the distance from the level surface, the loads on the tank in inertial axes are

    force_x = −m_0 (x'' + y_0 alpha'') + sum m_n (omega_n² d_n + 2 zeta_n omega_n s_n')
    force_y = −m_T g + m_T (h'' + x_T alpha'')
    moment  = m_T g x_T + (y_L + l²/(12 h_f)) m_T g alpha − m_T x_T (h'' + x_T alpha'') − m_0 y_0 (x'' + y_0 alpha'')
              − I_0 alpha'' + sum m_n [(omega_n² y_n + g) d_n + 2 zeta_n omega_n y_n s_n']

with the weight at rest, the springs' and dampers' reactions, and the weight that moves with the surface (l²/(12 h_f): all modes
tilted by alpha, also those left out). All terms are of first order in the motion, those of its squares are left out: the weight
stays in force_y at any angle, and force_x is that of the inertial axis.
"""

from __future__ import annotations

import numpy as np

from ..tank.frozen import Load, static_load
from ..tank.liquid import Tank
from ..tank.modes import Modes
from ..tank.motion import SectionMotion
from ..tank.oscillators import Array, Complex, Oscillators


class LinearSlosh:
    """Modes of a tank with their damping ratios, shape (modes,). The state is the complex amplitude w, shape (modes,)."""

    def __init__(self, tank: Tank, modes: Modes, damping: Array) -> None:
        self.tank, self.modes = tank, modes
        self.oscillators = Oscillators(modes.omega, damping)
        self.level = tank.gravity / modes.omega**2  # displacement per radian of tilt where the surface is level [m]
        self.lever = tank.centre_y + modes.height  # y_n [m]
        self.fixed_lever = tank.centre_y + modes.fixed_height
        # reactions on the tank per displacement and velocity: force, moment. Shape: (2, modes)
        force = modes.mass * modes.omega**2
        damper = 2.0 * modes.mass * modes.omega * damping
        spring = np.stack([force, force * self.lever + modes.mass * tank.gravity])
        damper = np.stack([damper, damper * self.lever])
        # … and per imaginary and real part of w, whose combinations displacement and velocity are
        place, decay = 1.0 / self.oscillators.rate.imag, self.oscillators.rate.real / self.oscillators.rate.imag
        self._per_imag, self._per_real = spring * place + damper * decay, damper
        # per tilt, less the springs' reactions where the surface is level
        tilt = modes.rest_tilt + float(modes.mass @ self.level)
        weight = np.array([0.0, (tank.mass * tank.centre_y + tilt) * tank.gravity])
        self._per_tilt = weight - spring @ self.level
        self._static = static_load(tank)
        self._mass, self._static_moment = tank.mass, tank.static_moment
        own = modes.fixed_mass * self.fixed_lever**2 + modes.fixed_inertia
        self._turning = own + tank.mass * tank.x**2  # inertia about the elastic axis of all that does not slosh

    def start(self, motion: SectionMotion) -> Complex:
        """Amplitudes of a level surface in a liquid that moves with the tank."""
        return self.oscillators.amplitude(self.level * motion.alpha, np.zeros_like(self.level))

    def advance(self, w: Complex, course: Array, duration: float) -> Complex:
        """Amplitudes after `duration` [s] of a course (tank.motion.course), without error."""
        tilt = self.tank.gravity * course[3] - course[8]
        return self.oscillators.advance(w, tilt[:, None] - course[5][:, None] * self.lever, duration)

    def load(self, w: Complex, motion: SectionMotion) -> Load:
        """Whole load on the tank."""
        waves = self._per_imag @ w.imag + self._per_real @ w.real + self._per_tilt * motion.alpha
        down, turn, aft = motion.h_ddot, motion.alpha_ddot, motion.x_ddot
        coupling = self.modes.fixed_mass * self.fixed_lever
        return Load(
            float(waves[0]) - self.modes.fixed_mass * aft - coupling * turn,
            self._static.force_y + self._mass * down + self._static_moment * turn,
            float(waves[1]) + self._static.moment - self._static_moment * down - coupling * aft - self._turning * turn,
        )

    def distance(self, w: Complex, motion: SectionMotion) -> Array:
        """Displacements d [m] from the level surface, shape (modes,)."""
        return self.oscillators.displacement(w) - self.level * motion.alpha

    def wave_height(self, w: Complex, motion: SectionMotion) -> float:
        """Surface above its level at rest at the aft wall, along y' [m]; at the fore wall it is the negative."""
        return float(self.modes.elevation @ self.oscillators.displacement(w)) + self.modes.rest_elevation * motion.alpha

    def energy(self, w: Complex, motion: SectionMotion) -> float:
        """Energy of the waves, kinetic in tank axes and potential above the level surface [J]."""
        d, v = self.distance(w, motion), self.oscillators.velocity(w)
        return 0.5 * float(self.modes.mass @ (v**2 + (self.modes.omega * d) ** 2))
