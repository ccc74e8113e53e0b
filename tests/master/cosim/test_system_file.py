"""`aeroslosh run`: systems of FMUs from a file, what they give and what is refused."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.io import netcdf_file

from aeroslosh.master import cli
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.cosim import system_file as assemblies
from aeroslosh.master.cosim.scheme import GaussSeidel
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.fmi.component import Component
from support.doubles import LINKED
from support.paths import CASES
from support.processes import Done, command

EXAMPLE = CASES / "tank_on_springs.toml"
TWO = """
[components.a]
fmu = "oscillator.fmu"
parameters = { mass = 1, stiffness = 4.0, initial_x = 1.0 }
[components.b]
fmu = "oscillator"
[components.b.parameters]
mass = 2.0
stiffness = 3.0
initial_v = -0.5
[components.link]
fmu = "link.fmu"
parameters = { stiffness = 2.0, damping = 0.1 }
[system]
wires = [
  "a.x -> link.x_a", "a.v -> link.v_a", "a.a -> link.a_a", "b.x -> link.x_b", "b.v -> link.v_b",
  "link.force_a -> a.force", "link.force_b -> b.force",
]
[run]
end = 1.0
step = 0.01
pictures = false
"""


@pytest.fixture
def call(doubles: Path, tmp_path: Path) -> Callable[..., int]:
    """`call(text, *arguments)` runs the command on a system file in this process: its exit code, or AeroSloshError."""

    def run(text: str, *arguments: str, fmus: Path = doubles) -> int:
        file = tmp_path / "two.toml"
        file.write_text(text, encoding="utf-8")
        return cli.run(["run", str(file), "--fmus", str(fmus), "--out", str(tmp_path / "out"), "--quiet", *arguments])

    return run


def history(folder: Path) -> dict[str, np.ndarray]:
    with netcdf_file(str(folder / "history.nc"), mmap=False) as file:
        return {name: variable[:].copy() for name, variable in file.variables.items()}


def result(folder: Path) -> dict:  # type: ignore[type-arg]
    return dict(json.loads((folder / "result.json").read_text(encoding="utf-8")))


def test_a_system_file_is_the_system_built_by_hand(call: Callable[..., int], doubles: Path, tmp_path: Path) -> None:
    """To the bit: same order, same steps; every output in the history with its unit."""
    assert call(TWO) == ExitCode.OK
    seen = history(tmp_path / "out")
    parts = {
        name: Component(doubles / f"{fmu}.fmu", name)
        for name, fmu in (("a", "oscillator"), ("b", "oscillator"), ("link", "link"))
    }
    parts["a"].set_all({"mass": 1.0, "stiffness": 4.0, "initial_x": 1.0})
    parts["b"].set_all({"mass": 2.0, "stiffness": 3.0, "initial_v": -0.5})
    parts["link"].set_all({"stiffness": 2.0, "damping": 0.1})
    system = System(list(parts.values()), wires(LINKED))
    system.initialize()
    scheme = GaussSeidel(1)
    scheme.reset(system)
    rows = [system.values.copy()]
    for _ in range(100):
        scheme.step(system, 0.01)
        rows.append(system.values.copy())
    system.close()
    names = [f"{c.name}.{n}" for c in parts.values() for n in c.outputs.names]
    assert set(seen) == {"time", "passes", *names}
    for name, column in zip(names, np.array(rows).T, strict=True):
        assert (seen[name] == column).all(), name
    assert seen["time"] == pytest.approx(0.01 * np.arange(101), abs=1e-14)  # products of a step: rounding alone
    with netcdf_file(str(tmp_path / "out" / "history.nc"), mmap=False) as file:
        assert file.variables["a.x"].units == b"m" and file.variables["link.force_a"].units == b"N"
    data = result(tmp_path / "out")
    assert data["converged"] and data["outcome"] == "completed" and data["failure"] is None
    assert data["last"]["a.x"] == seen["a.x"][-1] and data["scheme"]["steps"] == 100
    assert len(data["provenance"]["fmu_sha256"]["link"]) == 64


def test_the_resolved_file_runs_again_to_the_same_bits(call: Callable[..., int], tmp_path: Path) -> None:
    assert call(TWO, "--set", "coupling.scheme=implicit", "--set", "coupling.substeps={a=2}") == ExitCode.OK
    first = history(tmp_path / "out")
    assert call((tmp_path / "out" / "case.toml").read_text(encoding="utf-8")) == ExitCode.OK
    again = history(tmp_path / "out")
    assert all((first[name] == again[name]).all() for name in first) and max(first["passes"]) > 1


def test_overrides(call: Callable[..., int], tmp_path: Path) -> None:
    changes = ("components.a.parameters.mass=2", "run.end=0.5", "run.record_every=5", "components.b.parameters.initial_v=0")
    assert call(TWO, *(word for change in changes for word in ("--set", change))) == ExitCode.OK
    assert call(TWO.replace("mass = 1,", "mass = 2,").replace("-0.5", "0.0").replace("end = 1.0", "end = 0.5")) == ExitCode.OK
    changed, written = (history(tmp_path / name) for name in ("out.001", "out"))
    assert changed["time"].size == 11 and written["time"].size == 51
    assert all((changed[name] == written[name][::5]).all() for name in changed if name != "passes")


def test_a_model_that_predicts_another(call: Callable[..., int], tmp_path: Path) -> None:
    """A twin that predicts the link takes away its lag: one pass then gives what iterations give.

    1e-7: the prediction's own tolerance, of forces of about 1 N on 1 kg for 1 s."""
    twin = '\n[components.twin]\nfmu = "link.fmu"\npredicts = "link"\nparameters = { stiffness = 2.0, damping = 0.1 }\n'
    assert call(TWO, "--set", "coupling.scheme=implicit", "--set", "coupling.tolerance=1e-11") == ExitCode.OK
    assert call(TWO) == ExitCode.OK
    assert call(TWO + twin) == ExitCode.OK
    iterated, plain, predicted = (history(tmp_path / name)["a.x"] for name in ("out.001", "out.002", "out"))
    assert "twin" in result(tmp_path / "out")["cost"]["cpu_seconds_by_component"]
    gap, lag = np.max(np.abs(predicted - iterated)), np.max(np.abs(plain - iterated))
    assert gap < 1e-7 and lag > 1e-4


