"""Sweeps: computed in a folder, resumable, by worker processes or a cluster; and as one Dataset over the swept keys."""

from __future__ import annotations

import math
import os
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..base import notices, toml_text
from ..base.cores import usable_cores
from ..base.errors import AeroSloshError
from ..case import case as cases
from ..fmi import kernels
from ..results.provenance import provenance, source_hash
from ..sweeps import estimate, plan, results
from ..sweeps import sweep as sweeps
from ..sweeps.jobs import Job, Product
from ..sweeps.ledger import Ledger, Row
from ..sweeps.parameters import parameter
from ..sweeps.plan import Plan
from ..sweeps.progress import SweepProgress
from ..sweeps.sweep import Pool, Store
from ..sweeps.workers import LocalPool
from . import datasets
from .case import Case, plain
from .point import fmu_folder, warned
from .progress import Callback, Cancelled, ToCallback, Update, interruptible

if TYPE_CHECKING:
    import xarray as xr

RECYCLE = 500  # points after which a worker process is replaced
MODES = ("grid", "list", "latin-hypercube")


@dataclass
class Settings:
    """How a sweep is computed: `workers` processes, each replaced after `recycle` points, or the Dask cluster at `scheduler`;
    `resume` goes on with the sweep in the folder, `retry_failed` computes its failed points again."""

    workers: int = field(default_factory=usable_cores)
    recycle: int = RECYCLE
    scheduler: str | None = None
    resume: bool = False
    retry_failed: bool = False


def sweep(
    case: Case | str | os.PathLike[str],
    parameters: Mapping[str, Any],
    *,
    mode: str = "grid",
    command: str = "point",
    samples: int | None = None,
    seed: int | None = None,
    folder: str | os.PathLike[str] | None = None,
    workers: int | None = None,
    scheduler: str | None = None,
    resume: bool = True,
    retry_failed: bool = False,
    fmus: str | os.PathLike[str] | None = None,
    progress: bool | Callback = False,
) -> xr.Dataset:
    """Compute points (or boundaries) of `case` over swept keys; returns a Dataset over them.

    parameters  key → values, or → {"from": low, "to": high, "count": n, "spacing": "linear" or "log"}, for instance
                {"flow.mach": [0.7, 0.8], "slosh.fill_level": {"from": 0.2, "to": 0.8, "count": 4}}
    mode        "grid" (every combination; the Dataset's dimensions are the keys), "list" (values that go together; dimension
                `point`), "latin-hypercube" (`samples` drawn from ranges with `seed`; dimension `point`)
    command     "point" or "boundary" (then V_f is its lowest onset; several Mach numbers in one give rows of `point`)
    folder      the sweep's folder, in which an interrupted one goes on (unless not `resume`); None: a temporary one
    workers     processes (default: one for each usable core); `scheduler`: the URL of a Dask cluster instead
    progress    True: lines on standard error; a callback is given `Update`s of points done and cancels by returning False

    A point that fails is an outcome (`status` "failed", `cause`). Cancelled or interrupted, what is finished is kept in the
    folder; of a cancelled sweep it is returned. Raises AeroSloshError, KeyboardInterrupt."""
    if mode not in MODES:
        raise AeroSloshError(f"mode = '{mode}'", "ae.sweep", f"one of {', '.join(MODES)}")
    changes = {"sweep.mode": mode, "sweep.command": command, "sweep.samples": samples, "sweep.seed": seed}
    if workers is not None and (isinstance(workers, bool) or int(workers) != workers or workers < 1):
        raise AeroSloshError(f"workers = {workers!r}", "ae.sweep", "a whole number, at least 1")
    if not isinstance(parameters, Mapping):
        raise AeroSloshError(f"parameters = {parameters!r}", "ae.sweep", 'a dictionary: {"flow.mach": [0.7, 0.8]}')
    core = Case.of(case).changed({k: v for k, v in changes.items() if v is not None}).core
    swept = [parameter(name, _content(values), f"ae.sweep, {name}") for name, values in parameters.items()]
    core.sweep.parameters = {p.name: p.written for p in swept}
    wanted = plan.make(core, swept, fmu_folder(fmus), core.source or "ae.sweep")
    warned([p.case for p in wanted.points], command)
    settings = Settings(int(workers or usable_cores()), RECYCLE, scheduler, resume, retry_failed)
    with tempfile.TemporaryDirectory(prefix="aeroslosh_sweep_") as temporary, interruptible():
        place = Path(folder).absolute() if folder is not None else Path(temporary) / "sweep"
        reporter = _ToCallback(progress) if callable(progress) else SweepProgress(quiet=not progress)
        make_folder(place, place.exists() and sweeps.begun(place) and resume)
        with sweeps.locked(place):
            if sweeps.begun(place) and not resume:
                remedy = "go on with it: resume = True; start anew: another folder, or remove it"
                raise AeroSloshError("The folder holds a sweep already", str(place), remedy)
            store = Store.open(place, reporter.say)
            try:
                run(core, wanted, store, settings, reporter)
            except Cancelled:
                pass
            finally:
                store.close()
        found = dataset(place)
        if folder is None:
            del found.attrs["folder"]  # a temporary one
        return found


