"""The face of the structure without FMI: what its inputs mean, its state, its refusals."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
import pytest

from aeroslosh.fmus.kit.failure import ERROR
from aeroslosh.fmus.structure.fmu import Structure
from aeroslosh.fmus.structure.section import Section, SectionData

MOTION = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot", "energy")


def started(**values: Any) -> Structure:
    """Return an initialised face."""
    wing = Structure(instance_name="wing")
    assign(wing, values)
    wing.setup_experiment(0.0)
    wing.enter_initialization_mode()
    wing.exit_initialization_mode()
    return wing


def assign(wing: Structure, values: dict[str, Any]) -> None:
    """Set variables by name, as FMI does."""
    for name, value in values.items():
        reference = next(r for r, v in enumerate(wing.declared) if v.name == name)
        setter = wing.set_integer if wing.declared[reference].type == "Integer" else wing.set_real
        setter([reference], [value])


def test_signs_of_the_loads() -> None:
    """Lift (up) lifts the section: h (down) falls; a nose-up moment raises alpha; slosh loads act the same way."""
    base = {"static_imbalance": 0.0}
    assert started(**base, lift=100.0).h_ddot == pytest.approx(-100.0 / 57.73)
    assert started(**base, slosh_force_y=100.0).h_ddot == pytest.approx(-100.0 / 57.73)
    assert started(**base, moment=100.0).alpha_ddot == pytest.approx(100.0 / 50.2251)
    assert started(**base, slosh_moment=100.0).alpha_ddot == pytest.approx(100.0 / 50.2251)
    assert started(lift=100.0, trim_lift=100.0, moment=7.0, trim_moment=7.0).h_ddot == 0.0


def test_load_inputs_are_end_of_step_values_and_linear_in_between() -> None:
    wing = started(initial_alpha=0.02, lift=300.0, moment=-50.0)
    assign(wing, {"lift": 900.0, "slosh_moment": 80.0})
    assert wing.do_step(0.0, 0.01)
    exact = Section(SectionData()).propagate(
        np.array([0.0, 0.02, 0.0, 0.0]), np.array([-300.0, -50.0]), np.array([-900.0, 30.0]), 0.01
    )
    np.testing.assert_allclose([wing.h, wing.alpha, wing.h_dot, wing.alpha_dot], exact, rtol=1e-12)


def test_linear_prediction_is_exact_for_loads_linear_in_time() -> None:
    """Told the loads at the start of each step, the FMU finds those at its end, but for the first step, which has no slope."""
    times = np.array([0.0, 0.004, 0.010, 0.014, 0.02])

    def load(t: float) -> np.ndarray:
        return np.array([-300.0 - 4.0e4 * t, 900.0 * t])

    wing = started(load_prediction=1, lift=300.0)
    for start, end in itertools.pairwise(times):
        assign(wing, {"lift": -load(start)[0], "moment": load(start)[1]})
        assert wing.do_step(start, end - start)
    section = Section(SectionData())
    first = section.propagate(np.zeros(4), load(0.0), load(0.0), times[1])
    second = section.propagate(first, load(0.0), load(times[2]), times[2] - times[1])
    exact = section.propagate(second, load(times[2]), load(times[-1]), times[-1] - times[2])
    np.testing.assert_allclose([wing.h, wing.alpha, wing.h_dot, wing.alpha_dot], exact, rtol=1e-11)
    np.testing.assert_allclose(wing.h_ddot, section.acceleration(exact, load(times[-1]))[0], rtol=1e-10)


@pytest.mark.parametrize("cycles", [0.0, 0.5, 1.0], ids=["free", "released before", "released after"])
@pytest.mark.parametrize("prediction", [0, 1])
def test_rollback_is_exact_and_leaves_the_state_alone(prediction: int, cycles: float) -> None:
    wing = started(forced_cycles=cycles, load_prediction=prediction, damping_ratio_alpha=0.01)

    def run(first: int, last: int) -> list[list[str]]:
        rows = []
        for i in range(first, last):
            assign(wing, {"lift": 100.0 * (i % 7), "moment": -30.0 * (i % 5)})
            assert wing.do_step(i * 1e-3, 1e-3), wing.message
            rows.append([float(getattr(wing, name)).hex() for name in MOTION])
        return rows

    run(0, 50)
    state = wing._get_fmu_state()
    packed = wing._fmu_state_to_bytes(state)
    first = run(50, 90)
    wing._set_fmu_state(state)
    assert run(50, 90) == first
    wing._set_fmu_state(wing._fmu_state_from_bytes(packed))
    assert run(50, 90) == first


def test_state_restores_parameters_too() -> None:
    wing = started(initial_alpha=0.02, omega_h=80.0)
    state = wing._get_fmu_state()
    other = started(initial_alpha=0.01)
    other._set_fmu_state(state)
    wing.do_step(0.0, 0.01)
    other.do_step(0.0, 0.01)
    assert (other.h, other.alpha, other.omega_h) == (wing.h, wing.alpha, 80.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"static_imbalance": 60.0}, "mass matrix is not positive definite"),
        ({"forced_cycles": 2.0, "initial_h": 0.01}, "have no effect while the pitch is forced"),
        ({"omega_h": -1.0}, "parameter 'omega_h' = -1.0 rad/s is outside its range"),
        ({"load_prediction": 2}, "give a value of at least 0 and at most 1"),
    ],
)
def test_refusals_name_the_cause_and_the_remedy(values: dict[str, Any], words: str) -> None:
    wing = started(**values)
    assert words in wing.message
    assert "Remedy" in wing.message
    assert wing.do_step(0.0, 1e-3) == ERROR
    assert np.isnan(wing.get_real([next(r for r, v in enumerate(wing.declared) if v.name == "h")])[0])
