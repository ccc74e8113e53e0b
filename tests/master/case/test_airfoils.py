"""The airfoil of a case: known to the FMU or a file, else refused with place and nearest name; files by their full path."""

from __future__ import annotations

import zipfile
from pathlib import Path

import pytest

from aeroslosh.fmus.aero.airfoil import AirfoilError, contour
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case import airfoils
from aeroslosh.master.case import case as cases
from support.paths import ROOT

TABLE = ROOT / "fmus" / "aero" / airfoils.TABLE


@pytest.fixture
def fmu(tmp_path: Path) -> Path:
    """A stand-in for aero.fmu with the product's table of names."""
    path = tmp_path / "fmus" / "aero.fmu"
    path.parent.mkdir()
    with zipfile.ZipFile(path, "w") as archive:
        archive.write(TABLE, f"resources/aero_0/aero/{airfoils.TABLE}")
    return path


NAMES = ["NACA 0012", "0012", "naca2412", "NACA_64A010", "64a006", "65A215", "0512", "NACA 0000", "66A010", "64A030", "64A002",
         "2012", "0O12", "23012", "NACA", "", "64A01", "64A0100", "99", "63A021"]  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_the_table_knows_the_names_that_the_physics_knows(fmu: Path, name: str) -> None:
    try:
        contour(name)
    except AirfoilError:
        with pytest.raises(AeroSloshError):
            airfoils.check(name, "here", fmu)
    else:
        airfoils.check(name, "here", fmu)


@pytest.mark.parametrize(
    ("word", "near"),
    [
        ("NACA 0O12", "NACA 0012"),
        ("naca64a01o", "NACA 64A010"),
        ("NACA 64AO1O", "NACA 64A010"),
        ("NACA-OOI2", "NACA 0012"),
        ("NACA 64A030", "NACA 64A010"),
        ("mywng.dat", "mywing.dat"),
        ("wings/mywing.dat", ""),
    ],
)
def test_an_unknown_airfoil_is_refused_with_the_nearest_name(tmp_path: Path, fmu: Path, word: str, near: str) -> None:
    (tmp_path / "mywing.dat").write_text("1 0\n")
    with pytest.raises(AeroSloshError) as caught:
        airfoils.check(word, "case.toml, line 3", fmu, tmp_path)
    said = str(caught.value)
    assert caught.value.code == ExitCode.INPUT
    assert f'"{word}"' in said and "case.toml, line 3" in said and "NACA 5-digit" in said
    assert ("did you mean" in said) == bool(near) and near in said


def test_an_fmu_without_the_table_lets_every_name_through(tmp_path: Path) -> None:
    (tmp_path / "aero.fmu").write_bytes(b"no archive")
    airfoils.check("FAIL 100", "here", tmp_path / "aero.fmu")


def test_the_place_is_the_line_or_the_last_override(tmp_path: Path) -> None:
    case = tmp_path / "case.toml"
    case.write_text('[flow]\nmach = 0.7\nairfoil = "x"\n')
    assert airfoils.place(cases.load(case)) == f"{case}, line 3, key flow.airfoil"
    overrides = ["flow.airfoil=b", "flow.airfoil=a", "flow.mach=0.6"]
    assert airfoils.place(cases.load(case, overrides)) == "--set flow.airfoil=a"
    case.write_text("[flow]\nmach = 0.7\n")
    assert "default" in airfoils.place(cases.load(case))


def test_a_relative_file_is_resolved_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the case: beside it, then here. Of --set: here, then beside the case. A NACA name is no file of this folder."""
    beside, here = tmp_path / "beside", tmp_path / "here"
    for folder in (beside, here):
        folder.mkdir()
        (folder / "both.dat").write_text("1 0\n")
    (here / "here.dat").write_text("1 0\n")
    (beside / "beside.dat").write_text("1 0\n")
    (here / "0012").write_text("1 0\n")
    case = beside / "case.toml"
    monkeypatch.chdir(here)
    for word, in_case, by_set in (
        ("both.dat", beside / "both.dat", here / "both.dat"),
        ("here.dat", here / "here.dat", here / "here.dat"),
        ("beside.dat", beside / "beside.dat", beside / "beside.dat"),
        ("0012", "0012", "0012"),
        ("none.dat", "none.dat", "none.dat"),
        ("../here/here.dat", here / "here.dat", here / "here.dat"),
    ):
        case.write_text(f'[flow]\nairfoil = "{word}"\n')
        assert cases.load(case).flow.airfoil == str(in_case)
        case.write_text("")
        assert cases.load(case, [f'flow.airfoil="{word}"']).flow.airfoil == str(by_set)


def test_words_that_no_file_can_have_are_no_files() -> None:
    assert not airfoils.is_file("x" * 5000)
    assert not airfoils.is_file("a\0b")


def test_what_is_wrong_with_a_file_is_the_users_input() -> None:
    what = "Component 'aero' failed: AirfoilError: airfoil file 'a.dat', line 3: 'x' is not two numbers."
    assert airfoils.fault(what) == "Airfoil file 'a.dat', line 3: 'x' is not two numbers."
    assert airfoils.fault("Component 'aero' failed: MeshError: mesh folds over") is None
