"""What one point computes, in whatever process: a job comes in, a product (its record and its file's bytes) goes out.

A kind of job is a function of `KINDS`. An open setup is kept for the next point that can march it: its aero FMU rewinds to the
steady flow, structure and liquid are new, so that a result does not depend on what was computed before."""

from __future__ import annotations

import time as clock
import traceback
from collections import OrderedDict
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..analysis.verdict import Verdict
from ..base.errors import AeroSloshError, ComponentError
from ..boundary import solve
from ..case.case import Case
from ..case.fuel_tank import FMU
from ..case.scales import scales
from ..flutter import coarse_marches, ensemble
from ..flutter import march as flutter_march
from ..flutter.march import March
from ..flutter.setup import FlutterSetup
from ..fmi import unpack
from ..results import by_value, point_file, summary, trust
from ..results.point_file import Record
from ..results.provenance import provenance
from .plan import mach_of, setup_key

SETUPS = 2  # open setups a worker keeps
PROBED = 12  # steps whose time a probe measures, after as many that warm up


@dataclass(frozen=True)
class Job:
    """One point to compute. `files`: FMU name (or "airfoil") → path and SHA-256; `command` goes into the provenance."""

    id: str
    kind: str
    case: Case
    overrides: dict[str, Any]
    files: dict[str, tuple[Path, str]]
    attempt: int = 1
    command: str = ""

    @property
    def label(self) -> str:
        """For the user."""
        return f"point {self.id}"

    @property
    def setup_key(self) -> str:
        """Jobs of one key march the same setup."""
        return setup_key(self.case, mach_of(self.kind, self.case))

    @property
    def fmus(self) -> dict[str, Path]:
        """The FMU files by component name."""
        return {name: path for name, (path, _) in self.files.items() if name != "airfoil"}


@dataclass(frozen=True)
class Product:
    """A finished point: its record, and the content of its netCDF file."""

    record: Record
    netcdf: bytes


@dataclass(frozen=True)
class Probe:
    """What a few steps of a point cost, in seconds of CPU; `error` says why they could not be made."""

    open_seconds: float = 0.0
    step_seconds: float = 0.0
    error: str = ""


@dataclass
class Computed:
    """What a kind's function returns. `cause` is empty unless the point failed."""

    result: dict[str, Any]
    determined: bool
    marches: list[March] = field(default_factory=list)
    cause: str = ""
    traceback: str = ""


class FilesChanged(AeroSloshError):
    """A file of the sweep is gone or is another than the sweep began with: nothing may be computed from it."""


class _Enough(Exception):
    """A probe has seen its steps."""


class Bench:
    """The open setups of one process, the latest last."""

    def __init__(self) -> None:
        self._setups: OrderedDict[str, FlutterSetup] = OrderedDict()

    def setup(self, job: Job) -> FlutterSetup:
        """A setup for `job`, at its case: one kept, or a new one. Raises AeroSloshError."""
        key = job.setup_key
        setup = self._setups.pop(key, None)
        if setup is None:
            while len(self._setups) >= SETUPS:
                self._setups.popitem(last=False)[1].close()
            setup = FlutterSetup(job.case, job.fmus, job.case.flow.mach)
        self._setups[key] = setup
        setup.case = job.case
        for component in setup.system.components:
            component.messages.clear()
        return setup

    def drop(self, job: Job) -> None:
        """Close the setup of `job`: after a failure nothing of it is trusted."""
        setup = self._setups.pop(job.setup_key, None)
        if setup is not None:
            setup.close()


def compute(job: Job, bench: Bench, worker: str) -> Product:
    """The point of `job`. A failure is a product too. Raises FilesChanged."""
    check_files(job)
    begin = clock.time(), clock.perf_counter(), clock.process_time()
    try:
        found = KINDS[job.kind](job, bench)
    except AeroSloshError as error:
        trace = error.traceback if isinstance(error, ComponentError) else str(error)
        found = Computed({}, False, [], error.what, trace)
    except Exception as error:  # a fault of ours must not end the sweep; the traceback goes where the user looks
        found = Computed({}, False, [], f"internal error: {type(error).__name__}: {error}", traceback.format_exc())
    if found.cause:
        bench.drop(job)
    cpu, wall = clock.process_time() - begin[2], clock.perf_counter() - begin[1]
    record = Record(
        id=job.id,
        kind=job.kind,
        overrides=job.overrides,
        status="failed" if found.cause else "done",
        determined=found.determined and not found.cause,
        result=found.result or None,
        cause=found.cause,
        traceback=found.traceback,
        attempts=job.attempt,
        worker=worker,
        cpu_seconds=cpu,
        wall_seconds=wall,
        started=begin[0],
        finished=clock.time(),
    )
    return finished(record, job, found.marches)


