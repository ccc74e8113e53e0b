"""A network with output feedback in a tank, behind the same face as one on the modal memory (surrogate.Surrogate)."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..tank.liquid import Tank
from . import feedback, network
from .body import from_load, to_load
from .feedback import Feedback, columns, one_step
from .memory import Array, Complex
from .network import Network, NetworkError, untrained
from .surrogate import State, Surrogate, fits, inputs
from .violent_network import Violent
from .violent_tank import ViolentSurrogate

EDGE = 4.0
"""Standard deviations of the training data that count as their edge: a network with feedback keeps no more of them."""


class FeedbackSurrogate:
    """`net` in `tank`: one fixed step (`step` [s], a scale model's where the tank is one), whole loads from delayed ones.

    What is known of waves and of breaking comes from the linear memory, as for the other networks. Raises NetworkError for a tank
    it does not know, loads that are not three, and steps that are not its own."""

    edge = 1.0  # of the validity: up to here the loads hold

    def __init__(self, net: Feedback, tank: Tank, viscosity: float, gas_density: float) -> None:
        if net.outputs != 3:
            raise NetworkError(f"network '{net.name}' gives {net.outputs} loads. Remedy: one of along, up and moment")
        fits(net.name, net.shape, net.room, tank)
        self.net, self.tank = net, tank
        self.base = Surrogate(untrained("ems", False), tank, viscosity, gas_density)
        self.body = self.base.body
        self.step = net.step * math.sqrt(tank.length / tank.gravity)

    def start(self, motion: Array) -> State:
        """Level surface, liquid moving with the tank, and so for ever before."""
        state, (m, n) = self.base.start(motion), self.net.delays
        a = state.answer
        force_x, force_y, moment = (np.array([value]) for value in (a.force_x, a.force_y, a.moment))
        own = from_load(force_x, force_y, moment, self.tank, motion[3:4])[0]
        return state._replace(lags=np.concatenate([np.tile(self._input(motion), m), np.tile(own, n)]))

    def advance(self, state: State, start: Array, end: Array, duration: float) -> State:
        """After one step of its own."""
        if abs(duration - self.step) > 1e-6 * self.step:
            raise NetworkError(
                f"network '{self.net.name}' knows steps of {self.step:.6g} s alone, not {duration:.6g} s. Remedy: communicate at "
                "that step, or take a network without output feedback"
            )
        (m, n), u = self.net.delays, self._input(end)
        split = m * len(u)
        before, loads = state.lags[:split], state.lags[split:]
        own = one_step(self.net, np.concatenate([u, before, loads])[None])[0]
        z = np.abs((np.concatenate([u, before, loads]) - self.net.shift) / self.net.scale)
        new = self.base.advance(state, start, end, duration)
        whole = to_load(own, self.tank, float(end[3]))
        answer = new.answer._replace(
            force_x=whole[0], force_y=whole[1], moment=whole[2], extrapolation=float(z.max()) / EDGE
        )  # fmt: skip
        lags = np.concatenate([np.concatenate([u, before])[:split], np.concatenate([own, loads])[: 3 * n]])
        return State(new.w, new.waves, answer, lags)

    def effective_gravity(self, motion: Array) -> float:
        """What holds the liquid down at its centre, along the tank's y' [m/s2]."""
        return self.base.effective_gravity(motion)

    def wave_height(self, w: Complex) -> float:
        """Surface above its level at rest at the aft wall [m], of the linear waves."""
        return self.base.wave_height(w)

    def _input(self, motion: Array) -> Array:
        """What the network is told of an instant: plunge is that of the tank's centre."""
        moved, (s, c) = motion.copy(), (math.sin(motion[3]), math.cos(motion[3]))
        moved[0] += self.tank.x * s + self.tank.y * (1.0 - c)
        return columns(self.net.inputs, inputs(self.base, motion[None]), moved[None], self.tank.length)[0]


def read(path: Path) -> Network | Feedback:
    """A network of either kind. Raises NetworkError."""
    try:
        kind = network.read_archive(path)[0].get("kind")
    except Exception:  # the reader of the usual kind says what is wrong
        kind = None
    return feedback.load(path) if kind == feedback.KIND else network.load(path)


def in_tank(
    net: Network | Feedback, tank: Tank, viscosity: float, gas_density: float, branch: Violent | None = None
) -> Surrogate | FeedbackSurrogate | ViolentSurrogate:
    """A network of any kind in a tank, with its violent branch where that knows the tank. Raises NetworkError."""
    if isinstance(net, Feedback):
        return FeedbackSurrogate(net, tank, viscosity, gas_density)
    if branch is not None and branch.knows(tank):
        return ViolentSurrogate(net, branch, tank, viscosity, gas_density)
    return Surrogate(net, tank, viscosity, gas_density)
