"""Checkpoints: a march that goes on from one is the uninterrupted march, to the bit; what does not fit is refused."""

from __future__ import annotations

import json
import signal
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

from aeroslosh.master import cli
from aeroslosh.master.base import pvd, vtk
from aeroslosh.master.base.errors import AeroSloshError, ComponentError, ExitCode
from aeroslosh.master.cosim import checkpoint
from aeroslosh.master.fmi.component import Component
from support.paths import CASES
from support.processes import COMMAND, started, until

CASE = CASES / "paper_s.toml"
SYSTEM = """
[components.a]
fmu = "spring.fmu"
parameters = { mass = 1, stiffness = 4.0, initial_x = 1.0 }
[components.b]
fmu = "oscillator.fmu"
parameters = { mass = 2.0, stiffness = 3.0, initial_v = -0.5 }
[components.link]
fmu = "link.fmu"
parameters = { stiffness = 2.0, damping = 0.1, mass_a = 0.3 }
[system]
wires = [
  "a.x -> link.x_a", "a.v -> link.v_a", "a.a -> link.a_a", "b.x -> link.x_b", "b.v -> link.v_b",
  "link.force_a -> a.force", "link.force_b -> b.force",
]
[coupling]
waveform = { a = "linear" }
[run]
end = 1.0
step = 0.01
pictures = false
"""
TWIN = '[components.twin]\nfmu = "link.fmu"\npredicts = "link"\nparameters = { stiffness = 1.8, damping = 0.1, mass_a = 0.3 }\n'
Call = Callable[..., int]


