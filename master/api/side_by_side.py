"""The Mach numbers of a boundary side by side in worker processes: they find and tell what one process finds and tells.

A point is kept the moment it is done. What is said of a Mach number waits until those before it are done, so that lines of
several do not mix and come in the order of the case. A worker that dies has its Mach number searched once more. Of a search that
begins anew the user hears what he has not heard yet."""

from __future__ import annotations

import dataclasses
import time as clock
from collections import deque
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..base import interrupts
from ..base.cores import usable_cores
from ..base.errors import AeroSloshError, ExitCode
from ..boundary import search
from ..boundary.search import BoundaryPoint
from ..case.case import Case
from ..flutter.march import March
from ..sweeps.one_mach import MachJob, Solved
from ..sweeps.workers import LocalPool

TRIES = 2  # times a Mach number is given to a worker that dies over it
NUMBERS = "Mach numbers"  # label of how many are done
FOREVER = 1 << 30
Messages = list[tuple[str, int, str]]  # component, FMI status, text


@dataclasses.dataclass
class Listener:
    """Who hears what happens.

    In the order of the Mach numbers: `say` a line, `march` a march, `outcome` a point that is to be told. When it happens:
    `setup` a place, the hashes of its FMUs and its section's line, `keep` a point, `progress` label, done, total and a line of
    all that is at work, `spent` a process and the seconds of CPU that it has taken so far."""

    say: Callable[[str], None]
    march: Callable[[March, Messages], None]
    setup: Callable[[int, dict[str, str], str], None]
    keep: Callable[[BoundaryPoint], None]
    outcome: Callable[[BoundaryPoint], None]
    progress: Callable[[str, int, int, str], None]
    spent: Callable[[int, float], None]


@dataclasses.dataclass
class _Mach:
    """One Mach number: its job, what it told and nobody has heard, how much was heard, how much came in this attempt."""

    job: MachJob
    waiting: deque[tuple[Any, ...]] = dataclasses.field(default_factory=deque)
    heard: int = 0
    came: int = 0
    tries: int = 0
    made: list[March] = dataclasses.field(default_factory=list)
    begin: float = 0.0
    at: tuple[str, int, int] | None = None  # label, step, steps while it is computed
    point: BoundaryPoint | None = None
    held: bool = False  # until those before it are done: then it is known where to start


