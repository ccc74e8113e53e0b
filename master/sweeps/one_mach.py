"""One Mach number of a boundary in a worker process: a job comes in, what happens goes out as it happens, at the end the point.

What is told, each a tuple (word, content …):
  "begin"     the search begins, perhaps anew
  "setup"     SHA-256 of the FMUs by component, what the aero FMU says of its section
  "say"       a line for the user
  "start"     label of a march that begins
  "step"      step and steps of it, now and then
  "march"     a march that is done, and the log of the FMUs since the last: (component, status, text)"""

from __future__ import annotations

import contextlib
import os
import time as clock
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..boundary import solve
from ..boundary.search import BoundaryPoint
from ..case.case import Case
from ..cosim.loop import Watcher
from ..cosim.system import System
from ..flutter.march import March
from ..flutter.setup import FlutterSetup, not_known

EVERY = 0.2  # seconds between two words on how far a march is
Tell = Callable[[tuple[Any, ...]], None]


@dataclass(frozen=True)
class MachJob:
    """The Mach number `case.boundary.mach[0]` to search; `position` among those of the boundary.

    start         V_f and slope that the Mach numbers before it give to begin with; None while these are not all finished
    section_file  where the aero FMU writes its section, if anywhere"""

    position: int
    case: Case
    fmus: dict[str, Path]
    start: tuple[float, float | None] | None = None
    section_file: Path | None = None

    @property
    def mach(self) -> float:
        """The Mach number."""
        return self.case.boundary.mach[0]

    @property
    def id(self) -> str:
        """Its place."""
        return str(self.position)

    @property
    def label(self) -> str:
        """For the user."""
        return f"Mach {self.mach:g}"

    @property
    def setup_key(self) -> str:
        """No job shares a setup with another."""
        return self.id


@dataclass(frozen=True)
class Solved:
    """What became of the job of `position`: its point, or None where it needs a `start`, which it was not given.

    `cpu` seconds that process `pid` has taken since it began"""

    position: int
    point: BoundaryPoint | None
    pid: int
    cpu: float


class _StartNeeded(BaseException):
    """The search needs to know where its neighbours crossed; no failure of the Mach number."""


def compute(job: MachJob, tell: Tell) -> Solved:
    """Search the Mach number of `job`."""
    case, found = job.case, list[BoundaryPoint]()
    tell(("begin",))

    def on_setup(setup: FlutterSetup) -> None:
        tell(("setup", setup.hashes(), setup.airfoil_summary))

    def before_march(setup: FlutterSetup, V_f: float) -> Watcher:
        if job.start is None and case.boundary.method != "linear" and setup.needed_cycles is not_known:
            raise _StartNeeded  # no linear model could be had: marches alone begin where a neighbour crossed
        tell(("start", f"M {setup.mach:g} V_f {V_f:.4g}"))
        shown = 0.0

        def watch(step: int, steps: int, _: System) -> None:
            nonlocal shown
            now = clock.monotonic()
            if step == steps or now - shown >= EVERY:
                shown = now
                tell(("step", step, steps))

        return watch

    def on_march(setup: FlutterSetup, march: March) -> None:
        messages = [(c.name, *said) for c in setup.system.components for said in c.messages]
        for component in setup.system.components:
            component.messages.clear()
        tell(("march", march, messages))

    with contextlib.suppress(_StartNeeded):
        found = solve.solve(
            case,
            job.fmus,
            lambda text: tell(("say", text)),
            on_march=on_march,
            before_march=before_march,
            on_setup=on_setup,
            section_file=lambda: job.section_file,
            start=job.start,
        )
    for point in found:
        point.case = None  # the whole boundary's, which whoever asked has
    return Solved(job.position, found[0] if found else None, os.getpid(), clock.process_time())
