"""Local worker processes: started, given points, replaced when they die or have grown, one after the other or side by side."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import tempfile
from collections import OrderedDict, deque
from collections.abc import Iterable
from dataclasses import dataclass, field
from multiprocessing import Pipe
from multiprocessing.connection import wait
from typing import Any, Generic, Protocol, TypeVar, cast

from ..base.errors import AeroSloshError
from ..base.paths import PLACE
from .jobs import SETUPS, Job, Probe
from .worker import Answer

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")
GROWN = 512 << 20  # bytes by which a worker's resident memory may grow


class Task(Protocol):
    """What a worker computes: a point of a sweep, a Mach number of a boundary."""

    @property
    def id(self) -> str:
        """Its name."""

    @property
    def label(self) -> str:
        """For the user."""

    @property
    def setup_key(self) -> str:
        """Tasks of one key march the same setup."""


T = TypeVar("T", bound=Task)
P = TypeVar("P")  # what comes of it


class WorkerDied(Exception):
    """A worker ended without an answer; the text says how."""


class Worker:
    """One worker process and the pipe to it. `answered` points so far; `memory` [bytes] after the first and the last of them."""

    def __init__(self, name: str) -> None:
        self.name, self.answered, self.memory = name, 0, (0, 0)
        self.job: Any = None
        self._ready = False
        self.keys: deque[str] = deque(maxlen=SETUPS)
        self.pipe, theirs = Pipe()
        self._said = tempfile.TemporaryFile()  # noqa: SIM115
        path = os.pathsep.join([str(PLACE), *filter(None, [os.environ.get("PYTHONPATH")])])
        self._process = subprocess.Popen(
            [sys.executable, "-c", "from aeroslosh.master.sweeps.worker import main; main()", str(theirs.fileno()), name],
            stdin=subprocess.DEVNULL,
            stderr=self._said,
            pass_fds=[theirs.fileno()],
            env=os.environ | dict.fromkeys(THREADS, "1") | {"PYTHONPATH": path},
        )
        theirs.close()

    @property
    def pid(self) -> int:
        """Of the process."""
        return self._process.pid

    def give(self, what: str, job: Task) -> None:
        """Send a task: "compute" or "probe". Raises WorkerDied."""
        self.job = job
        if job.setup_key not in self.keys:
            self.keys.append(job.setup_key)
        try:
            self.pipe.send((what, job))
        except OSError:
            raise WorkerDied(self._death()) from None

    def take(self) -> Answer | None:
        """Wait for what the worker says: an answer, or None for its first word, that it is ready.

        Raises WorkerDied, and AeroSloshError when a file of the sweep has changed or workers cannot start at all."""
        try:
            answer: Answer = self.pipe.recv()
        except (EOFError, OSError):
            raise WorkerDied(self._death()) from None
        if not self._ready:
            self._ready = True
            return None
        if answer.told is not None:
            return answer
        if answer.refusal is not None:
            raise AeroSloshError(*answer.refusal)
        if answer.product is not None:
            self.answered += 1
            self.memory = (self.memory[0] or answer.memory, answer.memory)
        self.job = None
        return answer

    def ask(self, what: str, job: Task) -> Answer:
        """Give a task and wait for its answer. Raises like `take`."""
        self.give(what, job)
        while (answer := self.take()) is None:
            pass
        return answer

    def end(self) -> None:
        """End the process, whatever it does."""
        self.pipe.close()
        self._process.kill()
        self._process.wait()
        self._said.close()

    def _death(self) -> str:
        """How the process ended, and the last lines it wrote."""
        try:
            code = self._process.wait(timeout=5.0)
        except subprocess.TimeoutExpired:
            return "worker closed its pipe"
        how = f"signal {-code}" if code < 0 else f"exit code {code}"
        if code < 0 and -code in set(signal.Signals):
            how += f" ({signal.Signals(-code).name})"
        self._said.seek(0)
        words = self._said.read().decode("utf-8", "replace").strip()[-2000:]
        if code > 0 and not self._ready:
            remedy = "the worker's own words are above; see that aeroslosh runs on that machine"
            raise AeroSloshError(f"A worker process could not start ({how}): {words}", f"worker {self.name}", remedy)
        return f"worker ended by {how}" + (f"\n{words}" if words else "")


@dataclass
class Events(Generic[T, P]):
    """What happened: points given to a worker (job, worker's name), what workers told on the way, products, points lost with a
    cause, notes for the user."""

    started: list[tuple[T, str]] = field(default_factory=list)
    told: list[tuple[T, tuple[Any, ...]]] = field(default_factory=list)
    products: list[P] = field(default_factory=list)
    lost: list[tuple[T, str]] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)


class LocalPool(Generic[T, P]):
    """`count` workers on this machine, each replaced after `recycle` points."""

    def __init__(self, count: int, recycle: int) -> None:
        self.count, self._recycle = count, recycle
        self._jobs: OrderedDict[str, deque[T]] = OrderedDict()  # by setup: a worker goes on with the setup it has
        self._workers: list[Worker] = []
        self._started = 0

    @property
    def name(self) -> str:
        """For the user."""
        return f"{self.count} local worker{'s' if self.count > 1 else ''}"

    @property
    def size(self) -> int:
        """Points computed at a time."""
        return self.count

    @property
    def room(self) -> int:
        """The pool takes every job at once."""
        return 1 << 30

    def add(self, job: T) -> None:
        """Put a job into the queue."""
        self._jobs.setdefault(job.setup_key, deque()).append(job)

    def prepare(self, jobs: Iterable[Job]) -> list[Probe]:
        """What the first steps of these jobs cost."""
        worker, probes = self._start(), []
        for job in jobs:
            try:
                answer = worker.ask("probe", job)
            except WorkerDied as death:  # the point itself will tell; it is not lost on account of a probe
                worker.end()
                worker = self._start()
                probes.append(Probe(error=str(death)))
                continue
            probes.append(answer.probe or Probe())
        self._workers.append(worker)
        return probes

    def wait(self, seconds: float) -> Events[T, P]:
        """Give out points, then wait until something happens, at most so long. Raises AeroSloshError when a file has changed."""
        events = Events[T, P]()
        waiting = sum(map(len, self._jobs.values()))
        busy = sum(w.job is not None for w in self._workers)
        while len(self._workers) < min(self.count, busy + waiting):
            self._workers.append(self._start())
        for worker in list(self._workers):
            if worker.job is None and self._jobs:
                job = self._next(worker)
                events.started.append((job, worker.name))
                try:
                    worker.give("compute", job)
                except WorkerDied as death:
                    self._lose(worker, job, str(death), events)
        ready = wait([w.pipe for w in self._workers], 0.0 if events.lost else seconds)
        for worker in [w for w in self._workers if w.pipe in ready]:
            self._hear(worker, events)
        return events

    def close(self) -> None:
        """End all workers; what they compute is lost."""
        for worker in self._workers:
            worker.end()
        self._workers.clear()

    def _start(self) -> Worker:
        self._started += 1
        return Worker(f"local-{self._started}")

    def _next(self, worker: Worker) -> T:
        """A point whose setup the worker has open, else one of a setup nobody has, else the oldest."""
        held = {key for w in self._workers for key in w.keys}
        key = next((k for k in worker.keys if k in self._jobs), None)
        key = key or next((k for k in self._jobs if k not in held), None) or next(iter(self._jobs))
        jobs = self._jobs[key]
        job = jobs.popleft()
        if not jobs:
            del self._jobs[key]
        return job

    def _hear(self, worker: Worker, events: Events[T, P]) -> None:
        """Take what a worker says, or its death."""
        job: T | None = worker.job
        try:
            answer = worker.take()
        except WorkerDied as death:
            self._lose(worker, job, str(death), events)
            return
        if answer is not None and answer.told is not None and job is not None:
            events.told.append((job, answer.told))
        if answer is None or answer.product is None or job is None:
            return
        events.products.append(cast(P, answer.product))
        if worker.answered >= self._recycle or worker.memory[1] > worker.memory[0] + GROWN:
            self._retire(worker)

    def _lose(self, worker: Worker, job: T | None, cause: str, events: Events[T, P]) -> None:
        """A worker is dead, and with it what it computed."""
        self._retire(worker)
        if job is not None:
            events.lost.append((job, cause))
            events.notes.append(f"{worker.name}: {cause.splitlines()[0]} while it computed {job.label}")

    def _retire(self, worker: Worker) -> None:
        self._workers.remove(worker)
        worker.end()
