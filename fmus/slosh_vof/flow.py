"""Two-phase flow in one moving tank: start, advance, loads, state. Metres, seconds, radians, newtons."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..tank.motion import SectionMotion, course
from . import cushion, probes, side_walls, step
from . import loads as wall
from .grid import Grid
from .multigrid import plan
from .partition import partition
from .plic import fill_ghosts, reconstruct, surface
from .surface import flat, from_heights
from .wall_layer import memory

Array = NDArray[np.float64]


class FlowError(RuntimeError):
    """The flow could not be advanced; the text says where, why and the remedy."""


@dataclass(frozen=True)
class Fluids:
    """Densities [kg/m3], kinematic viscosities [m2/s], surface tension [N/m]; the liquid's density is the tank's.

    gas_pressure [Pa]: absolute, the mean over the gas at the start, from which it is compressed by pressure ~ density^gas_gamma
    (`cushion`); 0: it cannot be compressed.
    """

    gas_density: float = 1.2
    liquid_viscosity: float = 1e-6
    gas_viscosity: float = 1.48e-5
    surface_tension: float = 0.0
    gas_pressure: float = 0.0
    gas_gamma: float = 1.4


@dataclass(frozen=True)
class Numerics:
    """cfl: largest Courant number of a step (at most 1/2); tolerance: largest divergence left, times the step; max_step [s].

    wall_slip: no friction on walls; wall_layer: friction of the laminar layer where cells are too thick for it (`wall_layer`);
    side_wall_omega [rad/s]: angular frequency of the friction on the front and the back wall (`side_walls`), 0 for none.
    """

    cfl: float = 0.5
    tolerance: float = 1e-7
    max_step: float = 5e-3
    max_iterations: int = 200
    wall_slip: bool = False
    wall_layer: bool = False
    side_wall_omega: float = 0.0


class Loads(NamedTuple):
    """Whole loads on the tank, weight included, for its width: inertial axes, tank axes [N], per wall; moment about EA [N m]."""

    force_x: float
    force_y: float
    moment: float
    force_x_tank: float
    force_y_tank: float
    force_west: float
    force_east: float


class StepReport(NamedTuple):
    """What a communication step took: time steps, their last length [s], pressure iterations, whether all converged, residual."""

    steps: int
    step_size: float
    iterations: int
    converged: bool
    residual: float


class Flow:
    """Volume fractions, velocities and pressure of a tank that moves with a wing section."""

    def __init__(self, grid: Grid, fluids: Fluids = Fluids(), numerics: Numerics = Numerics(),
                 sensors: tuple[probes.Probe, ...] = (), window: float = 0.0) -> None:  # fmt: skip
        """Set up the arrays. sensors: pressure probes, their time mean over `window` [s] (`probes`; its ValueError)."""
        tank = grid.tank
        self.grid, self.fluids, self.numerics = grid, fluids, numerics
        sides = [
            side_walls.rate(nu, numerics.side_wall_omega, tank.width) for nu in (fluids.liquid_viscosity, fluids.gas_viscosity)
        ]
        longest = _longest_step(grid, fluids, numerics, max(sides))
        self.numbers = step.Numbers(
            grid.nx, grid.ny, grid.dx, grid.dy, tank.density, fluids.gas_density, fluids.liquid_viscosity, fluids.gas_viscosity,
            fluids.surface_tension, tank.gravity, numerics.cfl, numerics.tolerance, longest, numerics.max_iterations,
            numerics.wall_slip,
            numerics.wall_layer and not numerics.wall_slip and fluids.liquid_viscosity > 0.0)  # fmt: skip
        self.sides = side_walls.Sides(tank.density * sides[0], fluids.gas_density * sides[1]) if max(sides) > 0.0 else None
        levels, length = plan(grid.nx, grid.ny, grid.dx, grid.dy)
        self.places = step.Places(grid.x, grid.y, grid.open_x, grid.open_y, levels)
        self.plates = np.array(grid.plates, dtype=np.int64).reshape(-1, 3)
        self.ribs = partition(grid)
        self.gas = cushion.cushion(grid, fluids.gas_pressure, fluids.gas_gamma, fluids.gas_density)
        self.state = np.zeros((step.STATE_ROWS + (self.gas is not None), grid.size))
        self.work = np.zeros((step.WORK_ROWS, grid.size))
        self.coarse = np.zeros((7 + (self.gas is not None), length), dtype=np.float32)
        self.surface = surface(grid.nx, grid.ny)
        self.layers = memory(grid.nx, grid.ny)
        self.notes = np.zeros(step.NOTES)
        self.frame = np.zeros(5)
        self.watch = probes.watch(grid, sensors, window)
        self.shared = False

    def start(self, motion: SectionMotion, wave: float = 0.0) -> StepReport:
        """Liquid at rest in the tank's frame, its surface level in inertial axes, plus the first standing wave.

        wave [m]: its amplitude, crest at the west wall. Accelerations of `motion` act at once, rates do not move the liquid
        relative to the tank.
        """
        grid = self.grid
        if wave:
            fractions = from_heights(grid, lambda x: wave * np.cos(np.pi * x / grid.tank.length), motion.alpha, settled=True)
        else:
            fractions = flat(grid, motion.alpha)
        return self.start_from(fractions, motion)

    def start_from(self, fractions: Array, motion: SectionMotion) -> StepReport:
        """Start at rest from volume fractions, shape (ny, nx)."""
        n, work = self.numbers, self.work
        self.state = np.zeros_like(self.state)
        self.work[:] = 0.0
        self.layers[:] = 0.0
        self.shared = False
        c = self.state[step.C]
        self.grid.inner(c)[:] = fractions
        fill_ghosts(c, n.nx, n.ny)
        reconstruct(c, n.nx, n.ny, self.surface, self.ribs)
        work[step.OLD_RHO] = n.gas_density + (n.liquid_density - n.gas_density) * c
        step.frame_force(course(motion, motion, 1.0), 1.0, n.gravity, self.frame)
        iterations, residual = step.accelerate(
            self.state, work, self.coarse, self.surface, self.layers, self.frame, self.places, n, n.max_step,
            min(1e-3 * n.tolerance, 1e-9), self.sides, self.ribs)  # fmt: skip
        q = self.state[step.Q]
        for row, face, width, ahead in ((step.AX, step.KX, n.dy, 1), (step.AY, step.KY, n.dx, self.grid.stride)):
            self.state[row, :-ahead] -= work[face, :-ahead] * (q[ahead:] - q[:-ahead]) / width
        if self.gas is not None:
            cushion.charge(self.state[step.GAS], q, self.state[step.C], self.grid, self.gas, n.liquid_density)
        self.state[step.Q_BEFORE] = self.state[step.Q]
        self.notes[:] = 0.0
        self.watch.rings[:] = 0.0
        if self.watch.cells.size:
            probes.sample(
                self.watch, self.state, self.surface, work[step.RHO], self.frame, *self.places[:4], n, 0.0)  # fmt: skip
        return StepReport(0, 0.0, iterations, residual <= 1.0, residual)

    def advance(self, start: SectionMotion, end: SectionMotion, duration: float) -> StepReport:
        """March from one motion to another over `duration` [s]. Raises FlowError where the flow cannot be advanced."""
        if duration < step.SMALLEST_STEP:
            raise FlowError(f"a communication step of {duration:g} s. Remedy: at least {step.SMALLEST_STEP:g} s")
        if duration > step.MOST_STEPS * self.numbers.max_step:  # said at once, not after as many steps
            raise FlowError(_WORDS[step.TOO_MANY])
        if self.shared:  # a snapshot holds these arrays
            self.state, self.shared = self.state.copy(), False
        table = course(start, end, duration)
        outcome = step.advance(
            self.state, self.work, self.coarse, self.surface, self.layers, self.notes, table, duration, self.places,
            self.numbers, self.sides, self.watch if self.watch.cells.size else None, self.ribs, self.gas)  # fmt: skip
        step.frame_force(table, 1.0, self.numbers.gravity, self.frame)
        notes = self.notes
        if outcome != step.OK:
            self.work[:], self.coarse[:] = 0.0, 0.0  # no trace in a state that is restored after this
            raise FlowError(_WORDS[outcome].format(step=notes[step.TIME_STEP], steps=int(notes[step.STEPS])))
        return StepReport(
            int(notes[step.STEPS]),
            float(notes[step.TIME_STEP]),
            int(notes[step.ITERATIONS]),
            notes[step.UNCONVERGED] == 0.0,
            float(notes[step.RESIDUAL]),
        )

    def loads(self, motion: SectionMotion) -> Loads:
        """Loads at the present time; motion: that at the end of the last step."""
        out = self._walls()
        out *= self.grid.tank.width
        along, up = float(out[wall.FORCE_X]), float(out[wall.FORCE_Y])
        sin, cos = np.sin(motion.alpha), np.cos(motion.alpha)
        return Loads(
            float(along * cos + up * sin), float(up * cos - along * sin), float(out[wall.MOMENT]), along, up,
            float(out[wall.WEST]), float(out[wall.EAST]))  # fmt: skip

    def _walls(self) -> Array:
        out = np.zeros(wall.ROWS)
        wall.wall_loads(
            self.state, self.surface, self.work[step.RHO], self.work[step.TAU], self.frame, self.places.x, self.places.y,
            self.plates, self.numbers, out, self.ribs)  # fmt: skip
        if self.sides is not None:
            sides = np.zeros(3)
            side_walls.side_loads(self.state, self.places, self.numbers, self.sides, sides)
            out[[wall.FORCE_X, wall.FORCE_Y, wall.MOMENT]] += sides
        return out

    @property
    def fractions(self) -> Array:
        """Volume fraction of liquid, shape (ny, nx), rows from the floor up."""
        return self.grid.inner(self.state[step.C])

    @property
    def pressure(self) -> Array:
        """Pressure [Pa] of the cells above that in the middle of the roof, shape (ny, nx)."""
        out = self._walls()
        return self.numbers.liquid_density * self.grid.inner(self.state[step.Q]) - out[wall.DATUM]

    @property
    def velocity(self) -> tuple[Array, Array]:
        """Velocities relative to the tank in its axes [m/s] at cell centres, shapes (ny, nx)."""
        s, (u, v) = self.grid.stride, self.state[[step.U, step.V]]
        u, v = 0.5 * (u + np.roll(u, 1)), 0.5 * (v + np.roll(v, s))
        return self.grid.inner(u), self.grid.inner(v)

    @property
    def volume(self) -> float:
        """Liquid volume [m3]."""
        return float(np.sum(self.fractions)) * self.grid.dx * self.grid.dy * self.grid.tank.width

    @property
    def wave_heights(self) -> tuple[float, float]:
        """Rise of the liquid column at the west and the east wall above the still level [m]."""
        columns = self.fractions[:, [0, -1]].sum(axis=0) * self.grid.dy - self.grid.tank.depth
        return float(columns[0]), float(columns[1])

    def heights(self, x: Array) -> Array:
        """Rise of the liquid column at x [m] from the west wall above the still level [m], shape of x.

        Linear between the middles of columns of one bay; a gauge on a rib is aft of it.
        """
        grid = self.grid
        columns, middles = self.fractions.sum(axis=0) * grid.dy - grid.tank.depth, (np.arange(grid.nx) + 0.5) * grid.dx
        out = np.asarray(np.interp(x, middles, columns))
        for first, last in grid.bays if len(grid.bays) > 1 else []:
            here = (x >= first * grid.dx) & ((x < last * grid.dx) | (last == grid.nx))
            out = np.where(here, np.interp(x, middles[first:last], columns[first:last]), out)
        return out

    def pressures(self) -> list[tuple[float, float, float]]:
        """Each probe's pressure [Pa] above that of the gas: at its middle, mean over its face, that mean over the window."""
        rings = self.watch.rings
        return [
            (float(row[probes.POINT]), float(row[probes.AREA]), probes.time_mean(self.watch, n)) for n, row in enumerate(rings)
        ]

    def save(self) -> dict[str, Any]:
        """All the next step reads, by reference: the arrays are not modified after."""
        self.shared = True
        return {
            "state": self.state,
            "layers": self.layers.copy(),
            "density": self.work[step.RHO].copy(),
            "shear": self.work[step.TAU].copy(),
            "notes": self.notes.copy(),
            "frame": self.frame.copy(),
            "probes": self.watch.rings.copy(),
        }

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take back what `save` returned."""
        self.state, self.shared = snapshot["state"], True
        self.layers = snapshot["layers"].copy()
        self.work[step.RHO] = snapshot["density"]
        self.work[step.TAU] = snapshot["shear"]
        self.notes = snapshot["notes"].copy()
        self.frame = snapshot["frame"].copy()
        self.watch.rings[:] = snapshot["probes"]
        reconstruct(self.state[step.C], self.numbers.nx, self.numbers.ny, self.surface, self.ribs)


_WORDS = {
    step.NOT_FINITE: "the flow is no longer finite after {steps} time steps of this communication step. Remedy: look at the "
    "motion for values no tank would survive; a smaller cfl helps with violent impacts",
    step.TOO_SMALL: "the time step fell below 1e-9 s after {steps} time steps (last {step:.1e} s). Remedy: look at the motion "
    "for values no tank would survive, or use fewer cells",
    step.TOO_MANY: "more than 2 million time steps in one communication step. Remedy: shorter communication steps",
}


def _longest_step(grid: Grid, fluids: Fluids, numerics: Numerics, sides: float) -> float:
    """Limit of explicit viscosity, friction of side walls [1/s], capillary waves and gravity waves on the grid [s]."""
    cell = min(grid.dx, grid.dy)
    limits = [numerics.max_step, 0.5 * (cell / grid.tank.gravity) ** 0.5]
    viscosity = max(fluids.liquid_viscosity, fluids.gas_viscosity)
    if viscosity > 0.0:
        limits.append(0.2 * cell**2 / viscosity)
    if sides > 0.0:
        limits.append(0.2 / sides)
    if fluids.surface_tension > 0.0:
        # Brackbill, Kothe and Zemach, J. Comput. Phys. 100 (1992) 335
        limits.append(0.5 * ((grid.tank.density + fluids.gas_density) * cell**3 / (4 * np.pi * fluids.surface_tension)) ** 0.5)
    return float(min(limits))
