"""A worker: a process that computes one point after the other, told what to do through a pipe
(`main`; arguments: the file number of its end, the worker's name).

It ends by itself, also in the middle of a point, when the process at the other end of the pipe is gone, however that ended."""

from __future__ import annotations

import dataclasses
import gc
import os
import pickle
import queue
import signal
import sys
import threading
from dataclasses import dataclass
from multiprocessing.connection import Connection
from typing import Any

from . import jobs, one_mach
from .jobs import Bench, FilesChanged, Job, Probe, Product
from .one_mach import MachJob, Solved

IDLE = 900.0  # seconds without work after which a worker ends: it may have been forgotten on a cluster


@dataclass(frozen=True)
class Answer:
    """What a worker says of a task: one of `product`, `probe`, `refusal` (what, where, remedy of a FilesChanged) is there; before
    that, of a Mach number, any number of answers with `told` (see module `one_mach`).
    The first answer has none of them: the worker is ready.

    memory     resident memory of the worker afterwards, bytes"""

    product: Product | Solved | None = None
    told: tuple[Any, ...] | None = None
    probe: Probe | None = None
    refusal: tuple[str, str, str] | None = None
    memory: int = 0


def main() -> None:
    """Answer tasks until told to stop."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches the whole group; the master decides
    os.dup2(2, 1)  # whatever an FMU prints
    pipe, name = Connection(int(sys.argv[1])), sys.argv[2]
    tasks: queue.SimpleQueue[Any] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(pipe, tasks), daemon=True).start()
    bench = Bench()
    gc.freeze()  # what was imported stays, and is not looked through after every point
    pipe.send(Answer())
    while True:
        try:
            what, job = tasks.get(timeout=IDLE)
        except queue.Empty:
            os._exit(0)
        answer = _answer(what, job, bench, name, lambda told: pipe.send(Answer(told=told)))
        gc.collect()  # every FMU instance leaves cycles; among numba's many objects the collector alone comes too seldom
        pipe.send(dataclasses.replace(answer, memory=resident_memory()))


def resident_memory() -> int:
    """Of this process, in bytes; 0 where the system does not tell."""
    try:
        with open("/proc/self/statm", encoding="ascii") as file:
            return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return 0


def _answer(what: str, job: Job | MachJob, bench: Bench, name: str, tell: one_mach.Tell) -> Answer:
    try:
        if isinstance(job, MachJob):
            return Answer(product=one_mach.compute(job, tell))
        if what == "probe":
            return Answer(probe=jobs.probe(job, bench))
        return Answer(product=jobs.compute(job, bench, name))
    except FilesChanged as error:
        return Answer(refusal=(error.what, error.where, error.remedy))


def _listen(pipe: Connection, tasks: queue.SimpleQueue[Any]) -> None:
    """Hand on what comes through the pipe. `os._exit`: pythonfmu's wrapper can abort at a normal exit."""
    while True:
        try:
            task = pipe.recv()
        except (EOFError, OSError, pickle.UnpicklingError):
            os._exit(1)
        if task is None:
            os._exit(0)
        tasks.put(task)
