"""Face of the equivalent mechanical system: names, units and state of linear slosh in a rectangular tank."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.interfaces import (
    ACCELERATED,
    GRAVITY_OF,
    MASS_OF,
    MOTION,
    PLACE,
    SLOSH,
    SURGE,
    motion_inputs,
    slosh_outputs,
    surge_inputs,
    tank_parameters,
)  # fmt: skip
from ..kit.prediction import prediction
from ..kit.slave import Slave
from ..kit.variables import choice, output, parameter
from ..tank import plausible
from ..tank.friction import Friction, Seen
from ..tank.frozen import constants, residual_load
from ..tank.liquid import Tank
from ..tank.modes import modes, stokes_damping, wave_frequencies
from ..tank.motion import SectionMotion, course
from ..tank.oscillators import LARGEST_DAMPING, Array
from .linear import LinearSlosh
from .parametric import ParametricSlosh
from .validity import WAVES, Gate

LIMITS = {
    "high": "They stay behind when the tank moves sideways: right far above their frequencies",
    "low": "They move with the tank: right far below their frequencies",
}
INPUTS = (*MOTION, *SURGE)
LOADS = (*ACCELERATED, *MASS_OF, *PLACE, "gravity", "modes", "parametric")
"""What the loads at the start are made of; force_y of all modes, the others also of what those left out do."""


class SloshEms(Slave):
    """Linear slosh of a rectangular tank as modal masses on springs, with what tells where linear slosh ends."""

    stop_time = 10.0
    step_size = 1e-2

    variables = (
        *tank_parameters(),
        parameter("modes", 100, "", "Modes that slosh", min=1, max=400),
        parameter("damping_ratio", 0.0, "1", "Damping ratio of every mode; 0 = from liquid_viscosity, laminar", min=0.0,
                  max=LARGEST_DAMPING),
        choice("limit", "low", LIMITS, "What the modes left out do"),
        parameter("parametric", False, "", "Gravity of the moment and finite angles (parametric slosh) instead of linear slosh"),
        prediction("motion"),
        *motion_inputs(),
        *surge_inputs(),
        *slosh_outputs(LOADS, more={name: ("limit",) for name in SLOSH if name != "force_y"}),
        output("effective_gravity", "m/s2", "Gravity less acceleration at the liquid's centre, along the tank's vertical",
               quantity="Acceleration", depends=GRAVITY_OF),
        output("wave_height_west", "m", "Surface above its level at rest at the fore wall, tank axes", quantity="Length",
               depends=("alpha", "tank_length")),
        output("wave_height_east", "m", "Surface above its level at rest at the aft wall, tank axes", quantity="Length",
               depends=("alpha", "tank_length")),
        output("wave_energy", "J/m", "Energy of the waves, kinetic in tank axes and potential above the level surface",
               depends=("alpha", *MASS_OF, "gravity", "modes", "parametric", "damping_ratio", "liquid_viscosity")),
        output("validity", "1", "Largest since the start: 0 fine, 1 at the edge of linear slosh, above: it does not hold",
               depends=("alpha", "tank_length", "tank_height", "fill_level")),
        output("parametric_resonance", "1", "Above 1 the changing gravity makes a wave grow (principal resonance)"),
    )  # fmt: skip

    def prepare(self) -> None:
        """Tank, modes and propagators from the parameters."""
        plausible.check(self.__dict__)
        self.tank = Tank(
            self.tank_length, self.tank_height, self.tank_width, self.fill_level, self.tank_x, self.tank_y,
            self.liquid_density, self.gravity,
        )  # fmt: skip
        parameters = modes(self.tank, self.modes, tuple(LIMITS)[self.limit])
        model = ParametricSlosh if self.parametric else LinearSlosh
        self.slosh = model(self.tank, parameters, self._damping(parameters.omega, np.arange(1.0, 2.0 * self.modes, 2.0)))
        waves = np.arange(1.0, WAVES + 1.0)
        omega = wave_frequencies(self.tank, waves)
        self.gate = Gate(self.tank, self.parametric, omega, self._damping(omega, waves))
        self.friction = Friction(self.tank, self.liquid_viscosity, self.damping_ratio)

    def initialize(self) -> None:
        """Level surface at the initial tilt, liquid moving with the tank."""
        self.__dict__.update(constants(self.tank))
        self.motion = self._motion()
        self.w, self.beat, self.worst = self.slosh.start(self.motion), self.gate.start(), 0.0
        self.layers = self.friction.start(self.motion)
        self._publish()

    def step(self, time: float, step_size: float) -> None:
        """Advance along the course between the motions at both ends of the step."""
        end = self._motion()
        path = course(self.motion, end, step_size)
        self.w = self.slosh.advance(self.w, path, step_size)
        self.beat = self.gate.advance(self.beat, path, step_size)
        self.layers = self.friction.advance(self.layers, path, end, step_size)
        self.motion = end
        self._publish()

    def save(self) -> dict[str, Any]:
        """Amplitudes of modes and watched waves, what friction was seen to do, motion, largest validity."""
        kept = {"w": self.w, "beat": self.beat, "layers": list(self.layers)}
        return kept | {"motion": list(self.motion), "worst": self.worst}

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take them back."""
        self.w, self.beat, self.worst = snapshot["w"], snapshot["beat"], snapshot["worst"]
        self.layers, self.motion = Seen(*snapshot["layers"]), SectionMotion(*snapshot["motion"])

    def _motion(self) -> SectionMotion:
        return SectionMotion(
            self.h, self.h_dot, self.h_ddot, self.alpha, self.alpha_dot, self.alpha_ddot, self.x, self.x_dot, self.x_ddot
        )

    def _damping(self, omega: Array, halves: Array) -> Array:
        if self.damping_ratio > 0.0:
            return np.full_like(omega, self.damping_ratio)
        # the laminar formula ends where the layers are no longer thin
        return np.minimum(stokes_damping(self.tank, omega, self.liquid_viscosity, halves), LARGEST_DAMPING)

    def _publish(self) -> None:
        motion, load = self.motion, self.slosh.load(self.w, self.motion)
        self.force_x, self.force_y, self.moment = load
        self.force_x_residual, self.force_y_residual, self.moment_residual = residual_load(load, self.tank, motion)
        self.effective_gravity = self.gate.effective_gravity(motion)
        self.wave_height_east = self.slosh.wave_height(self.w, motion)
        self.wave_height_west = -self.wave_height_east
        self.wave_energy = self.slosh.energy(self.w, motion)
        moved = self.gate.measure(motion, self.wave_height_east)
        self.worst = max(self.worst, moved, self.friction.number(self.layers))
        self.validity = self.worst
        self.parametric_resonance = float(np.abs(self.beat).max())
