"""A system file: FMUs of any origin, their wires, how they are coupled and for how long. TOML, read and written like a case.

[components.tank]               a name
fmu = "slosh_ems.fmu"           relative to this file, else in the folder of the FMUs
parameters = { fill_level = 0.4 }
predicts = ""                   another component that this one predicts (docs/coupling.md)

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

from ..base import settings, texts
from ..base.errors import AeroSloshError
from ..base.settings import key, rule
from ..fmi import installed
from ..fmi.component import Component
from .assemble import assemble
from .coupling_settings import Coupling
from .system import System, wires


@dataclass
class Part:
    """One FMU instance."""

    fmu: str = key("", "FMU file, relative to the system file, or a name in the folder of the FMUs")
    parameters: dict[str, Any] = field(default_factory=dict, metadata=rule("variable = value, set before it starts", empty=True))
    predicts: str = key("", "component that this one predicts; it is not stepped with the others")


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
    """A system file. `name` is the file's stem, `folder` where it lies; `path` and `lines` go into messages."""

    name: str = "system"
    folder: Path = Path()
    path: Path = Path("system.toml")
    lines: settings.Lines = field(default_factory=dict)
    changed: dict[str, str] = field(default_factory=dict)  # key → the override that gave it
    run: Run = field(default_factory=Run)
    system: Wiring = field(default_factory=Wiring)
    coupling: Coupling = field(default_factory=Coupling)
    components: dict[str, Part] = field(default_factory=dict)

    @property
    def steps(self) -> int:
        """Communication steps of the run."""
        return max(1, round((self.run.end - self.run.start) / self.run.step))

    @property
    def dt(self) -> float:
        """The communication step [s]: run.step, or the nearest of which the run holds a whole number."""
        even = (self.run.end - self.run.start) / self.steps
        # to the bit, where it is run.step but for rounding: a run made longer then takes the same steps
        return self.run.step if abs(even - self.run.step) <= 1e-12 * self.run.step else even

    def where(self, table: str, key: str) -> str:
        """For messages: the file, line and key, or the override that gave the value."""
        dotted = f"{table}.{key}" if key else table
        if dotted in self.changed:
            return f"--set {self.changed[dotted]}"
        parent, _, name = table.rpartition(".")  # an inline table may stand on one line of its parent
        places = [(table, key), (f"{table}.{key}", ""), (parent, name), (table, ""), ("", table)]
        line = next((self.lines[place] for place in places if place in self.lines), None)
        return f"{self.path}, " + (f"line {line}, " if line else "") + f"key {dotted}"


TABLES: dict[str, Any] = {n: h for n, h in typing.get_type_hints(Assembly).items() if dataclasses.is_dataclass(h)}


def load(path: Path, overrides: Sequence[str] = ()) -> Assembly:
    """Read a system file and apply `table.key=value` overrides. Raises AeroSloshError (file, line, key, remedy)."""
    data, lines = settings.read(path, "system file", "cases/tank_on_springs.toml")
    return of_data(data, lines, path, path.resolve().parent, overrides)


