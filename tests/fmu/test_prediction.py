"""Every FMU predicts its inputs where it is asked to: the same numbers as an instance that is told them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.fmus.kit.prediction import Extrapolator

MOTION = ["h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot"]
SURGE = ["x", "x_dot", "x_ddot"]
CASES: dict[str, tuple[str, dict[str, Any], list[str]]] = {
    "structure": ("load_prediction", {"initial_alpha": 0.01}, ["lift", "moment", "slosh_force_y", "slosh_moment"]),
    "aero": ("motion_prediction", {"cells_around": 64, "cells_normal": 16}, MOTION),
    "slosh_vof": ("motion_prediction", {"cells_x": 16, "cells_y": 16}, MOTION + SURGE),
    "slosh_ems": ("motion_prediction", {}, MOTION + SURGE),
    "slosh_rbf": ("motion_prediction", {}, MOTION + SURGE),
}


@pytest.mark.parametrize("component", CASES)
def test_predicted_inputs_are_those_of_the_line_through_the_last_two(
    fmu: Callable[[str], Path], host: Callable[..., Any], tmp_path: Path, component: str
) -> None:
    switch, values, names = CASES[component]
    rows = host("predicted", str(fmu(component)), switch, values, names, str(tmp_path / "state"))
    assert rows["ahead"] == rows["told"]  # uneven steps, to the bit
    assert rows["resumed"] == rows["ahead"][6:]
    assert rows["ahead"][4] != rows["ahead"][11]


def test_the_first_step_holds_and_equal_steps_are_the_masters_weights() -> None:
    ahead = Extrapolator([1.0, -2.0])
    assert ahead.next([1.0, -2.0], 0.1) == [1.0, -2.0]
    assert ahead.next([1.5, -1.0], 0.1) == [2.0 * 1.5 - 1.0, 2.0 * -1.0 + 2.0]
    assert ahead.next([2.0, 0.0], 0.05) == [2.25, 0.5]
    assert ahead.next([2.0, 0.0], 10.0) == [2.0, 0.0]  # no slope, however long the step
    assert ahead.next([3.0, 0.0], 1e-6) == [pytest.approx(3.0), 0.0]
    assert ahead.next([4.0, 0.0], 1.0) == [6.0, 0.0]  # a jump in a tiny step is not followed a million times
