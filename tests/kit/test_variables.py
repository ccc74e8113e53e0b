"""Declarations: what is refused when written, what a value is told, one spelling of the interfaces."""

from __future__ import annotations

import math

import pytest

from aeroslosh.fmus.kit import interfaces, units
from aeroslosh.fmus.kit.slave import Slave
from aeroslosh.fmus.kit.variables import choice, input_, output, parameter


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: parameter("a", 5.0, "m", "", max=4.0), "outside its range"),
        (lambda: parameter("a", 5.0, "furlong", ""), "Unknown unit 'furlong'"),
        (lambda: parameter("a b", 5.0, "m", ""), "no identifier"),
        (lambda: parameter("a", math.nan, "m", ""), "not a finite number"),
        (lambda: choice("a", "x", {"y": ""}, ""), "x"),
    ],
)
def test_wrong_declarations_are_refused(make: object, words: str) -> None:
    with pytest.raises(ValueError, match=words):
        make()  # type: ignore[operator]


def test_a_problem_names_variable_value_unit_and_remedy() -> None:
    depth = parameter("depth", 0.5, "m", "", min=0.1, max=1.0)
    assert depth.problem(0.1) == depth.problem(1.0) == ""
    assert depth.problem(2.0) == (
        "parameter 'depth' = 2.0 m is outside its range. Remedy: give a value of at least 0.1 and at most 1.0 m"
    )
    assert "input 'u' = inf is not a finite number" in input_("u", 0.0, "N", "").problem(math.inf)
    assert "at least" not in input_("u", 0.0, "N", "").problem(math.nan)


def test_clashing_names_are_refused() -> None:
    with pytest.raises(TypeError, match="declared twice: u"):
        type("Twice", (Slave,), {"variables": (input_("u", 0.0, "1", ""), output("u", "1", ""))})
    with pytest.raises(TypeError, match="taken by the base class: save"):
        type("Taken", (Slave,), {"variables": (input_("save", 0.0, "1", ""),)})
    late = type("Late", (Slave,), {"variables": (input_("time", 0.0, "1", ""),)})
    with pytest.raises(TypeError, match="'time' is taken"):
        late(instance_name="late")


def test_outputs_of_the_structure_fit_the_inputs_of_the_fluids() -> None:
    given = {variable.name: variable for variable in interfaces.motion_outputs(dict.fromkeys(interfaces.MOTION, ()))}
    for wanted in interfaces.motion_inputs():
        assert wanted.unit == given[wanted.name].unit
        assert wanted.quantity == given[wanted.name].quantity
    loads = {variable.name: variable for variable in interfaces.aero_outputs(("alpha",), ("chord",), ("elastic_axis",))}
    for wanted in interfaces.wing_load_inputs()[:2]:
        assert wanted.unit == loads[wanted.name].unit
    assert (loads["lift"].depends, loads["C_M"].depends) == (("alpha", "chord"), ("alpha", "elastic_axis"))
    frozen = {variable.name: variable.unit for variable in interfaces.frozen_liquid_parameters()}
    told = {variable.name: variable.unit for variable in interfaces.slosh_outputs(())}
    assert frozen.items() <= told.items()


def test_units_agree_with_each_other() -> None:
    """N/m times m is N, and so on: exponents add up."""

    def times(first: str, second: str) -> dict[str, float]:
        a, b = units.base(first), units.base(second)
        return {key: n for key in {*a, *b} if (n := a.get(key, 0) + b.get(key, 0))}

    assert times("N/m", "m") == units.base("N")
    assert times("N/rad", "rad") == units.base("N") == units.base("J/m")
    assert times("kg/m", "m2/s") == times("kg.m", "1/s")
    assert times("Pa", "m2") == units.base("N")
    assert times("rad/s2", "s") == units.base("rad/s")
