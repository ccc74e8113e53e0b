"""The command itself, in a process of its own."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from scipy.io import netcdf_file

from master import vtk

CASE = Path(__file__).parents[2] / "cases" / "isogai_a.toml"


def aeroslosh(*arguments: str | Path, fmus: Path | None = None) -> subprocess.CompletedProcess[str]:
    """Run the command."""
    environment = dict(os.environ)
    if fmus is not None:
        environment["AEROSLOSH_FMUS"] = str(fmus)
    return subprocess.run(
        [sys.executable, "-m", "master.cli", *map(str, arguments)], capture_output=True, text=True, env=environment
    )


def test_point_prints_json_and_writes_one_folder(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    done = aeroslosh("point", CASE, "--mach", "0.3", "--vf", "0.6", "--json", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["verdict"] == "damped" and data["V_f"] == 0.6 and data["mach"] == 0.3
    for key in ("growth_rate", "growth_rate_uncertainty", "frequency", "frequency_uncertainty", "cost"):
        assert data[key] is not None
    assert {p.name for p in out.iterdir()} == {
        "case.toml",
        "result.json",
        "history.nc",
        "run.log",
        "histories.png",
        "phase.png",
        "mach_field.png",
        "fields",
        "fields.pvd",
    }
    assert "mach = 0.3 " in (out / "case.toml").read_text()
    assert len(json.loads((out / "result.json").read_text())["provenance"]["fmu_sha256"]["aero"]) == 64
    with netcdf_file(str(out / "history.nc"), mmap=False) as file:
        assert {"time", "tau", "h_over_b", "alpha", "lift", "moment", "C_L", "C_M", "C_D", "subiterations", "residual"} <= set(
            file.variables
        )
        assert all(v.units and v.long_name for v in file.variables.values())
        assert file.variables["alpha"].units == b"rad"
        for name in ("command", "date", "versions", "fmu_sha256", "cpu", "host"):
            assert getattr(file, name)
    fields = sorted((out / "fields").glob("*.vts"))
    assert len(fields) == 4
    assert vtk.read(fields[0]).cells["mach"].shape == (48, 168)
    assert vtk.read(fields[0]).cells["velocity"].shape == (48, 168, 3)


def test_second_run_moves_the_first_aside_and_other_folders_are_safe(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    arguments = ("point", CASE, "--mach", "0.3", "--no-pictures", "--quiet", "--out")
    for _ in range(2):
        assert aeroslosh(*arguments, out, fmus=flutter_fmus).returncode == 0
    assert sorted(p.name for p in tmp_path.iterdir()) == ["run", "run.001"]
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("do not lose")
    done = aeroslosh(*arguments, tmp_path / "mine", fmus=flutter_fmus)
    assert done.returncode == 2 and "holds something else than a run" in done.stderr
    assert (tmp_path / "mine" / "thesis.txt").read_text() == "do not lose"


@pytest.mark.parametrize("model", ["frozen", "ems"])
def test_slosh_is_named_in_every_result(flutter_fmus: Path, tmp_path: Path, model: str) -> None:
    out = tmp_path / "run"
    case = CASE.with_name("paper_s.toml")
    done = aeroslosh("point", case, "--mach", "0.3", "--slosh", model, "--json", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["slosh"] == model and (data["slosh_validity"] is not None) is (model == "ems")
    assert len(json.loads((out / "result.json").read_text())["provenance"]["fmu_sha256"]["slosh"]) == 64
    assert f'model = "{model}"' in (out / "case.toml").read_text()
    with netcdf_file(str(out / "history.nc"), mmap=False) as file:
        assert file.slosh == model.encode() and ("slosh_force_y" in file.variables) is (model == "ems")


def test_boundary_prints_json(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    done = aeroslosh(
        "boundary",
        CASE,
        "--mach",
        "0.3",
        "--vf",
        "2.3",
        "--set",
        "flutter.steps_per_cycle=200",
        "--json",
        "--out",
        out,
        fmus=flutter_fmus,
    )
    assert done.returncode == 0, done.stderr
    point = json.loads(done.stdout)["points"][0]
    assert point["V_f"] == pytest.approx(2.387, rel=0.01) and point["converged"] and point["slosh"] == "none"
    assert (out / "boundary.png").is_file()
    assert len(list(out.glob("history_*.nc"))) == len(point["marches"])


def test_a_failing_component_reaches_the_user(flutter_fmus: Path, tmp_path: Path) -> None:
    """Our message, the FMU's traceback, exit code 3, no signal; the history so far is kept."""
    out = tmp_path / "run"
    done = aeroslosh("point", CASE, "--mach", "0.3", "--set", "flow.airfoil=FAIL 100", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 3, (done.returncode, done.stderr)
    assert "aeroslosh: Component 'aero' failed: ValueError: the test double was told to fail (100 % on purpose)" in (done.stderr)
    assert "| Traceback" in done.stderr and "in advance" in done.stderr
    with netcdf_file(str(out / "history.nc"), mmap=False) as file:
        assert file.variables["alpha"].shape == (100,)
    assert "told to fail" in json.loads((out / "result.json").read_text())["failure"]
    assert "Traceback" in (out / "run.log").read_text()


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--mach", "3"], ["flow.mach = 3.0", "out of range", "remedy"]),
        (["--slosh", "water"], ["slosh.model", "available: none, frozen, ems, rbf, vof"]),
        (["--slosh", "rbf"], ["FMU missing: slosh_rbf.fmu", "make fmus"]),
        (["--set", "section.mass_ratio=-1"], ["section.mass_ratio", "above 0"]),
        (["--set", "flow.machh=1"], ["did you mean 'mach'"]),
        (["--bogus"], ["unrecognized arguments"]),
    ],
)
def test_bad_input_exits_with_2_and_leaves_nothing(
    flutter_fmus: Path, tmp_path: Path, arguments: list[str], says: list[str]
) -> None:
    done = aeroslosh("point", CASE, "--out", tmp_path / "run", *arguments, fmus=flutter_fmus)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    for part in says:
        assert part in done.stderr, done.stderr
    assert not list(tmp_path.iterdir())


def test_missing_fmus(tmp_path: Path) -> None:
    done = aeroslosh("point", CASE, "--fmus", tmp_path, "--out", tmp_path / "run")
    assert done.returncode == 2 and "make fmus" in done.stderr


def test_undetermined_exits_with_4(flutter_fmus: Path, tmp_path: Path) -> None:
    done = aeroslosh(
        "point",
        CASE,
        "--mach",
        "0.3",
        "--no-pictures",
        "--set",
        "flow.airfoil=NAN 90",
        "--out",
        tmp_path / "run",
        fmus=flutter_fmus,
    )
    assert done.returncode == 4 and "UNDETERMINED" in done.stdout
