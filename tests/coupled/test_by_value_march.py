"""A wing in kg/m, Hz and metres of altitude marches as the same wing in dimensionless words; results say both."""

from __future__ import annotations

import json
import math
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aeroslosh.master.boundary import solve
from aeroslosh.master.case import atmosphere
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.results import by_value, summary
from aeroslosh.master.ssp import system as ssp_system
from support import sections, theory

AXIS, X_ALPHA, R2, RATIO, MU = 0.35, 0.2, 0.3, 0.4, 40.0
CHORD, ALTITUDE, PITCH = 1.6, 4000.0, 9.0
DRY = ("--no-pictures", "--set", "flutter.steps_per_cycle=72", "--quiet")


def wing(folder: Path, mach: float = 0.3, more: str = "", pitch: float = PITCH) -> Path:
    """The file of the section above by value, at an altitude."""
    p, T = atmosphere.air(ALTITUDE)
    b = 0.5 * CHORD
    mass = MU * math.pi * p / (287.05 * T) * b**2
    path = folder / "wing.toml"
    path.write_text(
        f"[section]\nchord = {CHORD}\nelastic_axis = {AXIS}\nmass = {mass!r}\nx_cg = {AXIS + 0.5 * X_ALPHA!r}\n"
        f"inertia = {R2 * mass * b**2!r}\nplunge_frequency = {RATIO * pitch!r}\npitch_frequency = {pitch!r}\n"
        f'[flow]\nmach = {mach!r}\naltitude = {ALTITUDE}\nairfoil = "NACA 0012"\n{more}'
    )
    return path


def dimensionless(mach: float) -> Case:
    """The same section in dimensionless words."""
    case = sections.named(AXIS, X_ALPHA, R2, RATIO, MU)
    p, T = atmosphere.air(ALTITUDE)
    case.section.chord, case.flow.airfoil, case.flow.mach = CHORD, "NACA 0012", mach
    case.flow.static_pressure, case.flow.static_temperature = p, T
    sound = math.sqrt(1.4 * 287.05 * T)
    case.flutter.V_f = mach * sound / (0.5 * CHORD * 2.0 * math.pi * PITCH * math.sqrt(MU))
    return case


def test_both_forms_march_alike(flutter_fmus: Path, tmp_path: Path) -> None:
    fmus, found = find_fmus(flutter_fmus), []
    for case in (cases.load(wing(tmp_path), command="point"), dimensionless(0.3)):
        with FlutterSetup(case, fmus, case.flow.mach) as setup:
            found.append(flutter_march.march(setup, case.flutter.V_f))
    mine, other = found
    assert mine.history["alpha"].size == other.history["alpha"].size > 500
    for name in ("h", "alpha", "lift", "moment"):
        scale = np.abs(other.history[name]).max()
        assert scale > 0.0 and np.abs(mine.history[name] - other.history[name]).max() < 1e-9 * scale
    assert mine.fit is not None and other.fit is not None
    assert mine.fit.growth_rate == pytest.approx(other.fit.growth_rate, rel=1e-6)
    data = summary.march_data(mine)
    said = data["by_value"]
    assert (said["pitch_frequency"], said["plunge_frequency"]) == pytest.approx((PITCH, RATIO * PITCH), rel=1e-12)
    assert said["pressure_altitude"] == pytest.approx(ALTITUDE, abs=1e-6)
    assert said["airspeed"] == pytest.approx(
        0.3 * 324.579, rel=1e-5
    )  # 20.046796 sqrt(262.15), the speed of sound of the standard
    text = summary.march_summary(data)
    assert "97.37 m/s true" in text and "pressure altitude 4000 m" in text and "pitch 9 Hz" in text


def test_a_boundary_tells_margin_and_flutter_speed(flutter_fmus: Path, tmp_path: Path) -> None:
    """The double's loads do not depend on Mach: the wing flutters where its own V_f, proportional to it, is the exact one."""
    exact = theory.neutral(dimensionless(0.3), 0.3, 0.2, 3.0)
    pitch = PITCH * dimensionless(0.3).flutter.V_f / exact  # neutral at Mach 0.3
    path = wing(tmp_path, 0.3, '[boundary]\nmach = [0.25, 0.34]\nmethod = "linear"\nV_f_range = [0.2, 3.0]\n', pitch)
    case = cases.load(path, command="boundary")
    points = solve.solve(case, find_fmus(flutter_fmus), lambda text: None)
    rows: list[dict[str, Any]] = [{"slosh": "none"} | summary.point_data(p) for p in points]
    for row in rows:
        crossing = row["crossings"][0]
        d = crossing["by_value"]
        assert crossing["V_f"] == pytest.approx(exact, rel=5e-3)
        assert d["margin"] == pytest.approx(0.3 / row["mach"], rel=5e-3)
        assert row["by_value"]["margin"] == pytest.approx(d["margin"], rel=1e-12)
        assert d["neutral_pitch_frequency"] * d["margin"] == pytest.approx(pitch, rel=1e-12)
        assert d["flutter_airspeed"] == pytest.approx(0.3 * 324.579, rel=5e-3)
    (met,) = by_value.matched(rows)
    assert met["mach"] == pytest.approx(0.3, rel=5e-3) and met["onset"] and met["between"] == [0.25, 0.34]
    assert met["airspeed"] == pytest.approx(0.3 * 324.579, rel=5e-3)
    assert met["equivalent_airspeed"] == pytest.approx(met["airspeed"] * math.sqrt(0.819129 / 1.225), rel=1e-4)
    assert met["dynamic_pressure"] == pytest.approx(0.5 * 0.819129 * met["airspeed"] ** 2, rel=1e-4)
    text = summary.boundary_summary(rows)
    assert "this wing in this air flutters from about Mach 0.3" in text and "margin" in text
    assert "lowest neutral V_f above the wing's own: least margin 1.20" in summary.boundary_summary(rows[:1])


