"""Three meshes: the published example, values of known order, and what is no convergence."""

from __future__ import annotations

import math

import pytest

from aeroslosh.master.analysis.richardson import FORMAL, LOWEST, SAFETY, study


def test_the_example_of_celik_et_al() -> None:
    """18,000, 8,000 and 4,500 cells: order 1.53, extrapolated 6.1685, GCI 2.2 % (Table 1, first column, as printed there)."""
    found = study([(180, 100), (100, 80), (90, 50)], [6.063, 5.972, 5.863])
    assert found.behaviour == "monotone"
    assert found.order == pytest.approx(1.53, abs=0.01)
    assert found.extrapolated == pytest.approx(6.1685, abs=2e-4)
    assert found.gci == pytest.approx(0.022, abs=5e-4)


@pytest.mark.parametrize("order", [0.7, 1.0, 1.5, 2.0])
def test_values_of_known_order(order: float) -> None:
    cells = [(168, 48), (112, 32), (75, 21)]
    values = [0.59 + 30.0 * (a * n) ** (-order / 2.0) for a, n in cells]
    found = study(cells, values)
    assert found.order == pytest.approx(order, rel=1e-6) and found.order_used == pytest.approx(order, rel=1e-6)
    assert found.extrapolated == pytest.approx(0.59, rel=1e-9)
    assert found.error == pytest.approx(0.59 - values[0])
    assert found.gci == pytest.approx(SAFETY * abs(0.59 / values[0] - 1.0))


@pytest.mark.parametrize(("order", "used"), [(0.2, LOWEST), (3.5, FORMAL)])
def test_an_order_beyond_reason_is_limited_and_told(order: float, used: float) -> None:
    cells = [(180, 80), (120, 53), (80, 36)]
    found = study(cells, [1.0 + 10.0 * (a * n) ** (-order / 2.0) for a, n in cells])
    assert found.order == pytest.approx(order, rel=1e-6) and found.order_used == used


@pytest.mark.parametrize(
    ("values", "behaviour"),
    [([1.0, 1.01, 0.98], "oscillating"), ([1.0, 1.03, 1.04], "diverging"), ([1.0, 1.03, 1.03], "diverging")],
)
def test_what_does_not_converge_is_not_extrapolated(values: list[float], behaviour: str) -> None:
    found = study([(180, 80), (120, 53), (80, 36)], values)
    assert found.behaviour == behaviour and math.isnan(found.order)
    assert found.extrapolated == values[0] and found.error == pytest.approx(max(values) - min(values))
    assert found.as_data()["order"] is None


@pytest.mark.parametrize("rounding", [(0.0, 0.0), (4e-16, -4e-16), (4e-16, 8e-16), (-4e-16, 0.0)])
def test_a_value_that_no_mesh_changes(rounding: tuple[float, float]) -> None:
    """But for the last bits."""
    found = study([(180, 80), (120, 53), (80, 36)], [2.0, 2.0 + rounding[0], 2.0 + rounding[1]])
    assert (found.behaviour, found.error, found.gci) == ("monotone", 0.0, 0.0)
