"""Parameters of the FMUs that have no key of their own: the tables [aero.parameters], [structure.parameters], [slosh.parameters].

What an FMU has, with type and range, its own model description says; a wrong name, type or value is refused before anything
starts. What the case sets itself (masses, Mach number, meshes, …) has one place, its key, and is refused here with that key."""

from __future__ import annotations

import dataclasses
import functools
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import fmpy

from ..base import settings
from ..base.errors import AeroSloshError
from ..fmi import unpack
from ..fmi.values import Value, fitted
from .tables import Slosh

if TYPE_CHECKING:
    from .case import Case

TABLES = ("aero", "structure", "slosh")
KEY = "parameters"
FMU = {"frozen": "slosh_ems", "ems": "slosh_ems", "rbf": "slosh_rbf", "vof": "slosh_vof"}  # slosh.model → FMU
_MASTERS = "coupling.predictor_order (the master extrapolates itself)"
_LIQUID = "the keys of [slosh] (the liquid that the structure carries)"
_TRIM = "nothing: the trim is that of the steady flow and the liquid at rest"
RESERVED: dict[str, dict[str, str]] = {  # table → variable → what sets it
    "aero": {
        "mach": "flow.mach",
        "mean_alpha": "flow.mean_alpha_deg",
        "chord": "section.chord",
        "elastic_axis": "section.elastic_axis",
        "static_pressure": "flow.static_pressure or flow.altitude",
        "static_temperature": "flow.static_temperature or flow.altitude",
        "airfoil": "flow.airfoil",
        "cells_around": "aero.cells_around",
        "cells_normal": "aero.cells_normal",
        "farfield_chords": "aero.farfield_chords",
        "tolerance": "aero.tolerance",
        "max_subiterations": "aero.max_subiterations",
        "field_folder": "output.fields",
        "section_file": "output.pictures",
        "motion_prediction": _MASTERS,
    },
    "structure": {
        "mass": "section.mass or section.mass_ratio",
        "static_imbalance": "section.static_imbalance, section.x_cg or section.x_alpha",
        "inertia": "section.inertia, section.inertia_cg or section.r2_alpha",
        "omega_h": "section.plunge_frequency, section.plunge_stiffness or section.frequency_ratio",
        "omega_alpha": "section.pitch_frequency, section.pitch_stiffness or flutter.V_f",
        "damping_ratio_h": "section.damping_ratio_h",
        "damping_ratio_alpha": "section.damping_ratio_alpha",
        "liquid_mass": _LIQUID,
        "liquid_static_moment": _LIQUID,
        "liquid_inertia": _LIQUID,
        "liquid_stiffness": _LIQUID,
        "forced_amplitude": "flutter.forced_amplitude_deg",
        "forced_frequency": "flutter.forced_frequency",
        "forced_cycles": "flutter.forced_cycles",
        "forced_ramp_cycles": "flutter.forced_ramp_cycles",
        "initial_alpha_dot": "flutter.initial_alpha_dot",
        "trim_lift": _TRIM,
        "trim_moment": _TRIM,
        "load_prediction": _MASTERS,
    },
    "slosh": {
        **{f.name: f"slosh.{f.name}" for f in dataclasses.fields(Slosh) if f.name != KEY},
        "field_folder": "nothing in a flutter case: `aeroslosh drive FMU --fields` writes a liquid's fields",
        "motion_prediction": _MASTERS,
    },
}


def check(case: Case, fmus: Mapping[str, Path]) -> None:
    """Refuse a parameter that an FMU of this case has not, that its key sets, of a wrong type or out of range.

    fmus: component or FMU name → file. Raises AeroSloshError with file, line and key (or the override)."""
    for table in TABLES:
        for name, value in getattr(case, table).parameters.items():
            key, where = f"{table}.{KEY}.{name}", place(case, table, name)
            if name in RESERVED[table]:
                raise AeroSloshError(f"{key}: the case sets {name} itself", where, f"give {RESERVED[table][name]}")
            files = [fmus[fmu] for fmu in _fmus(case, table) if fmu in fmus]
            if files:
                _check_one(table, name, value, files, where)


def place(case: Case, table: str, name: str) -> str:
    """File, line and key (or the override) that gave the parameter."""
    key = f"{table}.{KEY}.{name}"
    return case.places.get(key) or case.places.get(f"{table}.{KEY}") or f"{case.source or case.name}, key {key}"


def blamed(case: Case, table: str, told: str) -> str | None:
    """The parameter of the case's table that an FMU's error speaks of first, by name or by its text; None for none."""
    given = getattr(case, table).parameters
    spots = {name: told.find(name) for name in given} | {
        name: told.find(value) for name, value in given.items() if name not in told and isinstance(value, str) and value
    }
    named = [name for name, spot in spots.items() if spot >= 0]
    return min(named, key=lambda name: spots[name]) if named else None


def values(parameters: Mapping[str, Any], variables: Mapping[str, Any]) -> dict[str, Value]:
    """Those of the checked `parameters` that an FMU with these `variables` (name → FMPy's) has, as the FMU takes them."""
    return {name: fitted(variables[name], value, name, name) for name, value in parameters.items() if name in variables}


def whole(case: Case, key: str, fmus: Mapping[str, Path]) -> bool:
    """Whether the FMU parameter `key` (table.parameters.name) takes whole numbers and no others."""
    table, _, name = key.split(".", 2)
    found = [_variables(fmus[fmu]).get(name) for fmu in _fmus(case, table) if fmu in fmus]
    return any(variable is not None and variable.type in ("Integer", "Enumeration") for variable in found)


def _fmus(case: Case, table: str) -> list[str]:
    """The names of the FMUs that the table's parameters may belong to."""
    if table != "slosh":
        return [table]
    return [FMU[model] for model in (case.slosh.model, case.slosh.predictor) if model in FMU]


def _check_one(table: str, name: str, value: Any, files: Sequence[Path], where: str) -> None:
    """One free parameter against the FMUs `files`, of which at least one must have it."""
    own = {file: _variables(file) for file in files}
    names = sorted({n for found in own.values() for n in found if n not in RESERVED[table]})
    having = [found[name] for found in own.values() if name in found]
    if not having:
        remedy = settings.nearest(name, names, "those without a key of their own are") if names else "it has none without a key"
        others = "; another slosh model's parameter? leave it out with --set 'slosh.parameters={}'" if table == "slosh" else ""
        files_named = " and ".join(file.name for file in files)
        raise AeroSloshError(f"{files_named} has no parameter '{name}'", where, remedy + others)
    for variable in having:
        fitted(variable, value, f"{table}.{KEY}.{name}", where)


def _variables(path: Path) -> dict[str, Any]:
    """The parameters of the FMU at `path`: name → FMPy's model variable."""
    return _read(str(path), path.stat().st_mtime_ns)


@functools.lru_cache(maxsize=32)
def _read(path: str, changed: int) -> dict[str, Any]:
    try:
        description = fmpy.read_model_description(str(unpack.unzip(Path(path))[0]), validate=False)
    except AeroSloshError:
        raise
    except Exception as error:  # FMPy raises bare Exceptions here
        raise AeroSloshError(f"{Path(path).name} cannot be read: {error}", path, "give an FMI 2.0 FMU") from None
    return {v.name: v for v in description.modelVariables if v.causality == "parameter"}
