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
        root = np.sqrt(inertia)
        self._bank = Oscillators(np.tile(first.omega, 2) / root, np.minimum(np.tile(zeta, 2) / root, LARGEST_DAMPING))
        self._push = 1.0 / inertia  # of the body force
        self._lever = np.tile(tank.centre_y + first.height, 2)
        self._level = np.tile(tank.gravity / first.omega**2, 2)
        # of displacement, velocity and push → the force along, and the moment about the liquid's centre over half the length [N]
        arm = 2.0 / tank.length
        own = np.stack([-first.mass, -arm * first.mass * first.height])
        self._own = np.concatenate([own, own], axis=1)
        self._weight = np.tile(arm * first.mass * tank.gravity, 2)
        self._least = 1e-12 * tank.mass * tank.gravity
        self._gravity = tank.gravity

    @property
    def far_above(self) -> float:
        """The number for motions far above the first mode's frequency, without following them: the inertia alone counts."""
        return max(self.thick, 2.0 * float(self.layers[0]) / LOADS)

    def start(self, motion: SectionMotion) -> Seen:
        """Level surface in a liquid that moves with the tank."""
        return Seen(self._bank.amplitude(self._level * motion.alpha, np.zeros(2 * MODES)), 0.0, 0.0)

    def advance(self, seen: Seen, course: Array, end: SectionMotion, duration: float) -> Seen:
        """After `duration` [s] of a course (tank.motion.course) that ends with the motion `end`."""
        bank, g = self._bank, self._gravity
        force = ((g * course[3] - course[8])[:, None] - course[5][:, None] * self._lever) * self._push
        w = bank.advance(seen.w, force, duration)
        s, push = bank.displacement(w), (g * end.alpha - end.x_ddot - end.alpha_ddot * self._lever) * self._push
        acceleration = push - bank.omega * (2.0 * bank.damping * bank.velocity(w) + bank.omega * s)
        along, turn = (self._own * acceleration).reshape(2, 2, MODES).sum(axis=2)
        turn = turn + (self._weight * s).reshape(2, MODES).sum(axis=1)
        load = float(np.hypot(along[0], turn[0]))
        return Seen(w, max(seen.load, load), max(seen.gap, float(np.hypot(along[1] - along[0], turn[1] - turn[0]))))

    def number(self, seen: Seen) -> float:
        """0 without friction, 1 at the edge, above: linear slosh does not hold."""
        moved = seen.gap / seen.load / LOADS if seen.load > self._least else 0.0
        return max(self.thick, moved)
