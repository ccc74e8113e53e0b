"""A cheap model predicts what an expensive component will answer: EMS or a network for two-phase slosh.

The wires that leave the expensive component must be guessed before it is stepped. The components that drive it (the structure)
are stepped together with the cheap model, from saved states, until the loads on the wires agree with the motion they cause; to
the cheap model's answer is added by how much the two models differed lately, extrapolated. Then all return to the step's
start. After the step the cheap model follows the motion that was found."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ..base.errors import AeroSloshError
from .acceleration import QuasiNewton
from .extrapolation import Extrapolation
from .system import System

PASSES = 6
TOLERANCE = 1e-7  # of the magnitudes seen; the models' difference leaves more


class Surrogate:
    """The cheap model of component `name` in `system`. Raises AeroSloshError where a component cannot rewind, or where the
    guess is of no use."""

    def __init__(self, system: System, name: str, order: int) -> None:
        self.name, self.component = name, system.surrogates[name]
        ends = [(w.source.partition("."), w.target.partition(".")) for w in system.wires]
        self._drivers = sorted({system.place[a[0]] for a, b in ends if b[0] == name and a[0] != name})
        self._driven = [np.array([k for k, (a, _) in enumerate(ends) if system.place[a[0]] == i]) for i in self._drivers]
        mine = [k for k in system.lagged if ends[k][0][0] == name]
        if not mine:
            raise AeroSloshError(
                f"'{self.component.name}' has nothing to predict: '{name}' is stepped before all that it feeds",
                "coupling.order",
                f"step '{name}' after the components it feeds, or leave the predicting model out",
            )
        for component in [self.component, *(system.components[i] for i in self._drivers)]:
            if not component.can_rewind:
                raise AeroSloshError(
                    f"'{component.name}' takes part in the prediction of '{name}', but cannot rewind",
                    f"{component.path.name} (canGetAndSetFMUstate is false)",
                    "leave the predicting model out, or take another export of this FMU",
                )
        self._mine = np.array(mine, dtype=np.intp)
        self._outputs = np.array([self.component.output_index[ends[k][0][2]] for k in mine], dtype=np.intp)
        self._difference = Extrapolation(order, self._now(system))
        self._newton = QuasiNewton()
        self._scale = np.abs(system.wire_values()[self._mine])

    def predict(self, system: System, carried: np.ndarray, dt: float) -> None:
        """Put the guess for the end of the step into `carried` (shape (n_wires,)), where the polynomial one stood."""
        mine, difference = self._mine, self._difference.next()
        parts = [system.components[i] for i in self._drivers]
        saved = [(c, c.save()) for c in [self.component, *parts]]
        self._newton.start()
        try:
            for _ in range(PASSES):
                guess = self._answer(system, carried, dt) + difference
                for component, state in saved:
                    component.rewind(state)
                np.maximum(self._scale, np.abs(guess), out=self._scale)
                size = np.where(self._scale > 0.0, self._scale, 1.0)
                r = guess - carried[mine]
                if float(np.max(np.abs(r / size))) <= TOLERANCE:
                    break
                carried[mine] = self._newton.next(carried[mine], r, size)
        finally:
            self._newton.end()
            for component, state in saved:
                component.free(state)
            for i in self._drivers:
                system.take(i)

    def follow(self, system: System, dt: float) -> None:
        """The step is done: the cheap model goes through it with the motion found."""
        system.feed_surrogate(self.name, system.wire_values())
        self.component.step(dt)
        self._difference.push(self._now(system))

    def state(self) -> dict[str, np.ndarray]:
        """For `restore`."""
        newton = {f"newton.{key}": value for key, value in self._newton.state().items()}
        return {"past": self._difference.past.copy(), "scale": self._scale.copy()} | newton

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""
        self._difference.past[:] = state["past"]
        self._scale = state["scale"].copy()
        self._newton.restore({key.removeprefix("newton."): value for key, value in state.items()})

    def _answer(self, system: System, carried: np.ndarray, dt: float) -> np.ndarray:
        """What the cheap model answers to the drivers' motion under `carried`."""
        now = carried.copy()
        for i, wires in zip(self._drivers, self._driven, strict=True):
            system.feed(i, now)
            system.step_component(i, dt)
            now[wires] = system.values[system.source[wires]]
        system.feed_surrogate(self.name, now)
        self.component.step(dt)
        return self.component.outputs.values[self._outputs]

    def _now(self, system: System) -> np.ndarray:
        """By how much the models differ at present."""
        return system.wire_values()[self._mine] - self.component.outputs.values[self._outputs]
