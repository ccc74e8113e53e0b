"""Several internal steps are told as one: by the worst of them."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from aeroslosh.fmus.aero.control import StepReport, together
from aeroslosh.fmus.aero.fmu import Aero

GOOD, FAIR, BAD = StepReport(5, 2e-3, True, 0), StepReport(7, 9e-3, True, 0), StepReport(25, 4e-2, False, 1)


@pytest.mark.parametrize("reports", [[GOOD, BAD, FAIR], [BAD, GOOD, FAIR], [FAIR, GOOD, BAD]])
def test_the_worst_is_told_wherever_it_stands(reports: list[StepReport]) -> None:
    assert together(reports) == StepReport(37, 4e-2, False, 1)
    assert together([GOOD, FAIR, GOOD]) == StepReport(17, 9e-3, True, 0)
    assert together([GOOD]) == GOOD
    blown = together([BAD, StepReport(3, math.nan, False, 2)])
    assert math.isnan(blown.residual) and not blown.converged


def test_a_communication_step_of_several_internal_ones_tells_the_worst() -> None:
    """The face, on a flow whose second of four steps does not converge."""
    aero: Any = Aero.__new__(Aero)
    reports = iter([GOOD, BAD, FAIR, GOOD])
    aero.flow = SimpleNamespace(step=lambda *_: next(reports), coefficients=SimpleNamespace(lift=0.0), refactorings=0, mach=0.3)
    aero.flow.coefficients = (0.1, 0.2, 0.3)
    aero.stream = SimpleNamespace(
        speed=100.0, sound_speed=1.0, scaled_time=lambda t: t, scaled_motion=lambda m: m, dynamic_pressure=1.0
    )
    aero.chord, aero.max_step, aero.mean_alpha, aero.steps, aero.write_fields = 1.0, 0.5, 0.0, 0, False
    for name in ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot"):
        setattr(aero, name, 0.0)
    aero.motion = aero._motion()
    Aero.step(aero, 0.0, 0.02)  # two chords of travel
    assert next(reports, None) is None
    assert (aero.subiterations, aero.residual, aero.converged, aero.retries) == (42, 4e-2, False, 1)
