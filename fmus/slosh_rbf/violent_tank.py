"""A network with a violent branch in a tank, behind the same face as one without (surrogate.Surrogate).

Where the surface is whole (violent_memory.share) the loads are those of the calm network to the bit. As it breaks they go over to
the mean of a broken surface: force up by the branch, force along and moment about the liquid's centre those of the frozen liquid,
whose deviations do no work to speak of and cannot be told pointwise.
"""

from __future__ import annotations

import numpy as np

from ..kit.compiled import jit
from ..tank.liquid import Tank
from .body import to_load
from .memory import FX, GAMMA, SPIN, Array, Complex, Place, drive
from .network import Network, untrained
from .surrogate import SAME_SHAPE, Answer, State, Surrogate
from .violent_memory import BEGIN, UNEVEN, Basin, basin, follow, still
from .violent_network import Violent, ViolentWeights, lift


def calm_part(network: Network, tank: Tank) -> Network:
    """`network` where it knows the fill of `tank`, its equations without weights elsewhere."""
    fits = not network.shape or abs(tank.depth / tank.length / network.shape - 1.0) <= SAME_SHAPE
    return network if fits else untrained("bilinear", True)


class ViolentSurrogate:
    """`network` for a whole surface and `branch` for a broken one in `tank`, with the viscosity [m2/s] of the liquid and the
    density [kg/m3] of the gas. The tank must be one that the branch knows (`Violent.knows`); raises NetworkError where the
    network does not know its height."""

    edge = 2.0  # of the validity: up to here the work of the loads holds

    def __init__(self, network: Network, branch: Violent, tank: Tank, viscosity: float, gas_density: float) -> None:
        self.calm = Surrogate(calm_part(network, tank), tank, viscosity, gas_density)
        self.branch, self.tank, self.body = branch, tank, self.calm.body
        self.basin = basin(self.calm.memory)
        self.flat = (1.0 + (tank.depth / tank.length) ** 2) / 6.0  # inertia of the frozen liquid over m_T l (l/2)

    def start(self, motion: Array) -> State:
        """Level surface, liquid moving with the tank. motion: the nine values of a SectionMotion."""
        state = self.calm.start(motion)
        return State(state.w, state.waves, replace_answer(state.answer, 0.0, 0.0, 0.0), state.lags, still())

    def advance(self, state: State, start: Array, end: Array, duration: float) -> State:
        """After a step of `duration` [s] between two motions. Raises NetworkError for one too long to follow waves."""
        new, thrown, out = self.calm.advance(state, start, end, duration), state.thrown.copy(), np.empty(6)
        _advance(thrown, start, end, duration, self.calm.memory.place, self.basin, self.branch.weights, self._fixed, out)
        return State(new.w, new.waves, self._blend(new.answer, out, float(end[3]), state.answer.beyond), new.lags, thrown)

    @property
    def _fixed(self) -> tuple[float, float, float]:
        return self.tank.fill_level, self.body.gas_mass, self.flat

    def _blend(self, calm: Answer, out: Array, tilt: float, beyond: float) -> Answer:
        """The calm answer and that of the branch (`_advance`), by their shares."""
        share, weight = float(out[3]), self.tank.mass * self.tank.gravity
        if share == 0.0:
            return replace_answer(calm, 0.0, 0.0, beyond)
        broken = to_load(out, self.tank, tilt)
        loads = [a + share * (b - a) for a, b in zip(calm[:3], broken, strict=True)]
        mixed = calm._replace(force_x=loads[0], force_y=loads[1], moment=loads[2])
        return replace_answer(mixed, share, share * weight * float(out[4]), max(beyond, float(out[5])))

    def effective_gravity(self, motion: Array) -> float:
        """What holds the liquid down at its centre, along the tank's y' [m/s2]."""
        return self.calm.effective_gravity(motion)

    def wave_height(self, w: Complex) -> float:
        """Surface above its level at rest at the aft wall [m], of the linear waves."""
        return self.calm.wave_height(w)

    def run(self, motions: Array, step: float) -> Array:
        """Loads of a whole record in inertial axes, (n, 3): free run from rest."""
        return self.march(self.start(motions[0]), motions, step)[1]

    def march(self, state: State, motions: Array, step: float) -> tuple[State, Array]:
        """The state after a record that goes on from `state`, which is that of its first sample, and the loads (n, 3); the gate
        stands still meanwhile."""
        calm, loads = self.calm.march(state, motions, step)
        thrown, table = state.thrown.copy(), np.empty((len(motions), 6))
        _run(thrown, motions, step, self.calm.memory.place, self.basin, self.branch.weights, self._fixed, table)
        broken, share = self.calm.inertial(table[:, :3], motions), table[:, 3:4]
        return calm._replace(thrown=thrown), np.where(share > 0.0, loads + share * (broken - loads), loads)


def replace_answer(answer: Answer, share: float, deviation: float, beyond: float) -> Answer:
    """With what a violent branch tells."""
    return answer._replace(share=share, deviation=deviation, beyond=beyond)


@jit
def _tell(
    thrown: Array, motion: Array, place: Place, basin: Basin, net: ViolentWeights, fixed: tuple[float, float, float], out: Array
) -> None:
    """out (6,): load (3,) in tank axes over m_T g and m_T g l, share of the branch, deviation of the force up over m_T g,
    distance to the training data; zeros where the branch has no share. fixed: fill, mass of the gas, inertia of the frozen
    liquid."""
    out[:] = 0.0
    if thrown[UNEVEN] <= BEGIN:
        return
    rows, told = np.empty(5), np.empty(4)
    drive(motion, place, rows)
    lift(thrown, rows[GAMMA], fixed[0], basin, net, told)
    out[0] = rows[FX]
    out[1] = told[0] - (1.0 + rows[GAMMA]) * (1.0 + fixed[1])
    out[2] = -fixed[2] * rows[SPIN]
    out[3], out[4], out[5] = told[3], told[1], told[2]


@jit
def _advance(
    thrown: Array, start: Array, end: Array, duration: float, place: Place, basin: Basin, net: ViolentWeights,
    fixed: tuple[float, float, float], out: Array,
) -> None:  # fmt: skip
    follow(thrown, start, end, duration, place, basin)
    _tell(thrown, end, place, basin, net, fixed, out)


@jit
def _run(
    thrown: Array, motions: Array, step: float, place: Place, basin: Basin, net: ViolentWeights,
    fixed: tuple[float, float, float], out: Array,
) -> None:  # fmt: skip
    for k in range(len(motions)):
        if k > 0:
            follow(thrown, motions[k - 1], motions[k], step, place, basin)
        _tell(thrown, motions[k], place, basin, net, fixed, out[k])