BAD = {
    "empty": ("", ["has no components", "two.toml", "[components.NAME]"]),
    "not TOML": ("[run\nend = 1", ["not valid TOML", "two.toml", "line 1"]),
    "no components": ("components = 3\n", ["components", "two.toml, line 1"]),
    "component is no table": ("[components]\na = 3\n", ["'components.a' is a table", "line 2", "[components.a]"]),
    "no FMU named": ("[components.a]\n", ["[components.a] names no FMU", "line 1", "fmu ="]),
    "unknown table": (TWO + "[rum]\nend = 2\n", ["Unknown table [rum]", "line 23", "did you mean 'run'"]),
    "unknown key": (TWO + "stop = 2\n", ["Unknown key 'stop' in [run]", "line 23", "run.stop", "'step'"]),
    "unknown key of a component": (
        TWO.replace('fmu = "oscillator"', 'fmu = "oscillator"\nfile = "x"'),
        ["Unknown key 'file' in [components.b]", "line 7", "components.b.file"],
    ),
    "name with a dot": ('[components."a.b"]\nfmu = "link.fmu"\n', ["'a.b' is no name", "line 1", "component.variable"]),
    "name with a space": ('[components."a b"]\nfmu = "link.fmu"\n', ["'a b' is no name", "line 1"]),
    "missing FMU": (TWO.replace('"link.fmu"', '"lnik.fmu"'), ["no FMU lnik.fmu", "line 12", "components.link.fmu", "make fmus"]),
    "wrong type": (
        TWO.replace("mass = 1,", 'mass = "1",'),
        ['mass has the wrong type: "1"', "line 4", "a.parameters.mass", "a number"],
    ),
    "truth for a number": (
        TWO.replace("mass = 2.0", "mass = true"),
        ["mass has the wrong type: true", "line 8", "b.parameters.mass"],
    ),
    "unknown parameter": (
        TWO.replace("mass = 2.0", "maas = 2.0"),
        ["no parameter or input 'maas'", "line 8", "components.b.parameters.maas", "did you mean 'mass'"],
    ),
    "an output set": (TWO.replace("mass = 2.0", "x = 2.0"), ["'b' has no parameter or input 'x'", "line 8"]),
    "wrong unit": (TWO.replace("a.v -> link.v_a", "a.x -> link.v_a"), ["Units differ", "a.x is in m", "line 15", "m/s"]),
    "no such variable": (TWO.replace("link.x_a", "link.xa"), ["no variable 'xa'", "line 15", "did you mean 'x_a'", "two.toml"]),
    "no such component": (TWO.replace("link.x_a", "lnk.x_a"), ["no component 'lnk'", "line 15", "a, b, link"]),
    "no wire": (TWO.replace("a.x -> link.x_a", "a.x > link.x_a"), ["is no wire", "line 15", "two.toml"]),
    "wired twice": (TWO.replace("a.v -> link.v_a", "b.x -> link.x_a"), ["link.x_a is wired twice", "line 15"]),
    "end before start": (TWO.replace("end = 1.0", "start = 1.0\nend = 1.0"), ["is not after run.start", "line 21", "run.end"]),
    "no step": (TWO.replace("step = 0.01", "step = 0"), ["run.step", "line 21", "above 0"]),
    "a substep for nobody": (TWO + "[coupling]\nsubsteps = { c = 2 }\n", ["no component 'c'", "line 24", "a, b, link"]),
    "an order of others": (TWO + '[coupling]\norder = ["a", "b"]\n', ["is no order of the components", "line 24"]),
    "predicts nobody": (TWO.replace('fmu = "oscillator"', 'fmu = "oscillator"\npredicts = "c"'), ["'b' predicts 'c'", "line 7"]),
    "a predicting model wired": (
        TWO.replace("a.x -> link.x_a", "a.x -> twin.x_a") + '[components.twin]\nfmu = "link.fmu"\npredicts = "link"\n',
        ["'twin' predicts 'link' and has no wires of its own", "line 15"],
    ),
    "predicts itself": (TWO.replace('fmu = "oscillator"', 'fmu = "oscillator"\npredicts = "b"'), ["'b' predicts 'b'", "line 7"]),
}


