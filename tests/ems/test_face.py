"""The face of slosh_ems without FMI: outputs that belong together, state, refusals."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from aeroslosh.fmus.kit.failure import ERROR
from aeroslosh.fmus.kit.interfaces import SLOSH, SLOSH_CONSTANT
from aeroslosh.fmus.slosh_ems.fmu import SloshEms
from aeroslosh.fmus.tank.frozen import Load, residual_load
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion

PLACE = {"tank_x": 0.3, "tank_y": 0.1}


def started(**values: Any) -> SloshEms:
    """Return an initialised face."""
    tank = SloshEms(instance_name="tank")
    assign(tank, values)
    tank.setup_experiment(0.0)
    tank.enter_initialization_mode()
    tank.exit_initialization_mode()
    return tank


def assign(tank: SloshEms, values: dict[str, Any]) -> None:
    """Set variables by name, as FMI does."""
    for name, value in values.items():
        reference = next(r for r, v in enumerate(tank.declared) if v.name == name)
        kind = tank.declared[reference].type
        {"Integer": tank.set_integer, "Boolean": tank.set_boolean}.get(kind, tank.set_real)([reference], [value])


def wave(name: str, size: float, omega: float, t: float) -> dict[str, float]:
    """Values of a coordinate in harmonic motion."""
    s, c = math.sin(omega * t), math.cos(omega * t)
    return {name: size * s, f"{name}_dot": size * omega * c, f"{name}_ddot": -size * omega**2 * s}


def drive(tank: SloshEms, waves: list[tuple[str, float, float]], step: float, first: int, last: int) -> None:
    for i in range(first, last):
        for name, size, omega in waves:
            assign(tank, wave(name, size, omega, (i + 1) * step))
        assert tank.do_step(i * step, step), tank.message


def test_at_rest_the_whole_load_is_the_weight() -> None:
    tank = started(**PLACE, tank_width=2.0)
    assert (tank.force_x, tank.force_y) == (0.0, pytest.approx(-75.0 * 9.81))
    assert (tank.static_force_y, tank.static_moment) == (tank.force_y, tank.moment)
    assert tank.moment == pytest.approx(75.0 * 9.81 * 0.3)
    assert (tank.force_x_residual, tank.force_y_residual, tank.moment_residual) == pytest.approx((0.0, 0.0, 0.0))
    assert (tank.parametric_resonance, tank.effective_gravity) == (0.0, 9.81)
    assert tank.validity == tank.friction.thick < 0.02  # water: the first wave's damping ratio of 0.002 over 0.15
    assert (tank.liquid_mass, tank.liquid_static_moment) == pytest.approx((75.0, 22.5))
    assert all(math.isfinite(getattr(tank, name)) for name in (*SLOSH, *SLOSH_CONSTANT))


@pytest.mark.parametrize("parametric", [False, True])
def test_residual_is_the_whole_load_less_the_carried_one(parametric: bool) -> None:
    tank = started(**PLACE, parametric=parametric)
    drive(tank, [("h", 0.01, 7.0), ("alpha", 0.05, 4.0), ("x", 0.003, 5.0)], 0.02, 0, 40)
    motion = SectionMotion(*(getattr(tank, name) for name in SectionMotion._fields))
    whole = Load(tank.force_x, tank.force_y, tank.moment)
    expected = residual_load(whole, Tank(0.5, 0.15, x=0.3, y=0.1), motion)
    assert (tank.force_x_residual, tank.force_y_residual, tank.moment_residual) == expected
    # linear slosh leaves nothing in the vertical; the masses on their tracks do
    assert (tank.force_y_residual == 0.0) == (not parametric)


def test_walls_are_named_fore_and_aft() -> None:
    """Tail down (nose up): the liquid stands higher at the aft, the east wall."""
    tank = started(alpha=0.02)
    assert tank.wave_height_east == pytest.approx(0.02 * 0.25)
    assert tank.wave_height_west == -tank.wave_height_east


def test_validity_is_the_largest_since_the_start() -> None:
    tank = started()
    assign(tank, {"h_ddot": -0.15 * 9.81})
    assert tank.do_step(0.0, 0.01)
    assert tank.validity == pytest.approx(0.5)
    assert tank.effective_gravity == pytest.approx(1.15 * 9.81)
    assign(tank, {"h_ddot": 0.0})
    assert tank.do_step(0.01, 0.01)
    assert tank.effective_gravity == 9.81
    assert tank.validity == pytest.approx(0.5)


def test_resonance_is_seen_before_the_waves_grow_and_only_there() -> None:
    """Plunge at twice the first frequency with 0.1 g: the guard first, then the waves; at 0.7 of that frequency neither."""
    omega, damping = 5.203020, 0.01
    seen = {}
    for factor in (2.0, 1.4):
        drive_at = factor * omega
        tank = started(parametric=True, modes=1, damping_ratio=damping, alpha=1e-5)
        assign(tank, {"alpha": 0.0})
        heights, guards = [], []
        for i in range(1200):
            assign(tank, wave("h", 0.1 * 9.81 / drive_at**2, drive_at, 0.04 * (i + 1)))
            assert tank.do_step(0.04 * i, 0.04), tank.message
            heights.append(abs(tank.wave_height_east))
            guards.append(tank.parametric_resonance)
        seen[factor] = max(heights[-100:]) / max(heights[:100]), max(guards), guards[150]
    assert seen[2.0][0] > 30.0
    assert seen[2.0][1] == pytest.approx(0.1 / (4 * damping), rel=0.1)
    assert seen[2.0][2] > 1.0  # after six seconds
    assert seen[1.4][0] < 0.2
    assert seen[1.4][1] < 0.5


@pytest.mark.parametrize("parametric", [False, True])
def test_rollback_is_exact_and_leaves_the_state_alone(parametric: bool) -> None:
    tank = started(**PLACE, parametric=parametric)
    waves = [("h", 0.002, 31.0), ("alpha", 0.02, 23.0), ("x", 0.001, 7.0)]

    def run() -> list[str]:
        drive(tank, waves, 4e-3, 20, 40)
        return [float(getattr(tank, name)).hex() for name in (*SLOSH, "validity", "parametric_resonance", "wave_energy")]

    drive(tank, waves, 4e-3, 0, 20)
    state = tank._get_fmu_state()
    packed = tank._fmu_state_to_bytes(state)
    first = run()
    tank._set_fmu_state(state)
    assert run() == first
    other = started()
    other._set_fmu_state(other._fmu_state_from_bytes(packed))
    tank = other
    assert run() == first


@pytest.mark.parametrize("viscosity", [1e-6, 1e-2])
def test_damping_from_viscosity_or_given(viscosity: float) -> None:
    """Honey overdamps short waves: the ratio is held at 0.9, where nothing swings."""
    damping = started(liquid_viscosity=viscosity).slosh.oscillators.damping
    assert np.all((damping > 0.0) & (damping <= 0.9))
    assert (damping[-1] == 0.9) == (viscosity == 1e-2)
    assert np.all(started(damping_ratio=0.005, liquid_viscosity=viscosity).slosh.oscillators.damping == 0.005)


def test_a_full_tank_runs() -> None:
    for parametric in (False, True):
        tank = started(fill_level=1.0, parametric=parametric)
        drive(tank, [("h", 0.01, 30.0), ("x", 0.001, 20.0)], 0.01, 0, 20)
        assert tank.force_x == pytest.approx(-75.0 * tank.x_ddot)
        assert (tank.wave_height_east, tank.wave_energy, tank.parametric_resonance) == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"tank_height": 0.0}, "parameter 'tank_height' = 0.0 m is outside its range"),
        ({"fill_level": -0.1}, "parameter 'fill_level' = -0.1 is outside its range"),
        ({"modes": 1000}, "give a value of at least 1 and at most 400"),
        ({"gravity": math.inf}, "'gravity' = inf is not a finite number"),
        ({"alpha": math.nan}, "input 'alpha' = nan is not a finite number"),
    ],
)
def test_refusals_name_the_cause_and_the_remedy(values: dict[str, Any], words: str) -> None:
    tank = started(**values)
    assert words in tank.message
    assert "Remedy" in tank.message
    assert tank.do_step(0.0, 1e-3) == ERROR
