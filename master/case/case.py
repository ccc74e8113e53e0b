"""A case: every setting of a flutter run, typed, with unit, range and description; read from TOML, written back resolved.

The tables of the file are the dataclasses of module `tables`, the keys their fields (module `settings` says how they are read).
What a file gives by value (kg/m, Hz, altitude) is turned into the dimensionless keys right after it is read (`by_value`)."""

from __future__ import annotations

import copy
import dataclasses
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..base import settings
from ..base.errors import AeroSloshError
from ..cosim.coupling_settings import Coupling
from . import airfoils, by_value, checks, dimensions, plausible
from .tables import Aero, Boundary, Flow, Flutter, Output, Section, Slosh, Structure, Sweep

__all__ = [
    "TABLES", "Aero", "Boundary", "Case", "Coupling", "Flow", "Flutter", "Output", "Section", "Slosh", "Structure", "Sweep",
    "apply_override", "changed", "dump", "flat", "load",
]  # fmt: skip


@dataclass
class Case:
    """All tables. `name` is the file's stem.

    source  the file it was read from, "" for a case made in code, whose defaults (Isogai's case A) are the author's affair
    given   "table.key" of every key that file, overrides or sweep set; the others stand at their default (`case_checks`)
    derived "table.key" of the dimensionless keys that follow from keys by value → those keys (`by_value.convert`)
    places  "table.key" → file and line, or override, for messages"""

    name: str = "isogai_a"
    section: Section = field(default_factory=Section)
    flow: Flow = field(default_factory=Flow)
    aero: Aero = field(default_factory=Aero)
    structure: Structure = field(default_factory=Structure)
    flutter: Flutter = field(default_factory=Flutter)
    coupling: Coupling = field(default_factory=Coupling)
    boundary: Boundary = field(default_factory=Boundary)
    slosh: Slosh = field(default_factory=Slosh)
    sweep: Sweep = field(default_factory=Sweep)
    output: Output = field(default_factory=Output)
    source: str = field(default="", compare=False)
    given: set[str] = field(default_factory=set, compare=False, repr=False)
    derived: dict[str, tuple[str, ...]] = field(default_factory=dict, compare=False, repr=False)
    places: dict[str, str] = field(default_factory=dict, compare=False, repr=False)


TABLES: dict[str, Any] = {name: hint for name, hint in typing.get_type_hints(Case).items() if dataclasses.is_dataclass(hint)}


def load(path: Path, overrides: Sequence[str] = (), command: str = "") -> Case:
    """Read a TOML case and apply `section.key=value` overrides. Raises AeroSloshError (file, line, key, remedy).

    command: "point" or "boundary" refuses a case without the keys that it needs (`checks.REQUIRED`); "" only reads: a sweep
    may bring them, and whoever marches the case asks then."""
    data, lines = settings.read(path, "case file", "cases/isogai_a.toml")
    case = Case(name=path.stem, source=str(path))
    if "components" in data:
        raise AeroSloshError("This is a system file, not a case", str(path), f"aeroslosh run {path}")
    settings.fill(case, TABLES, data, lines, path)
    case.given = {f"{table}.{name}" for table, content in data.items() for name in content}
    case.places = _places(data, lines, path)
    for override in overrides:
        _override(case, override)  # checked together at the end: two overrides may belong together
    # from here on a coordinate file is named by its full path, wherever the command runs
    case.flow.airfoil = airfoils.found(case.flow.airfoil, path, bool(airfoils.set_by(overrides)))
    _check(case, command, str(path))
    return case


def apply_override(case: Case, override: str) -> None:
    """Apply one `section.key=value` in place; the value is read as TOML, else as a word. Raises AeroSloshError."""
    _override(case, override)
    _check(case, "", f"--set {override}")


def changed(case: Case, values: Mapping[str, Any], where: str, command: str = "") -> Case:
    """A copy of `case` with the keys `values` (table.key → value), checked together, for `command` as in `load`.

    Raises AeroSloshError."""
    copied = copy.deepcopy(case)
    for dotted, value in values.items():
        table, _, name = dotted.partition(".")
        settings.assign(getattr(copied, table), table, name, value, f"{where}, key {dotted}")
        copied.given.add(dotted)
        copied.places = {key: place for key, place in copied.places.items() if not key.startswith(f"{dotted}.")}
        copied.places[dotted] = f"{where}, key {dotted}"
    _check(copied, command, where)
    return copied


def dump(case: Case) -> str:
    """The resolved case as TOML, each key with its unit and description, those at their default marked as such."""
    head = f'# resolved case {case.name}: every key with its value, unit and meaning; "default": nobody gave it\n'
    return head + settings.dump(case, TABLES, case.given if case.source else None, dimensions.comments(case))


def _override(case: Case, override: str) -> None:
    settings.override(case, TABLES, override)
    dotted = override.partition("=")[0].strip()
    case.given.add(dotted)
    case.places = {key: place for key, place in case.places.items() if not key.startswith(f"{dotted}.")}  # of an inline table
    case.places[dotted] = f"--set {override}"


def _check(case: Case, command: str, where: str) -> None:
    """Turn what is given by value into the dimensionless keys, then check the whole; `command` as in `load`."""
    plausible.refuse(case, where)  # what is given in wrong units is to be blamed itself, not what is converted with it
    by_value.convert(case, whole=bool(command) or not case.source)
    if command:
        checks.complete(case, command, where)
    if command == "boundary":
        by_value.one_speed(case)
    checks.together(case, where)


def _places(data: Mapping[str, Any], lines: settings.Lines, path: Path) -> dict[str, str]:
    """File and line of every key, those of inline tables among them."""
    found = {}
    for table, content in data.items():
        for name, value in content.items():
            line = lines.get((table, name), lines.get((f"{table}.{name}", ""), lines.get(("", table), "?")))
            found[f"{table}.{name}"] = f"{path}, line {line}, key {table}.{name}"
            for entry in value if isinstance(value, dict) else ():
                own = lines.get((f"{table}.{name}", entry), line)
                found[f"{table}.{name}.{entry}"] = f"{path}, line {own}, key {table}.{name}.{entry}"
    return found


def flat(case: Case) -> dict[str, Any]:
    """All settings as "table.key" → value."""
    return settings.flat(case, TABLES)
