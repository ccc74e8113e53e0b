"""The flutter set-up: the FMUs of one Mach number, wired, with the steady flow saved for every march to
start from."""

from __future__ import annotations

import math
from collections.abc import Callable
from contextlib import ExitStack, closing
from pathlib import Path

from ..base.errors import AeroSloshError, ComponentError
from ..case import aero_parameters, airfoils, checks, fmu_parameters, fuel_tank
from ..case.case import Case
from ..case.scales import Scales, scales
from ..cosim.assemble import assemble
from ..cosim.system import wires
from ..fmi import installed, kernels
from ..fmi.component import Component, Saved
from .statics import STEP, SteadySlopes, tilted

WIRES = """
structure.h -> aero.h
structure.h_dot -> aero.h_dot
structure.h_ddot -> aero.h_ddot
structure.alpha -> aero.alpha
structure.alpha_dot -> aero.alpha_dot
structure.alpha_ddot -> aero.alpha_ddot
aero.lift -> structure.lift
aero.moment -> structure.moment
"""
NEEDED = ("structure", "aero")
LOADS = ("lift", "moment")


def find_fmus(folder: Path, *models: str) -> dict[str, Path]:
    """The FMU files of `folder` by component name, with those of the liquid's `models`. Raises AeroSloshError when one is
    missing."""
    installed.ensure(folder)
    found = {name: folder / f"{name}.fmu" for name in (*NEEDED, *fuel_tank.needed(models))}
    missing = [path.name for path in found.values() if not path.is_file()]
    if missing:
        raise AeroSloshError(
            f"FMU missing: {', '.join(missing)}",
            str(folder),
            "build the FMUs with `make fmus`, or name their folder with --fmus DIR or AEROSLOSH_FMUS",
        )
    return found


def not_known(V_f: float) -> float:
    """The free cycles that a march needs beyond the case's while no linear model tells more: none."""
    return 0.0


def _tank(case: Case, fmus: dict[str, Path]) -> fuel_tank.Tank:
    """The liquid, tried at rest. Raises AeroSloshError, bad input, where its FMU refuses what the case gives (a shape, ribs)."""
    name = fuel_tank.FMU[case.slosh.model]
    # carried frozen for an error bar it may be none that the case names: its FMU lies where the others do
    found = {name: fmus["aero"].with_name(f"{name}.fmu")} | fmus
    try:
        return fuel_tank.Tank(case.slosh, found)
    except ComponentError as error:
        if (key := fmu_parameters.blamed(case, "slosh", error.what)) is None:
            raise
        raise AeroSloshError(error.what, fmu_parameters.place(case, "slosh", key), error.remedy) from None


