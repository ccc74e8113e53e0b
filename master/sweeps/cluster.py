"""The points of a sweep on a Dask cluster. A task of Dask hands its point to a worker process of our own on that machine, as
local points are computed: same numbers, one interpreter a point, no harm to the Dask worker when an FMU crashes.

The files that points are computed from (FMUs, airfoils) travel once, as a plugin of the cluster that every Dask worker sets up
when it joins; they are stored under their hash and checked before every point."""

from __future__ import annotations

import dataclasses
import hashlib
import os
import queue
import threading
import time as clock
from collections.abc import Callable, Sequence
from concurrent.futures import CancelledError
from pathlib import Path
from typing import Any, cast

from ..base import files as base_files
from ..base.errors import AeroSloshError, ExitCode
from ..fmi import unpack
from ..results.provenance import provenance, source_hash
from .jobs import Job, Probe, Product
from .workers import Events, Worker, WorkerDied

try:
    from distributed import Client, Future, WorkerPlugin
except ImportError:
    raise AeroSloshError(
        "--scheduler needs the package distributed",
        "command line",
        'install it in the environment of aeroslosh, here and on the workers: pip install "distributed>=2024.8"',
    ) from None

AHEAD = 2  # tasks given to the cluster for each of its threads
PATIENCE = 20.0  # seconds to reach the scheduler


# what runs on the cluster's machines


def versions() -> dict[str, str]:
    """Of all that can change a number, the master's own sources included."""
    found: dict[str, str] = provenance({})["versions"]
    return found | {"aeroslosh sources": source_hash()[:12]}


def stored(digest: str, suffix: str) -> Path:
    """Where a machine keeps a file of the sweep."""
    return unpack.cache_root().parent / "sweep_files" / f"{digest}{suffix}"


class Files(WorkerPlugin):
    """Puts files (hash and suffix → content) into the cache of every Dask worker."""

    def __init__(self, files: dict[tuple[str, str], bytes]) -> None:
        self.files = files
        self.name = "aeroslosh-" + hashlib.sha256("".join(sorted(d for d, _ in files)).encode()).hexdigest()[:16]

    def setup(self, worker: Any) -> None:
        """Called by Dask."""
        for (digest, suffix), content in self.files.items():
            path = stored(digest, suffix)
            if not path.is_file() or unpack.sha256(path) != digest:
                path.parent.mkdir(parents=True, exist_ok=True)
                base_files.write(path, content)


class Crew:
    """The worker processes of one Dask worker: one for each of its threads that has a task."""

    def __init__(self) -> None:
        self._idle: list[Worker] = []
        self._lock, self._first = threading.Lock(), threading.Lock()
        self._started = 0
        self._warm: set[str] = set()  # slosh models whose kernels are compiled

    def compute(self, job: Job, recycle: int) -> Product:
        """The point of `job`. Raises WorkerDied, AeroSloshError."""
        model = job.case.slosh.model
        with self._first:  # the kernels are compiled by one of the workers, not by all of them at once
            if model not in self._warm:
                self._once("probe", job, recycle)
                self._warm.add(model)
        product = self._once("compute", job, recycle)
        assert product is not None
        return product

    def _once(self, what: str, job: Job, recycle: int) -> Product | None:
        """A task in an idle worker; None after a probe."""
        with self._lock:
            worker = self._idle.pop() if self._idle else None
            self._started += worker is None
            name = f"{os.uname().nodename}-{os.getpid()}-{self._started}"
        worker = worker or Worker(name)
        try:
            answer = worker.ask(what, job)
        except BaseException:
            worker.end()
            raise
        if worker.answered >= recycle:
            worker.end()
        else:
            with self._lock:
                self._idle.append(worker)
        return cast(Product | None, answer.product)


_crew = Crew()


def task(job: Job, expected: dict[str, str], recycle: int) -> tuple[str, Any]:
    """What Dask runs: ("product", Product), ("died", cause) or ("refused", (what, where, remedy))."""
    here = versions()
    if here != expected:
        return "refused", _mismatch(f"a worker on {os.uname().nodename}", here, expected)
    files = {name: (stored(digest, path.suffix), digest) for name, (path, digest) in job.files.items()}
    case = job.case
    if "airfoil" in files:
        case = dataclasses.replace(case, flow=dataclasses.replace(case.flow, airfoil=str(files["airfoil"][0])))
    try:
        return "product", _crew.compute(dataclasses.replace(job, case=case, files=files), recycle)
    except WorkerDied as death:
        return "died", str(death)
    except AeroSloshError as error:
        return "refused", (error.what, error.where, error.remedy)


