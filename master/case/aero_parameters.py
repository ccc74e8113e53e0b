"""Parameters of the aero FMU for a case at a Mach number: for marches, steady slopes, and fields drawn of a motion once more."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from . import fmu_parameters
from .case import Case


def parameters(case: Case, mach: float, known: Mapping[str, Any]) -> dict[str, float | int | str]:
    """Name → value, SI and radians, without a folder for fields; `known`: variables of the FMU.

    Raises AeroSloshError for one of `aero.parameters` that the FMU does not have."""
    values: dict[str, float | int | str] = {
        "mach": mach,
        "mean_alpha": math.radians(case.flow.mean_alpha_deg),
        "chord": case.section.chord,
        "elastic_axis": case.section.elastic_axis,
        "static_pressure": case.flow.static_pressure,
        "static_temperature": case.flow.static_temperature,
        "airfoil": case.flow.airfoil,
        "cells_around": case.aero.cells_around,
        "cells_normal": case.aero.cells_normal,
        "farfield_chords": case.aero.farfield_chords,
    }
    given = {name: getattr(case.aero, name) for name in ("tolerance", "max_subiterations")}
    values |= {name: value for name, value in given.items() if value != "auto"}
    return values | fmu_parameters.values(case.aero.parameters, known)
