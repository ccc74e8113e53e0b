"""What an SSP archive holds of a coupled system: its FMUs, what the master sets in each before a march, the wires, the times.

Nothing is worked out here. The system is built and initialised by the code that marches it (`FlutterSetup`, `system_file.build`),
and what that code has set in each FMU (`Component.given`) is what the archive says; the trim loads of a section are those of its
own steady flow. Inputs get as start values what their wires carry at the start, so that a host which exchanges nothing before the
first step starts from the same state.

SSP tools step Jacobi and extrapolate nothing. Where the master would (coupling.predictor_order above 0), the archive switches on
the FMUs' own prediction: the tool then marches what our scheme "jacobi" with predictor_order 1 does.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base.errors import AeroSloshError
from ..case import case as cases
from ..case import fuel_tank
from ..case.case import Case
from ..case.scales import whole_nanoseconds
from ..cosim import system_file as assemblies
from ..cosim.assemble import PREDICTIONS
from ..cosim.coupling_settings import Coupling
from ..cosim.system import System, Wire
from ..cosim.system_file import Assembly
from ..flutter import span
from ..flutter.setup import FlutterSetup


@dataclass(frozen=True)
class Part:
    """A component: its FMU, FMPy's description of it, and `values`: parameters and start values of inputs, SI units."""

    name: str
    path: Path
    sha256: str
    description: Any
    values: dict[str, float | int | bool | str]

    @property
    def variables(self) -> dict[str, Any]:
        """Name → FMPy's model variable."""
        return {v.name: v for v in self.description.modelVariables}


@dataclass(frozen=True)
class Coupled:
    """A coupled system for export.

    start, dt, steps   of the run [s]; `dt` is a whole number of nanoseconds
    settings           the resolved case or system file; `notes` what of it no SSP tool is told"""

    name: str
    description: str
    parts: list[Part]
    wires: list[Wire]
    start: float
    dt: float
    steps: int
    settings: str
    notes: list[str]

    @property
    def stop(self) -> float:
        """End of the run [s]."""
        return self.start + self.steps * self.dt

    @property
    def settings_sha256(self) -> str:
        """Of the resolved settings."""
        return hashlib.sha256(self.settings.encode()).hexdigest()


def from_case(
    case: Case, fmus: dict[str, Path], prediction: str | None = None, say: Callable[[str], None] = lambda text: None
) -> Coupled:
    """The flutter system of `case` at its Mach number and V_f; solves the steady flow, for the trim.

    `prediction`: whether the FMUs predict their inputs: none, linear, or (None) what coupling.predictor_order says. Raises
    AeroSloshError for settings that change the motion and that an archive cannot hold, ComponentError when an FMU fails."""
    _refuse(case.coupling, "the case")
    with FlutterSetup(case, fmus, case.flow.mach, say=say) as setup:
        s = setup.start(case.flutter.V_f)
        parts = _parts(setup.system)
        connections = setup.system.wires
    notes = [*_predict(parts, case.coupling, prediction), *_limits(parts)]
    if case.flutter.forced_cycles == 0.0:  # a forced phase starts from rest and is not moved by loads
        notes += _starts(parts)
    if case.slosh.predictor != "none" and case.slosh.model != "frozen":
        notes.append(
            f"slosh.predictor = {case.slosh.predictor} is left out: one FMU predicting another's loads is no part of SSP."
        )
    if case.slosh.split == "none" and case.slosh.model not in ("none", "frozen"):
        notes.append(
            "slosh.split = none exchanges the liquid's whole load, which diverges where it is heavy: extrapolated above a third "
            "of the rest's mass, late by a step (--prediction none) above all of it."
        )
    liquid = fuel_tank.LABEL[case.slosh.model]
    protocol = "forced pitch, release, free motion" if case.flutter.forced_cycles > 0.0 else "free motion"
    about = f"Wing section at Mach {case.flow.mach:g}, V_f {case.flutter.V_f:g}, {liquid}: {protocol}."
    steps = span.length(case, s)[1]
    return Coupled(case.name, about, parts, connections, 0.0, s.dt, steps, cases.dump(case), notes)


