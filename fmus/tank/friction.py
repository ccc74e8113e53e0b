"""What a viscous liquid does that modes with a damping ratio do not: how wrong linear slosh is by friction.

A laminar layer on the walls takes energy from a wave and, as large, holds it back: its friction lags the flow by an eighth of a
period, so that the damping ratio zeta_l from the layers comes with added inertia 2 zeta_l, and the frequency falls by the part
zeta_l (Case and Parkinson, J. Fluid Mech. 2 (1957) 172, doi:10.1017/S0022112057000051; Lamb, Hydrodynamics, 6th ed. (1932),
articles 347 and 348). Modal masses have the damping and not the inertia. The same modes with it

    (1 + 2 zeta_l) s'' + 2 zeta omega s' + omega² s = f

are followed beside them, the first MODES of each. The largest difference of their loads on the tank since the start over the
largest load is a good guess of the error of linear slosh, as long as layers are thin; for thick ones all of this ends, and the
damping ratio of the first mode tells. `number` is the larger of

    difference of the loads / LOADS            zeta_1 / THICK

with the two edges found against slosh_vof (docs/ems.md): below 1 the loads are right within a quarter, as a rule."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .liquid import Tank
from .modes import layer_damping, modes, stokes_damping
from .motion import SectionMotion
from .oscillators import LARGEST_DAMPING, Array, Complex, Oscillators

MODES = 5
LOADS = 0.25
THICK = 0.15


class Seen(NamedTuple):
    """Amplitudes of the modes without and with the layers' inertia, shape (2 MODES,); the largest load [N] without it and the
    largest difference [N] since the start."""

    w: Complex
    load: float
    gap: float


class Friction:
    """Watches a tank whose liquid has the kinematic `viscosity` [m2/s]; `damping`: another damping ratio of the modes, 0 for the
    one that follows from the viscosity."""

    def __init__(self, tank: Tank, viscosity: float, damping: float = 0.0) -> None:
        first = modes(tank, MODES)
        laminar = stokes_damping(tank, first.omega, viscosity)
        self.layers = layer_damping(tank, first.omega, viscosity)
        self.thick = float(laminar[0]) / THICK
        zeta = np.full(MODES, damping) if damping > 0.0 else laminar
        inertia = np.concatenate([np.ones(MODES), 1.0 + 2.0 * self.layers])
        root, push = np.sqrt(inertia), 1.0 / inertia
        self._bank = bank = Oscillators(np.tile(first.omega, 2) / root, np.minimum(np.tile(zeta, 2) / root, LARGEST_DAMPING))
        lever = np.tile(tank.centre_y + first.height, 2)
        self._level = np.tile(tank.gravity / first.omega**2, 2)
        # accelerations of the modes from tilt, surge and pitch; from imaginary and real part of w
        self._drive = np.stack([tank.gravity * push, -push, -lever * push])
        place, decay = 1.0 / bank.rate.imag, bank.rate.real / bank.rate.imag
        by_real = -2.0 * bank.damping * bank.omega
        by_imag = by_real * decay - bank.omega**2 * place
        # force along and moment about the liquid's centre over half the length [N], without the inertia and with it
        arm = 2.0 / tank.length
        rows = np.stack([-first.mass, -arm * first.mass * first.height])
        masses = np.kron(np.eye(2), rows)
        weight = np.kron(np.eye(2), np.stack([np.zeros(MODES), arm * first.mass * tank.gravity]))
        self._of_waves = np.concatenate([masses * by_imag + weight * place, masses * by_real], axis=1)
        self._of_motion = masses @ self._drive.T
        self._least = 1e-12 * tank.mass * tank.gravity

    @property
    def far_above(self) -> float:
        """The number for motions far above the first mode's frequency, without following them: the inertia alone counts."""
        return max(self.thick, 2.0 * float(self.layers[0]) / LOADS)

    def start(self, motion: SectionMotion) -> Seen:
        """Level surface in a liquid that moves with the tank."""
        return Seen(self._bank.amplitude(self._level * motion.alpha, np.zeros(2 * MODES)), 0.0, 0.0)

    def advance(self, seen: Seen, course: Array, end: SectionMotion, duration: float) -> Seen:
        """After `duration` [s] of a course (tank.motion.course) that ends with the motion `end`."""
        w = self._bank.advance(seen.w, course[[3, 8, 5]].T @ self._drive, duration)
        push = np.array([end.alpha, end.x_ddot, end.alpha_ddot])
        along, turn, along_too, turn_too = (self._of_waves @ np.concatenate([w.imag, w.real]) + self._of_motion @ push).tolist()
        load, gap = math.hypot(along, turn), math.hypot(along_too - along, turn_too - turn)
        return Seen(w, max(seen.load, load), max(seen.gap, gap))

    def number(self, seen: Seen) -> float:
        """0 without friction, 1 at the edge, above: linear slosh does not hold."""
        moved = seen.gap / seen.load / LOADS if seen.load > self._least else 0.0
        return max(self.thick, moved)
