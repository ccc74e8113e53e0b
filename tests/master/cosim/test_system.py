"""Wiring mistakes are named before anything runs; FMU files that are none are refused."""

from __future__ import annotations

import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ComponentError
from aeroslosh.master.case.case import Case
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.flutter import setup
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.fmi import unpack
from aeroslosh.master.fmi.component import Component
from support.processes import supported


@pytest.fixture
def pair(doubles: Path) -> Iterator[list[Component]]:
    made = [Component(doubles / "oscillator.fmu", "a"), Component(doubles / "link.fmu", "link")]
    yield made
    for component in made:
        component.close()


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("a.x -> link.x_q", ["no variable 'x_q'", "did you mean 'x_"]),
        ("b.x -> link.x_a", ["no component 'b'", "a, link"]),
        ("link.x_a -> a.force", ["link.x_a is an input, not an output", "from an output to an input"]),
        ("a.x -> a.mass", ["parameter, not an input"]),
        ("a.x -> link.v_a", ["Units differ", "a.x is in m", "link.v_a in m/s"]),
        ("a.failed -> link.x_a", ["of type Boolean"]),
        ("a.x - link.x_a", ["is no wire"]),
    ],
)
def test_wiring_mistakes(pair: list[Component], line: str, says: list[str]) -> None:
    with pytest.raises(AeroSloshError) as caught:
        System(pair, wires([line]))
    assert caught.value.remedy
    for part in says:
        assert part in str(caught.value), str(caught.value)


def test_an_input_is_wired_once(pair: list[Component]) -> None:
    with pytest.raises(AeroSloshError, match=r"link\.x_a is wired twice"):
        System(pair, wires(["a.x -> link.x_a", "a.x -> link.x_a"]))


def test_names_are_unique(doubles: Path) -> None:
    twins = [Component(doubles / "oscillator.fmu", "a") for _ in range(2)]
    with pytest.raises(AeroSloshError, match="same name"):
        System(twins, [])
    for component in twins:
        component.close()


def test_lagged_wires_follow_the_order(pair: list[Component]) -> None:
    system = System(pair, wires(["a.x -> link.x_a", "link.force_a -> a.force"]))
    assert [str(system.wires[k]) for k in system.lagged] == ["link.force_a -> a.force"]


def test_unwired_inputs_keep_their_start_values(doubles: Path) -> None:
    a = Component(doubles / "oscillator.fmu", "a")
    a.set("force", 2.0)
    system = System([a], [])
    system.initialize()
    a.step(0.1)
    assert a.inputs.values[a.input_index["force"]] == 2.0
    assert a.get("x") > 0.0
    system.close()


def test_unknown_variable_of_a_component(doubles: Path) -> None:
    a = Component(doubles / "oscillator.fmu", "a")
    with pytest.raises(AeroSloshError, match="no variable 'masss'"):
        a.set("masss", 1.0)
    a.close()


def test_files_that_are_no_fmu(tmp_path: Path) -> None:
    with pytest.raises(AeroSloshError, match="missing"):
        Component(tmp_path / "aero.fmu", "aero")
    (tmp_path / "aero.fmu").write_text("not a zip")
    with pytest.raises(AeroSloshError, match="not a zip archive"):
        Component(tmp_path / "aero.fmu", "aero")


def test_unzipped_once_to_a_plain_folder(doubles: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A cache path with a space or é would end the process inside pythonfmu: another place is taken."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "plain"))
    first, digest = unpack.unzip(doubles / "link.fmu")
    stamp = (first / "modelDescription.xml").stat().st_mtime_ns
    again, same = unpack.unzip(doubles / "link.fmu")
    assert first == again and digest == same and str(first).startswith(str(tmp_path / "plain"))
    assert (first / "modelDescription.xml").stat().st_mtime_ns == stamp
    assert not [p for p in first.parent.iterdir() if p.name.startswith(".")]
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "é #%20"))
    elsewhere, _ = unpack.unzip(doubles / "link.fmu")
    assert str(elsewhere).isascii() and "#" not in str(elsewhere)


