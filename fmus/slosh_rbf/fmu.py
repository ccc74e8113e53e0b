"""Face of the surrogate: names, units and state of a network in a tank."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.failure import StepError
from ..kit.interfaces import (
    ACCELERATED,
    GRAVITY_OF,
    MASS_OF,
    MOTION,
    PLACE,
    SURGE,
    motion_inputs,
    slosh_outputs,
    surge_inputs,
    tank_parameters,
)  # fmt: skip
from ..kit.prediction import prediction
from ..kit.slave import Slave
from ..kit.variables import output, parameter
from ..tank import plausible
from ..tank.friction import Friction
from ..tank.frozen import Load, constants, residual_load
from ..tank.liquid import Tank
from ..tank.motion import SectionMotion
from .feedback import Feedback
from .feedback_tank import in_tank, read
from .memory import Array
from .network import Network, NetworkError, untrained
from .surrogate import Answer, State
from .violent_network import Violent
from .violent_network import load as read_branch

INPUTS = (*MOTION, *SURGE)
SHAPE = ("alpha", "tank_length", "tank_height", "fill_level")
"""Of tank and surface at the start."""
EQUATIONS = {"ems": False, "bilinear": True}
"""Networks without weights: the base alone, linear or with products of gravity's change."""
POINTWISE, MEAN, OUTSIDE = "pointwise loads", "conditional mean", "outside"


class SloshRbf(Slave):
    """Slosh of a rectangular tank by a radial-basis-function network on the memory of linear waves, trained on two-phase flow."""

    stop_time = 2.0
    step_size = 2e-3

    variables = (
        *tank_parameters(),
        parameter("network", "default", "", "Trained network in the FMU's resources, or bilinear or ems: equations alone"),
        prediction("motion"),
        *motion_inputs(),
        *surge_inputs(),
        *slosh_outputs((*ACCELERATED, *MASS_OF, *PLACE, "gravity", "gas_density", "network"), gas=True),
        output("extrapolation", "1", "Distance to the training data: 0 inside, 1 at their edge, above: outside",
               depends=(*SHAPE, "network")),
        output("validity", "1", "Largest so far: to 1 loads hold pointwise, to validity_edge on average; above it fails",
               depends=(*SHAPE, "network", "gravity", "liquid_viscosity")),
        output("validity_edge", "1", "Up to where the work of the loads holds: 2 with a violent branch, else 1",
               depends=("network",)),
        output("meaning", "", "What the loads are by validity: pointwise loads, conditional mean, outside", type=str,
               depends=("network", *SHAPE, "liquid_viscosity", "gravity")),
        output("force_y_deviation", "N/m", "Standard deviation of force_y about the conditional mean that is told",
               quantity="ForcePerLength"),
        output("unevenness", "1", "Largest |g_n/g - 1| + (l/2)|alpha''|/g since the start: towards 1.5 surfaces break",
               depends=(*GRAVITY_OF, "tank_length")),
        output("wave_growth", "1", "Logarithm of the growth of waves that gravity's changes feed (Faraday)"),
        output("effective_gravity", "m/s2", "Gravity less acceleration at the liquid's centre, along the tank's vertical",
               quantity="Acceleration", depends=GRAVITY_OF),
        output("wave_height_west", "m", "Surface above its level at rest at the fore wall, linear waves", quantity="Length",
               depends=("alpha", "tank_length")),
        output("wave_height_east", "m", "Surface above its level at rest at the aft wall, linear waves", quantity="Length",
               depends=("alpha", "tank_length")),
    )  # fmt: skip

    def prepare(self) -> None:
        """Tank, network and waves from the parameters."""
        plausible.check(self.__dict__)
        self.tank = Tank(
            self.tank_length, self.tank_height, self.tank_width, self.fill_level, self.tank_x, self.tank_y,
            self.liquid_density, self.gravity,
        )  # fmt: skip
        try:
            self.model = in_tank(self._network(), self.tank, self.liquid_viscosity, self.gas_density, self._branch())
        except NetworkError as error:
            raise StepError(str(error)) from error
        # trained on water in motions far above the first wave's frequency: what a viscous liquid does there is known beforehand
        self.friction = Friction(self.tank, self.liquid_viscosity).far_above

    def initialize(self) -> None:
        """Level surface at the initial tilt, liquid moving with the tank."""
        rest = constants(self.tank)
        gas = self.tank.mass * self.model.body.gas_mass
        rest["static_force_y"] -= gas * self.gravity
        rest["static_moment"] += gas * self.gravity * self.tank.x
        self.__dict__.update(rest)
        self.motion = self._motion()
        self.state, self.worst = self.model.start(self.motion), 0.0
        self._publish()

    def step(self, time: float, step_size: float) -> None:
        """Advance along the course between the motions at both ends of the step."""
        end = self._motion()
        try:
            self.state = self.model.advance(self.state, self.motion, end, step_size)
        except NetworkError as error:
            raise StepError(str(error)) from error
        self.motion = end
        self._publish()

    def save(self) -> dict[str, Any]:
        """Memory, waves of the gate, answer, delayed values, memory of the violent branch, motion, largest validity."""
        state = self.state
        kept = {"w": state.w, "waves": state.waves, "answer": list(state.answer), "lags": state.lags, "thrown": state.thrown}
        return kept | {"motion": self.motion, "worst": self.worst}

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take them back."""
        self.state = State(snapshot["w"], snapshot["waves"], Answer(*snapshot["answer"]), snapshot["lags"], snapshot["thrown"])
        self.motion, self.worst = snapshot["motion"], snapshot["worst"]

    def _network(self) -> Network | Feedback:
        if self.network in EQUATIONS:
            return untrained(self.network, EQUATIONS[self.network])
        known = {path.stem: path for path in sorted((self.folder / "weights").glob("*.npz"))}
        if self.network not in known:
            raise StepError(f"there is no network '{self.network}'. Remedy: one of {', '.join([*known, *EQUATIONS])}")
        return read(known[self.network])

    def _branch(self) -> Violent | None:
        """The violent branch that belongs to the network, if there is one: weights/branches/<network>.npz."""
        path = self.folder / "weights" / "branches" / f"{self.network}.npz"
        return read_branch(path) if self.network not in EQUATIONS and path.is_file() else None

    def _motion(self) -> Array:
        return np.array([getattr(self, name) for name in INPUTS])

    def _publish(self) -> None:
        answer, motion = self.state.answer, SectionMotion(*self.motion.tolist())
        whole = Load(answer.force_x, answer.force_y, answer.moment)
        self.force_x, self.force_y, self.moment = whole
        # the structure carries no gas: its weight is static load, its inertia stays in the residual
        weight = self.tank.mass * self.model.body.gas_mass * self.gravity
        liquid = Load(whole.force_x, whole.force_y + weight, whole.moment - weight * self.tank.x)
        self.force_x_residual, self.force_y_residual, self.moment_residual = residual_load(liquid, self.tank, motion)
        self.extrapolation, self.unevenness, self.wave_growth = answer.extrapolation, answer.uneven, answer.growth
        edge = self.model.edge
        # a liquid too viscous for its training is outside whatever the surface does
        self.worst = max(self.worst, answer.validity, self.friction if self.friction <= 1.0 else self.friction + edge - 1.0)
        self.validity, self.validity_edge, self.force_y_deviation = self.worst, edge, answer.deviation
        self.meaning = POINTWISE if self.worst <= 1.0 else MEAN if self.worst <= edge else OUTSIDE
        self.effective_gravity = self.model.effective_gravity(self.motion)
        self.wave_height_east = self.model.wave_height(self.state.w)
        self.wave_height_west = -self.wave_height_east