def failed(job: Job, cause: str, worker: str) -> Product:
    """The product of a point that no worker could finish."""
    now = clock.time()
    record = Record(job.id, job.kind, job.overrides, "failed", False, None, cause, "", job.attempt, worker, 0.0, 0.0, now, now)
    return finished(record, job, [])


def finished(record: Record, job: Job, marches: list[March]) -> Product:
    """A product with the provenance of `job`."""
    digests = {name: digest for name, (_, digest) in job.files.items()}
    liquid = FMU.get(job.case.slosh.model, "")
    if liquid in digests:  # by component, as the other commands have it
        digests["slosh"] = digests.pop(liquid)
    about = provenance(digests) | {"command": job.command}
    return Product(record, point_file.pack(record, marches, about))


def check_files(job: Job) -> None:
    """Raises FilesChanged unless every file is what it was when the sweep began."""
    for path, digest in job.files.values():
        if not path.is_file() or unpack.sha256(path) != digest:
            what = "has changed since the sweep began" if path.is_file() else "is gone"
            remedy = "put back the file that the sweep began with and go on with --resume, or start a new sweep with --out"
            raise FilesChanged(f"{path.name} {what}", str(path), remedy)


def probe(job: Job, bench: Bench) -> Probe:
    """Open the setup of `job` and make a few steps: its kernels are compiled then, and their cost is known."""
    check_files(job)
    begin, marks = clock.process_time(), [0.0, 0.0]

    def watch(step: int, steps: int, *_: object) -> None:
        if step in (PROBED, 2 * PROBED):
            marks[step // PROBED - 1] = clock.process_time()
        if step == 2 * PROBED:
            raise _Enough

    try:
        setup = bench.setup(job)
        opened = clock.process_time()
        flutter_march.march(setup, job.case.flutter.V_f, None, watch)
    except _Enough:
        return Probe(opened - begin, (marks[1] - marks[0]) / PROBED)
    except AeroSloshError as error:
        bench.drop(job)
        return Probe(error=error.what)
    bench.drop(job)
    return Probe(opened - begin, 0.0, "the march ended in its first steps")


def steps(job: Job) -> int:
    """Steps of one march of `job`."""
    f = job.case.flutter
    a_cycle = scales(job.case, mach_of(job.kind, job.case), f.V_f).steps_per_cycle
    return round(f.forced_cycles / f.forced_frequency * a_cycle) + round(f.free_cycles * a_cycle)


def _point(job: Job, bench: Bench) -> Computed:
    """One march; its coarse companions only where the sweep asks for them itself: they cost as much as half the sweep."""
    setup, case = bench.setup(job), job.case
    march = ensemble.march(setup, case.flutter.V_f)
    told = None
    if case.flutter.companion and "flutter.companion" in case.given:
        told = coarse_marches.beside(case, job.fmus, march)
        march = coarse_marches.widened(march, told)
    result = summary.march_data(march, setup.steady_cpu, told) | {"airfoil_summary": setup.airfoil_summary or None}
    failure = march.failure
    cause, trace = (failure.what, f"{failure}\n{failure.traceback}") if failure else ("", "")
    return Computed(result, trust.verdict(march) is not Verdict.UNDETERMINED, [march], cause, trace)


def _boundary(job: Job, bench: Bench) -> Computed:
    """All Mach numbers of one boundary; its setups are its own."""
    points = solve.solve(job.case, job.fmus, lambda text: None)
    model = job.case.slosh.model
    rows = [{"slosh": model} | summary.point_data(p) for p in points]
    result = {"slosh": model, "points": rows, "matched": by_value.matched(rows)}
    failures = [p.failure for p in points if p.failure is not None and not p.converged]
    cause = "; ".join(dict.fromkeys(f.what for f in failures))
    trace = "\n".join(f"{f}\n{f.traceback}" for f in failures)
    return Computed(result, all(trust.decided(p) for p in points), [m for p in points for m in p.marches], cause, trace)


KINDS: dict[str, Callable[[Job, Bench], Computed]] = {"point": _point, "boundary": _boundary}