def test_a_damaged_copy_heals(doubles: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever of an unzipped FMU is changed, cut short or gone; Python's compiled files too, which no archive holds."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    folder, _ = unpack.unzip(doubles / "link.fmu")
    whole = {path.relative_to(folder): path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    script = next(path for path in whole if path.suffix == ".py")
    binary = next(path for path in whole if path.suffix == ".so")
    compiled = folder / script.parent / "__pycache__" / "half.cpython-311.pyc"
    for name in (script, binary, Path("modelDescription.xml")):
        content = bytearray(whole[name])
        content[len(content) // 2] ^= 1
        for damage in (bytes(content), whole[name][:-1], None):
            compiled.parent.mkdir(exist_ok=True)
            compiled.write_bytes(b"0" * 20)
            (folder / name).unlink()
            if damage is not None:
                (folder / name).write_bytes(damage)
            assert unpack.unzip(doubles / "link.fmu")[0] == folder
            assert {path: (folder / path).read_bytes() for path in whole} == whole
            assert not compiled.exists() and not list(folder.parent.glob(".*"))
    compiled.parent.mkdir(exist_ok=True)
    compiled.write_bytes(b"0" * 20)
    unpack.unzip(doubles / "link.fmu")
    assert not compiled.exists()
    broken = tmp_path / "broken.fmu"
    content = bytearray((doubles / "link.fmu").read_bytes())
    content[len(content) // 3] ^= 0xFF
    broken.write_bytes(content)
    with pytest.raises(AeroSloshError, match="damaged"):
        unpack.unzip(broken)


@pytest.mark.parametrize("cause", ["wires", "coupling", "surrogate", "steady"])
def test_a_rig_that_cannot_be_assembled_leaves_no_instance(
    flutter_fmus: Path, monkeypatch: pytest.MonkeyPatch, cause: str
) -> None:
    case, fmus = Case(), find_fmus(flutter_fmus, "ems")
    case.slosh.model, case.slosh.predictor = "ems", "none"
    if cause == "wires":
        monkeypatch.setattr(setup, "WIRES", setup.WIRES + "structure.h -> aero.nothing\n")
    elif cause == "coupling":
        case.coupling.substeps = {"nobody": 2}
    elif cause == "surrogate":
        case.slosh.predictor, fmus["slosh_ems"] = "rbf", fmus["slosh_ems"]
        fmus["slosh_rbf"] = flutter_fmus / "no.fmu"
    else:
        case.flow.airfoil = "UNSTEADY 1"
    made: list[Component] = []
    instantiate = Component._instantiate

    def counted(self: Component) -> None:
        made.append(self)
        instantiate(self)

    monkeypatch.setattr(Component, "_instantiate", counted)
    with pytest.raises(AeroSloshError):
        FlutterSetup(case, fmus, 0.3)
    assert len(made) == (0 if cause == "surrogate" else 3)  # a file that is missing is seen before any starts
    assert {component.state for component in made} <= {"freed"}


def test_a_failing_step_tells_the_fmu_s_own_words(doubles: Path) -> None:
    aero = Component(doubles / "aero.fmu", "aero")
    aero.set("airfoil", "FAIL 3")
    aero.initialize()
    aero.step(1e-3)
    aero.step(1e-3)
    with pytest.raises(ComponentError) as caught:
        aero.step(1e-3)
    error = caught.value
    assert "told to fail (100 % on purpose)" in error.what and "ValueError" in error.what
    assert "step 3" in error.where and "t = 0.002 s" in error.where
    assert "Traceback" in error.traceback and "in advance" in error.traceback
    aero.close()


def test_many_lives_of_one_component(doubles: Path) -> None:
    aero = Component(doubles / "aero.fmu", "aero")
    for _ in range(50):
        aero.initialize()
        aero.step(1e-3)
        aero.restart()
    aero.close()


RACER = """
import sys, time
from pathlib import Path
from aeroslosh.master.fmi import unpack
path, go = Path(sys.argv[1]), float(sys.argv[2])
while time.time() < go:
    pass
folder, _ = unpack.unzip(path)
# what a process was given stays whole, whoever comes later
for _ in range(200):
    assert any(folder.glob("binaries/*/*")), "the binary is gone"
    time.sleep(0.001)
"""


def test_processes_that_unzip_at_once_leave_each_other_s_copy_alone(doubles: Path, tmp_path: Path) -> None:
    for _ in range(3):
        cache = tmp_path / f"cache{time.time_ns()}"
        go = str(time.time() + 1.0)
        racers = [
            subprocess.Popen(
                [sys.executable, "-c", RACER, str(doubles / "oscillator.fmu"), go],
                env=supported(XDG_CACHE_HOME=str(cache)),
                stderr=subprocess.PIPE,
                text=True,
            )
            for _ in range(6)
        ]
        for racer in racers:
            assert racer.wait(60) == 0, racer.stderr.read() if racer.stderr else ""
