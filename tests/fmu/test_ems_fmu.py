"""The slosh_ems FMU through FMPy: closed forms, energy, rollback, several instances, bad input."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.fmus.tank.potential import harmonic_load

Fmu = Callable[[str], Path]
Host = Callable[..., Any]
ERROR = 3  # fmi2Error
UNDAMPED = {"liquid_viscosity": 0.0}
LOADS = ["force_x", "force_y", "moment"]


def test_description_has_no_problems_and_the_shared_interface(fmu: Fmu) -> None:
    assert validate_fmu(str(fmu("slosh_ems"))) == []
    with ZipFile(fmu("slosh_ems")) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    units = {}
    for scalar in root.iter("ScalarVariable"):
        real = scalar.find("Real")
        if real is not None:
            units[scalar.get("name"), scalar.get("causality")] = real.get("unit")
    motion = {"h": "m", "h_dot": "m/s", "h_ddot": "m/s2", "alpha": "rad", "alpha_dot": "rad/s", "alpha_ddot": "rad/s2",
              "x": "m", "x_dot": "m/s", "x_ddot": "m/s2"}  # fmt: skip
    loads = {"force_x": "N/m", "force_y": "N/m", "moment": "N", "static_force_y": "N/m", "static_moment": "N",
             "force_x_residual": "N/m", "force_y_residual": "N/m", "moment_residual": "N", "liquid_mass": "kg/m",
             "liquid_static_moment": "kg", "liquid_inertia": "kg.m", "liquid_stiffness": "N/rad", "effective_gravity": "m/s2",
             "wave_height_west": "m", "wave_height_east": "m", "validity": "1", "parametric_resonance": "1"}  # fmt: skip
    tank = {"tank_length": "m", "tank_height": "m", "tank_width": "m", "fill_level": "1", "tank_x": "m", "tank_y": "m",
            "liquid_density": "kg/m3", "gas_density": "kg/m3", "liquid_viscosity": "m2/s", "gas_viscosity": "m2/s",
            "gravity": "m/s2", "damping_ratio": "1"}  # fmt: skip
    for causality, table in (("input", motion), ("output", loads), ("parameter", tank)):
        assert {name: units.get((name, causality)) for name in table} == table


OFF = {"tank_x": 1.8, "tank_y": 0.2, "tank_width": 0.7}


@pytest.mark.parametrize(
    ("name", "omega", "place", "parametric"),
    [
        ("x", 4.0, {}, False),
        ("x", 6.0, OFF, False),
        ("alpha", 4.0, OFF, False),
        ("alpha", 6.0, {}, False),
        ("x", 6.0, {}, True),
        ("alpha", 4.0, OFF, True),
    ],
    ids=["surge", "surge off the axis", "pitch off the axis", "pitch", "parametric surge", "parametric pitch off the axis"],
)
def test_harmonic_motion_is_that_of_the_closed_forms(
    fmu: Fmu, host: Host, name: str, omega: float, place: dict[str, float], parametric: bool
) -> None:
    """Undamped, so the free waves of the start never fade: all known frequencies are fitted, the forced part is compared.

    The parametric equations at a motion so small that its square is nothing.
    """
    count, size, step, steps = (8, 1e-8, 0.05, 600) if parametric else (60, 1e-3, 0.03, 900)
    values = {**UNDAMPED, "modes": count, "parametric": parametric, **place}
    rows = np.array(host("slosh_harmonic", str(fmu("slosh_ems")), values, {name: [size, omega, math.pi / 2]}, step, steps, LOADS))
    tank = Tank(0.5, 0.15, place.get("tank_width", 1.0), x=place.get("tank_x", 0.0), y=place.get("tank_y", 0.0))
    t = step * np.arange(steps + 1)[:, None]
    free = modes(tank, count).omega * t
    columns = np.hstack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t), np.cos(free), np.sin(free)])
    fitted = np.linalg.lstsq(columns, rows, rcond=None)[0]
    static = [0.0, -tank.mass * 9.81, tank.static_moment * 9.81]
    exact = np.array(harmonic_load(tank, omega, **{name: size}))
    scale = np.maximum(np.abs(exact), 1e-3 * np.abs(exact).max())
    # eight modes leave 2e-5 out; sixty less than 1e-7
    limit = 3e-5 if parametric else 1e-6
    np.testing.assert_allclose(fitted[0] / scale, exact / scale, rtol=0.0, atol=limit)
    np.testing.assert_allclose(fitted[1] / scale, 0.0, rtol=0.0, atol=limit)
    np.testing.assert_allclose(fitted[2], static, rtol=1e-9, atol=1e-6 * np.abs(exact).max())
    # and nothing is left: every sample is forced motion, free waves and weight
    np.testing.assert_allclose(columns @ fitted, rows, rtol=0.0, atol=1e-6 * np.abs(rows - static).max() + 1e-11)


def test_waves_keep_their_energy_once_the_tank_rests(fmu: Fmu, host: Host) -> None:
    """A tilt that is let go: the surface is level at the start, the tank from the first step on."""
    path = str(fmu("slosh_ems"))
    for parametric in (False, True):
        energy, height = np.array(host("ems_let_go", path, {**UNDAMPED, "parametric": parametric}, 0.02, 0.01, 1500)).T
        assert energy[0] > 1e-2
        np.testing.assert_allclose(energy, energy[0], rtol=1e-10)
        assert height.max() > 4e-3  # the surface swings: 0.02 rad over half the length is 5e-3
        assert height.min() < -4e-3


def test_communication_steps_do_not_matter(fmu: Fmu, host: Host) -> None:
    """Sixty against two hundred and forty steps a period of the fastest motion; the damping is that of water."""
    waves = {"h": [1e-3, 12.0, 0.1], "alpha": [5e-3, 8.0, 0.0], "x": [2e-3, 5.0, 0.4]}
    place = {"tank_x": 0.7, "tank_y": 0.2}
    period = 2.0 * math.pi / 12.0
    for parametric in (False, True):
        values = {**place, "parametric": parametric, "modes": 30}
        coarse, fine = (
            np.array(host("slosh_harmonic", str(fmu("slosh_ems")), values, waves, period / n, 4 * n, LOADS)) for n in (60, 240)
        )
        moving = np.ptp(fine, axis=0)
        np.testing.assert_allclose(coarse / moving, fine[::4] / moving, rtol=0.0, atol=2e-7)


@pytest.mark.validation  # a time: for an idle machine
@pytest.mark.parametrize("parametric", [False, True])
@pytest.mark.parametrize("count", [8, 100])
def test_cost(fmu: Fmu, host: Host, count: int, parametric: bool) -> None:
    """Printed with -s; a bound ten times above what was seen, for slow machines."""
    cost = host("slosh_cost", str(fmu("slosh_ems")), {"modes": count, "parametric": parametric}, 8.7e-4, 400)
    print(f"{count} modes, {'parametric' if parametric else 'linear'}: {cost:.0f} µs a step through FMI")
    assert cost < (4000 if parametric else 1000)


@pytest.mark.parametrize("parametric", [False, True])
def test_rollback_and_restart_in_a_new_process_are_exact_to_the_bit(
    fmu: Fmu, host: Host, tmp_path: Path, parametric: bool
) -> None:
    kept, path = str(tmp_path / "state"), str(fmu("slosh_ems"))
    values = {"parametric": parametric, "tank_x": 0.4, "fill_level": 0.3, "modes": 37, "limit": 0}
    seen = host("slosh_rollback", path, values, 2e-3, kept)
    assert seen["first"] == seen["second"]
    assert seen["first"][0] != seen["first"][-1]
    assert host("slosh_resume", path, 2e-3, kept) == seen["first"]


def test_instances_do_not_disturb_each_other(fmu: Fmu, host: Host) -> None:
    shallow, deep, alone = host("slosh_two", str(fmu("slosh_ems")))
    assert shallow == alone
    assert abs(shallow) > 0.0
    assert shallow != deep


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"fill_level": 1.2}, ["'fill_level' = 1.2", "at most 1.0"]),
        ({"fill_level": 0.0}, ["'fill_level' = 0.0", "at least 1e-06"]),
        ({"tank_length": -0.5}, ["'tank_length' = -0.5 m"]),
        ({"liquid_density": float("nan")}, ["'liquid_density' = nan"]),
        ({"modes": 0}, ["'modes' = 0", "at least 1"]),
        ({"damping_ratio": 1.0}, ["'damping_ratio' = 1.0", "at most 0.9"]),
        ({"limit": 2}, ["give one of 0 (high), 1 (low)"]),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_bad_parameters_are_clear_errors(fmu: Fmu, host: Host, values: dict[str, Any], words: list[str]) -> None:
    seen = host("bad_start", str(fmu("slosh_ems")), values)
    assert seen["failed"] is True
    assert seen["status"] == ERROR
    for word in words:
        assert word in seen["error"]


def test_a_surface_that_is_lost_ends_the_parametric_run_with_a_remedy(fmu: Fmu, host: Host) -> None:
    seen = host("slosh_lost", str(fmu("slosh_ems")), {"parametric": True})
    assert seen["status"] == ERROR
    assert "effective gravity was negative" in seen["error"]
    assert "Remedy: parametric = false" in seen["error"]
    assert seen["force_x"] == "nan"
    assert seen["again"] == 0
    # the linear equations do not see gravity change
    assert host("slosh_lost", str(fmu("slosh_ems")), {"parametric": False})["steps"] == 2000
