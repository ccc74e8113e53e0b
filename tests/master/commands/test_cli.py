"""The command itself: in a process of its own where its process is the point, else in this one."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from scipy.io import netcdf_file

from aeroslosh.master.base import vtk
from support.paths import CASES
from support.processes import Done, called, command

CASE = CASES / "isogai_a.toml"


def aeroslosh(*words: object, fmus: Path | None = None, run: Callable[..., Done] = called) -> Done:
    """The command in this process, or by `run=command` in one of its own."""
    return run(*words, **({} if fmus is None else {"AEROSLOSH_FMUS": str(fmus)}))


def test_point_prints_json_and_writes_one_folder(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "run"
    done = aeroslosh("point", CASE, "--mach", "0.3", "--vf", "0.6", "--json", "--out", out, fmus=flutter_fmus, run=command)
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
    words = ("--mach", "0.3", "--slosh", model, "--set", "flutter.forced_amplitude_deg=0.01")
    done = aeroslosh("point", case, *words, "--json", "--out", out, fmus=flutter_fmus)
    assert done.returncode == 0, done.stderr
    data = json.loads(done.stdout)
    assert data["slosh"] == model and (data["slosh_validity"] is not None) is (model == "ems")
    assert data["defaults"]["slosh.gravity"] == 9.81 and "slosh.tank_x" not in data["defaults"] and data["warnings"] == []
    assert len(json.loads((out / "result.json").read_text())["provenance"]["fmu_sha256"]["slosh"]) == 64
    assert f'model = "{model}"' in (out / "case.toml").read_text()
    with netcdf_file(str(out / "history.nc"), mmap=False) as file:
        assert file.slosh == model.encode() and ("slosh_force_y" in file.variables) is (model == "ems")


def test_a_slosh_model_that_does_not_hold_gives_no_verdict(flutter_fmus: Path, tmp_path: Path) -> None:
    """At 1 degree gravity in the tank changes by far more than linear slosh bears: point, boundary and sweep say so and end
    with 4; so does a liquid that is too viscous for any motion, which is told before the march."""
    case = CASE.with_name("paper_s.toml")
    words = (case, "--fmus", flutter_fmus, "--set", "flow.mach=0.3", "--set", "flutter.steps_per_cycle=100")
    done = aeroslosh("point", *words, "--vf", "1.5", "--no-pictures", "--out", tmp_path / "p")
    assert done.returncode == 4 and "UNDETERMINED" in done.stdout and "the slosh model does not hold" in done.stdout
    search = ("--set", "boundary.max_marches=2", "--set", "boundary.method=march")
    done = aeroslosh("boundary", *words, *search, "--mach", "0.3", "--vf", "2.3", "--no-pictures", "--out", tmp_path / "b")
    assert done.returncode == 4 and "does not hold" in done.stdout and "does not hold" in done.stderr
    told = json.loads((tmp_path / "b" / "result.json").read_text())["points"][0]
    assert told["slosh_holds"] is False and told["slosh_validity"] > 1.0 and told["verdict"] == "undetermined"
    grid = ("--grid", "flutter.forced_amplitude_deg=0.01,1.0", "--set", "flutter.V_f=1.5", "--workers", "1")
    done = aeroslosh("sweep", *words, *grid, "--no-pictures", "--out", tmp_path / "s")
    assert done.returncode == 4 and "1 points: the slosh model does not hold" in done.stdout
    assert "False" in (tmp_path / "s" / "sweep.csv").read_text()
    thick = ("--set", "slosh.liquid_viscosity=0.01", "--set", "flutter.forced_amplitude_deg=0.001", "--no-pictures")
    done = aeroslosh("point", *words, *thick, "--out", tmp_path / "t")
    assert done.returncode == 4 and 'slosh.model = "vof"' in done.stdout
    assert done.stderr.index("does not hold") < done.stderr.index("march at Mach")


@pytest.mark.parametrize("command", ["point", "boundary", "sweep", "export ssp"])
def test_an_empty_case_is_refused_by_every_command(flutter_fmus: Path, tmp_path: Path, command: str) -> None:
    case = tmp_path / "empty.toml"
    case.write_text("")
    swept = ("--grid", "flutter.V_f=0.5,0.6") if command == "sweep" else ()
    done = aeroslosh(*command.split(), case, *swept, "--out", tmp_path / "run.ssp", fmus=flutter_fmus)
    assert done.returncode == 2 and "empty.toml" in done.stderr and "cannot do without: section.elastic_axis" in done.stderr
    assert "Traceback" not in done.stderr and sorted(p.name for p in tmp_path.iterdir()) == ["empty.toml"]


def test_defaults_are_told_on_the_terminal(flutter_fmus: Path, tmp_path: Path) -> None:
    done = aeroslosh("point", CASE, "--mach", "0.3", "--no-pictures", "--quiet", "--out", tmp_path / "run", fmus=flutter_fmus)
    (line,) = [line for line in done.stderr.splitlines() if "keys at their default: section.damping_ratio_h = 0" in line]
    assert line.split()[0].isdigit() and line in (tmp_path / "run" / "run.log").read_text()
    assert len(json.loads((tmp_path / "run" / "result.json").read_text())["defaults"]) == int(line.split()[0])


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
    done = aeroslosh(
        "point", CASE, "--mach", "0.3", "--set", "flow.airfoil=FAIL 100", "--out", out, fmus=flutter_fmus, run=command
    )
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
        (["--slosh", "rbf"], ["cannot do without: slosh.tank_length", "--set slosh.tank_length=VALUE"]),
        (["--set", "section.mass_ratio=-1"], ["section.mass_ratio", "above 0"]),
        (["--set", "flow.machh=1"], ["did you mean 'mach'"]),
        (["--bogus"], ["unrecognized arguments"]),
    ],
)
def test_bad_input_exits_with_2_and_leaves_nothing(
    flutter_fmus: Path, tmp_path: Path, arguments: list[str], says: list[str]
) -> None:
    run = command if arguments == ["--bogus"] else called  # one of each kind is enough of processes
    done = aeroslosh("point", CASE, "--out", tmp_path / "run", *arguments, fmus=flutter_fmus, run=run)
    assert done.returncode == 2
    assert "Traceback" not in done.stderr
    for part in says:
        assert part in done.stderr, done.stderr
    assert not list(tmp_path.iterdir())


def test_missing_fmus(tmp_path: Path) -> None:
    done = aeroslosh("point", CASE, "--fmus", tmp_path, "--out", tmp_path / "run")
    assert done.returncode == 2 and "make fmus" in done.stderr


def test_a_missing_slosh_fmu(flutter_fmus: Path, tmp_path: Path) -> None:
    done = aeroslosh("point", CASE.with_name("paper_s.toml"), "--slosh", "rbf", "--out", tmp_path / "run", fmus=flutter_fmus)
    assert done.returncode == 2 and "FMU missing: slosh_rbf.fmu" in done.stderr and "make fmus" in done.stderr


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
