"""From a case to the points of its sweep: which keys take which values, every point's case checked before anything runs.

A point is what it is made of: its id is a hash of the resolved case (the tables that its command reads), of the FMUs and of the
airfoil's file. The same point twice is one point, and a point computed before is known again wherever the file lies."""

from __future__ import annotations

import copy
import dataclasses
import hashlib
import itertools
import json
import math
import typing
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.stats import qmc

from ..base import settings, toml_text
from ..base.errors import AeroSloshError
from ..case import airfoils, fmu_parameters
from ..case import case as cases
from ..case.case import Case
from ..flutter.setup import find_fmus
from ..fmi import unpack
from .parameters import EXAMPLE, MOST, Parameter

COMMON = ("section", "flow", "aero", "structure", "flutter", "coupling", "slosh")
READS = {"point": COMMON, "boundary": (*COMMON, "boundary")}  # the tables that decide what a point's result is


@dataclass(frozen=True)
class Point:
    """One point. `overrides`: swept key → value; `files`: FMU name (or "airfoil") → path and SHA-256."""

    id: str
    index: int
    overrides: dict[str, Any]
    case: Case
    files: dict[str, tuple[Path, str]]


@dataclass(frozen=True)
class Plan:
    """The whole sweep. `names` are the swept keys, `base` the case apart from them (table.key → TOML text), `fmus` the hashes of
    the FMUs, `repeated` the points asked for more than once."""

    kind: str
    mode: str
    names: tuple[str, ...]
    points: tuple[Point, ...]
    base: dict[str, str]
    fmus: dict[str, str]
    repeated: int


def make(case: Case, parameters: Sequence[Parameter], fmu_folder: Path, where: str) -> Plan:
    """Every point of the sweep of `case` over `parameters`; `where` is the case's file, for messages.

    Raises AeroSloshError for a key or value that is none, an airfoil that is none, a point whose keys do not go together, FMUs
    that are missing."""
    kind = case.sweep.command
    if not parameters:
        remedy = 'write [sweep.parameters] with lines like "flow.mach" = [0.7, 0.8], or give --grid flow.mach=0.7,0.8'
        raise AeroSloshError("The sweep has no parameters", where, remedy)
    wholes = {p.name for p in parameters if _whole(case, p.name, fmu_folder)}
    for p in parameters:
        _check(case, kind, p, p.name in wholes)
    names = tuple(p.name for p in parameters)
    if len(set(names)) < len(names) or {"flow.mach", "boundary.mach"} <= set(names):
        raise AeroSloshError(f"A key is swept twice: {', '.join(names)}", where, "keep one of them")
    bare = dataclasses.replace(copy.deepcopy(case), sweep=cases.Sweep(), output=cases.Output())
    digests: dict[Path, str] = {}
    points: dict[str, Point] = {}
    known: set[str] = set()
    combinations = _combinations(case, parameters, where, wholes)
    for n, values in enumerate(combinations, start=1):
        overrides = dict(zip(names, values, strict=True))
        text = ", ".join(f"{name} = {toml_text.literal(value)}" for name, value in overrides.items())
        own = cases.changed(bare, _keys(kind, overrides, where), f"{where}, point {n} of the sweep ({text})", kind)
        files = _files(own, fmu_folder, digests)
        fmu_parameters.check(own, {name: path for name, (path, _) in files.items()})
        if own.flow.airfoil not in known:
            place = parameters[names.index(airfoils.KEY)].where if airfoils.KEY in names else airfoils.place(case)
            airfoils.check(own.flow.airfoil, place, files["aero"][0], Path(where).parent, Path())
            known.add(own.flow.airfoil)
        label = _identity(kind, own, files)
        points.setdefault(label, Point(label, len(points), overrides, own, files))
    base = {name: value for name, value in _content(kind, bare).items() if name not in names}
    fmus = {name: digest for p in points.values() for name, (_, digest) in p.files.items() if name != "airfoil"}
    return Plan(kind, case.sweep.mode, names, tuple(points.values()), base, fmus, len(combinations) - len(points))


def setup_key(point_case: Case, mach: float) -> str:
    """Everything that an open setup depends on: two points of one key can march the same setup."""
    slosh = dataclasses.replace(point_case.slosh, seed=0, members=1)  # told the tank at each start
    tables = [dataclasses.asdict(table) for table in (point_case.flow, point_case.aero, slosh, point_case.coupling)]
    return json.dumps([*tables, point_case.section.chord, point_case.section.elastic_axis, mach], sort_keys=True)


def mach_of(kind: str, case: Case) -> float:
    """The Mach number at which a point starts."""
    return case.boundary.mach[0] if kind == "boundary" else case.flow.mach


def _check(case: Case, kind: str, p: Parameter, whole: bool) -> None:
    """Refuse a key that does not exist or cannot matter, and each value that the key does not allow; `whole`: it takes whole
    numbers alone."""
    table, dot, name = p.name.partition(".")
    if not dot or table not in cases.TABLES:
        raise AeroSloshError(
            f"'{p.name}' is no table.key of a case", p.where, settings.nearest(table, list(READS[kind]), "the tables are")
        )
    if table not in READS[kind]:
        more = '; [boundary] matters with sweep.command = "boundary"' if table == "boundary" else ""
        raise AeroSloshError(
            f"{p.name} changes nothing in a point of this sweep", p.where, f"sweep keys of {', '.join(READS[kind])}{more}"
        )
    values = p.values or (p.low, p.high)
    target = copy.deepcopy(getattr(case, table))
    for value in values:
        settings.assign(target, table, name, round(value) if whole and not p.values else value, p.where)


