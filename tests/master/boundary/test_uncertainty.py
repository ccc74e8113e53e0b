"""The error bar of a neutral V_f on section + thin airfoil, whose neutral V_f is known and whose loads no mesh changes."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import cache
from pathlib import Path

import pytest

from aeroslosh.master.analysis.crossings import Crossing
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.boundary.search import BoundaryPoint, Limits, sample, search
from aeroslosh.master.boundary.strategy import Confirm
from aeroslosh.master.boundary.uncertainty import Spread
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.results import summary as results_summary
from support import theory

MACH = 0.3


def case_of(steps_per_cycle: int, richardson: bool = False) -> Case:
    """Marches alone; Gauss–Seidel with loads extrapolated by a line, whose step error is of second order and can be seen."""
    case = Case()
    case.coupling.predictor_order = 1
    case.flutter.steps_per_cycle, case.boundary.tolerance = steps_per_cycle, 1e-3
    case.boundary.method, case.boundary.uncertainty, case.boundary.richardson = "march", True, richardson
    return case


@pytest.fixture(scope="module")
def searched(flutter_fmus: Path) -> Callable[..., BoundaryPoint]:
    """Return a function: arguments of `case_of` → the point at MACH; each is searched once."""
    return cache(lambda *settings: search_of(flutter_fmus, case_of(*settings)))


def search_of(fmus: Path, case: Case) -> BoundaryPoint:
    """The point at MACH."""
    found = find_fmus(fmus)
    with FlutterSetup(case, found, MACH) as setup:
        strategy = Confirm(case, lambda mach: setup, lambda of, mach: FlutterSetup(of, found, mach), print, marching=True)
        return strategy(lambda V_f: flutter_march.march(setup, V_f), MACH, 2.0, None)


def test_the_step_s_part_is_the_step_s_error(searched: Callable[..., BoundaryPoint]) -> None:
    """To 15 %: the growth rate bends here, and one march tells the shift by its slope. Fit and interpolation: 0.02 % of V_f."""
    case = case_of(200)
    exact = theory.neutral(case, MACH, 1.5, 3.0)
    point = searched(200)
    [crossing] = point.crossings
    error = exact - crossing.V_f
    assert crossing.met and abs(error) > 2e-3 * exact  # else there is nothing to tell
    assert crossing.parts["step"] == pytest.approx(error, rel=0.15)
    assert abs(error) <= 1.1 * crossing.uncertainty
    assert crossing.uncertainty == pytest.approx(math.hypot(*crossing.parts.values()))
    assert set(crossing.parts) == {"fit", "interpolation", "step", "amplitude", "mesh"} and not crossing.missing
    assert abs(crossing.parts["amplitude"]) < 1e-3  # a linear section
    assert abs(crossing.parts["mesh"]) < 1e-9


def test_the_step_s_part_is_of_second_order(searched: Callable[..., BoundaryPoint]) -> None:
    """To half an order: the slope that turns growth rates into V_f is known to a quarter in each of the two."""
    parts = [searched(steps).crossings[0].parts["step"] for steps in (200, 400)]
    assert 2.0**1.5 < parts[0] / parts[1] < 2.0**2.5


def test_three_meshes_and_the_number_of_marches_are_told(searched: Callable[..., BoundaryPoint]) -> None:
    """Two marches for step and amplitude, one on each coarser mesh; all in JSON and summary."""
    point = searched(100, True)
    data = results_summary.point_data(point)
    [crossing] = data["crossings"]
    assert crossing["richardson"]["cells"] == ((168, 48), (112, 32), (75, 21))
    assert crossing["richardson"]["values"][0] == pytest.approx(crossing["V_f"])
    assert crossing["richardson"]["gci"] < 1e-8 and crossing["tolerance_met"]
    assert data["cost"]["marches"] == len(point.marches) and data["cost"]["uncertainty_marches"] == 4
    assert f"({len(point.marches)} marches)" in data["outcome"]
    summary = results_summary.boundary_summary([data])
    assert "error bar of" in summary and "step " in summary and "112 x 32" in summary


@pytest.mark.parametrize("slope", [0.0, 1e-12, -1e-9, math.nan])
def test_a_growth_rate_that_does_not_change_tells_no_part(flutter_fmus: Path, slope: float) -> None:
    """Newton's step would divide by it."""
    said: list[str] = []
    crossing = Crossing(2.3, 2.5, "onset", slope, True, {"fit": 1e-3}, met=True)
    with FlutterSetup(case_of(100), find_fmus(flutter_fmus), MACH) as setup:
        spread = Spread(case_of(100), MACH, setup, lambda of, mach: setup, sample, said.append)
        wide = spread.widened(crossing, [flutter_march.march(setup, 2.3)])
        alone = spread.widened(crossing, [])
    assert wide.missing == alone.missing == ("step", "amplitude", "mesh") and wide.parts == {"fit": 1e-3}
    assert not spread.marches and "hardly changes with V_f" in said[0]


def test_a_part_that_cannot_be_had_is_named(flutter_fmus: Path) -> None:
    """The coarser mesh has no steady flow: the bar goes without that part and says so."""
    case, found = case_of(100), find_fmus(flutter_fmus)

    def no_rig(of: Case, mach: float) -> FlutterSetup:
        raise AeroSloshError("The steady flow did not converge")

    with FlutterSetup(case, found, MACH) as setup:
        point = search(lambda V_f: flutter_march.march(setup, V_f), MACH, 2.3, Limits(1.0, 3.0, 0.005, 6))
        said: list[str] = []
        [crossing] = point.crossings
        wide = Spread(case, MACH, setup, no_rig, sample, said.append).widened(crossing, point.marches)
    assert wide.missing == ("mesh",) and "mesh" not in wide.parts and wide.uncertainty > crossing.uncertainty
    assert any("did not converge" in text for text in said)
