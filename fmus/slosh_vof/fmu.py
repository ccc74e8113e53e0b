"""Face of the two-phase flow in a moving tank: names, units and state."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from ..kit.interfaces import (
    ACCELERATED,
    MOTION,
    PLACE,
    SURGE,
    motion_inputs,
    slosh_outputs,
    surge_inputs,
    tank_parameters,
)  # fmt: skip
from ..kit.prediction import prediction
from ..kit.slave import Slave, StepError
from ..kit.variables import Variable, input_, output, parameter
from ..tank import faraday, plausible
from ..tank.frozen import Load, constants, power, residual_load
from ..tank.liquid import Tank, TankError
from ..tank.motion import SectionMotion
from . import instruments, vtk
from .flow import Flow, FlowError, Fluids, Numerics, StepReport
from .grid import Baffles, Grid, GridError
from .ribs import RibError, parse
from .shape import Shape, ShapeError, fractions

INPUTS = (*MOTION, *SURGE)
LIMITS = {"h": 1e9, "h_dot": 1e6, "h_ddot": 1e5, "alpha": 1e6, "alpha_dot": 1e3, "alpha_ddot": 1e6,
          "x": 1e9, "x_dot": 1e6, "x_ddot": 1e5}  # fmt: skip
"""Largest magnitudes of the inputs: no tank survives more. As ranges of the face, so that a good value cures a bad one."""


GRID = ("cells_x", "cells_y", "baffle_count", "baffle_bottom", "baffle_top", "ribs")
SHAPE = ("initial_wave", "initial_spectrum", "initial_seed", "initial_column", "initial_file")
SOLVED = (*ACCELERATED, "tank_length", "tank_height", "fill_level", *PLACE, "liquid_density", "gas_density", "gravity",
          "surface_tension", *SHAPE, *GRID, "max_step", "tolerance")  # fmt: skip
"""What the pressure at the start is made of."""
SURFACE = ("alpha", *SHAPE, "cells_x", "tank_length", "tank_height", "fill_level", "ribs")
"""What the surface at the walls is made of at the start."""
THINNEST_GAS = 100.0
"""Least pressure of gas that can be compressed [Pa]: below it a unit was mistaken."""


def _force(name: str, text: str) -> Variable:
    return output(name, "N/m", text, quantity="ForcePerLength", depends=(*SOLVED, "tank_width"))


class SloshVof(Slave):
    """Two-phase flow (volume of fluid) in a rectangular tank, with baffles and ribs if wanted, that moves with a wing section."""

    stop_time = 2.0
    step_size = 2e-3

    variables = (
        *tank_parameters(),
        parameter("cells_x", 100, "", "Cells along the tank", min=16, max=2048),
        parameter("cells_y", 30, "", "Cells over the tank's height", min=16, max=2048),
        parameter("cfl", Numerics.cfl, "1", "Largest Courant number of an internal step", min=0.01, max=0.5),
        parameter("tolerance", Numerics.tolerance, "1", "Largest divergence left, times the internal step", min=1e-12, max=1e-2),
        parameter("max_step", Numerics.max_step, "s", "Longest internal step", min=1e-7, max=1.0),
        parameter("wall_slip", False, "", "Walls without friction; baffles have none in either case"),
        parameter("wall_layer", False, "", "Friction of the laminar layer where cells are too thick to hold it"),
        parameter("side_wall_omega", 0.0, "rad/s", "Angular frequency of the laminar friction on front and back wall, tank_width "
                  "apart; 0 = no friction there", min=0.0, max=1e4, quantity="AngularVelocity"),
        parameter("surface_tension", 0.0, "N/m", "Surface tension", min=0.0, max=1e3, quantity="SurfaceTension"),
        parameter("gas_pressure", 0.0, "Pa", "Absolute pressure of the gas at the start (its mean), from which it is compressed; "
                  "0 = gas that cannot be compressed", min=0.0, max=1e7, quantity="Pressure"),
        parameter("gas_gamma", Fluids.gas_gamma, "1", "Exponent of its pressure over its density: ratio of specific heats; "
                  "1 = isothermal", min=1.0, max=2.0),
        parameter("initial_wave", 0.0, "m", "Amplitude of the first standing wave at the start, crest at the west (fore) wall"),
        parameter("initial_column", 0.0, "m", "Width of a column at the west (fore) wall that holds all liquid; 0 = none",
                  min=0.0, quantity="Length"),
        parameter("initial_spectrum", 0.0, "m", "Largest rise of random standing waves at the start", min=0.0, quantity="Length"),
        parameter("initial_seed", 0, "", "Seed of these waves", min=0, max=1_000_000_000),
        parameter("initial_file", "", "", "CSV file of the surface: x from the west wall, height above the floor [m]"),
        parameter("baffle_count", 0, "", "Thin vertical baffles at equal distances", min=0, max=16),
        parameter("baffle_bottom", Baffles.bottom, "1", "Their foot over the tank's height", min=0.0, max=1.0),
        parameter("baffle_top", Baffles.top, "1", "Their tip over the tank's height", min=0.0, max=1.0),
        parameter("ribs", "", "", "Ribs: 'x=0.10 open=0.00:0.02,0.13:0.15; x=-0.1', x [m] aft of the tank's centre, "
                  "openings [m] above the floor; without openings: compartments"),
        parameter("field_folder", "", "", "Folder for VTK files, written where write_fields is true (empty: none)"),
        *instruments.parameters(),
        prediction("motion"),
        *motion_inputs(LIMITS),
        *surge_inputs(LIMITS),
        input_("write_fields", False, "", "Write the fields at the end of this step (or at the start)"),
        *slosh_outputs((*SOLVED, "tank_width"), gas=True),
        _force("force_x_tank", "Whole force along the tank, aft"),
        _force("force_y_tank", "Whole force along the tank's height, up"),
        _force("force_west", "Force of pressure on the west (fore) wall, along the tank, aft"),
        _force("force_east", "Force of pressure on the east (aft) wall, along the tank, aft"),
        output("liquid_volume", "m3", "Volume of the liquid", quantity="Volume",
               depends=("fill_level", "tank_height", "tank_length", "tank_width")),
        output("wave_height_west", "m", "Liquid column at the west (fore) wall above the still level, tank axes",
               quantity="Length", depends=SURFACE),
        output("wave_height_east", "m", "Liquid column at the east (aft) wall above the still level, tank axes",
               quantity="Length", depends=SURFACE),
        *instruments.outputs(SOLVED, SURFACE),
        output("work", "J/m", "Work of liquid and gas on the tank since the start; negative: taken out of its motion",
               quantity="EnergyPerLength"),
        output("wave_growth", "1", "Logarithm of the growth of waves that gravity's changes feed (Faraday), by linear theory"),
        output("time_step", "s", "Last internal step (0 at the start)", quantity="Time"),
        output("steps", "", "Internal steps of the last communication step", type=int),
        output("iterations", "", "Iterations of the pressure in them", type=int, depends=SOLVED),
        output("residual", "1", "Worst divergence left in them, over the tolerance's limit", depends=SOLVED),
        output("converged", "", "Whether all of them met the tolerance", type=bool, depends=SOLVED),
    )  # fmt: skip

    def prepare(self) -> None:
        """Tank, grid and arrays from the parameters."""
        plausible.check(self.__dict__)
        if not self.gas_density > 0.0:
            raise StepError(
                "gas_density = 0 kg/m3, but the gas moves too. Remedy: above 0; 1e-4 of the liquid's is as good as none"
            )
        if 0.0 < self.gas_pressure < THINNEST_GAS:
            raise StepError(
                f"gas_pressure = {self.gas_pressure:g} Pa is hardly any gas. Remedy: its absolute pressure in Pa, 101325 at "
                f"sea level ({self.gas_pressure:g} bar are {1e5 * self.gas_pressure:g} Pa), at least {THINNEST_GAS:g}; "
                "0 for gas that cannot be compressed"
            )
        try:
            self.tank = Tank(
                self.tank_length, self.tank_height, self.tank_width, self.fill_level, self.tank_x, self.tank_y,
                self.liquid_density, self.gravity,
            )  # fmt: skip
            baffles = Baffles(self.baffle_count, self.baffle_bottom, self.baffle_top)
            grid = Grid(self.tank, self.cells_x, self.cells_y, baffles, parse(self.ribs))
            fluids = Fluids(
                self.gas_density, self.liquid_viscosity, self.gas_viscosity, self.surface_tension, self.gas_pressure,
                self.gas_gamma,
            )  # fmt: skip
            numerics = Numerics(
                self.cfl, self.tolerance, self.max_step, wall_slip=self.wall_slip, wall_layer=self.wall_layer,
                side_wall_omega=self.side_wall_omega,
            )  # fmt: skip
            self.flow = Flow(grid, fluids, numerics, instruments.probes(self.__dict__), self.probe_window)
        except (TankError, GridError, RibError, FlowError) as error:
            raise StepError(str(error)) from error
        lengths = sorted({(last - first) * grid.dx if len(grid.rooms) > 1 else self.tank_length for first, last in grid.rooms})
        self.faraday = [faraday.waves(replace(self.tank, length=length), self.liquid_viscosity) for length in lengths]
        self.instrumented = self.probe_count + self.gauge_count > 0
        weight = self.gas_density * (self.tank_height - self.tank.depth) * self.tank_length * self.tank_width * self.gravity
        self.gas = Load(0.0, -weight, weight * self.tank_x)  # at rest

    def initialize(self) -> None:
        """Level surface at the initial tilt, or the shape asked for, at rest in the tank; accelerations act at once."""
        self.motion, self.count = self._motion(), 0
        rest = constants(self.tank)
        rest["static_force_y"] += self.gas.force_y
        rest["static_moment"] += self.gas.moment
        self.__dict__.update(rest)
        self.__dict__.update(instruments.UNUSED)
        shape = Shape(self.initial_wave, self.initial_spectrum, self.initial_seed, self.initial_column, self.initial_file)
        try:
            level = fractions(shape, self.flow.grid, self.motion.alpha)
        except ShapeError as error:
            raise StepError(str(error)) from error
        self._publish(self.flow.start_from(level, self.motion))
        self.work, self.power = 0.0, power(self._load, self.motion)
        self.wave_growth, self.waves = 0.0, np.stack([faraday.still() for _ in self.faraday])
        self._write(self.time)

    def step(self, time: float, step_size: float) -> None:
        """Advance along the course between the motions at both ends of the step."""
        end = self._motion()
        try:
            report = self.flow.advance(self.motion, end, step_size)
        except FlowError as error:
            raise StepError(str(error)) from error
        before, after = (faraday.gravity_change(self.tank, motion) for motion in (self.motion, end))
        pairs = zip(self.waves, self.faraday, strict=True)
        self.wave_growth = max(float(faraday.grow(grown, before, after, step_size, waves)) for grown, waves in pairs)
        self.motion, self.count = end, self.count + 1
        self._publish(report)
        before, self.power = self.power, power(self._load, self.motion)
        self.work += 0.5 * step_size * (before + self.power)
        self._write(time + step_size)

    def save(self) -> dict[str, Any]:
        """Flow, motion at its time and the number of communication steps."""
        return {"flow": self.flow.save(), "motion": list(self.motion), "count": self.count, "power": self.power,
                "waves": self.waves.copy()}  # fmt: skip

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take them back."""
        self.flow.restore(snapshot["flow"])
        self.motion, self.count = SectionMotion(*snapshot["motion"]), snapshot["count"]
        self.power, self.waves = snapshot["power"], snapshot["waves"].copy()

    @property
    def _load(self) -> Load:
        return Load(self.force_x, self.force_y, self.moment)

    def _motion(self) -> SectionMotion:
        return SectionMotion(*(getattr(self, name) for name in INPUTS))

    def _publish(self, report: StepReport) -> None:
        flow, loads = self.flow, self.flow.loads(self.motion)
        self.__dict__.update(loads._asdict())
        # the structure carries no gas: its weight is static load, its inertia stays in the residual
        liquid = Load(loads.force_x, loads.force_y - self.gas.force_y, loads.moment - self.gas.moment)
        self.force_x_residual, self.force_y_residual, self.moment_residual = residual_load(liquid, self.tank, self.motion)
        self.liquid_volume = flow.volume
        self.wave_height_west, self.wave_height_east = flow.wave_heights
        if self.instrumented:
            self.__dict__.update(instruments.readings(self.__dict__, flow))
        self.time_step, self.steps, self.iterations = report.step_size, report.steps, report.iterations
        self.residual, self.converged = report.residual, bool(report.converged)

    def _write(self, time: float) -> None:
        if self.write_fields:
            if not self.field_folder:
                raise StepError("write_fields is true but field_folder is empty. Remedy: set field_folder to a folder")
            vtk.write(Path(self.field_folder), self.count, self.flow, self.motion, time)
