"""Jobs side by side in spawned processes of one thread each.

A pool of its own because of kill -9: when the parent dies each worker finds its pipe closed after the job at hand and ends, while
those of concurrent.futures wait for ever. A worker that dies costs its job alone.
"""

from __future__ import annotations

import contextlib
import os
import time as clock
from collections import deque
from collections.abc import Callable, Generator, Sequence
from multiprocessing import get_context
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple

THREADS = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS")


class Answer(NamedTuple):
    """What came of a job: its number, its result (None after an error), the error's text ("" for none), CPU time [s]."""

    number: int
    result: Any
    error: str
    cpu: float


def run(function: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], workers: int) -> Generator[Answer]:
    """Yield the answers of function(*job), as they come. `function` is picklable; an exception in it becomes an error."""
    waiting = deque(enumerate(jobs))
    busy: dict[Connection, tuple[Any, int]] = {}
    try:
        while waiting or busy:
            while waiting and len(busy) < workers:
                number, job = waiting.popleft()
                pipe, process = _start(function)
                busy[pipe] = process, number
                _give(pipe, number, job)
            for ready in wait(list(busy)):
                assert isinstance(ready, Connection)
                process, number = busy[ready]
                try:
                    answer = Answer(*ready.recv())
                except (EOFError, OSError):
                    process.join()
                    del busy[ready]
                    ready.close()
                    yield Answer(number, None, f"its process ended by {_death(process.exitcode)}", 0.0)
                    continue
                if waiting:
                    number, job = waiting.popleft()
                    busy[ready] = process, number
                    _give(ready, number, job)
                else:
                    del busy[ready]
                    ready.close()
                    process.join()
                yield answer
    finally:
        for pipe, (process, _) in busy.items():
            pipe.close()
            process.kill()
            process.join()


def _start(function: Callable[..., Any]) -> tuple[Connection, Any]:
    """A process that serves `function`, and the pipe to it."""
    context = get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=_serve, args=(theirs, function), daemon=True)
    before = {name: os.environ.get(name) for name in THREADS}
    os.environ.update(dict.fromkeys(THREADS, "1"))  # libraries read these when they are loaded
    try:
        process.start()
    finally:
        for name, value in before.items():
            if value is None:
                del os.environ[name]
            else:
                os.environ[name] = value
    theirs.close()
    return ours, process


def _give(pipe: Connection, number: int, job: tuple[Any, ...]) -> None:
    with contextlib.suppress(OSError):  # a process that is dead already: its pipe tells when it is read
        pipe.send((number, job))


def _death(code: int) -> str:
    return f"signal {-code}" + (", perhaps for want of memory" if code == -9 else "") if code < 0 else f"exit code {code}"


def _serve(pipe: Connection, function: Callable[..., Any]) -> None:
    """Answer jobs until the pipe closes."""
    try:
        while True:
            number, job = pipe.recv()
            begin = clock.process_time()
            try:
                result, error = function(*job), ""
            except Exception as exception:  # some exceptions do not survive pickling: their text does
                result, error = None, f"{type(exception).__name__}: {exception}"
            pipe.send((number, result, error, clock.process_time() - begin))
    except (EOFError, OSError, KeyboardInterrupt):
        os._exit(0)  # a library that was loaded (pythonfmu's) may not survive Python's own end
