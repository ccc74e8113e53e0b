"""A system file: FMUs of any origin, their wires, how they are coupled and for how long. TOML, read and written like a case.

[components.tank]               a name
fmu = "slosh_ems.fmu"           relative to this file, else in the folder of the FMUs
parameters = { fill_level = 0.4 }
predicts = ""                   another component that this one foretells (docs/coupling.md)

[system]
wires = ["table.x -> tank.x"]   outputs to inputs; inputs without a wire keep their start values
[run]
[coupling]                      as in a case
"""

from __future__ import annotations

import dataclasses
import re
import typing
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from master import settings
from master.case import Coupling
from master.component import Component
from master.errors import AeroSloshError
from master.scheme import assemble
from master.settings import key, rule
from master.system import System, wires


@dataclass
class Part:
    """One FMU instance."""

    fmu: str = key("", "FMU file, relative to the system file, or a name in the folder of the FMUs")
    parameters: dict[str, Any] = field(default_factory=dict, metadata=rule("variable = value, set before it starts", empty=True))
    predicts: str = key("", "component that this one foretells; it is not stepped with the others")


@dataclass
class Wiring:
    """What is connected."""

    wires: list[str] = field(
        default_factory=list, metadata=rule('texts like "a.output -> b.input"; Real variables of one unit', empty=True)
    )


@dataclass
class Run:
    """For how long, and what is recorded."""

    start: float = key(0.0, "start time", "s")
    end: float = key(1.0, "end time", "s")
    step: float = key(1e-3, "communication step", "s", above=0.0)
    record_every: int = key(1, "steps between two samples of the history", low=1)
    pictures: bool = key(True, "a picture of all outputs over time")


@dataclass
class Assembly:
    """A system file. `name` is the file's stem, `folder` where it lies."""

    name: str = "system"
    folder: Path = Path()
    run: Run = field(default_factory=Run)
    system: Wiring = field(default_factory=Wiring)
    coupling: Coupling = field(default_factory=Coupling)
    components: dict[str, Part] = field(default_factory=dict)

    @property
    def steps(self) -> int:
        """Communication steps of the run."""
        return max(1, round((self.run.end - self.run.start) / self.run.step))


TABLES: dict[str, Any] = {n: h for n, h in typing.get_type_hints(Assembly).items() if dataclasses.is_dataclass(h)}


def load(path: Path, overrides: Sequence[str] = ()) -> Assembly:
    """Read a system file and apply `table.key=value` overrides. Raises AeroSloshError (file, line, key, remedy)."""
    data, lines = settings.read(path, "system file", "cases/two_tanks.toml")
    assembly = Assembly(path.stem, path.resolve().parent)
    given = data.pop("components", {})
    settings.fill(assembly, TABLES, data, lines, path)
    if not isinstance(given, dict) or not given:
        raise AeroSloshError("The system has no components", str(path), 'write [components.NAME] with fmu = "…"')
    for name, content in given.items():
        table = f"components.{name}"
        if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_-]*", name):
            raise AeroSloshError(f"'{name}' is no name for a component", f"{path}, [{table}]", "letters, digits, _ and -")
        assembly.components[name] = part = Part()
        settings.fill_table(part, table, content, lines, path)
        if not part.fmu:
            where = f"{path}, line {lines.get((table, ''), '?')}"
            raise AeroSloshError(f"[{table}] names no FMU", where, 'write fmu = "file.fmu"')
    for override in overrides:
        _override(assembly, override)
    if assembly.run.end <= assembly.run.start:
        raise AeroSloshError(
            f"run.end = {assembly.run.end:g} is not after run.start = {assembly.run.start:g}", str(path), "give a later end"
        )
    return assembly


def dump(assembly: Assembly) -> str:
    """The resolved system file."""
    text = f"# resolved system {assembly.name}: every key with its value, unit and meaning\n"
    for name, part in assembly.components.items():
        text += f"\n[components.{name}]\n{settings.dump_table(part)}"
    return text + settings.dump(assembly, TABLES)


def flat(assembly: Assembly) -> dict[str, Any]:
    """All settings as "table.key" → value."""
    parts = {f"components.{n}.{k}": v for n, p in assembly.components.items() for k, v in dataclasses.asdict(p).items()}
    return parts | settings.flat(assembly, TABLES)


def find(assembly: Assembly, folder: Path) -> dict[str, Path]:
    """The FMU file of each component: beside the system file, else in `folder`. Raises AeroSloshError."""
    found = {}
    for name, part in assembly.components.items():
        file = part.fmu if part.fmu.endswith(".fmu") else f"{part.fmu}.fmu"
        places = [assembly.folder / file, folder / file]
        path = next((p for p in places if p.is_file()), None)
        if path is None:
            raise AeroSloshError(
                f"components.{name}: there is no FMU {file}",
                " or ".join(str(p.parent) for p in places),
                "build the FMUs with `make fmus`, or name their folder with --fmus DIR or AEROSLOSH_FMUS",
            )
        found[name] = path
    return found


def build(assembly: Assembly, fmus: dict[str, Path]) -> System:
    """Instances of all FMUs, their parameters set, wired, not yet initialised. Raises AeroSloshError, ComponentError."""
    made: dict[str, Component] = {}
    try:
        for name, part in assembly.components.items():
            made[name] = component = Component(fmus[name], name)
            for variable, value in part.parameters.items():
                _set(component, variable, value)
        guides = {part.predicts: made[name] for name, part in assembly.components.items() if part.predicts}
        stepped = [made[name] for name, part in assembly.components.items() if not part.predicts]
        return assemble(stepped, wires(assembly.system.wires), assembly.coupling, guides)
    except BaseException:
        for component in made.values():
            component.close()
        raise


def _set(component: Component, variable: str, value: Any) -> None:
    """One parameter or start value, if its type fits."""
    known = component.variables.get(variable)
    where = f"components.{component.name}.parameters.{variable}"
    if known is None or known.causality in ("output", "local", "independent"):
        names = ", ".join(n for n, v in component.variables.items() if v.causality in ("parameter", "input"))
        raise AeroSloshError(f"'{component.name}' has no parameter or input '{variable}'", where, f"one of {names}")
    kinds = {"Real": (int, float), "Integer": (int,), "Enumeration": (int,), "Boolean": (bool,), "String": (str,)}[known.type]
    if not isinstance(value, kinds) or (isinstance(value, bool) and known.type != "Boolean"):
        raise AeroSloshError(f"{variable} = {value!r} is no {known.type}", where, "give a value of that type")
    component.set(variable, value)


def _override(assembly: Assembly, text: str) -> None:
    """`table.key=value`, also `components.NAME.key=value` and `components.NAME.parameters.variable=value`."""
    dotted, _, value = text.partition("=")
    words = dotted.strip().split(".")
    if words[0] != "components":
        settings.override(assembly, TABLES, text)
        return
    if len(words) < 3 or words[1] not in assembly.components:
        known = ", ".join(assembly.components)
        raise AeroSloshError(
            "Such an override has the form components.NAME.key=value", f"--set {text}", f"components are: {known}"
        )
    part = assembly.components[words[1]]
    if words[2] == "parameters" and len(words) > 3:
        part.parameters[".".join(words[3:])] = settings.written(value)
    else:
        settings.assign(part, f"components.{words[1]}", words[2], settings.written(value), f"--set {text}")
