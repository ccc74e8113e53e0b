"""Face of the structure: names, units and state of a 2-DOF section with the forced-then-free protocol."""

from __future__ import annotations

from dataclasses import fields
from typing import Any

import numpy as np

from ..kit.interfaces import frozen_liquid_parameters, motion_outputs, wing_load_inputs
from ..kit.prediction import prediction
from ..kit.slave import Slave, StepError
from ..kit.variables import output, parameter
from .protocol import ForcedPitch, Run
from .section import Array, Section, SectionData

LOADS = ("lift", "moment", "slosh_force_y", "slosh_moment")
INITIAL = ("initial_h", "initial_alpha", "initial_h_dot", "initial_alpha_dot")
FORCED = ("forced_amplitude", "forced_frequency", "forced_cycles", "forced_ramp_cycles")
LIQUID = ("liquid_mass", "liquid_static_moment", "liquid_inertia", "liquid_stiffness")
BODY = ("mass", "static_imbalance", "inertia", "omega_h", "omega_alpha", *LIQUID)
ACCELERATION = (
    *BODY, "damping_ratio_h", "damping_ratio_alpha", *INITIAL, "forced_cycles", "trim_lift", "trim_moment", *LOADS
)  # fmt: skip
# what the motion at the start is made of
STARTS = {
    "h": ("initial_h",),
    "h_dot": ("initial_h_dot",),
    "h_ddot": ACCELERATION,
    "alpha": ("initial_alpha",),
    "alpha_dot": ("initial_alpha_dot", *FORCED),
    "alpha_ddot": ACCELERATION,
}
FREE = "; needs forced_cycles = 0"
DEGREE = 0.017453292519943295


class Structure(Slave):
    """Wing section with plunge and pitch on springs: forced pitch, release, free motion under the loads."""

    stop_time = 0.5
    step_size = 1e-3

    variables = (
        parameter("mass", 57.73, "kg/m", "Mass per metre of span, without liquid", min=1e-9),
        parameter("static_imbalance", 51.957, "kg", "Mass times distance of its centre aft of the elastic axis"),
        parameter("inertia", 50.2251, "kg.m", "Moment of inertia about the elastic axis", min=1e-9),
        parameter("omega_h", 100.0, "rad/s", "Uncoupled plunge frequency, without liquid", min=0.0),
        parameter("omega_alpha", 100.0, "rad/s", "Uncoupled pitch frequency, without liquid", min=0.0),
        parameter("damping_ratio_h", 0.0, "1", "Structural damping ratio of plunge", min=0.0, max=10.0),
        parameter("damping_ratio_alpha", 0.0, "1", "Structural damping ratio of pitch", min=0.0, max=10.0),
        *frozen_liquid_parameters(),
        parameter("forced_amplitude", DEGREE, "rad", "Amplitude of the forced pitch", min=-1.6, max=1.6),
        parameter("forced_frequency", 100.0, "rad/s", "Frequency of the forced pitch", min=1e-9),
        parameter("forced_cycles", 0.0, "1", "Cycles of forced pitch; 0 = free start", min=0.0, max=1e6),
        parameter("forced_ramp_cycles", 1.0, "1", "Cycles in which the amplitude rises", min=0.0, max=1e6),
        parameter("initial_h", 0.0, "m", f"Plunge at the start{FREE}"),
        parameter("initial_alpha", 0.0, "rad", f"Pitch at the start{FREE}", min=-1.6, max=1.6),
        parameter("initial_h_dot", 0.0, "m/s", f"Plunge rate at the start{FREE}"),
        parameter("initial_alpha_dot", 0.0, "rad/s", f"Pitch rate at the start{FREE}"),
        parameter("trim_lift", 0.0, "N/m", "Lift held by the trim, taken off the input lift"),
        parameter("trim_moment", 0.0, "N", "Moment held by the trim, taken off the input moment"),
        prediction("load"),
        *wing_load_inputs(),
        *motion_outputs(STARTS),
        output("released", "", "True from the release on", type=bool, depends=("forced_cycles",)),
        output(
            "energy",
            "J/m",
            "Kinetic and strain energy of the section, frozen liquid included",
            depends=(*BODY, *INITIAL, *FORCED),
        ),
    )

    def prepare(self) -> None:
        """Build the section from the parameters."""
        data = {field.name: getattr(self, field.name) for field in fields(SectionData)}
        self.section = Section(SectionData(**data))
        self.forced = ForcedPitch(self.forced_amplitude, self.forced_frequency, self.forced_cycles, self.forced_ramp_cycles)
        self.initial = np.array([self.initial_h, self.initial_alpha, self.initial_h_dot, self.initial_alpha_dot])
        if self.forced.cycles > 0.0 and self.initial.any():
            raise StepError(
                "initial_h, initial_alpha and their rates have no effect while the pitch is forced. "
                "Remedy: set them to 0, or forced_cycles to 0 for a free start"
            )
        self.run = Run(self.section, self.forced, self.initial, np.zeros(2))

    def initialize(self) -> None:
        """Start the protocol under the loads at the start."""
        self.run = Run(self.section, self.forced, self.initial, self._load())
        self._publish()

    def step(self, time: float, step_size: float) -> None:
        """Advance under loads linear over the step."""
        self.run.advance(step_size, self._load())
        self._publish()

    def save(self) -> dict[str, Any]:
        """Return time, state and loads."""
        run = self.run
        return {
            "t": run.t,
            "y": run.y,
            "load": run.load,
            "released": run.released,
        }

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take them back."""
        run = self.run
        run.t, run.y, run.load, run.released = (snapshot[key] for key in ("t", "y", "load", "released"))

    def _load(self) -> Array:
        return np.array(
            [
                -(self.lift - self.trim_lift) - self.slosh_force_y,  # plunge is positive down
                (self.moment - self.trim_moment) + self.slosh_moment,
            ]
        )

    def _publish(self) -> None:
        run = self.run
        self.h, self.alpha, self.h_dot, self.alpha_dot = map(float, run.y)
        self.h_ddot, self.alpha_ddot = map(float, run.acceleration)
        self.released = run.released
        self.energy = run.section.energy(run.y)
