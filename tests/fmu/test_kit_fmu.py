"""What a host sees of any FMU of the kit: failures, states, several instances, the description."""

from __future__ import annotations

import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import pytest
from fmpy.validation import validate_fmu

from aeroslosh.fmus.build.archive import BuildError, build, install
from support.paths import COMPONENTS

FAULTY, KERNELS = COMPONENTS / "faulty", COMPONENTS / "kernels"
ERROR = 3  # fmi2Error
Fmu = Callable[[str | Path], Path]
Host = Callable[..., Any]


@pytest.mark.parametrize("component", ["structure", FAULTY, KERNELS], ids=str)
def test_description_has_no_problems(fmu: Fmu, component: str | Path) -> None:
    assert validate_fmu(str(fmu(component))) == []


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (1, "ZeroDivisionError: 100 % forced: %s %n"),
        (2, "SystemExit: 3"),
        (3, "output 'y' = nan at t = 0.1 s"),
        (8, "RuntimeError: long long"),
        (9, "RuntimeError: no such file: caf?.dat. Remedy: look at"),
    ],
    ids=["exception", "exit", "not a number", "long message", "half a character"],
)
def test_failure_in_a_step_reaches_the_host_and_a_state_cures_it(fmu: Fmu, host: Host, kind: int, words: str) -> None:
    seen = host("fault", str(fmu(FAULTY)), kind)
    assert seen["good"] == [0]
    assert seen["bad"] == [ERROR, ERROR, 0]
    assert not seen["seen"]["after_start"]
    assert seen["seen"]["failed"] is True
    assert words in seen["seen"]["error"]
    assert "\n" not in seen["seen"]["error"]
    assert seen["seen"]["y"] != seen["seen"]["y"]  # NaN
    assert seen["recovered"] == {"failed": False, "error": "", "y": 2.0, "next": 4.0}
    status, category, text = seen["log"][0]
    assert (status, category) == (3, "logStatusError")
    assert words in text
    if kind == 1:
        assert "Traceback" in text


def test_failed_initialisation_is_seen_at_once(fmu: Fmu, host: Host) -> None:
    seen = host("fault", str(fmu(FAULTY)), 4)["seen"]
    assert seen["after_start"] is True
    assert "ValueError: no start is possible. Remedy: another fault" in seen["error"]


@pytest.mark.parametrize(("kind", "words"), [(5, "cannot save"), (6, "cannot restore"), (7, "a set cannot be saved")])
def test_failure_in_a_state_function_is_seen(fmu: Fmu, host: Host, kind: int, words: str) -> None:
    seen = host("state_faults", str(fmu(FAULTY)), kind)
    assert seen["failed"] is True
    assert words in seen["error"]
    assert seen["status"] == ERROR


def test_refused_values(fmu: Fmu, host: Host) -> None:
    seen = host("refused", str(fmu(FAULTY)))
    for case, words in {
        "gain=9.0": "'gain' = 9.0 is outside its range. Remedy: give a value of at least 0.5 and at most 4.0",
        "gain=nan": "parameter 'gain' = nan is not a finite number",
        "count=7": "'count' = 7 is outside its range. Remedy: give a value of at least 1 and at most 5",
        "fault=99": "give one of 0 (none), 1 (raise)",
        "u=inf": "input 'u' = inf is not a finite number. Remedy: give a finite value in m",
        "y=1.0": "output 'y' cannot be set",
    }.items():
        before, failed, error, status, y = seen[case]
        assert words in before, case
        assert words in error, case
        assert (failed, status, y) == (True, ERROR, "nan"), case
    value, status, error = seen["input"]
    assert (value, status) == (0.0, ERROR)  # not applied
    assert "input 'u' = nan" in error
    assert seen["input again"] == [0, False, 2.0]
    assert seen["late"][0] == ERROR
    assert "parameter 'gain' is fixed" in seen["late"][1]
    assert seen["numbers"] == [2.0, 3, "text"]


def test_reset_cures_a_failure(fmu: Fmu, host: Host) -> None:
    assert host("reset", str(fmu(FAULTY))) == {"statuses": [ERROR, 0], "y": 2.0, "failed": False}


def test_two_hundred_instances_in_one_process(fmu: Fmu, host: Host) -> None:
    assert host("many", str(fmu("structure")), 200) == 200