def _mismatch(where: str, here: dict[str, str], expected: dict[str, str]) -> tuple[str, str, str]:
    """what, where and remedy of an error about versions that differ."""
    names = sorted(name for name in here.keys() | expected.keys() if here.get(name) != expected.get(name))
    said = ", ".join(f"{name} {here.get(name)} (master: {expected.get(name)})" for name in names)
    return f"The versions of {where} differ: {said}", "--scheduler", "install the same environment (requirements.lock) everywhere"


# the master's side


class DaskPool:
    """The workers of the scheduler at `address`. Raises AeroSloshError when it cannot be reached or its workers do not fit."""

    def __init__(self, address: str, plan_files: Sequence[tuple[Path, str]], recycle: int, say: Callable[[str], None]) -> None:
        self.address, self._recycle, self._say = address, recycle, say
        self._expected = versions()
        self._open: dict[Any, Job] = {}
        self._done: queue.SimpleQueue[Any] = queue.SimpleQueue()
        self._fresh: list[Job] = []
        self._counted = (-1.0, 0)
        try:
            self._client = Client(address, timeout=PATIENCE, set_as_default=False)
        except (OSError, ValueError, TypeError) as error:
            remedy = "start it (`dask scheduler`), and name its address: --scheduler tcp://host:8786"
            raise AeroSloshError(f"No Dask scheduler answers: {error}", f"--scheduler {address}", remedy) from None
        try:
            self._check_workers()
            files = {(digest, path.suffix): path.read_bytes() for path, digest in plan_files}
            self._client.register_plugin(Files(files))
        except BaseException:
            self._client.close()
            raise

    @property
    def name(self) -> str:
        """For the user."""
        return f"Dask scheduler {self.address}, {self.size} threads of workers"

    @property
    def size(self) -> int:
        """Points computed at a time."""
        now = clock.monotonic()
        if now > self._counted[0] + 1.0:  # a question to the scheduler
            self._counted = now, sum(self._client.nthreads().values())
        return self._counted[1]

    @property
    def room(self) -> int:
        """A few tasks more than there are threads."""
        return max(1, AHEAD * self.size) - len(self._open)

    def prepare(self, jobs: Sequence[Job]) -> list[Probe]:
        """Every Dask worker prepares itself with its first point."""
        if not self.size:
            self._say(f"waiting for workers to join {self.address}")
        return []

    def add(self, job: Job) -> None:
        """Give a job to the cluster."""
        key = f"aeroslosh-{job.id}-{job.attempt}-{os.urandom(4).hex()}"
        future = self._client.submit(task, job, self._expected, self._recycle, key=key, pure=False)
        self._open[future] = job
        self._fresh.append(job)
        future.add_done_callback(self._done.put)

    def wait(self, seconds: float) -> Events[Job, Product]:
        """What came back. Raises AeroSloshError when the scheduler is gone or a worker does not fit."""
        started, self._fresh = self._fresh, []
        events: Events[Job, Product] = Events(started=[(job, "cluster") for job in started])
        deadline = clock.monotonic() + (0.0 if started else seconds)
        while True:
            try:
                future = self._done.get(timeout=max(0.0, deadline - clock.monotonic()))
            except queue.Empty:
                break
            self._hear(future, events)
            deadline = 0.0  # take what else is there, then report
        if self._client.status not in ("running", "connecting"):
            raise self._gone()
        return events

    def close(self) -> None:
        """Leave the cluster; points being computed there end by themselves and are thrown away."""
        for future in self._open:
            future.cancel()
        self._client.close(timeout=5)

    def _hear(self, future: Future, events: Events[Job, Product]) -> None:
        job = self._open.pop(future)
        try:
            what, content = future.result(timeout=60)
        except CancelledError:
            raise self._gone() from None
        except Exception as error:  # KilledWorker: the task's Dask workers died, one after the other
            events.lost.append((job, f"{type(error).__name__}: {error}"))
            return
        if what == "refused":
            raise AeroSloshError(*content)
        if what == "died":
            events.lost.append((job, content))
            events.notes.append(f"cluster: {content.splitlines()[0]} while it computed point {job.id}")
        else:
            events.products.append(content)

    def _check_workers(self) -> None:
        """Raises AeroSloshError unless every worker there now has our versions; later ones are refused at their first task."""
        try:
            found = self._client.run(versions)
        except Exception as error:
            remedy = "install aeroslosh with the same environment (requirements.lock) on the workers"
            raise AeroSloshError(
                f"The Dask workers cannot run aeroslosh: {error!r}", f"--scheduler {self.address}", remedy
            ) from None
        for address, here in found.items():
            if here != self._expected:
                raise AeroSloshError(*_mismatch(f"the Dask worker {address}", here, self._expected))

    def _gone(self) -> AeroSloshError:
        remedy = "start it and its workers again, then go on with --resume"
        return AeroSloshError("The Dask scheduler is gone", self.address, remedy, ExitCode.INCOMPLETE)