def command(*arguments: str | Path, fmus: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "aeroslosh", *map(str, arguments)],
        capture_output=True, text=True, env={**os.environ, "AEROSLOSH_FMUS": str(fmus)},
    )  # fmt: skip


def test_sweep_over_altitude_and_its_resume(flutter_fmus: Path, tmp_path: Path) -> None:
    path, out = wing(tmp_path), tmp_path / "s"
    arguments = ("sweep", path, "--grid", "flow.altitude=0,8000", "--workers", "1", "--out", out, *DRY)
    done = command(*arguments, fmus=flutter_fmus)
    assert done.returncode == 0, done.stderr
    header, *rows = (out / "sweep.csv").read_text().splitlines()
    column = header.split(",").index
    masses = {float(row.split(",")[column("mass")]) for row in rows}
    speeds = [float(row.split(",")[column("airspeed")]) for row in rows]
    assert len(rows) == 2 and max(masses) == pytest.approx(min(masses), rel=1e-12)
    assert speeds == pytest.approx([0.3 * 340.294, 0.3 * 308.063], rel=1e-5)
    again = command(*arguments, "--resume", fmus=flutter_fmus)
    assert again.returncode == 0 and "0 failed" in again.stdout and "points to compute" not in again.stderr
    changed = command(*arguments, "--resume", "--set", "section.pitch_frequency=12", fmus=flutter_fmus)
    assert "section.pitch_frequency" in changed.stderr + changed.stdout


def test_the_command_says_both_and_restarts(flutter_fmus: Path, tmp_path: Path) -> None:
    path, out = wing(tmp_path), tmp_path / "run"
    changes = ("--set", "section.mass=120", "--set", "structure.parameters={}", *DRY)
    done = command("point", path, "--json", *changes, "--out", out, "--checkpoint", tmp_path / "c.npz", fmus=flutter_fmus)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["by_value"]["mass"] == pytest.approx(120.0) and data["V_f"] == pytest.approx(cases.load(
        path, ["section.mass=120"], "point").flutter.V_f)  # fmt: skip
    text = (out / "case.toml").read_text()
    assert "\nmass = 120.0 " in text and "\n# mass_ratio = " in text and "\naltitude = 4000.0 " in text
    assert command("point", path, *changes, "--restart", tmp_path / "c.npz", "--out", out, fmus=flutter_fmus).returncode == 0
    other = ("--set", "section.mass=121", *DRY)
    done = command("point", path, *other, "--restart", tmp_path / "c.npz", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 2 and "section.mass: 120.0 then, 121.0 now" in done.stderr
    done = command("point", path, "--vf", "0.5", *DRY, "--out", out, fmus=flutter_fmus)
    assert done.returncode == 2 and "flutter.V_f and section.pitch_frequency are both given" in done.stderr


def test_parameters_of_the_fmus_are_in_the_archive(flutter_fmus: Path, tmp_path: Path) -> None:
    tank = "[flutter]\nforced_cycles = 0\n[structure.parameters]\ninitial_alpha = 0.01\n[slosh]\nmodel = 'ems'\n"
    tank += "tank_length = 0.5\ntank_height = 0.15\nfill_level = 0.5\ntank_x = 0\ntank_y = 0\nliquid_density = 800\n"
    tank += "liquid_viscosity = 2e-6\n[slosh.parameters]\nlimit = 'high'\n"
    case = cases.load(wing(tmp_path, more=tank), command="point")
    fmus = find_fmus(flutter_fmus, "ems")
    parts = {part.name: part.values for part in ssp_system.from_case(case, fmus).parts}
    assert parts["structure"]["initial_alpha"] == 0.01 and parts["slosh"]["limit"] == 0
    with FlutterSetup(case, fmus, 0.3) as setup:
        march = flutter_march.march(setup, case.flutter.V_f)
    assert march.history["alpha"][0] == 0.01 and march.release == 0


def test_a_wrong_parameter_is_refused_before_anything_is_written(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    done = command("point", wing(tmp_path), "--set", "structure.parameters.initial_alfa=0.1", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 2 and "did you mean 'initial_alpha'?" in done.stderr
    assert "--set structure.parameters.initial_alfa=0.1" in done.stderr and not out.exists()