def _whole(case: Case, name: str, fmu_folder: Path) -> bool:
    """Whether a key, if there is one of this name, takes whole numbers and no others."""
    table, _, key = name.partition(".")
    if table in fmu_parameters.TABLES and key.startswith(f"{fmu_parameters.KEY}."):
        return fmu_parameters.whole(case, name, find_fmus(fmu_folder, case.slosh.model, case.slosh.predictor))
    hint = typing.get_type_hints(cases.TABLES[table]).get(key) if table in cases.TABLES else None
    kinds = typing.get_args(hint) or (hint,)
    return int in kinds and float not in kinds


def _combinations(case: Case, parameters: Sequence[Parameter], where: str, wholes: Set[str]) -> list[tuple[Any, ...]]:
    """The values of every point, in the order of `parameters`; `wholes`: the names of those that take whole numbers alone."""
    mode = case.sweep.mode
    if mode == "latin-hypercube":
        return _drawn(case, parameters, wholes)
    columns = []
    for p in parameters:
        if not p.values and not p.count:
            raise AeroSloshError(f"The range of {p.name} has no count", p.where, EXAMPLE)
        columns.append(p.values or tuple(_in_range(p, i / (p.count - 1), p.name in wholes) for i in range(p.count)))
    lengths = [len(column) for column in columns]
    if (math.prod(lengths) if mode == "grid" else max(lengths)) > MOST:
        raise AeroSloshError(f"The sweep has {math.prod(lengths):,} points", where, f"at most {MOST:,}: take fewer values")
    if mode == "grid":
        return list(itertools.product(*columns))
    if len(set(lengths)) > 1:
        said = ", ".join(f"{p.name} {n}" for p, n in zip(parameters, lengths, strict=True))
        raise AeroSloshError(f"A list needs as many values of every key: {said}", parameters[0].where, 'or take mode = "grid"')
    return list(zip(*columns, strict=True))


def _drawn(case: Case, parameters: Sequence[Parameter], wholes: Set[str]) -> list[tuple[Any, ...]]:
    """Latin hypercube (McKay, Beckman and Conover 1979, doi 10.1080/00401706.1979.10489755): every range cut into as many
    slices as there are points, one value in each slice; a list is cut into equal shares."""
    unit = qmc.LatinHypercube(len(parameters), rng=np.random.default_rng(case.sweep.seed)).random(case.sweep.samples)
    return [
        tuple(
            p.values[int(u * len(p.values))] if p.values else _in_range(p, float(u), p.name in wholes)
            for p, u in zip(parameters, row, strict=True)
        )
        for row in unit
    ]


def _in_range(p: Parameter, share: float, whole: bool) -> float | int:
    """The value at `share` (0 to 1) of the range: 12 digits, so that 0.6 is 0.6; whole where the key wants that."""
    if p.log:
        value = p.low * (p.high / p.low) ** share
    else:
        value = p.low + share * (p.high - p.low)
    return round(value) if whole else float(f"{value:.12g}")


def _keys(kind: str, overrides: Mapping[str, Any], where: str) -> dict[str, Any]:
    """The keys to set for `overrides`: a boundary's Mach numbers are a list, an airfoil's file lies beside the case."""
    keys = dict(overrides)
    if kind == "boundary" and "flow.mach" in keys:
        keys["boundary.mach"] = [keys["flow.mach"]]
    airfoil = keys.get(airfoils.KEY)
    if isinstance(airfoil, str):
        keys[airfoils.KEY] = airfoils.found(airfoil, Path(where), set_=False)
    return keys


def _files(case: Case, fmu_folder: Path, digests: dict[Path, str]) -> dict[str, tuple[Path, str]]:
    """The files that a point is computed from, with their hashes (kept in `digests`)."""
    files = {name: path.resolve() for name, path in find_fmus(fmu_folder, case.slosh.model, case.slosh.predictor).items()}
    if Path(case.flow.airfoil).is_file():
        files["airfoil"] = Path(case.flow.airfoil).resolve()
    for path in files.values():
        if path not in digests:
            digests[path] = unpack.sha256(path)
    return {name: (path, digests[path]) for name, path in files.items()}


def _content(kind: str, case: Case) -> dict[str, str]:
    """table.key → TOML text of the tables that decide the result; an airfoil's file counts by its content, not by its place."""
    content = {
        f"{table}.{f.name}": toml_text.literal(getattr(getattr(case, table), f.name))
        for table in READS[kind]
        for f in dataclasses.fields(getattr(case, table))
        if getattr(getattr(case, table), f.name) is not None
    }
    if Path(case.flow.airfoil).is_file():
        content["flow.airfoil"] = "a file"
    return content


def _identity(kind: str, case: Case, files: Mapping[str, tuple[Path, str]]) -> str:
    """The point's id: 16 hexadecimal digits."""
    text = json.dumps([kind, _content(kind, case), {name: digest for name, (_, digest) in files.items()}], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]