def test_two_versions_in_one_process(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    other = tmp_path / "faulty"
    other.mkdir()
    for path in FAULTY.glob("*.py"):
        text = path.read_text(encoding="utf-8").replace("self.history.sum()", "10.0 * self.history.sum()")
        (other / path.name).write_text(text, encoding="utf-8")
    seen = host("two_versions", str(fmu(FAULTY)), str(build(other, tmp_path)))
    assert seen["y"] == [2.0]
    assert seen["failed"] is True  # the state of one version is refused by the other
    assert "was made by version" in seen["error"]
    assert "Remedy" in seen["error"]


def test_the_same_sources_build_the_same_bytes(tmp_path: Path) -> None:
    once, again = (build(FAULTY, tmp_path / folder, check=False) for folder in ("once", "again"))
    built = again.read_bytes()
    assert built == once.read_bytes()
    install(once, Path("/opt/a python/bin/python3"))
    with zipfile.ZipFile(once) as archive, zipfile.ZipFile(again) as plain:
        members = set(archive.namelist())
        assert members - set(plain.namelist()) == {"resources/python.txt"}  # the path of a Python, and nothing else, is added
        assert all(archive.read(name) == plain.read(name) for name in plain.namelist())
        assert archive.read("resources/python.txt") == b"/opt/a python/bin/python3\n"
    install(again, Path("/opt/a python/bin/python3"))
    assert again.read_bytes() == once.read_bytes()
    with zipfile.ZipFile(again) as archive:
        assert {info.date_time for info in archive.infolist()} == {(1980, 1, 1, 0, 0, 0)}
        modes = {info.filename: info.external_attr >> 16 & 0o777 for info in archive.infolist()}
    assert modes["binaries/linux64/faulty.so"] == 0o755
    assert modes["modelDescription.xml"] == 0o644


def test_a_face_that_cannot_be_imported_is_a_clear_error(tmp_path: Path) -> None:
    broken = tmp_path / "broken"
    broken.mkdir()
    (broken / "fmu.py").write_text("from ..kit.slave import Slave\nclass Broken(Slave):\n    variables = (1 / 0,)\n")
    with pytest.raises(BuildError, match=r"broken: the face cannot be described[\s\S]*ZeroDivisionError"):
        build(broken, tmp_path)
    assert not list(tmp_path.glob("*.fmu"))


def test_compiled_kernels_are_found_from_another_unzip_folder(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    path = str(fmu(KERNELS))
    first = host("kernels", path, XDG_CACHE_HOME=str(tmp_path), LOCALAPPDATA=str(tmp_path))
    second = host("kernels", path, XDG_CACHE_HOME=str(tmp_path), LOCALAPPDATA=str(tmp_path))
    assert first == {"y": 20.0, "hits": 0, "misses": 1, "error": ""}
    assert second == {"y": 20.0, "hits": 1, "misses": 0, "error": ""}


def test_description_of_the_structure(fmu: Fmu) -> None:
    with zipfile.ZipFile(fmu("structure")) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
        requirements = archive.read("resources/requirements.txt").decode()
    units = {unit.get("name"): unit.find("BaseUnit") for unit in root.iter("Unit")}
    assert {key: units["N/m"].get(key) for key in ("kg", "m", "s")} == {"kg": "1", "m": None, "s": "-2"}
    assert {key: units["kg/m"].get(key) for key in ("kg", "m")} == {"kg": "1", "m": "-1"}
    scalars = {scalar.get("name"): scalar for scalar in root.iter("ScalarVariable")}
    for name, scalar in scalars.items():
        assert scalar.get("description") is not None, name
        real = scalar.find("Real")
        assert real is None or real.get("unit") in units, name
    assert scalars["mass"].find("Real").attrib == {
        "declaredType": "MassPerLength [kg/m]", "quantity": "MassPerLength", "unit": "kg/m", "min": "1e-09", "start": "57.73"
    }  # fmt: skip
    assert scalars["load_prediction"].find("Integer").attrib == {"min": "0", "max": "1", "start": "0"}
    outputs = [unknown.attrib for unknown in root.find("ModelStructure/Outputs")]
    assert all(unknown["dependencies"] == "" for unknown in outputs)  # the structure goes first
    assert len(outputs) == sum(scalar.get("causality") == "output" for scalar in scalars.values())
    simulation = root.find("CoSimulation").attrib
    assert simulation["canGetAndSetFMUstate"] == simulation["canSerializeFMUstate"] == "true"
    assert simulation["canInterpolateInputs"] == simulation["providesDirectionalDerivative"] == "false"
    assert [line.split(">")[0] for line in requirements.split()] == ["numpy", "scipy"]
