"""A network in a tank: advance with the motion, load, how far it can be trusted. Also whole records at once."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ..kit.compiled import jit
from ..tank.faraday import Waves, grow, still, waves
from ..tank.liquid import Tank
from .body import Body, base_load, body, from_load, to_load
from .gate import EDGE_GROWTH, EDGE_UNEVEN, uneven
from .memory import GAMMA, MODES, Array, Complex, Memory, Place, Step, drive, remember
from .network import Network, NetworkError, Weights, read_out
from .readout import EVEN, ODD, SPACE, features
from .violent_memory import BEGIN

NO_LAGS: Array = np.zeros(0)
MOST_TURNS = 1e6
"""Most radians of the fastest wave watched in one step: about a second of work."""
INSIDE = 0.01
"""Least distance to its training data that a violent branch tells: where it speaks, loads do not hold pointwise."""
SAME_SHAPE = 0.02
"""Relative difference of depth over length up to which a network holds: first-mode frequencies then differ by 1 %."""


class Answer(NamedTuple):
    """Load in inertial axes [N, N, N m about the elastic axis], distance to the training data (1 at its edge), largest D and
    logarithm of wave growth so far; of a network with a violent branch: its share in the load, the deviation of the force up from
    the mean that it tells [N], and the largest distance to its training data so far (below 0: there is no branch)."""

    force_x: float
    force_y: float
    moment: float
    extrapolation: float
    uneven: float
    growth: float
    share: float = 0.0
    deviation: float = 0.0
    beyond: float = -1.0

    @property
    def validity(self) -> float:
        """Up to 1 the loads hold pointwise. Above, the surface breaks, waves grow of themselves, or nothing like it was trained
        on: the model does not hold, but with a violent branch, which tells the mean of a broken surface: from 1 to 2 that
        holds."""
        pointwise = max(self.uneven / EDGE_UNEVEN, self.growth / EDGE_GROWTH, self.extrapolation)
        if pointwise <= 1.0 or self.beyond < 0.0:
            return pointwise
        # waves that grow of themselves where gravity never vanishes, or slow large motions, are in neither training
        return 1.0 + (max(self.beyond, INSIDE) if self.uneven > BEGIN else max(self.growth / EDGE_GROWTH, self.extrapolation))


class State(NamedTuple):
    """What the next step needs (memory, and the waves of the gate) and the answer at this moment."""

    w: Complex
    waves: Array
    answer: Answer
    lags: Array = NO_LAGS  # earlier motions and loads, of a network with output feedback
    thrown: Array = NO_LAGS  # memory of a violent branch


@dataclass(frozen=True)
class Record:
    """A motion and the loads that belong to it: motions (n, 9) at equal steps [s] and loads (n, 3) in inertial axes."""

    step: float
    motions: Array
    loads: Array


def fits(name: str, known_shape: float, known_room: float, tank: Tank) -> None:
    """Raise NetworkError for a tank that is no scale model of the one that network `name` was trained on (0: any will do)."""
    shape, room = tank.depth / tank.length, tank.height / tank.length
    if known_shape and abs(shape / known_shape - 1.0) > SAME_SHAPE:
        raise NetworkError(
            f"network '{name}' knows liquid of depth/length {known_shape:.4g}, this tank has {shape:.4g} "
            f"(fill_level {tank.fill_level:g}, tank_height {tank.height:g} m, tank_length {tank.length:g} m). Remedy: a tank "
            "of the same shape at any size, the network 'bilinear' or 'ems', slosh_vof, or a network trained for it"
        )
    if known_room and room < (1.0 - SAME_SHAPE) * known_room:
        raise NetworkError(
            f"network '{name}' was trained under a roof at {known_room:.4g} of the tank's length, here it is at "
            f"{room:.4g}: waves would reach it earlier. Remedy: a tank as high, slosh_vof, or a network trained for it"
        )


class Surrogate:
    """`network` in `tank`, with the viscosity [m2/s] of the liquid and the density [kg/m3] of the gas.

    A tank of the trained shape (depth and height over length) is a scale model of the one trained on: frequencies go with
    sqrt(g/l), loads with the weight. Other shapes are refused (NetworkError). The offset from the elastic axis is exact: motion
    and load are taken at the liquid."""

    edge = 1.0  # of the validity: up to here the loads hold

    def __init__(self, network: Network, tank: Tank, viscosity: float, gas_density: float) -> None:
        fits(network.name, network.shape, network.room, tank)
        self.network, self.tank = network, tank
        self.memory = Memory(tank, viscosity)
        self.body = body(self.memory, gas_density)
        self.waves = waves(tank, viscosity)
        self.surface = tank.fill_level < 1.0

    def start(self, motion: Array) -> State:
        """Level surface, liquid moving with the tank. motion: the nine values of a SectionMotion."""
        w, out = self.memory.start(motion), np.empty(6)
        _answer(w, motion, self.memory.place, self.body, self.network.weights, self.network.reach, out)
        return State(w, still(), self._told(out, motion, 0.0, 0.0))

    def advance(self, state: State, start: Array, end: Array, duration: float) -> State:
        """After a step of `duration` [s] between two motions. Raises NetworkError for one too long to follow waves."""
        longest = MOST_TURNS / float(self.waves.omega[-1])
        if not duration <= longest:
            raise NetworkError(
                f"a communication step of {duration:g} s; the growth of waves is followed over at most {longest:.3g} s. Remedy: "
                "shorter communication steps"
            )
        step, waves, out = self.memory.step(duration), state.waves.copy(), np.empty(6)
        net = self.network
        w = _advance(state.w, waves, start, end, step, self.memory.place, self.waves, self.body, net.weights, net.reach, out)
        return State(w, waves, self._told(out, end, state.answer.uneven, float(out[5])))

    def _told(self, out: Array, motion: Array, uneven: float, growth: float) -> Answer:
        """The answer of a kernel in the units of a user; a full tank has no surface to break."""
        uneven = max(uneven, float(out[4])) if self.surface else 0.0
        return Answer(*to_load(out, self.tank, float(motion[3])), float(out[3]), uneven, growth if self.surface else 0.0)

    def effective_gravity(self, motion: Array) -> float:
        """What holds the liquid down at its centre, along the tank's y' [m/s2]."""
        rows = np.empty(5)
        drive(motion, self.memory.place, rows)
        return float(self.tank.gravity * (1.0 + rows[GAMMA]))

    def wave_height(self, w: Complex) -> float:
        """Surface above its level at rest at the aft wall [m], of the linear waves."""
        m = self.memory.modes
        return float(m.elevation @ (w[:MODES].imag * self.body.place))

    def run(self, motions: Array, step: float) -> Array:
        """Loads of a whole record in inertial axes, (n, 3): free run from rest."""
        return self._march(self.memory.start(motions[0]), motions, step)[1]

    def march(self, state: State, motions: Array, step: float) -> tuple[State, Array]:
        """The state after a record that goes on from `state`, which is that of its first sample, and the loads (n, 3); the gate
        stands still meanwhile."""
        w, loads = self._march(state.w, motions, step)
        return state._replace(w=w), loads

    def _march(self, w: Complex, motions: Array, step: float) -> tuple[Complex, Array]:
        loads, net = np.empty((len(motions), 3)), self.network.weights
        w = _run(w, motions, self.memory.step(step), self.memory.place, self.body, net, loads)
        return w, self.inertial(loads, motions)

    def inertial(self, loads: Array, motions: Array) -> Array:
        """Loads (n, 3) in tank axes over m_T g and m_T g l as loads in inertial axes."""
        return np.array([to_load(load, self.tank, tilt) for load, tilt in zip(loads, motions[:, 3], strict=True)])


class Table(NamedTuple):
    """What a readout is trained on: features (n, ODD), (n, EVEN), coordinates (n, SPACE); what the base leaves and the whole
    load, (n, 3): along, up, moment over m_T g and m_T g l."""

    odd: Array
    even: Array
    space: Array
    rest: Array
    whole: Array


def tabulate(base: Surrogate, record: Record) -> Table:
    """Features of a record under the memory of `base` (an untrained network), and what its base leaves of the loads."""
    n = len(record.motions)
    table = Table(np.empty((n, ODD)), np.empty((n, EVEN)), np.empty((n, SPACE)), np.empty((n, 3)), np.empty((n, 3)))
    own = np.empty((n, 3))
    _tabulate(
        base.memory.start(record.motions[0]), record.motions, base.memory.step(record.step), base.memory.place, base.body,
        base.network.weights, table.odd, table.even, table.space, own,
    )  # fmt: skip
    F = record.loads
    table.whole[:] = from_load(F[:, 0], F[:, 1], F[:, 2], base.tank, record.motions[:, 3])
    table.rest[:] = table.whole - own
    return table


def inputs(base: Surrogate, motions: Array) -> Array:
    """What the liquid feels at each sample of a motion (n, 9): memory.drive. Shape: (n, 5)."""
    rows = np.empty((len(motions), 5))
    for motion, row in zip(motions, rows, strict=True):
        drive(motion, base.memory.place, row)
    return rows


@jit
def _answer(w: Complex, motion: Array, place: Place, body: Body, net: Weights, reach: Array, out: Array) -> None:
    """out (6,): load (3,) in tank axes, distance to the training data, D; the last entry stays."""
    rows, space = np.empty(5), np.empty(SPACE)
    drive(motion, place, rows)
    read_out(w, rows, body, net, space, out)
    beyond = 0.0
    for k in range(SPACE):
        beyond = max(beyond, abs(space[k]) / reach[k])
    out[3], out[4] = beyond, uneven(rows)


@jit
def _advance(
    w: Complex, grown: Array, start: Array, end: Array, step: Step, place: Place, waves: Waves, body: Body, net: Weights,
    reach: Array, out: Array,
) -> Complex:  # fmt: skip
    """The memory after a step; out as in `_answer`, its last entry the growth of waves, which are advanced in place."""
    before, after = np.empty(5), np.empty(5)
    drive(start, place, before)
    drive(end, place, after)
    out[5] = grow(grown, before[GAMMA], after[GAMMA], step.duration, waves)
    new = remember(w, start, end, step, place)
    _answer(new, end, place, body, net, reach, out)
    return new


@jit
def _run(w: Complex, motions: Array, step: Step, place: Place, body: Body, net: Weights, out: Array) -> Complex:
    rows, space = np.empty(5), np.empty(SPACE)
    for k in range(len(motions)):
        if k > 0:
            w = remember(w, motions[k - 1], motions[k], step, place)
        drive(motions[k], place, rows)
        read_out(w, rows, body, net, space, out[k])
    return w


@jit
def _tabulate(
    w: Complex, motions: Array, step: Step, place: Place, body: Body, net: Weights,
    odd: Array, even: Array, space: Array, own: Array,
) -> None:  # fmt: skip
    rows = np.empty(5)
    for k in range(len(motions)):
        if k > 0:
            w = remember(w, motions[k - 1], motions[k], step, place)
        drive(motions[k], place, rows)
        features(w, rows, body, odd[k], even[k], space[k])
        base_load(w, rows, body, net.bilinear, own[k])
