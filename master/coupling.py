"""One communication step of a system, by the scheme the case names.

Inputs are values at the END of the step. A scheme is a small class with a `name`, `reset(system)` (after
initialisation or a rewind) and `step(system, dt)`; quasi-Newton schemes fit the same face.

What a lagged load does (docs/coupling.md): the inertia of a fluid of mass ratio ε that acts d steps late damps a motion of
frequency ω by ε/(1+ε)/2 · ω · d · dt, which no structure has."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from master.acceleration import Aitken, Relaxation
from master.errors import AeroSloshError
from master.system import System

EXTRAPOLATION = {0: (1.0,), 1: (2.0, -1.0), 2: (3.0, -3.0, 1.0)}  # weights of y_n, y_{n-1}, y_{n-2}


@dataclass(frozen=True)
class StepReport:
    """What one step took: passes over the components, the last relative change, and whether it was small enough."""

    passes: int = 1
    change: float = 0.0
    converged: bool = True


class Scheme(Protocol):
    """The face of a coupling scheme."""

    name: str

    def reset(self, system: System) -> None:
        """Start a march: forget all history."""

    def step(self, system: System, dt: float) -> StepReport:
        """Advance all components by `dt` [s]."""


class Predictor:
    """Extrapolates what the lagged wires will carry, by a polynomial of `order` 0, 1 or 2 through the last values."""

    def __init__(self, order: int) -> None:
        self.order = order
        self._weights = np.array(EXTRAPOLATION[order])

    def reset(self, system: System) -> None:
        """All earlier values equal the present ones: the march starts at rest."""
        self._past = np.tile(system.wire_values(), (self.order + 1, 1))

    def carried(self) -> np.ndarray:
        """The prediction for the end of the step, every wire. Shape: (n_wires,)."""
        return self._weights @ self._past

    def push(self, carried: np.ndarray) -> None:
        """Note what the wires carry at the end of the step done."""
        self._past[1:] = self._past[:-1]
        self._past[0] = carried


class GaussSeidel:
    """One pass in the order of the components; what is not yet known is extrapolated. Second order with order ≥ 1."""

    name = "gauss-seidel"

    def __init__(self, predictor_order: int = 1) -> None:
        self.predictor = Predictor(predictor_order)

    def reset(self, system: System) -> None:
        """Start a march."""
        self.predictor.reset(system)

    def step(self, system: System, dt: float) -> StepReport:
        """One pass."""
        one_pass(system, self.predictor.carried(), dt)
        self.predictor.push(system.wire_values())
        return StepReport()


class Jacobi:
    """One pass in which every component sees extrapolated values alone: components could run at the same time.

    With order 0 the motion reaches the fluids a step late and their loads come back a step late."""

    name = "jacobi"

    def __init__(self, predictor_order: int = 1) -> None:
        self.predictor = Predictor(predictor_order)

    def reset(self, system: System) -> None:
        """Start a march."""
        self.predictor.reset(system)

    def step(self, system: System, dt: float) -> StepReport:
        """One pass."""
        carried = self.predictor.carried()
        for i in range(len(system.components)):
            system.feed(i, carried)
            system.step_component(i, dt)
        self.predictor.push(system.wire_values())
        return StepReport()


class Implicit:
    """Repeats the step from saved states until what the lagged wires carry no longer changes.

    A pass maps x (assumed values on the lagged wires) to H(x) (the values the pass ends with). Converged when
    |H(x) − x| ≤ tolerance (|H(x)| + largest magnitude seen on that wire), every wire. Not converged in
    `max_iterations`: the last pass stands and the report says so.
    """

    name = "implicit"

    def __init__(
        self,
        predictor_order: int = 1,
        tolerance: float = 1e-6,
        max_iterations: int = 12,
        relaxation: Relaxation | None = None,
    ) -> None:
        self.predictor = Predictor(predictor_order)
        self.tolerance, self.max_iterations = tolerance, max_iterations
        self.relaxation = relaxation or Aitken()

    def reset(self, system: System) -> None:
        """Start a march. Raises AeroSloshError when a component cannot rewind."""
        for component in system.components:
            if not component.can_rewind:
                raise AeroSloshError(
                    f"Implicit coupling repeats steps, but '{component.name}' cannot rewind",
                    f'coupling.scheme = "implicit", {component.path.name} (canGetAndSetFMUstate is false)',
                    'use coupling.scheme = "gauss-seidel", or another export of this FMU',
                )
        self.predictor.reset(system)
        self._scale = np.abs(system.wire_values()[system.lagged_array])

    def step(self, system: System, dt: float) -> StepReport:
        """Passes until converged."""
        lagged = system.lagged_array
        carried = self.predictor.carried()
        if not lagged.size:
            one_pass(system, carried, dt)
            self.predictor.push(system.wire_values())
            return StepReport()
        self.relaxation.start()
        saved = [component.save() for component in system.components]
        change, converged, passes = np.inf, False, 0
        size = np.ones(lagged.size)  # magnitudes in which the relaxation sees the wires, fixed for the step
        try:
            while True:
                one_pass(system, carried, dt)
                passes += 1
                result = system.wire_values()[lagged]
                residual = result - carried[lagged]
                np.maximum(self._scale, np.abs(result), out=self._scale)
                allowed = np.abs(result) + self._scale
                scaled = residual / np.where(allowed > 0.0, allowed, 1.0)
                change = float(np.max(np.abs(scaled)))
                converged = change <= self.tolerance
                if converged or passes >= self.max_iterations:
                    break
                if passes == 1:
                    size = np.where(self._scale > 0.0, self._scale, 1.0)
                carried[lagged] = size * self.relaxation.next(carried[lagged] / size, residual / size)
                for component, state in zip(system.components, saved, strict=True):
                    component.rewind(state)
        finally:
            for component, state in zip(system.components, saved, strict=True):
                component.free(state)
        self.predictor.push(system.wire_values())
        return StepReport(passes, change, converged)


def one_pass(system: System, carried: np.ndarray, dt: float) -> None:
    """Step every component in order; `carried` holds the assumed values of the lagged wires. Others are fresh."""
    lagged = system.lagged_array
    for i in range(len(system.components)):
        now = system.wire_values()
        now[lagged] = carried[lagged]
        system.feed(i, now)
        system.step_component(i, dt)


def make(scheme: str, predictor_order: int, tolerance: float, max_iterations: int) -> Scheme:
    """The scheme called `scheme`."""
    if scheme == Implicit.name:
        return Implicit(predictor_order, tolerance, max_iterations)
    if scheme == Jacobi.name:
        return Jacobi(predictor_order)
    return GaussSeidel(predictor_order)
