"""Inputs foretold within an FMU, for hosts that pass on only what is there at the start of a step.

An input of these FMUs is the value at the END of the communication step, and the master foretells it. A host without
predictor sets what it has: values at the start. With its prediction on, an FMU takes them as such and extrapolates each Real
input linearly from the step before: what the master's Jacobi scheme with `predictor_order` 1 would have set, at equal steps.
"""

from __future__ import annotations

from typing import Any

from .variables import Variable, parameter

SUFFIX = "_prediction"
GROWTH = 2.0
"""Most times its last change by which an input is extrapolated."""


def prediction(what: str) -> Variable:
    """Declare the switch of an FMU whose inputs are `what` ("load", "motion"); the slave finds it by its name.

    An Integer: several tools that read SSP pass over enumerations.
    """
    text = f"What input {what} means: 0 values at the end of the step, 1 values at its start, extrapolated linearly over it"
    return parameter(f"{what}{SUFFIX}", 0, "", text, min=0, max=1)


class Extrapolator:
    """The last values read and the step taken from there.

    A step much longer than the one before follows the slope for GROWTH times that one only: a host that splits a step at a jump
    of its inputs makes tiny ones, whose slope is that of the jump.
    """

    def __init__(self, values: list[float]) -> None:
        """Start from initial `values`; they count as having been the same before."""
        self.values, self.step_size = values, 0.0

    def next(self, values: list[float], step_size: float) -> list[float]:
        """Return the values at the end of a step of `step_size` [s] from those at its start."""
        share = min(step_size / self.step_size, GROWTH) if self.step_size > 0.0 else 0.0
        # at equal steps 2 new - old, rounded once, to the bit what a master's extrapolation of first order gives
        ahead = [(1.0 + share) * new - share * old for new, old in zip(values, self.values, strict=True)]
        self.values, self.step_size = values, step_size
        return ahead

    def save(self) -> dict[str, Any]:
        """Return what `restore` takes."""
        return {"values": list(self.values), "step_size": self.step_size}

    @classmethod
    def restore(cls, saved: dict[str, Any]) -> Extrapolator:
        """Return an extrapolator that goes on from `save`."""
        again = cls(list(saved["values"]))
        again.step_size = saved["step_size"]
        return again