@pytest.fixture(scope="module")
def fmus(springs: Path, doubles: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """spring, stubborn, oscillator, link in one folder."""
    folder = tmp_path_factory.mktemp("restart_fmus")
    for path in (*springs.glob("*.fmu"), doubles / "oscillator.fmu", doubles / "link.fmu"):
        (folder / path.name).symlink_to(path)
    return folder


@pytest.fixture
def run(fmus: Path, tmp_path: Path) -> Call:
    """`run(out, *arguments)`: the command `run` on SYSTEM in this process."""

    def call(out: str, *arguments: str, text: str = SYSTEM) -> int:
        file = tmp_path / "system.toml"
        file.write_text(text, encoding="utf-8")
        return cli.run(["run", str(file), "--fmus", str(fmus), "--out", str(tmp_path / out), "--quiet", *arguments])

    return call


def history(folder: Path) -> dict[str, np.ndarray]:
    with netcdf_file(str(folder / "history.nc"), mmap=False) as file:
        return {name: variable[:].copy() for name, variable in file.variables.items()}


def result(folder: Path) -> dict[str, Any]:
    return dict(json.loads((folder / "result.json").read_text(encoding="utf-8")))


def assert_same(first: Path, second: Path) -> None:
    """Every channel of two run folders, to the bit."""
    one, two = history(first), history(second)
    assert set(one) == set(two)
    for name, column in one.items():
        assert column.shape == two[name].shape and (column == two[name]).all(), name


def sets(*changes: str) -> list[str]:
    return [word for change in changes for word in ("--set", change)]


# systems


@pytest.mark.parametrize(
    ("changes", "text"),
    [
        ([], SYSTEM),
        (["coupling.predictor_order=2"], SYSTEM),
        (["coupling.scheme=jacobi"], SYSTEM),
        (["coupling.scheme=implicit", "coupling.acceleration=aitken"], SYSTEM),
        (["coupling.scheme=implicit", "coupling.acceleration=iqn-ils", "coupling.tolerance=1e-10"], SYSTEM),
        (["coupling.scheme=implicit", "coupling.acceleration=constant", "coupling.relaxation=0.7"], SYSTEM),
        (["coupling.substeps={ a = 2, b = 3 }", 'coupling.waveform={ a = "quadratic", b = "quadratic" }'], SYSTEM),
        (["coupling.substeps={ a = 2, b = 3 }", "coupling.scheme=implicit"], SYSTEM),
        (["run.record_every=7"], SYSTEM),
        ([], SYSTEM + TWIN),
        (["coupling.scheme=implicit", 'coupling.waveform={ a = "quadratic" }'], SYSTEM + TWIN),
    ],
    ids=lambda value: " ".join(value) or "plain" if isinstance(value, list) else "twin" if "twin" in value else "",
)
def test_a_system_goes_on_to_the_bit(run: Call, tmp_path: Path, changes: list[str], text: str) -> None:
    """The checkpoint left at step 90 of 100, in which every scheme has its memory filled."""
    file = str(tmp_path / "march.npz")
    assert run("whole", *sets(*changes), text=text) == ExitCode.OK
    assert run("watched", *sets(*changes), "--checkpoint", file, "--every", "45", text=text) == ExitCode.OK
    assert checkpoint.read(Path(file)).about["done"] == 90
    assert run("again", *sets(*changes), "--restart", file, text=text) == ExitCode.OK
    assert_same(tmp_path / "whole", tmp_path / "watched")
    assert_same(tmp_path / "whole", tmp_path / "again")
    assert result(tmp_path / "whole")["scheme"] == result(tmp_path / "again")["scheme"]


def test_a_longer_run_and_checkpoints_of_restarts(run: Call, tmp_path: Path) -> None:
    """0.3 s, then on to 0.58 s, then to 1.14 s, each from the last one's checkpoint, written over itself.

    0.58 / 58 and 1.14 / 114 are not 0.01 in floating point: the step must be."""
    file = str(tmp_path / "march.npz")
    assert run("whole", *sets("run.end=1.14")) == ExitCode.OK
    assert run("part", *sets("run.end=0.3"), "--checkpoint", file, "--every", "29") == ExitCode.OK
    for end in ("0.58", "1.14"):
        assert run("part", *sets(f"run.end={end}"), "--restart", file, "--checkpoint", file, "--every", "29") == ExitCode.OK
    assert_same(tmp_path / "whole", tmp_path / "part")
    # the end moved to where the checkpoint stands: nothing is left to do
    assert run("none", *sets("run.end=0.87"), "--restart", file) == ExitCode.OK
    assert (history(tmp_path / "none")["a.x"] == history(tmp_path / "whole")["a.x"][:88]).all()
    assert run("part", *sets("run.end=1.14"), "--restart", file) == ExitCode.OK
    assert_same(tmp_path / "whole", tmp_path / "part")


def test_killed_in_the_middle(fmus: Path, run: Call, tmp_path: Path) -> None:
    """kill -9 as soon as a checkpoint is there, of a run of a million steps; then 200 steps on from what it left."""
    file, settings = tmp_path / "march.npz", ["run.step=1e-4", "coupling.scheme=implicit"]
    (tmp_path / "system.toml").write_text(SYSTEM, encoding="utf-8")
    words = ["run", str(tmp_path / "system.toml"), "--fmus", str(fmus), "--out", str(tmp_path / "killed"), "--quiet"]
    words += [*sets(*settings, "run.end=100"), "--checkpoint", str(file), "--every", "50"]
    with started([*COMMAND, *words]) as process:
        until(lambda: file.exists() or process.poll() is not None)
        process.kill()
        _, said = process.communicate()
    assert process.returncode == -signal.SIGKILL, said
    assert not (tmp_path / "killed").exists()
    done = checkpoint.read(file).about["done"]
    end = sets(*settings, f"run.end={(done + 200) * 1e-4:.4f}")
    assert run("whole", *end) == ExitCode.OK
    assert run("again", *end, "--restart", str(file)) == ExitCode.OK
    assert history(tmp_path / "again")["time"].size == done + 201
    assert_same(tmp_path / "whole", tmp_path / "again")


@pytest.fixture
def written(run: Call, tmp_path: Path) -> Path:
    """A checkpoint at step 100 of SYSTEM."""
    assert run("first", "--checkpoint", str(tmp_path / "march.npz"), "--every", "50") == ExitCode.OK
    return tmp_path / "march.npz"


@pytest.mark.parametrize(
    ("changes", "says"),
    [
        (["components.a.parameters.mass=3"], ["another case", "components.a.parameters", "'mass': 1,", "'mass': 3,"]),
        (["coupling.scheme=implicit"], ["another case", "coupling.scheme: 'gauss-seidel' then, 'implicit' now"]),
        (["coupling.substeps={ b = 2 }"], ["another case", "coupling.substeps"]),
        (["run.step=0.02"], ["another case", "run.step: 0.01 then, 0.02 now"]),
        (["run.record_every=2"], ["another case", "run.record_every"]),
        (["run.end=0.5"], ["stands at step 100, run.end = 0.5 at step 50", "a later end"]),
        (["run.end=1.004"], ["the step would be 0.01004", "whole number of steps"]),
    ],
)
def test_another_case_is_refused(run: Call, written: Path, tmp_path: Path, changes: list[str], says: list[str]) -> None:
    with pytest.raises(AeroSloshError) as caught:
        run("again", *sets(*changes), "--restart", str(written))
    for part in (*says, "march.npz", "remedy"):
        assert part in str(caught.value), str(caught.value)
    assert caught.value.code == ExitCode.INPUT and not (tmp_path / "again").exists()


def test_another_fmu_is_refused(run: Call, written: Path, fmus: Path, tmp_path: Path) -> None:
    """The same file but for a comment in the archive: another hash."""
    other = tmp_path / "link.fmu"
    other.write_bytes((fmus / "link.fmu").read_bytes())
    with zipfile.ZipFile(other, "a") as archive:
        archive.comment = b"rebuilt"
    with pytest.raises(AeroSloshError, match="FMU of 'link' is not the one of the checkpoint"):
        run("again", "--restart", str(written))


@pytest.mark.parametrize("kind", ["cut", "one bit", "empty", "text", "array", "archive", "folder", "missing", "json"])
def test_files_that_are_no_checkpoint(run: Call, written: Path, fmus: Path, tmp_path: Path, kind: str) -> None:
    data, file = written.read_bytes(), tmp_path / "other.npz"
    if kind == "cut":
        file.write_bytes(data[: 2 * len(data) // 3])
    elif kind == "one bit":  # in the middle of a state: the archive's checksum tells
        at = data.index(b"component.a/state") + 200
        file.write_bytes(data[:at] + bytes([data[at] ^ 1]) + data[at + 1 :])
    elif kind == "empty":
        file.write_bytes(b"")
    elif kind == "text":
        file.write_text("march = 3\n", encoding="utf-8")
    elif kind == "array":
        with file.open("wb") as stream:
            np.save(stream, np.zeros(3))
    elif kind == "archive":
        file = fmus / "link.fmu"
    elif kind == "folder":
        file.mkdir()
    elif kind == "json":
        np.savez(file, about=np.frombuffer(b"[1, 2]", dtype=np.uint8))
    with pytest.raises(AeroSloshError) as caught:
        run("again", "--restart", str(file))
    assert file.name in caught.value.where and caught.value.remedy and caught.value.code == ExitCode.INPUT
    assert "no checkpoint" in caught.value.what or "cannot be read" in caught.value.what


def test_another_format_is_refused(run: Call, written: Path) -> None:
    with np.load(written) as file:
        arrays = dict(file)
    about = json.loads(arrays.pop("about").tobytes()) | {"format": 99}
    np.savez(written, about=np.frombuffer(json.dumps(about).encode(), dtype=np.uint8), **arrays)
    with pytest.raises(AeroSloshError, match="has format 99, this version reads"):
        run("again", "--restart", str(written))


def test_what_cannot_be_written_is_said_before_anything_runs(run: Call, tmp_path: Path) -> None:
    for words, says in (
        (["--checkpoint", str(tmp_path / "march.npz"), "--every", "0"], "--every 0"),
        (["--checkpoint", str(tmp_path / "none" / "march.npz")], "no folder for the checkpoint"),
        (["--checkpoint", str(tmp_path)], "is a folder"),
        (["--every", "5"], "--every without --checkpoint"),
    ):
        with pytest.raises(AeroSloshError, match=says):
            run("out", *words)
    stubborn = (
        SYSTEM.replace("spring.fmu", "stubborn.fmu")
        .replace("initial_x = 1.0", "initial_x = 1.0, mass = -1.0")
        .replace("mass = 1, ", "")
    )
    with pytest.raises(AeroSloshError, match="a cannot write its state to a file"):  # its bad mass would end the initialisation
        run("out", "--checkpoint", str(tmp_path / "march.npz"), text=stubborn)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["system.toml"]


def test_a_state_that_is_not_taken_back(fmu: Callable[[str], Path]) -> None:
    """Our FMUs return OK from fmi2SetFMUstate and say `failed`: the master asks, and does not wait for the next step."""
    component = Component(fmu("slosh_ems"), "slosh")
    component.initialize()
    data = bytearray(component.serialized())
    component.restore(bytes(data), 0.0, 0)
    data[len(data) // 2] ^= 1
    with pytest.raises(ComponentError, match="damaged"):
        component.restore(bytes(data), 0.0, 0)
    component.close()


# flutter marches


@pytest.fixture
def point(flutter_fmus: Path, tmp_path: Path) -> Call:
    """`point(out, *arguments)`: the command `point` with the thin airfoil double in this process."""

    def call(out: str, *arguments: str, fmus: Path = flutter_fmus) -> int:
        words = ["point", str(CASE), "--fmus", str(fmus), "--out", str(tmp_path / out), "--quiet", "--mach", "0.3", "--vf", "1.5"]
        return cli.run([*words, *arguments])

    return call


EMS = ["--slosh", "ems"]
BARE = [*EMS, "--no-pictures"]


@pytest.mark.parametrize(
    "changes",
    [
        ["coupling.scheme=gauss-seidel"],
        ["coupling.scheme=implicit", "coupling.acceleration=aitken"],
        ["coupling.scheme=implicit", "coupling.acceleration=iqn-ils", "slosh.split=none"],
        ["coupling.substeps={ slosh = 3, structure = 2 }"],
        ['coupling.order=["slosh", "structure", "aero"]'],
        ["coupling.scheme=implicit", "coupling.substeps={ slosh = 2 }", 'coupling.waveform={ slosh = "quadratic" }'],
        ["coupling.scheme=jacobi", "coupling.predictor_order=2", "slosh.parametric=true"],
    ],
    ids=" ".join,
)
def test_a_flutter_march_goes_on_to_the_bit(point: Call, tmp_path: Path, changes: list[str]) -> None:
    file, words = str(tmp_path / "march.npz"), [*BARE, *sets("flutter.free_cycles=2", *changes)]
    code = point("whole", *words)
    assert point("watched", *words, "--checkpoint", file, "--every", "150") == code
    done = checkpoint.read(Path(file)).about["done"]
    assert point("again", *words, "--restart", file) == code
    assert_same(tmp_path / "whole", tmp_path / "watched")
    assert_same(tmp_path / "whole", tmp_path / "again")
    assert 0 < done < history(tmp_path / "whole")["tau"].size - 1
    first, again = result(tmp_path / "whole"), result(tmp_path / "again")
    for key in ("growth_rate", "frequency", "verdict", "scheme", "unconverged_steps"):
        assert first.get(key) == again.get(key), key


def test_a_longer_march(point: Call, tmp_path: Path) -> None:
    """More free cycles from the checkpoint of a march that ended: the long march, to the bit."""
    file, words = str(tmp_path / "march.npz"), [*BARE, *sets("flutter.max_free_cycles=1.5")]  # as long as asked for
    assert (
        point("whole", *words, *sets("flutter.free_cycles=4")) == ExitCode.UNDETERMINED
    )  # linear slosh does not hold at 1 degree
    point("short", *words, *sets("flutter.free_cycles=2"), "--checkpoint", file, "--every", "72")
    assert point("again", *words, *sets("flutter.free_cycles=4"), "--restart", file) == ExitCode.UNDETERMINED
    assert_same(tmp_path / "whole", tmp_path / "again")
    with pytest.raises(AeroSloshError, match="checkpoint stands at step"):
        point("shorter", *words, *sets("flutter.free_cycles=1.5", "flutter.forced_cycles=2"), "--restart", file)


def instants(run: Path, steps: int) -> list[int]:
    """The steps at which a march of so many wrote its fields, the last one at its end."""
    times = [time for time, path in pvd.read(run / "fields.pvd") if path.suffix == ".vts"]
    return [round(steps * time / max(times)) for time in sorted(times)]


def test_fields_and_pictures_after_a_restart(point: Call, tmp_path: Path) -> None:
    """The interrupted run's folder is gone: the fields end up in the new one, at their times; earlier ones are not made up."""
    file, words = tmp_path / "march.npz", [*EMS, *sets("flutter.free_cycles=2", "flutter.steps_per_cycle=100")]
    assert point("whole", *words, "--checkpoint", str(file), "--every", "130") in (ExitCode.OK, ExitCode.UNDETERMINED)
    # 400 steps, fields over the last period of the flutter mode; the checkpoint between the last two
    steps = instants(tmp_path / "whole", 400)
    assert checkpoint.read(file).about["done"] == 390 and steps[2] < 390 < steps[3]
    point("again", *words, "--restart", str(file))
    assert {p.name for p in (tmp_path / "again").iterdir()} == {p.name for p in (tmp_path / "whole").iterdir()}
    whole, again = (sorted((tmp_path / name / "fields").iterdir()) for name in ("whole", "again"))
    assert len(whole) == 4 and [p.name for p in again] == [whole[-1].name]
    assert again[0].read_bytes() == whole[-1].read_bytes()
    assert vtk.read(again[0]).cells["mach"].size
    lines = [(tmp_path / name / "fields.pvd").read_text(encoding="utf-8").splitlines() for name in ("whole", "again")]
    assert [line for line in lines[1] if "DataSet" in line] == [line for line in lines[0] if "DataSet" in line][-1:]
    assert not [p for p in tmp_path.iterdir() if p.name.startswith(".")], "a hidden folder was left"


def test_a_checkpoint_while_fields_are_written(point: Call, tmp_path: Path) -> None:
    """At the last instant but one the FMU has `write_fields` true in its state: the restart writes the fields asked for and no
    others."""
    settings = sets("flutter.free_cycles=2", "flutter.steps_per_cycle=100", "output.pictures=false")
    file, words = tmp_path / "march.npz", [*EMS, *settings]
    point("first", *words)
    instant = str(instants(tmp_path / "first", 400)[2])
    point("whole", *words, "--checkpoint", str(file), "--every", instant)
    point("again", *words, "--restart", str(file))
    assert len(list((tmp_path / "again" / "fields").glob("*.vts"))) == 1
    point("bare", *words, "--restart", str(file), "--no-pictures")
    assert not (tmp_path / "bare" / "fields").exists() and not [p for p in tmp_path.iterdir() if p.name.startswith(".")]
    # a march that began without a folder for fields cannot get one: it says so, and goes on
    point("plain", *words, "--no-pictures", "--checkpoint", str(file), "--every", instant)
    point("wish", *words, "--restart", str(file), "--set", "output.pictures=true")
    assert "no flow fields" in (tmp_path / "wish" / "run.log").read_text(encoding="utf-8")
    assert (tmp_path / "wish" / "histories.png").is_file() and not (tmp_path / "wish" / "fields").exists()


def test_a_flutter_checkpoint_is_checked_before_the_steady_flow(
    point: Call, flutter_fmus: Path, doubles: Path, springs: Path, tmp_path: Path
) -> None:
    """UNSTEADY ends the setup in its steady solution: an error that comes before it names the checkpoint instead."""
    file = str(tmp_path / "march.npz")
    point("first", *BARE, *sets("flutter.free_cycles=1.5"), "--checkpoint", file, "--every", "100")
    late = sets("flow.airfoil=UNSTEADY", "flutter.free_cycles=1.5")
    other = tmp_path / "fmus"
    other.mkdir()
    for name in ("structure", "slosh_ems", "aero"):
        (other / f"{name}.fmu").write_bytes((flutter_fmus / f"{name}.fmu").read_bytes())
    with zipfile.ZipFile(other / "slosh_ems.fmu", "a") as archive:
        archive.comment = b"rebuilt"
    for words, fmus, says in (
        ([*BARE, *late, "--restart", file], flutter_fmus, r"another case \(flow.airfoil"),
        ([*BARE, *sets("flutter.free_cycles=1.5"), "--restart", file], other, "FMU of 'slosh' is not the one"),
        ([*BARE, *late, "--checkpoint", file, "--every", "0"], flutter_fmus, "--every 0"),
        ([*BARE, *late, "--checkpoint", str(tmp_path / "none" / "x.npz")], flutter_fmus, "no folder for the checkpoint"),
    ):
        with pytest.raises(AeroSloshError, match=says):
            point("again", *words, fmus=fmus)
    (other / "aero.fmu").unlink()
    (other / "aero.fmu").symlink_to(springs / "stubborn.fmu")
    with pytest.raises(AeroSloshError, match="aero cannot write its state to a file"):
        point("again", *BARE, *late, "--checkpoint", file, fmus=other)
    assert not (tmp_path / "again").exists()


def test_the_predicted_vof_march_goes_on_to_the_bit(
    fmu: Callable[[str], Path], flutter_fmus: Path, point: Call, tmp_path: Path
) -> None:
    """slosh_vof predicted by slosh_ems: five FMUs, the prediction's own memory among what is restored."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    for path in (*flutter_fmus.glob("*.fmu"), fmu("slosh_vof")):
        (fmus / path.name).symlink_to(path)
    changes = sets(
        "slosh.predictor=ems", "slosh.cells_x=32", "slosh.cells_y=16", "flutter.steps_per_cycle=24", "flutter.free_cycles=1.5",
        "flutter.forced_cycles=0.5", "flutter.forced_ramp_cycles=0.5", "slosh.modes=5", "flutter.max_free_cycles=1.5",
    )  # fmt: skip
    file, words = str(tmp_path / "march.npz"), ["--slosh", "vof", "--no-pictures", *changes]
    for scheme in ("gauss-seidel", "implicit"):
        more = sets(f"coupling.scheme={scheme}")
        code = point("whole", *words, *more, "--checkpoint", file, "--every", "29", fmus=fmus)
        assert point("again", *words, *more, "--restart", file, fmus=fmus) == code
        assert checkpoint.read(Path(file)).about["done"] == 29
        assert_same(tmp_path / "whole", tmp_path / "again")


# substeps in the flutter setup, and messages


def test_substeps_of_the_slosh_fmu(point: Call, tmp_path: Path) -> None:
    """slosh_ems follows the motion by its positions, rates and accelerations at both ends of its step. Between substeps these run
    linearly or along a parabola instead (which errs most where the forced phase ends: its memory is of before): errors of second
    order, which go down by 4 when the step is halved (0.5: the next order). They are far below the step's own error: a
    hundredth of what half the step does to the growth rate."""
    course = {"linear": [], "quadratic": []}  # type: ignore[var-annotated]
    rates = []
    for steps in (72, 144):
        ends = {}
        for waveform in ("", *course):
            changes = [f"flutter.steps_per_cycle={steps}", "flutter.free_cycles=2"]
            if waveform:
                changes += ["coupling.substeps={ slosh = 4 }", f'coupling.waveform={{ slosh = "{waveform}" }}']
            point("out", *BARE, *sets(*changes))
            ends[waveform] = history(tmp_path / "out")["alpha"]
            if not waveform:
                rates.append(result(tmp_path / "out")["growth_rate"])
        for waveform in course:
            course[waveform].append(float(np.max(np.abs(ends[waveform] - ends[""])) / np.max(np.abs(ends[""]))))
    for errors in course.values():
        assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.5), course
        assert 0.0 < errors[0] < 1e-2 * abs(rates[1] - rates[0]), (course, rates)
    assert course["quadratic"][1] < course["linear"][1]


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("coupling.substeps={ tank = 2 }", ["coupling.substeps", "no component 'tank'", "structure, aero, slosh"]),
        ("coupling.substeps={ slosh = 0 }", ["coupling.substeps.slosh = 0", "from 1"]),
        ("coupling.substeps={ slosh = 2.5 }", ["coupling.substeps.slosh", "a whole number"]),
        ("coupling.substeps=4", ["coupling.substeps is a table", "write substeps"]),
        ('coupling.waveform={ slosh = "cubic" }', ["coupling.waveform.slosh", "hold, linear, quadratic"]),
        ('coupling.waveform={ slosh = "linear" }', ["takes its inputs once a step", "substeps above 1"]),
        ('coupling.order=["aero", "structure"]', ["is no order of the components", "structure, aero, slosh"]),
        ('coupling.order=["aero", "structure", "tank"]', ["is no order of the components", "name each once"]),
        ("coupling.acceleration=newton", ["coupling.acceleration", "constant, aitken, iqn-ils"]),
        ("coupling.relaxation=0", ["coupling.relaxation", "above 0"]),
        ("coupling.reuse_steps=-1", ["coupling.reuse_steps", "from 0"]),
        ("coupling.retries=1.0", ["coupling.retries", "a whole number"]),
        ('coupling.tolerance_of={ "aero.lift" = 0 }', ["coupling.tolerance_of.aero.lift", "above 0"]),
        ("coupling.predictor_order=3", ["coupling.predictor_order = 3", "0 to 2"]),
        ("coupling.substep={ slosh = 2 }", ["Unknown key 'substep'", "did you mean 'substeps'"]),
    ],
)
def test_coupling_settings_of_a_case(point: Call, tmp_path: Path, change: str, says: list[str]) -> None:
    with pytest.raises(AeroSloshError) as caught:
        point("out", *BARE, "--set", change)
    for part in (*says, "remedy"):
        assert part in str(caught.value), str(caught.value)
    assert caught.value.code == ExitCode.INPUT and not list(tmp_path.iterdir())


def test_a_tolerance_of_what_does_not_lag(point: Call) -> None:
    with pytest.raises(AeroSloshError) as caught:
        point("out", *BARE, *sets("coupling.scheme=implicit", 'coupling.tolerance_of={ "aero.drag" = 1e-3 }'))
    assert "'aero.drag' is not iterated" in caught.value.what and "aero.lift" in caught.value.remedy
