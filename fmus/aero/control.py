"""How hard a flow is solved, what that took, and the error when it cannot be done."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple


class MarchError(RuntimeError):
    """The flow could not be advanced; the message says where, what was tried and the remedy."""


class StepReport(NamedTuple):
    """What a time step took: subiterations, last rms density change over that of the step, whether below tolerance, retries."""

    subiterations: int
    residual: float
    converged: bool
    retries: int


def together(reports: Sequence[StepReport]) -> StepReport:
    """Steps made one after the other as one: what all took, and the residual of the worst of them."""
    worst = min(reports, key=lambda r: (r.converged, -r.residual if math.isfinite(r.residual) else -math.inf))
    return StepReport(
        sum(r.subiterations for r in reports),
        worst.residual,
        all(r.converged for r in reports),
        sum(r.retries for r in reports),
    )


@dataclass(frozen=True)
class Settings:
    """How hard each flow is solved.

    tolerance: rms density change of the last subiteration over that of the whole step; cfl: pseudo-time step of a
    subiteration; steady_tolerance: rms density change an iteration; steady_cfl, steady_step: local and global pseudo-time step,
    the global one not below steady_least_cfl in any cell (those at the outer boundary are many chords large);
    steady_lift: relative error of the lift that is left, by the trend of its last changes.
    """

    tolerance: float = 1e-2
    max_subiterations: int = 60
    cfl: float = 25.0
    steady_tolerance: float = 3e-7
    steady_iterations: int = 8000
    steady_cfl: float = 20.0
    steady_step: float = 1.0
    steady_least_cfl: float = 1.0
    steady_lift: float = 1e-4
