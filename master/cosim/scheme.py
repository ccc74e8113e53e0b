"""One communication step of a system, by the scheme the case names.

Inputs are values at the END of the step. A scheme is a small class with a `name`, `reset(system)` (after initialisation or a
rewind), `step(system, dt)`, and `state()`, `restore()` for checkpoints.

What a lagged load does (docs/coupling.md): the inertia of a fluid of mass ratio ε that acts d steps late damps a motion of
frequency ω by ε/(1+ε)/2 · ω · d · dt, which no structure has."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Protocol

import numpy as np

from .extrapolation import Extrapolation
from .model_predictor import Surrogate
from .system import System


class StepEnd(StrEnum):
    """How the iteration of a step ended; the words of the JSON result."""

    CONVERGED = "converged"
    STALLED = "stalled"
    USED_UP = "passes used up"
    NOT_FINITE = "not a finite number"
    FAILED = "a component failed"


@dataclass(frozen=True)
class StepReport:
    """What one step took.

    passes     over the components, of all attempts
    change     the last relative change of a lagged wire; the largest of them
    outcome    how its last attempt ended
    attempts   1, and one for each retry
    worst      the wire with the largest change"""

    passes: int = 1
    change: float = 0.0
    outcome: StepEnd = StepEnd.CONVERGED
    attempts: int = 1
    worst: str = ""

    @property
    def converged(self) -> bool:
        """Whether the change was small enough."""
        return self.outcome is StepEnd.CONVERGED


ONE_PASS = StepReport()


class Scheme(Protocol):
    """The interface of a coupling scheme."""

    name: str

    def reset(self, system: System) -> None:
        """Start a march: forget all history. Raises AeroSloshError where a component lacks what the scheme needs."""

    def step(self, system: System, dt: float) -> StepReport:
        """Advance all components by `dt` [s]."""

    def state(self) -> dict[str, np.ndarray]:
        """What `restore` needs between two steps."""

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state` (after `reset`)."""


class Predictor:
    """What the wires will carry at the end of the step: extrapolated by a polynomial of `order` 0, 1 or 2; what a component
    with a surrogate will answer is predicted by that."""

    def __init__(self, order: int) -> None:
        self.order = order

    def reset(self, system: System) -> None:
        """All earlier values equal the present ones: the march starts at rest."""
        self._wires = Extrapolation(self.order, system.wire_values())
        self._surrogates = [Surrogate(system, name, self.order) for name in system.surrogates]

    def carried(self, system: System, dt: float) -> np.ndarray:
        """The prediction for every wire. Shape: (n_wires,)."""
        carried = self._wires.next()
        for surrogate in self._surrogates:
            surrogate.predict(system, carried, dt)
        return carried

    def held(self) -> np.ndarray:
        """What the wires carried at the start of the step."""
        return self._wires.past[0].copy()

    def push(self, system: System, dt: float) -> None:
        """The step is done: note what the wires carry at its end."""
        self._wires.push(system.wire_values())
        for surrogate in self._surrogates:
            surrogate.follow(system, dt)

    def state(self) -> dict[str, np.ndarray]:
        """For `restore`."""
        state = {"wires": self._wires.past.copy()}
        for surrogate in self._surrogates:
            state |= {f"{surrogate.name}.{key}": value for key, value in surrogate.state().items()}
        return state

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""
        self._wires.past[:] = state["wires"]
        for surrogate in self._surrogates:
            start = f"{surrogate.name}."
            surrogate.restore({k.removeprefix(start): v for k, v in state.items() if k.startswith(start)})


class _Explicit:
    """What the schemes of one pass share."""

    def __init__(self, predictor_order: int = 1) -> None:
        self.predictor = Predictor(predictor_order)

    def reset(self, system: System) -> None:
        """Start a march."""
        self.predictor.reset(system)

    def state(self) -> dict[str, np.ndarray]:
        """For `restore`."""
        return self.predictor.state()

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""
        self.predictor.restore(state)


class GaussSeidel(_Explicit):
    """One pass in the order of the components; what is not yet known is extrapolated. Second order with order ≥ 1."""

    name = "gauss-seidel"

    def step(self, system: System, dt: float) -> StepReport:
        """One pass."""
        system.begin_step(dt)
        system.one_pass(self.predictor.carried(system, dt), dt)
        self.predictor.push(system, dt)
        return ONE_PASS


class Jacobi(_Explicit):
    """One pass in which every component sees extrapolated values alone: components could run at the same time.

    With order 0 the motion reaches the fluids a step late and their loads come back a step late."""

    name = "jacobi"

    def step(self, system: System, dt: float) -> StepReport:
        """One pass."""
        system.begin_step(dt)
        carried = self.predictor.carried(system, dt)
        for i in range(len(system.components)):
            system.feed(i, carried)
            system.step_component(i, dt)
        self.predictor.push(system, dt)
        return ONE_PASS
