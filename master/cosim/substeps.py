"""How one component goes through a communication step: in how many substeps, and what its inputs do meanwhile.

Inputs are values at the END of the step. The course of an input within the step is "hold" (the end value throughout), "linear"
(from the value at the start) or "quadratic" (through the value a step earlier as well). Substeps take the course's values at
their own ends. An FMU with canInterpolateInputs gets the course's derivatives at the start of each (sub)step instead, as
FMI 2.0 (section 4.2.1) defines: it follows the course itself.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.errors import AeroSloshError
from ..fmi.component import Component


@dataclass(frozen=True)
class Pace:
    """`substeps` in a communication step and the `waveform` of the inputs in it."""

    substeps: int = 1
    waveform: str = "hold"


class Stride:
    """Steps `component` at `pace`. Raises AeroSloshError when the FMU can make nothing of the waveform asked for.

    `begin(inputs)` tells the values at the start of a communication step, once a step; passes repeated from there follow."""

    def __init__(self, component: Component, pace: Pace) -> None:
        self.component, self.pace = component, pace
        self._derivatives = component.can_interpolate and pace.waveform != "hold"
        if pace.waveform != "hold" and pace.substeps == 1 and not self._derivatives:
            raise AeroSloshError(
                f"'{component.name}' takes its inputs once a step: waveform = \"{pace.waveform}\" changes nothing",
                component.path.name,
                "give it substeps above 1, or leave the waveform out (it cannot interpolate inputs by itself)",
            )
        self.plain = pace.substeps == 1 and pace.waveform == "hold"
        self._ratio = 0.0
        self.reset()

    def reset(self) -> None:
        """A march begins: the inputs were always what they are."""
        self._start = self._before = self.component.inputs.values.copy()
        self._last = 0.0

    def begin(self, inputs: np.ndarray, dt: float) -> None:
        """A communication step of `dt` [s] begins with these values of the Real inputs. Shape: (n_inputs,)."""
        self._before, self._start = self._start, inputs.copy()
        self._ratio = dt / self._last if self._last > 0.0 else 0.0  # of the first step nothing earlier is known: linear
        self._last = dt

    def step(self, dt: float) -> None:
        """Advance by `dt` [s] to the inputs in the component's buffer."""
        component = self.component
        if self.plain:
            component.step(dt)
            return
        end, begin, n = component.inputs.values.copy(), component.time, self.pace.substeps
        small = dt / n  # the same to the bit each time: FMUs keep what they computed for a step size
        for k in range(1, n + 1):
            if self._derivatives:
                at = (k - 1) / n
                first, second = self._slopes(end, at)
                component.inputs.values[:] = self._course(end, at)
                component.step(small, first / dt, second / dt**2 if self.pace.waveform == "quadratic" else None)
            else:
                component.inputs.values[:] = self._course(end, k / n)
                component.step(small)
        component.inputs.values[:], component.time = end, begin + dt  # sums of substeps would drift from the others' clock

    def state(self) -> dict[str, np.ndarray]:
        """For `restore`; what `begin` sets anew is not in it."""
        return {"start": self._start, "last": np.array(self._last)}

    def restore(self, state: dict[str, np.ndarray]) -> None:
        """Return to a `state`."""
        self._start, self._last = state["start"], float(state["last"])

    def _course(self, end: np.ndarray, at: float) -> np.ndarray:
        """The inputs at the fraction `at` of the step."""
        if self.pace.waveform == "hold":
            return end
        if at == 1.0:  # to the bit, or a rewound step would differ
            return end
        course = self._start + at * (end - self._start)
        return course + 0.5 * at * (at - 1.0) * self._bend(end)

    def _slopes(self, end: np.ndarray, at: float) -> tuple[np.ndarray, np.ndarray]:
        """First and second derivative of the course at the fraction `at`, per step and step squared."""
        bend = self._bend(end)
        return end - self._start + (at - 0.5) * bend, bend

    def _bend(self, end: np.ndarray) -> np.ndarray:
        """Second derivative of the course, per step squared: of the parabola through three values, 0 when linear."""
        if self.pace.waveform != "quadratic":
            return np.zeros_like(end)
        r = self._ratio
        return 2.0 * r / (1.0 + r) * (end - self._start - r * (self._start - self._before))