def from_assembly(assembly: Assembly, fmus: dict[str, Path], prediction: str | None = None) -> Coupled:
    """The system of a system file. `prediction` and what is raised: as in `from_case`."""
    _refuse(assembly.coupling, str(assembly.path))
    system = assemblies.build(assembly, fmus)
    try:
        system.initialize(assembly.run.start)
        parts = _parts(system)
    finally:
        system.close()
    left_out = [
        f"components.{name} is left out: one FMU predicting '{part.predicts}' is no part of SSP."
        for name, part in assembly.components.items()
        if part.predicts
    ]
    notes = [*_predict(parts, assembly.coupling, prediction), *left_out, *_limits(parts), *_starts(parts)]
    about = f"{assembly.name}: {', '.join(f'{part.name} ({part.path.stem})' for part in parts)}"
    run = assembly.run
    settings = assemblies.dump(assembly)
    return Coupled(assembly.name, about, parts, system.wires, run.start, _whole(assembly.dt), assembly.steps, settings, notes)


def _parts(system: System) -> list[Part]:
    """The components of an initialised system, in the order of their names: a host's order may not matter."""
    wired = {wire.target for wire in system.wires}
    parts = []
    for component in sorted(system.components, key=lambda c: c.name):
        values = dict(component.given)
        for name, position in component.input_index.items():
            value = float(component.inputs.values[position])
            if f"{component.name}.{name}" in wired and (name in values or value != float(component.variables[name].start or 0.0)):
                values[name] = value
        parts.append(Part(component.name, component.path, component.sha256, component.description, values))
    return parts


def _whole(dt: float) -> float:
    """`dt` [s] in whole nanoseconds. Raises AeroSloshError below one."""
    if not (whole := whole_nanoseconds(dt)):
        raise AeroSloshError(f"The step is {dt:g} s", "run.step", "give a step of at least a nanosecond: SSP tools count in them")
    return whole


def _refuse(coupling: Coupling, where: str) -> None:
    """Settings without which the motion would be another one."""
    for table in ("substeps", "waveform"):
        if content := getattr(coupling, table):
            raise AeroSloshError(
                f"SSP cannot carry coupling.{table} = {content}: every tool steps each FMU once a step with its last inputs",
                f"{where}, key coupling.{table}",
                f"leave it out (--set 'coupling.{table}={{}}'), and give a smaller step if one component needs it",
            )


def _predict(parts: list[Part], coupling: Coupling, wish: str | None) -> list[str]:
    """Switch the FMUs' prediction on where it is wished for; what the archive does not say of the coupling."""
    # the order of an implicit scheme is a first guess, and a loop that needs it is too strong to be extrapolated
    own = coupling.extrapolated > 0 and coupling.scheme != "implicit"
    on = own if wish is None else wish == "linear"
    without = []
    for part in parts:
        names = [name for name in PREDICTIONS if name in part.variables]
        part.values.update({name: int(on) for name in names if on or name in part.values})
        without += [] if names or not any(v.causality == "input" for v in part.variables.values()) else [part.name]
    notes = [
        f"coupling.scheme = {coupling.scheme} is no part of SSP: tools pass values on once a step, to all at once (Jacobi). "
        + (
            "The FMUs extrapolate their inputs linearly themselves: our scheme jacobi with predictor_order = 1."
            if on
            else "Motion and loads are then late by a step each, which adds a growth rate like the step (docs/ssp.md)."
        )
    ]
    if on and without:
        notes.append(f"No prediction of their own have {', '.join(without)}: their inputs are late by a step.")
    if coupling.scheme == "implicit":
        notes.append(
            "A system that needs implicit coupling may diverge in such a tool, at any step; with --prediction linear it does "
            "where the load that is exchanged weighs more than a third of the rest."
        )
    return notes


def _limits(parts: list[Part]) -> list[str]:
    """Values that not every tool can give to the FMUs."""
    notes = []
    for part in parts:
        for name, value in part.values.items():
            full, variable = f"{part.name}.{name}", part.variables[name]
            if variable.type == "Enumeration":
                notes.append(f"{full} is an enumeration, which libcosim and ecos pass over: there the FMU's own value holds.")
            elif variable.type == "String" and value != (variable.start or ""):
                notes.append(f"{full} is a text, which FMPy's SSP simulation cannot set.")
                if Path(str(value)).is_file():
                    notes.append(f"{full} = {value} is a file of this machine, which is not in the archive.")
    return notes


def _starts(parts: list[Part]) -> list[str]:
    """Inputs that do not start at 0."""
    names = [f"{part.name}.{n}" for part in parts for n, v in part.values.items() if part.variables[n].causality == "input" and v]
    if not names:
        return []
    return [f"FMPy's SSP simulation gives 0 to every input in its first step, and these start elsewhere: {', '.join(names)}."]
