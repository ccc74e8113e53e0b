"""What step, forced amplitude and mesh change in a neutral V_f: the parts of its error bar that the marches of its search do
not tell.

Step and mesh: Richardson's rule, the difference to the limit that a difference of two levels promises for second order; with
`boundary.richardson` three meshes and the order they show (module `richardson`). Amplitude: what half of it changes, as it is:
there is no limit to go to, the answer depends on the motion. The mesh's part by two meshes is no bound.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass, field

from ..analysis.crossings import Crossing, Sample
from ..analysis.richardson import study
from ..base.errors import AeroSloshError
from ..case.case import Case, Flutter
from ..flutter import march as flutter_march
from ..flutter.coarse_marches import coarser
from ..flutter.march import March
from ..flutter.setup import FlutterSetup

PARTS = ("step", "amplitude", "mesh")  # of an error bar, made here
ORDER = 2.0  # of the scheme in time and space
FLAT = 1e-6  # a growth rate that changes by less than this (over omega_alpha) while V_f doubles does not tell a V_f
LEAP = 0.02  # a mesh that moves V_f by more than this (relative) is marched on once more, where it moved it to


@dataclass
class Spread:
    """Marches about one crossing: `case` at `mach` on its open `setup`; `open_setup` opens one of another case there; `take`
    reads the crossing's mode; `say` tells the user. `marches` are those done."""

    case: Case
    mach: float
    setup: FlutterSetup
    open_setup: Callable[[Case, float], FlutterSetup]
    take: Callable[[March], Sample]
    say: Callable[[str], None]
    marches: list[March] = field(default_factory=list)

    def widened(self, crossing: Crossing, searched: list[March]) -> Crossing:
        """`crossing` with the parts step, amplitude and mesh; V_f stays that of the case's step, amplitude and mesh.

        `searched`: the marches it was found by; the nearest to it is repeated."""
        near = sorted((m for m in searched if self.take(m).known), key=lambda m: abs(m.scales.V_f - crossing.V_f))
        if not near or not abs(crossing.slope) * crossing.V_f > FLAT:
            self.say("  step, amplitude, mesh: the growth rate hardly changes with V_f there, not in the error bar")
            return dataclasses.replace(crossing, missing=PARTS)
        base = near[0]
        V_f, sample = base.scales.V_f, self.take(base)
        own = V_f - sample.growth_rate / crossing.slope  # as the other settings' are told, so that curvature cancels
        f = self.case.flutter
        finer = dataclasses.replace(f, steps_per_cycle=2 * base.scales.steps_per_cycle)
        smaller = dataclasses.replace(
            f, forced_amplitude_deg=0.5 * f.forced_amplitude_deg, initial_alpha_dot=0.5 * f.initial_alpha_dot
        )
        values = {"step": self._on_own_mesh(finer, V_f, crossing), "amplitude": self._on_own_mesh(smaller, V_f, crossing)}
        parts = dict(crossing.parts)
        parts["step"] = (values["step"] - own) / (1.0 - 2.0**-ORDER)
        parts["amplitude"] = values["amplitude"] - own
        cells = [(self.case.aero.cells_around, self.case.aero.cells_normal)]
        on_meshes = [own]
        for _ in range(2 if self.case.boundary.richardson else 1):
            cells.append(coarser(cells[-1]))
            on_meshes.append(self._on_mesh(cells[-1], V_f, crossing))
        grids = None
        if len(cells) == 3 and all(map(math.isfinite, on_meshes)) and len(set(cells)) == 3:
            grids = study(cells, [value + crossing.V_f - own for value in on_meshes])
            parts["mesh"] = grids.error
        else:
            ratio = math.sqrt(math.prod(cells[0]) / math.prod(cells[1]))
            parts["mesh"] = (own - on_meshes[1]) / (ratio**ORDER - 1.0) if ratio > 1.0 else math.nan
        missing = tuple(name for name, value in parts.items() if not math.isfinite(value))
        for name in PARTS:
            self.say(f"  {name}: " + ("no growth rate, not in the error bar" if name in missing else f"V_f {parts[name]:+.5f}"))
        kept = {name: value for name, value in parts.items() if name not in missing}
        return dataclasses.replace(crossing, parts=kept, missing=missing, grids=grids)

    def _on_own_mesh(self, settings: Flutter, V_f: float, crossing: Crossing) -> float:
        """The neutral V_f under other settings of the march; nan without a growth rate."""
        self.setup.case = dataclasses.replace(self.case, flutter=settings)
        try:
            return self._neutral(self.setup, V_f, crossing)
        except AeroSloshError as error:
            self.say(f"  {settings.steps_per_cycle} steps a cycle, {settings.forced_amplitude_deg:g}°: {error.what}")
            return math.nan
        finally:
            self.setup.case = self.case

    def _on_mesh(self, cells: tuple[int, int], V_f: float, crossing: Crossing) -> float:
        """The neutral V_f on another mesh; nan without a growth rate, or without a steady flow to start from."""
        aero = dataclasses.replace(self.case.aero, cells_around=cells[0], cells_normal=cells[1])
        try:
            with self.open_setup(dataclasses.replace(self.case, aero=aero), self.mach) as setup:
                return self._neutral(setup, V_f, crossing)
        except AeroSloshError as error:
            self.say(f"  mesh of {cells[0]} x {cells[1]} cells: {error.what}")
            return math.nan

    def _neutral(self, setup: FlutterSetup, V_f: float, crossing: Crossing) -> float:
        """Newton's step from a march at `V_f`, with the crossing's slope; a long one is checked by a march there."""
        first = self._march(setup, V_f)
        found = V_f - first.growth_rate / crossing.slope
        if not abs(found / V_f - 1.0) > LEAP:
            return found
        second = self._march(setup, min(max(found, 0.75 * V_f), 1.25 * V_f))
        change = second.growth_rate - first.growth_rate
        return second.V_f - second.growth_rate * (second.V_f - V_f) / change if change else math.nan

    def _march(self, setup: FlutterSetup, V_f: float) -> Sample:
        self.marches.append(flutter_march.march(setup, V_f))
        return self.take(self.marches[-1])
