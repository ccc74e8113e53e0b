"""How long a march is: to the release, to the first look at its free response, and at most."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..case.case import Case
from ..case.scales import Scales

GROWTH = 1.5  # a march that is not settled goes on by this factor
MOST_TIMES, MOST_CYCLES = 8.0, 80.0  # max_free_cycles = "auto"
PERIODS = 1.25  # of the slower natural mode that a verdict needs


def length(case: Case, s: Scales) -> tuple[int, int]:
    """Steps of the forced phase, and of the whole march."""
    release = round(case.flutter.forced_cycles / case.flutter.forced_frequency * s.steps_per_cycle)
    return release, release + round(case.flutter.free_cycles * s.steps_per_cycle)


@dataclass(frozen=True)
class Span:
    """How long a march is, in steps: to the release, to the first look at its free response, and at most.

    least  what shows the slower of the section's two natural modes for PERIODS of its own: no verdict but growth before"""

    release: int
    planned: int
    least: int
    most: int

    @classmethod
    def of(cls, case: Case, s: Scales, needed: float = 0.0, enough: float = math.inf) -> Span:
        """That of `case`. A limit that the case leaves to us is no shorter than `least`, within MOST_CYCLES. `needed`: free
        cycles that a linear model expects the modes to take to part (`LinearModel.cycles`); the first look is not before.
        `enough` of them do, where the case plans more."""
        f, (release, planned) = case.flutter, length(case, s)
        least = PERIODS / max(slower_frequency(case), 1e-3)
        if enough < f.free_cycles:
            planned = min(planned, release + math.ceil(max(least, enough) * s.steps_per_cycle))
        if isinstance(f.max_free_cycles, float | int):
            most = float(f.max_free_cycles)
        else:
            most = min(max(MOST_TIMES * f.free_cycles, least), MOST_CYCLES)
        steps = [release + math.ceil(cycles * s.steps_per_cycle) for cycles in (least, most)]
        most_steps = max(planned, steps[1])
        parted = release + math.ceil(min(needed, MOST_CYCLES) * s.steps_per_cycle)
        return cls(release, min(max(planned, parted), most_steps), steps[0], most_steps)

    def longer(self, steps: int) -> int:
        """Where a march that is not settled after `steps` goes on to."""
        further = self.release + math.ceil(GROWTH * (steps - self.release))
        return min(max(further, self.least), self.most)


def slower_frequency(case: Case) -> float:
    """The lower natural frequency of the section in vacuum, over omega_alpha."""
    s = case.section
    # (1 − x²/r²) λ² − (1 + ratio²) λ + ratio² = 0, λ = (ω/ω_α)²
    ratio, mass = s.frequency_ratio**2, 1.0 - s.x_alpha**2 / s.r2_alpha
    return math.sqrt(2.0 * ratio / (1.0 + ratio + math.sqrt(max((1.0 + ratio) ** 2 - 4.0 * mass * ratio, 0.0))))
