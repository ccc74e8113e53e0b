"""What stands in an archive, what is refused, and the command."""

from __future__ import annotations

import hashlib
import io
import json
import math
import os
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree as ET

import pytest
from fmpy.ssp.ssd import read_ssd, read_ssv

from aeroslosh.master import cli
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case.scales import scales
from aeroslosh.master.cosim.assemble import PREDICTIONS
from aeroslosh.master.cosim.coupling_settings import Coupling
from aeroslosh.master.flutter.setup import FlutterSetup
from aeroslosh.master.fmi.component import Component
from aeroslosh.master.ssp import archive as ssp_archive
from aeroslosh.master.ssp import system as ssp_system
from aeroslosh.master.ssp import units as ssp_units
from aeroslosh.master.ssp.system import Coupled, Part

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import ROOT, SMALL, Fmu, files, small

NS = {prefix: f"{{{uri}}}" for prefix, uri in ssp_archive.SPACES.items()}


@pytest.fixture(scope="module")
def coupled(fmu: Fmu) -> Coupled:
    case = small("ems")
    return ssp_system.from_case(case, files(fmu, case))


@pytest.fixture(scope="module")
def folder(fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The product's FMUs, up to date, in one folder."""
    place = tmp_path_factory.mktemp("fmus")
    for name in ("structure", "aero", "slosh_ems", "slosh_rbf"):
        os.symlink(fmu(name), place / f"{name}.fmu")
    return place


def unpacked(data: bytes) -> dict[str, bytes]:
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def values(content: dict[str, bytes], component: str) -> dict[str, tuple[str, str, str | None]]:
    """Name → type, text and unit of a component's parameters."""
    found = {}
    for parameter in ET.fromstring(content[f"resources/{component}.ssv"]).iter(f"{NS['ssv']}Parameter"):
        kind = parameter[0]
        found[parameter.get("name", "")] = (kind.tag.removeprefix(NS["ssv"]), kind.get("value", ""), kind.get("unit"))
    return found


def test_content(coupled: Coupled, tmp_path: Path) -> None:
    """The files, FMUs byte for byte, and both kinds of description valid by the schemas of SSP 1.0."""
    path = tmp_path / "a.ssp"
    ssp_archive.write(coupled, path)
    content = unpacked(path.read_bytes())
    names = ["aero.fmu", "aero.ssv", "slosh.ssv", "slosh_ems.fmu", "structure.fmu", "structure.ssv"]
    wanted = ["SystemStructure.ssd", "extra/aeroslosh/settings.toml", *(f"resources/{name}" for name in names)]
    assert list(content) == wanted
    with zipfile.ZipFile(path) as archive:
        assert {entry.date_time for entry in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
    for part in coupled.parts:
        assert content[f"resources/{part.path.name}"] == part.path.read_bytes()
        assert read_ssv(str(path), f"resources/{part.name}.ssv", validate=True).name == "initialValues"
    description = read_ssd(str(path), validate=True)
    assert [element.name for element in description.system.elements] == ["aero", "slosh", "structure"]
    assert [p.name for p in tmp_path.iterdir()] == ["a.ssp"]  # no temporary file stays


def test_values(coupled: Coupled) -> None:
    """Numbers that a person can check: Isogai's ratios, the frozen liquid (800 kg/m3 in half of 0.5 m x 0.15 m), the trim."""
    case = small("ems")
    s = scales(case, 0.8, 0.7)
    content = unpacked(ssp_archive.archive(coupled))
    structure, aero, tank = (values(content, name) for name in ("structure", "aero", "slosh"))
    mass = 60.0 * math.pi * 101325.0 / (287.05 * 288.15)
    assert float(structure["mass"][1]) == pytest.approx(mass, rel=1e-12) and structure["mass"][2] == "kg/m"
    assert float(structure["omega_alpha"][1]) == s.omega_alpha and structure["omega_alpha"][2] == "rad/s"
    assert float(structure["liquid_mass"][1]) == pytest.approx(30.0, rel=1e-12)
    assert float(structure["liquid_static_moment"][1]) == pytest.approx(54.0, rel=1e-12)
    assert structure["trim_lift"] == structure["lift"] and structure["trim_lift"][2] == "N/m"  # residual loads rest at 0
    assert aero["mach"] == ("Real", "0.8", "1") and aero["cells_around"] == ("Integer", "64", None)
    assert tank["liquid_density"] == ("Real", "800.0", "kg/m3") and tank["tank_x"][1] == "1.8"
    assert "airfoil" not in aero  # the FMU's own: FMPy sets no texts


def test_values_are_all_that_the_master_sets(coupled: Coupled, fmu: Fmu) -> None:
    """A fresh FMU with the archive's values has every parameter that the master's own has, but for the prediction of inputs."""
    case = small("ems")
    content = unpacked(ssp_archive.archive(coupled))
    with FlutterSetup(case, files(fmu, case), 0.8) as setup:
        setup.start(0.7)
        for part in coupled.parts:
            fresh = Component(part.path, part.name)
            for name, (kind, text, _) in values(content, part.name).items():
                fresh.set(name, {"Real": float, "Integer": int, "Boolean": "true".__eq__, "String": str}[kind](text))
            for variable in part.variables.values():
                if variable.causality == "parameter" and variable.name not in PREDICTIONS:
                    assert fresh.get(variable.name) == setup.system[part.name].get(variable.name), variable.name
            fresh.close()


def test_units(coupled: Coupled) -> None:
    """Every Real has a unit that is defined in its own file, by base units; both ends of a connection have the same."""
    content = unpacked(ssp_archive.archive(coupled))
    root = ET.fromstring(content["SystemStructure.ssd"])
    for tree in (root, *(ET.fromstring(content[f"resources/{part.name}.ssv"]) for part in coupled.parts)):
        defined = {unit.get("name") for unit in tree.iter(f"{NS['ssc']}Unit")}
        used = [e.get("unit") for space in ("ssc", "ssv") for e in tree.iter(f"{NS[space]}Real")]
        assert used and set(used) <= defined
    base = {unit.get("name"): unit[0].attrib for unit in root.iter(f"{NS['ssc']}Unit")}
    assert base["N/m"] == {"kg": "1", "s": "-2"} and base["kg.m"] == {"kg": "1", "m": "1"} and base["1"] == {}
    ends = {
        f"{component.get('name')}.{connector.get('name')}": (connector.get("kind"), connector[0].get("unit"))
        for component in root.iter(f"{NS['ssd']}Component")
        for connector in component.iter(f"{NS['ssd']}Connector")
    }
    connections = list(root.iter(f"{NS['ssd']}Connection"))
    assert len(connections) == len(coupled.wires) == 16
    for c in connections:
        a, b = (ends[f"{c.get(f'{end}Element')}.{c.get(f'{end}Connector')}"] for end in ("start", "end"))
        assert (a[0], b[0]) == ("output", "input") and a[1] == b[1]
    wired = {wire.target for wire in coupled.wires}
    assert {name for name, (kind, _) in ends.items() if kind == "input"} == wired  # FMPy mistakes any other


def test_step_and_origin(coupled: Coupled) -> None:
    """Where the step stands, and what the archive says of where it comes from."""
    content = unpacked(ssp_archive.archive(coupled))
    root = ET.fromstring(content["SystemStructure.ssd"])
    s = scales(small("ems"), 0.8, 0.7)
    assert coupled.dt == pytest.approx(s.dt, abs=0.5e-9) and coupled.dt * 1e9 == pytest.approx(round(coupled.dt * 1e9), abs=1e-6)
    experiment = root.find(f"{NS['ssd']}DefaultExperiment")
    assert experiment is not None and experiment.get("startTime") == "0.0"
    assert float(experiment.get("stopTime", "")) == pytest.approx(2.25 * s.period, rel=0.01)
    algorithm = next(root.iter(f"{NS['osp']}FixedStepAlgorithm"))
    assert float(algorithm.get("baseStepSize", "")) == pytest.approx(coupled.dt, rel=1e-14)
    assert root.find(f"{NS['ssd']}Annotations") is None  # OMSimulator refuses it there
    first, second = root.findall(f"{NS['ssd']}System/{NS['ssd']}Annotations/{NS['ssc']}Annotation")
    assert (first.get("type"), second.get("type")) == ("org.openmodelica", "aeroslosh")
    master = first.find(f"{NS['oms']}SimulationInformation/{NS['oms']}FixedStepMaster")
    assert master is not None and (master.get("description"), float(master.get("stepSize", ""))) == ("oms-ma", coupled.dt)
    assert b"<oms:FixedStepMaster " in content["SystemStructure.ssd"]  # it looks for the prefix
    export = next(second.iter(f"{NS['aeroslosh']}Export"))
    assert float(export.get("step", "")) == coupled.dt and int(export.get("steps", "")) == coupled.steps
    assert export.get("settings_sha256") == hashlib.sha256(content["extra/aeroslosh/settings.toml"]).hexdigest()
    hashes = {fmu.get("component"): fmu.get("sha256") for fmu in export}
    assert hashes["aero"] == hashlib.sha256(content["resources/aero.fmu"]).hexdigest()
    assert root.get("generationTool", "").startswith("aeroslosh ") and repr(coupled.dt) in root.get("description", "")
    assert "no part of SSP" in root.get("description", "")


def test_step_is_not_cut_short() -> None:
    """libcosim cuts off what is below a nanosecond of the number it reads."""
    for count in [*range(1000000, 1000200), 872665, 1455168, 10_000_000, 333_333_333]:
        assert int(ssp_archive._not_cut_short(count / 1e9) * 1e9) == count


def test_same_system_same_bytes(coupled: Coupled, fmu: Fmu) -> None:
    """Two exports are one file; another V_f is another."""
    case = small("ems")
    assert ssp_archive.archive(coupled) == ssp_archive.archive(ssp_system.from_case(case, files(fmu, case)))
    other = small("ems", "flutter.V_f=0.71")
    assert ssp_archive.archive(coupled) != ssp_archive.archive(ssp_system.from_case(other, files(fmu, other)))


def test_command(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A case with Mach number, V_f and load prediction of the command line."""
    changes = [word for key in SMALL for word in ("--set", key)]
    target = tmp_path / "new" / "a.ssp"
    words = ["export", "ssp", str(ROOT / "cases" / "paper_s.toml"), *changes, "--fmus", str(folder), "--out", str(target)]
    assert cli.run([*words, "--slosh", "frozen", "--mach", "0.75", "--vf", "0.65", "--prediction", "linear", "--json"]) == 0
    data = json.loads(capsys.readouterr().out)
    content = unpacked(target.read_bytes())
    assert values(content, "aero")["mach"][1] == "0.75" and values(content, "structure")["load_prediction"][:2] == (
        "Integer",
        "1",
    )
    assert set(data["components"]) == {"aero", "structure"} and len(data["connections"]) == 8
    assert "liquid_mass" in values(content, "structure")
    assert data["step"] == pytest.approx(scales(small("none"), 0.75, 0.65).dt, abs=1e-9) and data["stop"] > 0
    assert data["settings_sha256"] == hashlib.sha256(content["extra/aeroslosh/settings.toml"]).hexdigest()
    assert not any("first step" in note for note in data["notes"])  # it starts from rest
    assert any("gauss-seidel" in note and "predictor_order = 1" in note for note in data["notes"])
    assert cli.run(words) == ExitCode.OK
    assert repr(data["step"])[:4] in capsys.readouterr().out  # people are told the step too


def test_a_predictor_is_left_out_and_told(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Its FMU is needed all the same: the system is built by the code that marches it."""
    changes = [word for key in SMALL for word in ("--set", key)]
    words = ["export", "ssp", str(ROOT / "cases" / "paper_s.toml"), *changes, "--fmus", str(folder), "--json"]
    words += ["--slosh", "rbf", "--set", "slosh.predictor=ems", "--out", str(tmp_path / "a.ssp")]
    assert cli.run(words) == ExitCode.OK
    data = json.loads(capsys.readouterr().out)
    assert data["components"]["slosh"]["fmu"] == "slosh_rbf.fmu" and "slosh_predictor" not in data["components"]
    assert any("slosh.predictor = ems is left out" in note for note in data["notes"])


def test_system_file(folder: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The example of `aeroslosh run`: all its parameters, and a warning that its loop is strong."""
    target = tmp_path / "stand.ssp"
    file = ROOT / "cases" / "tank_on_springs.toml"
    assert cli.run(["export", "ssp", str(file), "--fmus", str(folder), "--out", str(target), "--json"]) == ExitCode.OK
    data = json.loads(capsys.readouterr().out)
    content = unpacked(target.read_bytes())
    assert data["step"] == 0.01 and data["stop"] == 20.0 and data["steps"] == 2000
    stand = values(content, "stand")
    assert stand["omega_alpha"] == ("Real", "5.6", "rad/s") and stand["initial_alpha"][1] == "0.02"
    assert float(values(content, "tank")["alpha"][1]) == 0.02  # an input's start value
    assert values(content, "tank")["modes"] == ("Integer", "5", None)
    assert any("may diverge" in note for note in data["notes"])
    assert any("FMPy" in note and "tank.alpha" in note and "tank.h_dot" not in note for note in data["notes"])
    read_ssd(str(target), validate=True)


def test_two_fmus_of_one_name(coupled: Coupled) -> None:
    """Different files of one name lie under their components' names, the same file lies there once."""
    a, b, c = coupled.parts
    first, second = (Part(n, Path(f"{n}/x.fmu"), sha, p.description, {}) for n, sha, p in (("a", "1", a), ("b", "2", b)))
    twice = Coupled("n", "", [first, second], [], 0.0, 1e-3, 1, "", [])
    assert [ssp_archive._source(p, twice) for p in twice.parts] == ["resources/a.fmu", "resources/b.fmu"]
    same = Coupled("n", "", [first, Part("c", Path("c/x.fmu"), "1", c.description, {})], [], 0.0, 1e-3, 1, "", [])
    assert {ssp_archive._source(p, same) for p in same.parts} == {"resources/x.fmu"}


def test_one_name_for_two_units(coupled: Coupled) -> None:
    """Refused, naming both."""
    fake: Any = SimpleNamespace(kg=0, m=2, s=0, A=0, K=0, mol=0, cd=0, rad=0, factor=1.0, offset=0.0)
    other = SimpleNamespace(unitDefinitions=[SimpleNamespace(name="m", baseUnit=fake)])
    with pytest.raises(AeroSloshError, match="'m' is one unit in aero and another in foreign"):
        ssp_units.of_parts([coupled.parts[0], Part("foreign", Path("f.fmu"), "", other, {})])
    fake.m, fake.factor = 1, 0.001
    scaled = SimpleNamespace(
        unitDefinitions=[SimpleNamespace(name="mm", baseUnit=fake), SimpleNamespace(name="?", baseUnit=None)]
    )
    assert ssp_units.of_parts([Part("foreign", Path("f.fmu"), "", scaled, {})]) == {"mm": {"m": "1", "factor": "0.001"}}


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["cases/paper_s.toml", "--set", "coupling.substeps={ aero = 2 }"], "SSP cannot carry coupling.substeps"),
        (["cases/paper_s.toml", "--set", "coupling.waveform={ aero = 'linear' }"], "SSP cannot carry coupling.waveform"),
        (["cases/tank_on_springs.toml", "--vf", "0.7"], "--vf belongs to a flutter case"),
        (["cases/tank_on_springs.toml", "--out", "stand.zip"], "by its ending"),
        (["cases/tank_on_springs.toml", "--set", "run.step=1e-10", "--set", "run.end=1e-9"], "at least a nanosecond"),
        (["cases/tank_on_springs.toml", "--out", "/dev/null/a.ssp"], "cannot be written"),
        (["cases/missing.toml"], "cannot be read"),
        (["cases/paper_s.toml", "--slosh", "soup"], "not available"),
    ],
)
def test_refused(folder: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, words: list[str], said: str) -> None:
    """What is wrong and what to do."""
    monkeypatch.chdir(tmp_path)
    with pytest.raises(AeroSloshError) as caught:
        cli.run(["export", "ssp", str(ROOT / words[0]), *words[1:], "--fmus", str(folder)])
    assert said in str(caught.value) and caught.value.remedy and caught.value.code == ExitCode.INPUT
    assert not list(tmp_path.iterdir())


def test_notes_of_values_that_tools_cannot_set(coupled: Coupled, tmp_path: Path) -> None:
    """Texts, files and enumerations."""
    file = tmp_path / "wing.dat"
    file.write_text("x")
    aero, tank, _ = coupled.parts
    told = Part("aero", aero.path, "", aero.description, {"airfoil": str(file), "mach": 0.7})
    assert len(notes := ssp_system._limits([told])) == 2 and "FMPy" in notes[0] and str(file) in notes[1]
    assert not ssp_system._limits(coupled.parts)
    few = Part("slosh", tank.path, "", tank.description, {"limit": 0})
    assert "libcosim and ecos pass over" in ssp_system._limits([few])[0]


@pytest.mark.parametrize(
    ("order", "wish", "written"), [(1, None, "1"), (2, None, "1"), (0, None, None), (1, "none", None), (0, "linear", "1")]
)
def test_prediction_is_that_of_the_case_or_of_the_command(
    folder: Path, tmp_path: Path, order: int, wish: str | None, written: str | None
) -> None:
    """The FMUs' own prediction, in flutter cases and system files; where it is off the FMU's default holds."""
    target = tmp_path / "stand.ssp"
    words = ["export", "ssp", str(ROOT / "cases" / "tank_on_springs.toml")]  # its scheme is implicit
    if order >= 0:
        words += ["--set", "coupling.scheme=jacobi", "--set", f"coupling.predictor_order={order}"]
    assert cli.run([*words, *(["--prediction", wish] if wish else []), "--fmus", str(folder), "--out", str(target)]) == 0
    content = unpacked(target.read_bytes())
    for component, name in (("stand", "load_prediction"), ("tank", "motion_prediction")):
        assert values(content, component).get(name, (None, None))[1] == written


def test_components_without_prediction_are_named(coupled: Coupled) -> None:
    """Old or foreign FMUs."""
    aero = coupled.parts[0]
    plain = [v for v in aero.description.modelVariables if v.name != "motion_prediction"]
    foreign = Part("foreign", aero.path, "", SimpleNamespace(modelVariables=plain), {})
    notes = ssp_system._predict([foreign], Coupling(), "linear")
    assert any("No prediction of their own have foreign" in note for note in notes) and not foreign.values