@pytest.mark.parametrize("kind", list(BAD))
def test_bad_files_are_refused(call: Callable[..., int], tmp_path: Path, kind: str) -> None:
    """File, line, key and remedy; exit code 2; nothing is left behind."""
    text, says = BAD[kind]
    with pytest.raises(AeroSloshError) as caught:
        call(text)
    assert caught.value.code == ExitCode.INPUT and caught.value.remedy
    for part in says:
        assert part in str(caught.value), str(caught.value)
    assert [p.name for p in tmp_path.iterdir()] == ["two.toml"]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("components.c.parameters.mass=2", ["components.NAME.key=value", "a, b, link"]),
        ("components.a.parameters.mass", ["components.NAME.key=value"]),
        ("components.a.parameters.maas=2", ["no parameter or input 'maas'", "--set components.a.parameters.maas=2"]),
        ("components.a.parameters.mass=heavy", ['mass has the wrong type: "heavy"', "--set components.a.parameters.mass=heavy"]),
        ("components.a.fmuu=x", ["Unknown key 'fmuu'", "did you mean 'fmu'"]),
        ("components.a.fmu=none.fmu", ["no FMU none.fmu", "--set components.a.fmu=none.fmu"]),
        ("run.end=-1", ["is not after run.start", "--set run.end=-1"]),
        ("run.ende=1", ["Unknown key 'ende'"]),
        ("coupling.scheme=strong", ["coupling.scheme", "gauss-seidel, implicit, jacobi"]),
    ],
)
def test_bad_overrides_are_refused(call: Callable[..., int], change: str, says: list[str]) -> None:
    with pytest.raises(AeroSloshError) as caught:
        call(TWO, "--set", change)
    for part in (*says, "remedy"):
        assert part in str(caught.value), str(caught.value)