def run(
    case: cases.Case,
    wanted: Plan,
    store: Store,
    settings: Settings,
    reporter: SweepProgress,
    say: Callable[[str], None] | None = None,
    command: str = "",
) -> None:
    """Compute what is left of the plan into the folder of `store`, which this process holds locked.

    say, command  for the log, and for the provenance; by default the reporter's and the program's command line
    Raises AeroSloshError (INCOMPLETE: full disk, cluster gone)."""
    tell = say or reporter.say

    def on_product(product: Product) -> None:
        reporter.took(product.record.wall_seconds)
        if product.record.cause:
            tell(f"point {product.record.id} failed: {product.record.cause}")

    case.given |= set(wanted.names)  # case.toml marks as defaults what is neither given nor swept
    store.enter(wanted, provenance({})["versions"] | {"aeroslosh sources": source_hash()[:12]})
    store.write("case.toml", cases.dump(case).encode())
    store.mend()
    if settings.retry_failed:
        tell(f"{store.retry()} failed points are computed again")
    left = store.left(wanted)
    if not left:
        return
    if settings.scheduler is None:
        with notices.to(tell):
            kernels.prepare_all(dict.fromkeys(p for job in left for p in job.fmus.values()))
    pool = _pool(settings, wanted, tell)
    try:
        tell(f"{len(left)} of {len(wanted.points)} points to compute on {pool.name}")
        _forecast(pool, left, reporter)
        sweeps.run(wanted, store, pool, command or " ".join(sys.argv), reporter.show, on_product)
    finally:
        pool.close()


def dataset(folder: Path) -> xr.Dataset:
    """The finished points of a sweep folder, whatever computed them; attributes name the folder and what is not finished.

    Raises AeroSloshError where there is no sweep."""
    path = folder / "ledger.sqlite"
    if not path.is_file():
        raise AeroSloshError("There is no sweep", str(folder), "give the folder that a sweep wrote, whole")
    ledger = Ledger(path)
    try:
        rows, about = ledger.rows(), ledger.about()
    finally:
        ledger.close()
    return _dataset(rows, about, folder)


def make_folder(folder: Path, resume: bool) -> None:
    """Make the folder, or see that it is a sweep's. Raises AeroSloshError."""
    if sweeps.begun(folder):
        return
    if resume:
        remedy = "start it without --resume, or name its folder with --out"
        raise AeroSloshError("There is no sweep to resume", str(folder), remedy)
    if folder.exists() and (not folder.is_dir() or any(p.name != sweeps.LOCK for p in folder.iterdir())):
        remedy = "give another folder with --out, or remove it"
        raise AeroSloshError("The output folder exists and holds something else than a sweep", str(folder), remedy)
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise sweeps.unwritable(error, folder) from None


class _ToCallback(SweepProgress):
    """Points done, to a callback."""

    def __init__(self, callback: Callback) -> None:
        super().__init__(quiet=True)
        self._to = ToCallback(callback)

    def say(self, text: str) -> None:
        """An event."""
        self._to.say(text)

    def show(self, counts: dict[str, int]) -> None:
        """Points pending, done and failed. Raises Cancelled."""
        total = sum(counts.values())
        self._to.update(Update("points", total - counts["pending"], total))


def _content(values: Any) -> Any:
    """What a swept key takes, as a case file writes it: numpy's numbers as Python's."""
    found = plain(values)
    return found if isinstance(found, list | dict) else [found]


def _pool(settings: Settings, wanted: Plan, say: Callable[[str], None]) -> Pool:
    """Local workers, or those of a cluster."""
    if settings.scheduler is None:
        return LocalPool(settings.workers, settings.recycle)
    from ..sweeps.cluster import DaskPool  # a package that only clusters need

    files = {file for p in wanted.points for file in p.files.values()}
    return DaskPool(settings.scheduler, sorted(files), settings.recycle, say)


def _forecast(pool: Pool, left: list[Job], reporter: SweepProgress) -> None:
    """Expect so much time of a point."""
    tried = estimate.to_probe(left) if pool.size > 1 else []
    probes = pool.prepare(tried)
    reporter.workers = min(pool.size, len(left))
    if probes:
        reporter.expected = estimate.cost(left, tried, probes).cpu_seconds / len(left)


def _dataset(rows: Sequence[Row], about: dict[str, Any], folder: Path) -> xr.Dataset:
    kind = str(about.get("kind", "point"))
    finished = [row for row in rows if row.status in ("done", "failed")]
    names = list(dict.fromkeys(name for row in rows for name in row.overrides))
    table = results.flat(finished, kind, names)
    for line in table:  # a list or a table is no coordinate: its text is
        line |= {n: toml_text.literal(line[n]) for n in names if isinstance(line[n], list | dict)}
    combinations = {tuple(line[name] for name in names) for line in table}
    axes = [len({line[name] for line in table}) for name in names]
    whole = bool(table) and len(table) == len(combinations) == math.prod(axes)
    keys = ["status", *results.RESULTS[kind], "cause", "cpu_seconds", "wall_seconds"]
    found = datasets.grid(table, names, [k for k in keys if k not in names], whole)
    return found.assign_attrs(folder=str(folder), points=len(rows), finished=len(finished), command=kind)
