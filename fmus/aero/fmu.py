"""Face of the aerodynamics: names, units and state of the Euler flow around a moving section."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np

from ..kit.interfaces import aero_outputs, motion_inputs
from ..kit.prediction import prediction
from ..kit.slave import Slave, StepError
from ..kit.variables import input_, output, parameter
from . import vtk
from .airfoil import section, write_csv
from .control import Settings, together
from .field import Motion
from .freestream import Freestream, between
from .march import Flow
from .mesh import o_mesh

SOUND_STEP = 0.8
"""Longest internal step in chords that sound travels."""
FLOW = ("alpha", "mean_alpha", "mach", "airfoil", "cells_around", "cells_normal", "farfield_chords")
"""What the steady flow at the start is made of, without dimensions."""
MOST_PARTS = 10_000
"""Most internal steps of a communication step; 2 ms each on the default mesh."""


class Aero(Slave):
    """Two-dimensional Euler flow around a rigidly moving airfoil (arbitrary Lagrangian-Eulerian), transonic."""

    stop_time = 0.1
    step_size = 1e-3

    variables = (
        parameter("mach", 0.8, "1", "Freestream Mach number", min=0.05, max=0.98),
        parameter("mean_alpha", 0.0, "rad", "Incidence at alpha = 0, positive nose-up", min=-0.35, max=0.35),
        parameter("chord", 1.0, "m", "Chord", min=1e-6),
        parameter("elastic_axis", -0.5, "1", "Elastic axis x/c from the leading edge, positive aft", min=-20.0, max=20.0),
        parameter("static_pressure", 101325.0, "Pa", "Freestream static pressure", min=1e-3),
        parameter("static_temperature", 288.15, "K", "Freestream static temperature", min=1.0),
        parameter("airfoil", "NACA 64A010", "", "NACA 4-, 5-digit or 6A name, or a coordinate file (Selig or Lednicer order)"),
        parameter("cells_around", 168, "", "Cells around the airfoil", min=64, max=4096),
        parameter("cells_normal", 48, "", "Cells from the wall to the outer boundary", min=16, max=1024),
        parameter("farfield_chords", 200.0, "1", "Distance of the outer boundary in chords", min=5.0, max=1000.0),
        parameter("tolerance", 1e-2, "1", "Last subiteration's density change over that of the step", min=1e-8, max=0.5),
        parameter("max_subiterations", 60, "", "Most subiterations a step", min=3, max=1000),
        parameter("max_step", 0.5, "1", "Longest internal step in chords of travel at freestream speed", min=1e-3, max=10.0),
        parameter("field_folder", "", "", "Folder for VTK files, written where write_fields is true (empty: none)"),
        parameter("section_file", "", "", "CSV file that takes file points, contour and mesh surface at the start (empty: none)"),
        prediction("motion"),
        *motion_inputs(),
        input_("write_fields", False, "", "Write mesh, Mach field and surface pressure at the end of this step"),
        *aero_outputs(FLOW, force=("static_pressure", "chord"), arm=("elastic_axis",)),
        output("subiterations", "", "Subiterations of the last step (iterations of the steady flow at the start)", type=int,
               depends=FLOW),
        output("residual", "1", "Last subiteration's density change over that of the step", depends=FLOW),
        output("converged", "", "Whether the last step, all of its internal ones, met the tolerance", type=bool, depends=FLOW),
        output("refactorings", "", "Linearisations since the start", type=int, depends=FLOW),
        output("retries", "", "Repetitions of the last step with smaller pseudo-steps", type=int, depends=FLOW),
        output("airfoil_summary", "", "The section, and what was done to its file: points, base, thickness, camber",
               type=str, depends=("airfoil",)),
    )  # fmt: skip

    def prepare(self) -> None:
        """Mesh and stream from the parameters."""
        self.section = section(self.airfoil)
        mesh = o_mesh(self.section, self.cells_around, self.cells_normal, self.farfield_chords)
        settings = Settings(tolerance=self.tolerance, max_subiterations=self.max_subiterations)
        self.flow = Flow(mesh, self.mach, self.elastic_axis, settings)
        self.stream = Freestream(self.mach, self.static_pressure, self.static_temperature, self.chord)
        self.steady: dict[str, Any] | None = None

    def initialize(self) -> None:
        """Steady flow at the initial pitch; the rates act from the first step on."""
        incidence = self.mean_alpha + self.alpha
        if self.steady is None or self.steady["incidence"] != incidence:
            report = self.flow.solve_steady(incidence)
            self.steady, self.steady_report = self.flow.save(), report
        self.flow.restore(self.steady)
        self.steps = 0
        self.airfoil_summary = self.section.summary
        if self.section_file:
            write_csv(Path(self.section_file), self.section, self.flow.mesh.node[0])
        self.motion = self._motion()
        self._publish(self.steady_report)

    def step(self, time: float, step_size: float) -> None:
        """March to the motion at the end of the step, in internal steps of at most max_step chords of travel.

        At low speed the way of sound counts: the subiterations stall on longer steps.
        """
        start, end = self.motion, self._motion()
        stream = self.stream
        travel = max(step_size * stream.speed / self.max_step, step_size * stream.sound_speed / SOUND_STEP) / self.chord
        if not travel < MOST_PARTS:
            raise StepError(
                f"a communication step of {step_size:g} s takes {travel:.3g} internal steps, at most {MOST_PARTS} are made. "
                "Remedy: shorter communication steps"
            )
        parts = max(1, math.ceil(travel - 1e-9))
        dt = stream.scaled_time(step_size / parts)
        reports = []
        for part in range(1, parts + 1):
            motion = end if part == parts else between(start, end, step_size, part / parts)
            reports.append(self.flow.step(stream.scaled_motion(motion), self.mean_alpha + motion.alpha, dt))
        self.motion = end
        self.steps += 1
        self._publish(together(reports))
        if self.write_fields:
            if not self.field_folder:
                raise StepError("write_fields is true but field_folder is empty. Remedy: set field_folder to a folder")
            vtk.write(Path(self.field_folder), self.steps, self.flow, self.chord, self.h)

    def rehearse(self) -> None:
        """Call the kernels that a start and a first step do not."""
        self.flow.evaluate(np.float32)

    def save(self) -> dict[str, Any]:
        """Flow, motion at its time and the number of steps."""
        return {"flow": self.flow.save(), "motion": list(self.motion), "steps": self.steps}

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take them back."""
        self.flow.restore(snapshot["flow"])
        self.motion, self.steps = Motion(*snapshot["motion"]), snapshot["steps"]

    def _motion(self) -> Motion:
        return Motion(self.h, self.h_dot, self.h_ddot, self.alpha, self.alpha_dot, self.alpha_ddot)

    def _publish(self, report: Any) -> None:
        lift, drag, moment = (float(value) for value in self.flow.coefficients)
        self.C_L, self.C_D, self.C_M = lift, drag, moment
        force = self.stream.dynamic_pressure * self.chord
        self.lift, self.moment = force * lift, force * self.chord * moment
        self.subiterations, self.residual = report.subiterations, report.residual
        self.converged, self.retries = report.converged, report.retries
        self.refactorings = self.flow.refactorings