class SideBySide:
    """Searches every Mach number of `case.boundary` by `workers` processes."""

    def __init__(
        self, case: Case, fmus: dict[str, Path], workers: int, listener: Listener, section_file: Callable[[int], Path | None]
    ) -> None:
        self._case, self._listener = case, listener
        self._machs = [
            _Mach(MachJob(n, dataclasses.replace(case, boundary=dataclasses.replace(case.boundary, mach=[m])), fmus,
                          section_file=section_file(n)))
            for n, m in enumerate(case.boundary.mach)
        ]  # fmt: skip
        self._front = 0  # the first that is not done
        self._pool = LocalPool[MachJob, Solved](workers, FOREVER)

    def run(self) -> list[BoundaryPoint]:
        """The points, in the order of the case. Raises AeroSloshError when workers cannot start, and what the listener raises:
        then marches made of Mach numbers that are not done are given to it as points interrupted."""
        try:
            for mach in self._machs:
                self._give(mach)
            while self._front < len(self._machs):
                self._hear()
        except BaseException as stop:
            self._pool.close()
            if not isinstance(stop, Exception):  # asked to stop
                halves = [m for m in self._machs if m.point is None and m.made]
                points = [search.interrupted(m.job.mach, m.made, m.begin) for m in halves]
                for act in (self._listener.keep, self._listener.outcome):
                    for point in points:
                        act(point)
            raise
        finally:
            self._pool.close()
        return [mach.point for mach in self._machs if mach.point is not None]

    def _give(self, mach: _Mach) -> None:
        """Hand it to the workers, with where to start if that is known."""
        before = self._machs[: mach.job.position]
        if all(other.point is not None for other in before):
            points = [other.point for other in before if other.point is not None]
            start = search.prior(points, mach.job.mach, self._case.flutter.V_f)
            mach.job = dataclasses.replace(mach.job, start=start)
        mach.held = False
        self._pool.add(mach.job)

    def _hear(self) -> None:
        """Wait for what workers say."""
        events = self._pool.wait(1.0)
        for text in events.notes:
            self._note(text)
        for job, _ in events.started:
            mach = self._machs[job.position]
            mach.begin, mach.at = clock.perf_counter(), (job.label, 0, 0)
            self._show(mach)
        for job, told in events.told:
            self._take(self._machs[job.position], told)
        for job, cause in events.lost:
            mach = self._machs[job.position]
            mach.tries += 1
            mach.at = None
            if mach.tries < TRIES:
                self._give(mach)
            else:
                self._done(mach, search.failed(job.mach, _died(job, cause), mach.made, mach.begin))
        for solved in events.products:
            mach = self._machs[solved.position]
            self._listener.spent(solved.pid, solved.cpu)
            if solved.point is not None:
                self._done(mach, solved.point)
            else:
                mach.at, mach.held = None, True
                if mach.job.position == self._front:
                    self._give(mach)

    def _take(self, mach: _Mach, told: tuple[Any, ...]) -> None:
        """What the worker at this Mach number tells."""
        word, *content = told
        if word == "begin":
            mach.came, mach.made = 0, []
            mach.waiting.clear()
        elif word == "setup":
            self._listener.setup(mach.job.position, *content)
        elif word == "start":
            mach.at = (content[0], 0, 0)
        elif word == "step" and mach.at is not None:
            mach.at = (mach.at[0], *content)
            self._show(mach)
        else:
            if word == "march":
                mach.made.append(content[0])
            mach.came += 1
            if mach.came > mach.heard:
                mach.waiting.append(told)
                self._pass_on()

    def _done(self, mach: _Mach, point: BoundaryPoint) -> None:
        """A point: kept at once, its outcome said when it is its turn."""
        point.case = self._case
        with interrupts.held():
            self._listener.keep(point)  # before anything that may cancel
            mach.point, mach.at = point, None
        mach.waiting.append(("outcome", point))
        self._pass_on()
        count = sum(other.point is not None for other in self._machs)
        self._listener.progress(NUMBERS, count, len(self._machs), self._line())

    def _pass_on(self) -> None:
        """What the user may hear now: all of the first Mach number that is not done, and of those done behind it."""
        while self._front < len(self._machs):
            mach = self._machs[self._front]
            while mach.waiting:
                word, *content = mach.waiting.popleft()
                mach.heard += 1
                hear: Callable[..., None] = getattr(self._listener, word)  # say, march, outcome
                hear(*content)
            if mach.point is None:
                if mach.held:
                    self._give(mach)
                return
            self._front += 1

    def _note(self, text: str) -> None:
        """A line of the workers themselves."""
        self._listener.say(f"note: {text}")

    def _show(self, mach: _Mach) -> None:
        if mach.at is not None:
            self._listener.progress(*mach.at, self._line())

    def _line(self) -> str:
        """All that is at work, in a line."""
        count = sum(mach.point is not None for mach in self._machs)
        at = [mach.at for mach in self._machs if mach.at is not None]
        texts = [f"{label}  {step}/{steps}" if steps else label for label, step, steps in at]
        return "   ".join([f"  {count} of {len(self._machs)} done", *texts])


def wanted(workers: int | None, given: str, where: str) -> int:
    """How many processes: as many as were asked for, or one for each usable core. Raises AeroSloshError."""
    if workers is None:
        return usable_cores()
    if isinstance(workers, bool) or int(workers) != workers or workers < 1:
        raise AeroSloshError(given, where, "a whole number, at least 1")
    return int(workers)


def _died(job: MachJob, cause: str) -> AeroSloshError:
    """What a user is told of a Mach number over which workers died."""
    head, _, words = cause.partition("\n")
    error = AeroSloshError(
        f"{head} twice",
        job.label,
        f"search it again: --mach {job.mach:g} --workers 1; less memory: fewer --workers",
        ExitCode.INCOMPLETE,
    )
    error.traceback = words
    return error