class FlutterSetup:
    """Structure, aero and slosh FMU at one Mach number. Use as a context manager.

    `start(V_f)` makes the structure of that V_f and rewinds the aero FMU to its steady flow: what a march
    begins with. `tank` is the liquid (None when dry). `section_file`: where the aero
    FMU writes the points of the airfoil's file and the wall of the mesh. Raises AeroSloshError, for an airfoil that gives no
    mesh as bad input.
    """

    def __init__(
        self,
        case: Case,
        fmus: dict[str, Path],
        mach: float,
        field_folder: Path | None = None,
        say: Callable[[str], None] = lambda text: None,
        section_file: Path | None = None,
    ) -> None:
        checks.complete(case, "setup", case.source)
        fmu_parameters.check(case, fmus)
        self.case, self.mach = case, mach
        self._steady: Saved | None = None
        self._fmus = fmus
        self._slopes: SteadySlopes | str | None = "not asked for"
        # free cycles that a march at V_f needs, where a linear model knows them
        self.needed_cycles: Callable[[float], float] = not_known
        self.enough_cycles = math.inf  # free cycles that do for the mode which a march is made for
        kernels.prepare_all(fmus.values())
        with ExitStack() as opened:  # what is made is freed again unless all of it can be
            self.structure = opened.enter_context(closing(Component(fmus["structure"], "structure")))
            self.aero = opened.enter_context(closing(Component(fmus["aero"], "aero")))
            self.tank = opened.enter_context(closing(_tank(case, fmus))) if case.slosh.model != "none" else None
            tank = self.tank
            if tank is not None and tank.validity is not None and not fuel_tank.holds(tank.validity, tank.edge):
                told = fuel_tank.broken(tank.validity, tank.edge)
                say(f"warning: {told} for this liquid in this tank, at rest already: no verdict")
            moving = self.tank.moving if self.tank else None
            components, lines = [self.structure, self.aero], WIRES.strip().splitlines()
            if moving is not None:
                components, lines = [*components, moving], lines + fuel_tank.wiring(case.slosh.split)
            surrogate = self.tank.surrogate if self.tank else None
            self.system = assemble(components, wires(lines), case.coupling, {"slosh": surrogate} if surrogate else {})
            say(f"steady flow at Mach {mach:g}")
            self._solve_steady(field_folder, section_file)
            opened.pop_all()
        self.steady_cpu = self.aero.cpu

    def __enter__(self) -> FlutterSetup:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def steady(self) -> Saved:
        """The aero FMU's state after its steady solution. Raises AeroSloshError when the setup is closed."""
        if self._steady is None:
            raise AeroSloshError("The set-up is closed", "FlutterSetup.steady", "open a new one")
        return self._steady

    @property
    def airfoil_summary(self) -> str:
        """What the aero FMU says of its section in a line; empty where it says nothing."""
        return str(self.aero.get("airfoil_summary")) if "airfoil_summary" in self.aero.variables else ""

    @property
    def exchanges_whole_loads(self) -> bool:
        """Whether a moving liquid's whole load, inertia and all, reaches the structure once a step."""
        moving = self.tank is not None and self.tank.moving is not None
        return moving and self.case.slosh.split == "none" and self.case.coupling.scheme != "implicit"

    def hashes(self) -> dict[str, str]:
        """SHA-256 of every FMU, by component."""
        return {c.name: c.sha256 for c in self.system.everyone} | ({"slosh": self.tank.sha256} if self.tank else {})

    def start(self, V_f: float) -> Scales:
        """Ready the FMUs for a march at `V_f`: aero at its steady flow, a new structure in trim, a new liquid at rest."""
        case, s = self.case, scales(self.case, self.mach, V_f)
        self.aero.rewind(self.steady)
        if self.structure.state != "instantiated":
            self.structure.restart()
        force_y = slosh_moment = 0.0
        if self.tank is not None:
            self.tank.restart(case.slosh.seed)
            force_y, slosh_moment = self.tank.rest
            self.structure.set_all(self.tank.carried)
        lift, moment = self.aero.get("lift"), self.aero.get("moment")
        flutter = case.flutter
        self.structure.set_all(
            fmu_parameters.values(case.structure.parameters, self.structure.variables)
            | {
                "mass": s.mass,
                "static_imbalance": s.static_imbalance,
                "inertia": s.inertia,
                "omega_h": s.omega_h,
                "omega_alpha": s.omega_alpha,
                "damping_ratio_h": case.section.damping_ratio_h,
                "damping_ratio_alpha": case.section.damping_ratio_alpha,
                "forced_amplitude": math.radians(flutter.forced_amplitude_deg),
                "forced_frequency": flutter.forced_frequency * s.omega_alpha,
                "forced_cycles": flutter.forced_cycles,
                "forced_ramp_cycles": min(flutter.forced_ramp_cycles, flutter.forced_cycles),
                "initial_alpha_dot": flutter.initial_alpha_dot * s.omega_alpha,
                "trim_lift": lift + force_y,
                "trim_moment": moment + slosh_moment,
                "lift": lift,
                "moment": moment,
            }
        )
        self.system.initialize()
        return s

    def close(self) -> None:
        """Free the instances."""
        steady, self._steady = self._steady, None
        try:
            if steady is not None:
                self.aero.free(steady)
        finally:
            self.system.close()

    def slopes(self) -> SteadySlopes | None:
        """Slopes of the steady loads over incidence by a second steady solution, once; None where it does not converge."""
        if isinstance(self._slopes, str):
            self._slopes = self._find_slopes(STEP)
        return self._slopes

    def other_slopes(self) -> SteadySlopes | None:
        """The same from a steady solution on the other side, three times as far: what the two differ by is no linear slope."""
        return self._find_slopes(-3.0 * STEP)

    def stiffness(self, V_f: float) -> float:
        """Pitch stiffness that the steady flow and the liquid leave at `V_f`, over the structure's own; nan where not known."""
        slopes = self.slopes()
        if slopes is None:
            return math.nan
        return slopes.stiffness(scales(self.case, self.mach, V_f), self.tank.static_stiffness if self.tank else 0.0)

    def divergence(self) -> float:
        """The V_f of static divergence by the steady flow; inf where there is none, nan where it is not known."""
        slopes = self.slopes()
        if slopes is None:
            return math.nan
        s = scales(self.case, self.mach, self.case.flutter.V_f)
        return slopes.divergence(s, self.tank.static_stiffness if self.tank else 0.0)

    def _find_slopes(self, step: float) -> SteadySlopes | None:
        other = Component(self._fmus["aero"], "aero")
        try:
            other.set_all(aero_parameters.parameters(tilted(self.case, step), self.mach, self.aero.variables))
            other.initialize()
            if "converged" in other.variables and not other.get("converged"):
                return None
            s = scales(self.case, self.mach, self.case.flutter.V_f)
            q = 0.5 * s.density * s.speed**2 * 2.0 * s.half_chord * step
            lift, moment = ((other.get(name) - load) / q for name, load in zip(LOADS, self._steady_loads, strict=True))
            return SteadySlopes(lift, moment / (2.0 * s.half_chord))
        except ComponentError:
            return None
        finally:
            self.steady_cpu += other.cpu
            other.close()

    def _solve_steady(self, field_folder: Path | None, section_file: Path | None) -> None:
        """Parameters of the aero FMU, its steady solution (in its initialisation), and the saved state."""
        aero = self.aero
        values = aero_parameters.parameters(self.case, self.mach, aero.variables)
        if field_folder is not None:
            values["field_folder"] = str(field_folder)
        if section_file is not None and "section_file" in aero.variables:
            values["section_file"] = str(section_file)
        aero.set_all(values)
        try:
            aero.initialize()
        except ComponentError as error:
            if (said := airfoils.fault(error.what)) is None:
                raise
            raise AeroSloshError(said, f'{airfoils.KEY} = "{self.case.flow.airfoil}"', error.remedy) from None
        if "converged" in aero.variables and not aero.get("converged"):
            raise AeroSloshError(
                f"The steady flow at Mach {self.mach:g} did not converge (residual {aero.get('residual'):.1e})",
                str(aero.path),
                "an unconverged start ruins the damping: change aero.cells_around or aero.tolerance",
            )
        self._steady_loads = tuple(aero.get(name) for name in LOADS)
        self._steady = aero.save()