def of_data(data: dict[str, Any], lines: settings.Lines, path: Path, folder: Path, overrides: Sequence[str] = ()) -> Assembly:
    """The system of a file's content, or of a program's; FMUs lie in `folder`. `path` and `lines` go into messages.

    Raises AeroSloshError."""
    assembly = Assembly(path.stem, folder, path, lines)
    if "flow" in data or "section" in data:
        raise AeroSloshError("This is a flutter case, not a system file", str(path), f"aeroslosh point {path}")
    given = data.pop("components", {})
    settings.fill(assembly, {**TABLES, "components": None}, data, lines, path)
    if not isinstance(given, dict) or not given:
        where = f"{path}, line {lines[('', 'components')]}" if ("", "components") in lines else str(path)
        raise AeroSloshError("The system has no components", where, 'write [components.NAME] with fmu = "…"')
    for name, content in given.items():
        table = f"components.{name}"
        if not re.fullmatch(r"[A-Za-z_][A-Za-z0-9_-]*", name):
            written = enumerate(texts.read(path, "system file").splitlines(), start=1)
            line = next((number for number, text in written if name in text and text.split("#")[0].strip()), "?")
            raise AeroSloshError(
                f"'{name}' is no name for a component",
                f"{path}, line {line}",
                "begin with a letter or _, go on with letters, digits, _ and -: wires write component.variable",
            )
        if not isinstance(content, dict):
            raise AeroSloshError(
                f"'{table}' is a table", assembly.where("components", name), f"write [{table}] with keys below it"
            )
        assembly.components[name] = part = Part()
        settings.fill_table(part, table, content, lines, path)
        if not part.fmu:
            where = f"{path}, line {lines.get((table, ''), '?')}"
            raise AeroSloshError(f"[{table}] names no FMU", where, 'write fmu = "file.fmu"')
    for override in overrides:
        _override(assembly, override)
    if assembly.run.end <= assembly.run.start:
        raise AeroSloshError(
            f"run.end = {assembly.run.end:g} is not after run.start = {assembly.run.start:g}",
            assembly.where("run", "end"),
            "give a later end",
        )
    _check_predictors(assembly)
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
    installed.ensure(folder)
    found = {}
    for name, part in assembly.components.items():
        file = part.fmu if part.fmu.endswith(".fmu") else f"{part.fmu}.fmu"
        places = [assembly.folder / file, folder / file]
        path = next((p for p in places if p.is_file()), None)
        if path is None:
            raise AeroSloshError(
                f"components.{name}: there is no FMU {file}",
                assembly.where(f"components.{name}", "fmu"),
                f"it is neither in {' nor in '.join(str(p.parent) for p in places)}: build the FMUs with `make fmus`, or name "
                "their folder with --fmus DIR or AEROSLOSH_FMUS",
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
                component.check_and_set(variable, value, assembly.where(f"components.{name}.parameters", variable))
        guides = {part.predicts: made[name] for name, part in assembly.components.items() if part.predicts}
        stepped = [made[name] for name, part in assembly.components.items() if not part.predicts]
        try:
            return assemble(stepped, wires(assembly.system.wires), assembly.coupling, guides)
        except AeroSloshError as error:  # what is wrong with a wire or a name: say in which file
            table, key = (
                ("coupling", error.where.partition(".")[2]) if error.where.startswith("coupling.") else ("system", "wires")
            )
            raise AeroSloshError(error.what, f"{assembly.where(table, key)}: {error.where}", error.remedy, error.code) from None
    except BaseException:
        for component in made.values():
            component.close()
        raise


def _check_predictors(assembly: Assembly) -> None:
    """One predicting model a component, and that one stepped. Raises AeroSloshError."""
    seen: dict[str, str] = {}
    wired = {end.strip().partition(".")[0] for line in assembly.system.wires for end in line.split("->")}
    for name, part in assembly.components.items():
        if not part.predicts:
            continue
        where = assembly.where(f"components.{name}", "predicts")
        stepped = [n for n, p in assembly.components.items() if not p.predicts]
        if part.predicts not in stepped:
            known = ", ".join(stepped) or "none"
            raise AeroSloshError(
                f"'{name}' predicts '{part.predicts}', which is not stepped", where, f"components stepped: {known}"
            )
        if part.predicts in seen:
            both = f"'{seen[part.predicts]}' and '{name}'"
            raise AeroSloshError(f"{both} both predict '{part.predicts}'", where, "keep one of them")
        if name in wired:
            raise AeroSloshError(
                f"'{name}' predicts '{part.predicts}' and has no wires of its own",
                assembly.where("system", "wires"),
                f"leave out its wires: it goes by those of '{part.predicts}'",
            )
        seen[part.predicts] = name


def _override(assembly: Assembly, text: str) -> None:
    """`table.key=value`, also `components.NAME.key=value` and `components.NAME.parameters.variable=value`."""
    dotted, equals, value = text.partition("=")
    words = dotted.strip().split(".")
    assembly.changed[dotted.strip()] = text
    if words[0] != "components":
        settings.override(assembly, TABLES, text)
        return
    if len(words) < 3 or not equals or words[1] not in assembly.components:
        known = ", ".join(assembly.components)
        raise AeroSloshError(
            "Such an override has the form components.NAME.key=value", f"--set {text}", f"components are: {known}"
        )
    part = assembly.components[words[1]]
    if words[2] == "parameters" and len(words) > 3:
        part.parameters[".".join(words[3:])] = settings.written(value)
    else:
        settings.assign(part, f"components.{words[1]}", ".".join(words[2:]), settings.written(value), f"--set {text}")
