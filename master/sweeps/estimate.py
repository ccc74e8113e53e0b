"""What a sweep will cost, from a few real steps of a point of every kind of setup in it."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..linear.model import CHECK, REST, STEP, SWEEP
from . import jobs
from .jobs import Job, Probe
from .plan import Plan
from .progress import duration

PROBES = 12  # setups that are tried at most
USUAL = 5  # marches at a Mach number of a boundary, as a rule


@dataclass(frozen=True)
class Estimate:
    """Seconds of one worker for all points, and what they are made of."""

    cpu_seconds: float
    steps: int
    marches: int
    setups: int
    step_milliseconds: dict[str, float]


def size_key(job: Job) -> str:
    """Jobs of one key take the same time a step: slosh model and meshes."""
    slosh = dataclasses.asdict(job.case.slosh)
    return json.dumps([slosh[name] for name in ("model", "cells_x", "cells_y", "modes")] + [dataclasses.asdict(job.case.aero)])


def to_probe(wanted: Sequence[Job]) -> list[Job]:
    """One job of every size, at most PROBES."""
    return list({size_key(job): job for job in reversed(wanted)}.values())[:PROBES]


def label(job: Job) -> str:
    """A size in words."""
    aero = job.case.aero
    return f"{aero.cells_around} x {aero.cells_normal} cells, slosh {job.case.slosh.model}"


def cost(wanted: Sequence[Job], tried: Sequence[Job], probes: Sequence[Probe]) -> Estimate:
    """The cost of all jobs; a size that was not tried (or failed) counts as the mean of the others."""
    known = {size_key(job): probe for job, probe in zip(tried, probes, strict=True) if not probe.error}
    mean = Probe(*(sum(getattr(p, n) for p in known.values()) / max(1, len(known)) for n in ("open_seconds", "step_seconds")))
    total, steps, marches, seen = 0.0, 0, 0, set()
    for job in wanted:
        probe = known.get(size_key(job), mean)
        each, of_it = _work(job)
        total += each * probe.step_seconds
        steps, marches = steps + each, marches + of_it
        if job.kind != "point" or job.setup_key not in seen:
            seen.add(job.setup_key)
            total += probe.open_seconds
    said = {label(job): round(1e3 * probe.step_seconds, 3) for job, probe in zip(tried, probes, strict=True) if not probe.error}
    return Estimate(total, steps, marches, len(seen), said)


def _work(job: Job) -> tuple[int, int]:
    """Steps and marches of a job."""
    a_march = jobs.steps(job)
    if job.kind == "point":
        return a_march, 1
    b = job.case.boundary
    marches = 0 if b.method == "linear" else min(USUAL, b.max_marches) + 3 * b.uncertainty
    sweeps = 0 if b.method == "march" else round((2.0 * (SWEEP + REST) + CHECK) / STEP)
    return len(b.mach) * (sweeps + marches * a_march), len(b.mach) * marches


def data(estimate: Estimate, workers: int) -> dict[str, Any]:
    """As JSON."""
    return dataclasses.asdict(estimate) | {"workers": workers, "wall_seconds": estimate.cpu_seconds / max(1, workers)}


def summary(data: dict[str, Any], plan: Plan) -> str:
    """`data` with the points, for people."""
    guess = f", {USUAL} marches a Mach number taken for granted" if plan.kind == "boundary" else ""
    wall = f"{duration(data['wall_seconds'])} on {data['workers']} workers"
    return "\n".join(
        [
            f"{data['points']} points ({plan.kind}) over {', '.join(plan.names)}; {data['finished']} are finished",
            f"  marches      {data['marches']} ({data['steps']:,} steps{guess}); {data['setups']} setups to open",
            *(f"  a step       {milliseconds:.2f} ms ({name})" for name, milliseconds in data["step_milliseconds"].items()),
            f"  cost         {duration(data['cpu_seconds'])} of one core, {wall}",
        ]
    )
