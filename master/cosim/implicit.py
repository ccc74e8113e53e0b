"""Implicit coupling: a step is repeated from saved states until what the lagged wires carry no longer changes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..base.errors import AeroSloshError, ComponentError
from ..fmi.component import Component, Saved
from .acceleration import Acceleration, Aitken
from .scheme import Predictor, StepEnd, StepReport
from .system import System

CAUTIOUS = 0.5  # relaxation of a step tried again
PROGRESS = 0.9  # a pass is progress when the change falls below this part of the smallest before


@dataclass(frozen=True)
class Criteria:
    """When a step has converged, and when to give up.

    relative, absolute   |H(x) − x| ≤ max(relative (|H(x)| + largest magnitude seen there), absolute) on every lagged wire
    relative_of, absolute_of   the same for single sources "component.output"; absolute ones in the source's unit
    max_iterations       passes of one attempt
    stall                passes without progress that end an attempt
    retries              attempts after the first: from the values held, with a cautious Aitken relaxation"""

    relative: float = 1e-6
    absolute: float = 0.0
    relative_of: Mapping[str, float] = field(default_factory=dict)
    absolute_of: Mapping[str, float] = field(default_factory=dict)
    max_iterations: int = 12
    stall: int = 6
    retries: int = 1

    def limits(self, sources: Sequence[str]) -> tuple[np.ndarray, np.ndarray]:
        """Relative and absolute tolerance of each source. Raises AeroSloshError for a name that is none of them."""
        for table, names in (("tolerance_of", self.relative_of), ("absolute_tolerance_of", self.absolute_of)):
            for name in names:
                if name not in sources:
                    raise AeroSloshError(
                        f"coupling.{table}: '{name}' is not iterated",
                        f"coupling.{table}",
                        f"the quantities that lag in this order are: {', '.join(dict.fromkeys(sources)) or 'none'}",
                    )
        relative = np.array([self.relative_of.get(name, self.relative) for name in sources])
        return relative, np.array([self.absolute_of.get(name, self.absolute) for name in sources])


@dataclass
class _Attempt:
    """One fixed-point iteration: passes, the last change (and where), and the best guess it had."""

    passes: int = 0
    change: float = np.inf
    worst: int = 0
    outcome: StepEnd = StepEnd.USED_UP
    best: float = np.inf
    guess: np.ndarray | None = None


class Implicit:
    """Repeats the step from saved states until converged, each pass in the order of the components.

    A pass maps x (assumed values on the lagged wires) to H(x) (the values the pass ends with). An attempt ends converged, after
    `max_iterations`, stalled, or with a component failure or a value that is not finite; then the step is tried again. When no
    attempt converges, the pass with the smallest change stands and the report says so; a failure in the last attempt is raised.
    """

    name = "implicit"

    def __init__(
        self, predictor_order: int = 1, criteria: Criteria | None = None, acceleration: Acceleration | None = None
    ) -> None:
        self.predictor = Predictor(predictor_order)
        self.criteria = criteria or Criteria()
        self.acceleration = acceleration or Aitken()

    def reset(self, system: System) -> None:
        """Start a march. Raises AeroSloshError when a component cannot rewind."""
        for component in system.components:
            if not component.can_rewind:
                raise AeroSloshError(
                    f"Implicit coupling repeats steps, but '{component.name}' cannot rewind",
                    f'coupling.scheme = "implicit", {component.path.name} (canGetAndSetFMUstate is false)',
                    'use coupling.scheme = "gauss-seidel", or another export of this FMU',
                )
        self._sources = [system.wires[k].source for k in system.lagged]
        self._relative, self._absolute = self.criteria.limits(self._sources)
        self.predictor.reset(system)
        self.acceleration.reset()
        self._scale = np.abs(system.wire_values()[system.lagged_array])

    def state(self) -> dict[str, np.ndarray]:
        """For `restore`."""
        parts = {"predictor": self.predictor.state(), "acceleration": self.acceleration.state()}
        state = {f"{part}.{key}": value for part, values in parts.items() for key, value in values.items()}
        return state | {"scale": self._scale.copy()}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""
        for name, part in (("predictor.", self.predictor), ("acceleration.", self.acceleration)):
            part.restore({k.removeprefix(name): v for k, v in state.items() if k.startswith(name)})
        self._scale = state["scale"].copy()

    def step(self, system: System, dt: float) -> StepReport:
        """Passes until converged."""
        system.begin_step(dt)
        carried = self.predictor.carried(system, dt)
        if not system.lagged:
            system.one_pass(carried, dt)
            self.predictor.push(system, dt)
            return StepReport()
        saved = [(component, component.save()) for component in system.components]
        try:
            attempts = self._attempts(system, carried, dt, saved)
        finally:
            for component, state in saved:
                component.free(state)
        self.predictor.push(system, dt)
        last = attempts[-1]
        passes, worst = sum(a.passes for a in attempts), self._sources[last.worst]
        return StepReport(passes, last.change, last.outcome, len(attempts), worst)

    def _attempts(self, system: System, carried: np.ndarray, dt: float, saved: list[tuple[Component, Saved]]) -> list[_Attempt]:
        """The first attempt and the retries; leaves the system at the end of the step."""
        attempts: list[_Attempt] = []
        acceleration = self.acceleration
        for left in range(self.criteria.retries, -1, -1):
            attempt = _Attempt()
            attempts.append(attempt)
            try:
                self._iterate(system, carried, dt, saved, acceleration, attempt)
            except ComponentError:  # perhaps the guess was wild: the next attempt is more careful
                attempt.outcome = StepEnd.FAILED
                self.acceleration.reset()
                if not left:
                    raise
            if attempt.outcome is StepEnd.CONVERGED:
                if acceleration is self.acceleration:
                    acceleration.end()
                return attempts
            if left:
                _rewind(system, saved)
                carried, acceleration = self.predictor.held(), Aitken(CAUTIOUS)
        self.acceleration.reset()  # what it learnt did not help
        best = min(attempts, key=lambda a: a.best)
        if best.guess is not None and best.best < PROGRESS * attempts[-1].change:
            _rewind(system, saved)
            carried[system.lagged_array] = best.guess
            system.one_pass(carried, dt)
            attempts[-1].passes += 1
            attempts[-1].change = best.best
        return attempts

    def _iterate(
        self,
        system: System,
        carried: np.ndarray,
        dt: float,
        saved: list[tuple[Component, Saved]],
        acceleration: Acceleration,
        attempt: _Attempt,
    ) -> None:
        """One attempt from the guess `carried`; the system is left at the end of the last pass."""
        lagged, criteria = system.lagged_array, self.criteria
        size, idle, progress = np.ones(lagged.size), 0, np.inf
        acceleration.start()
        while True:
            system.one_pass(carried, dt)
            attempt.passes += 1
            result = system.wire_values()[lagged]
            residual = result - carried[lagged]
            if not np.isfinite(residual).all():
                attempt.change, attempt.outcome = np.inf, StepEnd.NOT_FINITE
                self.acceleration.reset()
                return
            np.maximum(self._scale, np.abs(result), out=self._scale)
            magnitude = np.abs(result) + self._scale
            scaled = np.abs(residual) / np.where(magnitude > 0.0, magnitude, 1.0)
            allowed = np.maximum(self._relative * magnitude, self._absolute)
            over = np.abs(residual) - allowed
            attempt.change, attempt.worst = float(np.max(scaled)), int(np.argmax(np.where(over > 0.0, scaled, -1.0)))
            if np.all(over <= 0.0):
                attempt.outcome = StepEnd.CONVERGED
                return
            if attempt.change < attempt.best:
                attempt.best, attempt.guess = attempt.change, carried[lagged].copy()
            idle, progress = (0, attempt.change) if attempt.change < PROGRESS * progress else (idle + 1, progress)
            if idle >= criteria.stall:
                attempt.outcome = StepEnd.STALLED
                return
            if attempt.passes >= criteria.max_iterations:
                return
            if attempt.passes == 1:  # fixed for the step: an acceleration compares residuals of several passes
                size = np.where(self._scale > 0.0, self._scale, 1.0)
            carried[lagged] = acceleration.next(carried[lagged], residual, size)
            _rewind(system, saved)


def _rewind(system: System, saved: list[tuple[Component, Saved]]) -> None:
    for i, (component, state) in enumerate(saved):
        component.rewind(state)
        system.take(i)
