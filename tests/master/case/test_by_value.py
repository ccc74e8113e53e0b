"""Cases in kg/m, Hz, m/s and metres of altitude: what they become, what is refused, what is written back."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.case import atmosphere, by_value, checks, dimensions, plausible
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales
from support.wing import FORMS, SOUND, loaded, refused


def test_hand_values(tmp_path: Path) -> None:
    """b = 1 m and rho = 1.2 kg/m3: mu = 60 pi / (1.2 pi) = 50, x_alpha = 2 (0.45 - 0.35), r2 = 15 / 60."""
    s = loaded(tmp_path).section
    assert s.mass_ratio == pytest.approx(50.0, rel=1e-14)
    assert s.x_alpha == pytest.approx(0.2, rel=1e-14)
    assert s.r2_alpha == pytest.approx(0.25, rel=1e-14)
    assert s.frequency_ratio == pytest.approx(0.4, rel=1e-14)
    V_f = loaded(tmp_path).flutter.V_f
    assert V_f == pytest.approx(0.5 * SOUND / (20.0 * math.pi * math.sqrt(50.0)), rel=1e-14)
    assert V_f == pytest.approx(0.39076, rel=1e-4)  # by a pocket calculator: 173.61 / (62.832 x 7.0711)


@pytest.mark.parametrize("name", FORMS)
def test_every_form_is_the_same_wing(tmp_path: Path, name: str) -> None:
    usual, other = loaded(tmp_path), loaded(tmp_path, **FORMS[name])
    for key in by_value.ALTERNATIVES:
        assert by_value.value(other, key) == pytest.approx(by_value.value(usual, key), rel=1e-13), key
    s = scales(other, other.flow.mach, other.flutter.V_f)
    assert s.mass == pytest.approx(60.0 * math.pi, rel=1e-13) and s.inertia == pytest.approx(15.0 * math.pi, rel=1e-13)
    assert s.static_imbalance == pytest.approx(12.0 * math.pi, rel=1e-13)
    assert (s.omega_h / 2.0 / math.pi, s.omega_alpha / 2.0 / math.pi) == pytest.approx((4.0, 10.0), rel=1e-13)


def test_altitude_and_warm_air(tmp_path: Path) -> None:
    high = {"flow__static_pressure": None, "flow__static_temperature": None, "flow__altitude": 11000.0}
    f = loaded(tmp_path, **high).flow
    assert f.static_pressure == pytest.approx(22632.1, rel=5e-6) and f.static_temperature == pytest.approx(216.65)
    warm = loaded(tmp_path, **high, flow__delta_temperature=10.0).flow
    assert warm.static_pressure == f.static_pressure and warm.static_temperature == pytest.approx(226.65)


def test_mach_number_and_dynamic_pressure_fix_the_altitude(tmp_path: Path) -> None:
    """A matched point: at 10000 m and Mach 0.8, q = 0.7 p M^2."""
    p, T = atmosphere.air(10000.0)
    none = {"flow__static_pressure": None, "flow__static_temperature": None, "flow__mach": 0.8}
    by_q = loaded(tmp_path, **none, flutter__dynamic_pressure=0.7 * p * 0.64)
    by_eas = loaded(tmp_path, **none, flutter__equivalent_airspeed=math.sqrt(2.0 * 0.7 * p * 0.64 / 1.225))
    by_altitude = loaded(tmp_path, **none, flow__altitude=10000.0)
    for case in (by_q, by_eas, by_altitude):
        assert case.flow.static_pressure == pytest.approx(p, rel=1e-13)
        assert case.flow.static_temperature == pytest.approx(T, rel=1e-13)
        assert case.flutter.V_f == pytest.approx(by_altitude.flutter.V_f, rel=1e-13)
    said = refused(tmp_path, **none, flutter__dynamic_pressure=1e6)
    assert "flutter.dynamic_pressure" in said and "nowhere from -5000 to 47000 m" in said and "line" in said


CONFLICTS = [
    ({"section__mass_ratio": 50.0}, ("section.mass_ratio", "section.mass")),
    ({"section__x_alpha": 0.2}, ("section.x_alpha", "section.x_cg")),
    ({"section__static_imbalance": 1.0}, ("section.static_imbalance", "section.x_cg")),
    ({"section__r2_alpha": 0.25}, ("section.r2_alpha", "section.inertia")),
    ({"section__inertia_cg": 5.0}, ("section.inertia", "section.inertia_cg")),
    ({"section__frequency_ratio": 0.4}, ("section.frequency_ratio", "section.plunge_frequency")),
    ({"section__pitch_stiffness": 1e5}, ("section.pitch_frequency", "section.pitch_stiffness")),
    ({"flutter__V_f": 0.4}, ("flutter.V_f", "section.pitch_frequency")),
    ({"flow__altitude": 0.0}, ("flow.static_pressure", "flow.altitude")),
    ({"flutter__airspeed": 170.0}, ("flow.mach", "flutter.airspeed")),
    ({"flutter__dynamic_pressure": 1e4}, ("flow.mach", "flutter.dynamic_pressure")),
    (
        {"flow__mach": None, "flutter__airspeed": 170.0, "flutter__dynamic_pressure": 1e4},
        ("flutter.airspeed", "flutter.dynamic_pressure"),
    ),
    ({"flow__delta_temperature": 5.0}, ("flow.static_temperature", "flow.delta_temperature")),
]


@pytest.mark.parametrize(("changes", "keys"), CONFLICTS)
def test_two_forms_of_one_quantity(tmp_path: Path, changes: dict[str, Any], keys: tuple[str, ...]) -> None:
    said = refused(tmp_path, **changes)
    first, _, rest = said.partition("\n")
    lines = (tmp_path / "wing.toml").read_text().splitlines()
    for key in keys:
        number = next(n for n, line in enumerate(lines, start=1) if line.startswith(f"{key.partition('.')[2]} = "))
        assert key in first and f"wing.toml, line {number}, key {key}" in rest
    assert "leave out" in said
    with pytest.raises(AeroSloshError, match=keys[0]):  # a sweep's base too
        loaded(tmp_path, "", **changes)


def test_an_override_and_the_file(tmp_path: Path) -> None:
    said = refused(tmp_path, overrides=("flutter.V_f=0.5",))
    assert "--set flutter.V_f=0.5" in said and "line 8, key section.pitch_frequency" in said


MISSING = [
    ({"section__chord": None}, ("section.mass needs section.chord",)),
    ({"section__mass": None, "section__mass_ratio": 50.0}, ("section.inertia needs section.mass",)),
    ({"section__pitch_frequency": None, "flutter__V_f": 0.4}, ("section.plunge_frequency needs section.pitch_frequency or",)),
    (
        {"flow__static_pressure": None, "flow__static_temperature": None},
        ("section.mass needs flow.altitude", "section.pitch_frequency needs flow.altitude"),
    ),
    ({"flow__static_temperature": None}, ("section.mass needs flow.altitude",)),
]


@pytest.mark.parametrize(("changes", "words"), MISSING)
def test_half_a_set_by_value(tmp_path: Path, changes: dict[str, Any], words: tuple[str, ...]) -> None:
    said = refused(tmp_path, **changes)
    assert all(word in said for word in words) and "wing.toml, line" in said
    loaded(tmp_path, "", **changes)  # a sweep may bring the rest


def test_quantities_in_no_form(tmp_path: Path) -> None:
    said = refused(tmp_path, section__x_cg=None, section__inertia=None)
    assert "section.x_alpha, section.r2_alpha" in said and "or by value: section.static_imbalance or section.x_cg" in said
    assert "section.mass_ratio" not in said and "flutter.V_f" not in said
    said = refused(tmp_path, flow__mach=None)
    assert "leaves out a key that a point cannot do without: flow.mach" in said


def test_warmer_than_nothing(tmp_path: Path) -> None:
    changes = {f"section__{name}": None for name in ("mass", "x_cg", "inertia", "plunge_frequency", "pitch_frequency")}
    changes |= {"section__mass_ratio": 50.0, "section__x_alpha": 0.2, "section__r2_alpha": 0.25, "section__frequency_ratio": 0.4}
    changes |= {"flow__static_pressure": None, "flow__static_temperature": None, "flow__delta_temperature": 5.0}
    assert "no effect without flow.altitude" in refused(tmp_path, **changes, flutter__V_f=0.4)


def test_what_cannot_be(tmp_path: Path) -> None:
    said = refused(tmp_path, section__inertia=2.0)  # about the centre of mass, most likely: m (x_alpha b)^2 = 7.54
    assert "section.inertia = 2 kg m" in said and "7.54 kg m" in said and "section.inertia_cg" in said
    said = refused(tmp_path, flow__mach=None, flutter__airspeed=400.0)
    assert "flow.mach = 1.15" in said and "key flutter.airspeed (from which flow.mach follows)" in said
    assert "flow.altitude = 60000.0 is out of range" in refused(
        tmp_path, flow__static_pressure=None, flow__static_temperature=None, flow__altitude=60000.0
    )


def test_changes_are_converted_anew(tmp_path: Path) -> None:
    case = loaded(tmp_path, flow__static_pressure=None, flow__static_temperature=None, flow__altitude=0.0)
    heavier = loaded(tmp_path, overrides=(f"section.mass={120.0 * math.pi}", "section.x_cg=0.4"))
    assert heavier.section.mass_ratio == pytest.approx(100.0) and heavier.section.x_alpha == pytest.approx(0.1)
    high = cases.changed(case, {"flow.altitude": 8000.0}, "here", "point")
    assert high.section.mass_ratio / case.section.mass_ratio == pytest.approx(
        (101325.0 / 288.15) / (atmosphere.air(8000.0)[0] / atmosphere.air(8000.0)[1]), rel=1e-13
    )
    for one in (case, high):
        s = scales(one, one.flow.mach, one.flutter.V_f)
        assert s.mass == pytest.approx(60.0 * math.pi, rel=1e-13)
        assert s.omega_alpha == pytest.approx(20.0 * math.pi, rel=1e-13)
    faster = cases.changed(case, {"flow.mach": 0.6}, "here", "point")
    assert faster.flutter.V_f == pytest.approx(1.2 * case.flutter.V_f, rel=1e-13)


def test_a_case_in_code_by_value() -> None:
    case = cases.changed(Case(), {"section.mass": 100.0, "section.pitch_frequency": 20.0, "flow.altitude": 5000.0}, "here")
    s = scales(case, case.flow.mach, case.flutter.V_f)
    assert s.mass == pytest.approx(100.0, rel=1e-13) and s.omega_alpha == pytest.approx(40.0 * math.pi, rel=1e-13)
    checks.complete(case, "setup", "")
    case.section.mass = 50.0  # past the conversion
    with pytest.raises(AeroSloshError, match=r"changed after they had been converted"):
        checks.complete(case, "setup", "")


@pytest.mark.parametrize("name", ["by value", *FORMS])
def test_the_resolved_case_is_the_same_case_in_both_forms(tmp_path: Path, name: str) -> None:
    case = loaded(tmp_path, **FORMS.get(name, {}))
    text = cases.dump(case)
    (tmp_path / "wing.toml").write_text(text)
    again = cases.load(tmp_path / "wing.toml", command="point")
    assert again == case and cases.flat(again) == cases.flat(case)
    comments = [line[2:].partition("  #")[0] for line in text.splitlines() if line.startswith("# ") and " = " in line]
    live = tomllib.loads(text)
    both = live["section"] | live["flow"] | live["flutter"] | tomllib.loads("\n".join(comments))
    expected = {"mass": 60.0 * math.pi, "mass_ratio": 50.0, "x_cg": 0.45, "x_alpha": 0.2, "r2_alpha": 0.25, "inertia": 47.1239}
    expected |= {"plunge_frequency": 4.0, "pitch_frequency": 10.0, "mach": 0.5, "airspeed": 0.5 * SOUND}
    assert {key: both[key] for key in expected} == pytest.approx(expected, rel=1e-5)


def test_no_default_is_told_of_what_follows(tmp_path: Path) -> None:
    told = checks.defaults(loaded(tmp_path), "point")
    assert not {"section.mass_ratio", "flutter.V_f", "section.mass", "flow.altitude", "aero.parameters"} & set(told)


def test_a_boundary_takes_its_first_mach_number_as_the_start(tmp_path: Path) -> None:
    case = loaded(tmp_path, "boundary", flow__mach=None, boundary__mach=[0.7, 0.8])
    assert case.flutter.V_f == pytest.approx(0.7 * SOUND / (20.0 * math.pi * math.sqrt(50.0)), rel=1e-13)


def test_a_crossing_by_value(tmp_path: Path) -> None:
    """Neutral at 1.1 times the wing's V_f: neutral with a pitch frequency lower by that, or at a speed higher by that."""
    case = loaded(tmp_path)
    s = scales(case, 0.5, 1.1 * case.flutter.V_f)
    found = dimensions.crossing(s, by_value.omega_alpha(case))
    assert found["neutral_pitch_frequency"] == pytest.approx(10.0 / 1.1)
    assert found["own_V_f"] == pytest.approx(case.flutter.V_f) and found["margin"] == pytest.approx(1.1)
    assert found["flutter_airspeed"] == pytest.approx(0.55 * SOUND)
    assert found["flutter_equivalent_airspeed"] == pytest.approx(0.55 * SOUND * math.sqrt(1.2 / 1.225))
    assert found["flutter_dynamic_pressure"] == pytest.approx(0.6 * (0.55 * SOUND) ** 2)
    free = dimensions.crossing(s, None)
    assert free["neutral_pitch_frequency"] == pytest.approx(10.0 / 1.1) and free["margin"] is free["flutter_airspeed"] is None


def test_feet_and_radians_are_asked_about(tmp_path: Path) -> None:
    feet = {"flow__static_pressure": None, "flow__static_temperature": None, "flow__altitude": 35000.0}
    doubts = "\n".join(plausible.doubts(loaded(tmp_path, **feet, flow__mach=0.8)))
    assert "flow.altitude = 35000 m is unusual" in doubts and "35000 ft is 10668 m" in doubts
    small = {"section__chord": 0.2, "section__mass": 6.0, "section__inertia": 0.02}
    (doubt,) = plausible.doubts(loaded(tmp_path, **small, section__pitch_frequency=628.3, section__plunge_frequency=251.3))
    assert "section.pitch_frequency = 628.3 Hz is unusual" in doubt and "628.3 rad/s is 99.9" in doubt
    assert not plausible.doubts(loaded(tmp_path))
