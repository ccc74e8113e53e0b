"""The march of figures 15 and 16, and its motion driven through one FMU once more for the fields at the paper's instants."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..api.case import Case
from ..api.point import point
from ..case import aero_parameters, fuel_tank
from ..fmi import table_drive
from ..fmi.component import Component
from .boundaries import coarse
from .work import Work

MACH, V_F = 0.80, 0.70
MOTION = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot")
FORCED, FREE = 2.0, 5.0  # cycles


class Instant(NamedTuple):
    """One of the paper's four: number of the step, what it is, cycle of omega_alpha since the start, pitch [rad], h/b."""

    panel: str
    what: str
    step: int
    cycle: float
    alpha: float
    h_over_b: float


@dataclass(frozen=True)
class Replay:
    """The march: its motion (steps + 1, 6) in the order of MOTION, times [s], instants, and the case's scales."""

    times: np.ndarray
    motion: np.ndarray
    instants: list[Instant]
    verdict: str
    said: str
    chord: float
    elastic_axis: float


def march(work: Work) -> Replay:
    """The march with two-phase fuel, computed once for both figures."""
    case = case_of(work)

    def compute() -> dict[str, Any]:
        p = point(case, mach=MACH, V_f=V_F, fmus=work.fmus)
        columns = {name: p.history[name].values.tolist() for name in ("time", "tau", "h_over_b", *MOTION)}
        return {"columns": columns, "release": int(p.history.attrs["release_index"]), "verdict": str(p.verdict), "said": repr(p)}

    found = work.shared("march_fuel", compute)
    c = {name: np.array(values) for name, values in found["columns"].items()}
    return Replay(
        c["time"], np.stack([c[name] for name in MOTION], axis=1), instants(c, found["release"]), found["verdict"], found["said"],
        case["section.chord"], case["section.elastic_axis"],
    )  # fmt: skip


def case_of(work: Work) -> Case:
    """cases/paper_s.toml with two-phase fuel."""
    cycles = {"flutter.forced_cycles": FORCED, "flutter.free_cycles": FREE, "flutter.max_free_cycles": FREE}
    return coarse(work, Case.load("paper_s").changed({"slosh.model": "vof", "flow.mach": MACH, **cycles}))


def instants(columns: Mapping[str, np.ndarray], release: int) -> list[Instant]:
    """The paper's four: a cycle is one of omega_alpha; pi/4 of the fifth free cycle counts from its begin."""
    tau = columns["tau"]
    start = tau[release]
    wanted = (
        ("(a)", "steady flow, fuel at rest", tau[0]), ("(b)", "end of the forced cycles", start),
        ("(c)", "π/4 into the fifth free cycle", start + 2 * math.pi * (FREE - 1) + math.pi / 4),
        ("(d)", "end of the fifth free cycle", start + 2 * math.pi * FREE),
    )  # fmt: skip
    out = []
    for panel, what, place in wanted:
        k = int(np.argmin(np.abs(tau - place)))
        out.append(
            Instant(panel, what, k, float(tau[k] / (2 * math.pi)), float(columns["alpha"][k]), float(columns["h_over_b"][k]))
        )
    return out


def replay(work: Work, shown: Replay, name: str) -> list[Path]:
    """Drive the FMU `name` (aero or slosh_vof) through the motion; the file of its fields at each instant.

    Raises ComponentError where the FMU fails."""
    folder = work.folder(f"fields_{name}")
    case = case_of(work).core
    component = Component(work.fmu(name), name)
    try:
        if name == "aero":
            component.set_all(aero_parameters.parameters(case, MACH, component.variables))
        else:
            component.set_all(fuel_tank.parameters(case.slosh, component.variables))
        place = table_drive.prepare_fields(component, folder)
        first = 1 if name == "aero" else 0  # the aero FMU's fields begin with its first step, the section still at rest there
        steps = {max(first, i.step) for i in shown.instants}
        where = [component.input_index[n] for n in MOTION]
        for n, value in zip(MOTION, shown.motion[0], strict=True):
            component.set(n, float(value))
        component.set("write_fields", 0 in steps)
        component.initialize(float(shown.times[0]))
        for k in range(1, shown.times.size):
            component.inputs.values[where] = shown.motion[k]
            component.set("write_fields", k in steps)
            component.step(float(shown.times[k]) - component.time)
    finally:
        component.close()
    return sorted(place.glob("fields_*.vts"))[-len(shown.instants) :]