def test_a_refused_parameter_is_told_of_the_component_that_has_it(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """The tank's loads are no numbers then, which the stand refuses in turn: the tank is to blame."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for name in ("structure", "slosh_ems"):
        (fmus / f"{name}.fmu").symlink_to(fmu(name))
    words = ["run", str(EXAMPLE), "--fmus", str(fmus), "--out", str(tmp_path / "out"), "--no-pictures", "--quiet", "--set"]
    with pytest.raises(AeroSloshError) as caught:
        cli.run([*words, "components.tank.parameters.tank_length=500"])  # no range of the description, the FMU's own check
    assert "Component 'tank' failed" in caught.value.what and "tank_length" in caught.value.what
    with pytest.raises(AeroSloshError) as caught:
        cli.run([*words, "components.tank.parameters.fill_level=2"])
    assert "fill_level = 2 is out of range" in caught.value.what and caught.value.code == ExitCode.INPUT
    assert "--set components.tank.parameters.fill_level=2" in caught.value.where and caught.value.remedy.endswith("to 1")
    with pytest.raises(AeroSloshError) as caught:
        cli.run([*words, "components.tank.parameters.limit=cubic"])
    assert 'limit has the wrong type: "cubic"' in caught.value.what and caught.value.remedy == "give one of high, low"
    assert cli.run([*words, "components.tank.parameters.limit=high", "--set", "run.end=0.02"]) == ExitCode.OK


def test_inputs_are_not_extrapolated_twice(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """By the FMU and by the master; a Jacobi of order 0 leaves it to the FMU."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for name in ("structure", "slosh_ems"):
        (fmus / f"{name}.fmu").symlink_to(fmu(name))
    words = ["run", str(EXAMPLE), "--fmus", str(fmus), "--out", str(tmp_path / "out"), "--no-pictures", "--quiet", "--set"]
    words += ["run.end=0.02", "--set", "components.stand.parameters.load_prediction=1", "--set"]
    with pytest.raises(AeroSloshError, match=r"stand\.load_prediction = 1: the FMU extrapolates"):
        cli.run([*words, "coupling.scheme=gauss-seidel"])
    assert cli.run([*words, "coupling.scheme=jacobi", "--set", "coupling.predictor_order=0"]) == ExitCode.OK


def test_a_history_that_fits_nowhere(call: Callable[..., int]) -> None:
    with pytest.raises(AeroSloshError, match="does not fit into memory"):
        call(TWO, "--set", "run.end=1e14")


def test_two_models_cannot_predict_one(call: Callable[..., int]) -> None:
    twins = "".join(f'\n[components.t{i}]\nfmu = "link.fmu"\npredicts = "link"\n' for i in (1, 2))
    with pytest.raises(AeroSloshError, match="'t1' and 't2' both predict 'link'"):
        call(TWO + twins)


def test_a_file_that_is_no_fmu(call: Callable[..., int], tmp_path: Path) -> None:
    (tmp_path / "noise.fmu").write_bytes(b"not a zip")
    with pytest.raises(AeroSloshError) as caught:
        call('[components.a]\nfmu = "noise.fmu"\n')
    assert caught.value.code == ExitCode.INPUT
    assert "noise.fmu is not a zip archive" in str(caught.value) and "remedy" in str(caught.value)


def test_a_step_that_does_not_converge(call: Callable[..., int], tmp_path: Path) -> None:
    """Two passes at a tolerance they cannot reach: the run goes on, exit code 4, each step on record."""
    change = ("implicit", "max_iterations=2", "tolerance=1e-14", "retries=0")
    words = [f"coupling.{c}" if "=" in c else f"coupling.scheme={c}" for c in change]
    assert call(TWO, *(w for word in words for w in ("--set", word))) == ExitCode.UNDETERMINED
    data = result(tmp_path / "out")
    assert not data["converged"] and data["failure"] is None and data["end_time"] == 1.0
    count = data["scheme"]["steps"] - data["scheme"]["outcomes"].get("converged", 0)
    assert data["outcome"] == f"completed; {count} of 100 steps did not converge" and count > 50
    entry = data["scheme"]["unconverged"][0]
    assert entry["outcome"] == "passes used up" and entry["worst"] in ("link.force_a", "link.force_b")
    assert 0.0 < entry["time"] <= 1.0 and entry["change"] > 1e-14 and entry["passes"] >= 2
    assert history(tmp_path / "out")["time"].size == 101


AERO = """
[components.wing]
fmu = "aero.fmu"
parameters = { airfoil = "AIRFOIL", alpha = 0.01 }
[run]
end = 0.1
step = 0.01
pictures = false
"""


def test_a_failing_component_keeps_the_history(
    call: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call(AERO.replace("AIRFOIL", "FAIL 6")) == ExitCode.COMPONENT
    data = result(tmp_path / "out")
    assert "told to fail" in data["failure"] and data["end_time"] == pytest.approx(0.05) and not data["converged"]
    assert history(tmp_path / "out")["wing.lift"].size == 6
    assert "told to fail" in capsys.readouterr().err


def test_not_a_number_ends_the_run(call: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call(AERO.replace("AIRFOIL", "NAN 4"), "--json") == ExitCode.UNDETERMINED
    data = json.loads(capsys.readouterr().out)
    assert data["outcome"] == "wing.lift is not a finite number at step 4, t = 0.04 s" and not data["converged"]
    assert data["end_time"] == pytest.approx(0.03) and data["last"]["wing.lift"] != 0.0
    assert np.isfinite(history(tmp_path / "out")["wing.lift"]).all()


def test_not_a_number_in_an_implicit_step(call: Callable[..., int], tmp_path: Path) -> None:
    """An infinite gain in the loop: every attempt ends with it, the run stops, the JSON stays JSON."""
    text = TWO.replace("damping = 0.1", "damping = 1e308")
    assert call(text, "--set", "coupling.scheme=implicit") == ExitCode.UNDETERMINED
    data = result(tmp_path / "out")
    assert not data["converged"] and "is not a finite number at step 1" in data["outcome"]
    entry = data["scheme"]["unconverged"][0]
    assert entry["outcome"] == "not a finite number" and entry["change"] is None
    assert data["scheme"]["retried_steps"] == 1


def test_json_is_pure_and_the_command_ends_with_its_code(doubles: Path, tmp_path: Path) -> None:
    """The command in a process of its own, twice: one JSON object on standard output; a bad file says so in one piece."""
    (tmp_path / "two.toml").write_text(TWO, encoding="utf-8")

    def run(*words: object) -> Done:
        return command("run", *words, "--out", tmp_path / "out", AEROSLOSH_FMUS=str(doubles))

    done = run(str(tmp_path / "two.toml"), "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["outcome"] == "completed" and done.stdout.count("\n") == 1 and not done.stderr
    done = run(tmp_path / "none.toml")
    assert done.returncode == 2 and not done.stdout
    assert "cannot be read" in done.stderr and "cases/tank_on_springs.toml" in done.stderr and "Traceback" not in done.stderr


def test_the_step_is_the_one_asked_for_to_the_bit() -> None:
    """A run made longer takes the same steps; a step that does not divide the run is fitted to it."""
    assembly = assemblies.Assembly()
    for end, count in ((0.3, 30), (0.29, 29), (0.58, 58), (1.14, 114)):  # 0.29 / 29 is not 0.01 in floating point
        assembly.run.end, assembly.run.step = end, 0.01
        assert assembly.dt == 0.01 and assembly.steps == count
    assembly.run.end, assembly.run.step = 1.0, 0.3
    assert assembly.steps == 3 and assembly.dt == 1.0 / 3.0


def test_the_example(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """cases/tank_on_springs.toml: the stand gives most of its energy away, a good part of it goes through the waves, and both
    swing about rest, so the trim holds the water's weight and moment (heave: 1e-4 m, a hundredth of what the weight untrimmed
    gives)."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for name in ("structure", "slosh_ems"):
        (fmus / f"{name}.fmu").symlink_to(fmu(name))
    changes = ["--set", "run.end=10", "--no-pictures", "--quiet"]
    assert cli.run(["run", str(EXAMPLE), "--fmus", str(fmus), "--out", str(tmp_path / "out"), *changes]) == ExitCode.OK
    seen = history(tmp_path / "out")
    stand, waves = seen["stand.energy"], seen["tank.wave_energy"]
    assert np.max(waves) > 0.3 * stand[0] and np.min(stand) < 0.2 * stand[0]
    assert np.max(np.abs(seen["tank.force_y"] + 367.875)) < 20.0 and np.mean(seen["stand.h"]) == pytest.approx(0.0, abs=1e-4)
    assert seen["tank.validity"][-1] < 1.0
    assert result(tmp_path / "out")["scheme"]["passes_mean"] < 4.0
