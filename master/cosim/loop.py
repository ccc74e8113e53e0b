"""The one loop over communication steps, and the observers that look on and may end it.

A march ends early with a `Stop`: which kind of end it was (`End`), in words what happened, and whether the step in which it
happened counts. A failing component is such an end too: what was marched before it is kept."""

from __future__ import annotations

import time as clock
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import Any

import numpy as np

from ..base.errors import ComponentError
from .assemble import Statistics
from .checkpoint import Arrays, Keeper
from .scheme import Scheme, StepReport
from .system import System

Watcher = Callable[[int, int, System], None]  # step, steps, system


class End(Enum):
    """How a march can end early; the value is the remedy."""

    NOT_FINITE = "a smaller step, or coupling.scheme = 'implicit'"
    TOO_LARGE = "a smaller flutter.forced_amplitude_deg, or a greater flutter.max_alpha_deg"
    FAILED = "what the component's own message says"


@dataclass(frozen=True)
class Stop:
    """Why a march ended early. `counts`: whether the step it ended in is part of the result."""

    end: End
    text: str
    counts: bool = True


class Observer:
    """Looks on. What it returns after a step ends the march; later observers do not see that step."""

    def before(self, loop: Loop, step: int) -> None:
        """`step` is about to be made."""

    def after(self, loop: Loop, step: int, report: StepReport) -> Stop | None:
        """`step` has been made."""


@dataclass
class Loop:
    """A system and a scheme, both started, on their way. `target`: the step it marches to; `done`: the last that counts."""

    system: System
    scheme: Scheme
    dt: float
    observers: Sequence[Observer]
    done: int = 0
    target: int = 0
    stop: Stop | None = None
    failure: ComponentError | None = None
    _early: list[Observer] = field(init=False)

    def __post_init__(self) -> None:
        self._early = [o for o in self.observers if type(o).before is not Observer.before]

    def to(self, target: int) -> bool:
        """March on to step `target`; whether it got there. A component's failure is kept in `failure`, not raised."""
        self.target = target
        try:
            for step in range(self.done + 1, target + 1):
                for observer in self._early:
                    observer.before(self, step)
                report = self.scheme.step(self.system, self.dt)
                for observer in self.observers:
                    self.stop = observer.after(self, step, report)
                    if self.stop is not None:
                        self.done = step if self.stop.counts else step - 1
                        return False
                self.done = step
        except ComponentError as error:
            self.failure, self.stop = error, Stop(End.FAILED, error.what, counts=False)
            return False
        return True


class Counter(Observer):
    """Counts what the scheme took. `start`: time of step 0 [s]."""

    def __init__(self, statistics: Statistics, start: float = 0.0) -> None:
        self._statistics, self._start = statistics, start

    def after(self, loop: Loop, step: int, report: StepReport) -> None:
        """One more."""
        self._statistics.note(report, self._start + step * loop.dt)


class Finite(Observer):
    """Ends a march when an output is not a finite number. `instant(step)`: the time in words."""

    def __init__(self, instant: Callable[[int], str]) -> None:
        self._instant = instant

    def after(self, loop: Loop, step: int, report: StepReport) -> Stop | None:
        """Look at every output that is wired or recorded."""
        values = loop.system.values
        if np.isfinite(values).all():
            return None
        name = loop.system.output_names()[int(np.flatnonzero(~np.isfinite(values))[0])]
        text = f"{name} is not a finite number at step {step}, {self._instant(step)}"
        return Stop(End.NOT_FINITE, text, counts=False)


class Watch(Observer):
    """Shows how far the march is."""

    def __init__(self, watch: Watcher) -> None:
        self._watch = watch

    def after(self, loop: Loop, step: int, report: StepReport) -> None:
        """After each step."""
        self._watch(step, loop.target, loop.system)


class Checkpoints(Observer):
    """Writes a checkpoint every so many steps. `content(step)`: further arrays by part, and further JSON data."""

    def __init__(self, keeper: Keeper, content: Callable[[int], tuple[dict[str, Arrays], dict[str, Any]]]) -> None:
        self._keeper, self._content = keeper, content

    def after(self, loop: Loop, step: int, report: StepReport) -> None:
        """When it is time. Raises AeroSloshError when the file cannot be written."""
        if step % self._keeper.every == 0:
            self._keeper.write(loop.system, loop.scheme, *self._content(step))


@dataclass
class Cost:
    """Seconds of one march. `cpu` by component, `wall` of the whole march, `total_cpu` of the process in it."""

    cpu: dict[str, float]
    wall: float
    total_cpu: float
    steps: int

    @property
    def master_share(self) -> float:
        """The part of the CPU time spent outside the FMUs."""
        return max(0.0, 1.0 - sum(self.cpu.values()) / self.total_cpu) if self.total_cpu > 0 else 0.0


class Meter:
    """Measures the cost of a march of `system` from now on."""

    def __init__(self, system: System) -> None:
        self._system = system
        self._before = {c.name: c.cpu for c in system.everyone}
        self._wall, self._cpu = clock.perf_counter(), clock.process_time()

    def cost(self, steps: int) -> Cost:
        """So far, of `steps` steps."""
        wall, cpu = clock.perf_counter() - self._wall, clock.process_time() - self._cpu
        return Cost({c.name: c.cpu - self._before[c.name] for c in self._system.everyone}, wall, cpu, steps)
