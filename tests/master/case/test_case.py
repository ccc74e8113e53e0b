"""Cases: what is read, what is refused and how the refusal reads."""

from __future__ import annotations

import tomllib
from pathlib import Path

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case.case import Case, apply_override, dump, load
from support.paths import CASES

CASE = CASES / "isogai_a.toml"


def refused(tmp_path: Path, text: str) -> str:
    """The message for a case file with `text`."""
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(AeroSloshError) as caught:
        load(path)
    assert caught.value.code == ExitCode.INPUT
    assert caught.value.remedy
    return str(caught.value)


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_a_mark_in_front_and_other_line_ends_change_nothing(tmp_path: Path, ends: str) -> None:
    path = tmp_path / "own.toml"
    text = CASE.read_text().replace("0.825", "0.75", 1)
    path.write_bytes(b"\xef\xbb\xbf" + text.replace("\n", ends).encode())
    (tmp_path / "plain.toml").write_text(text)
    read, plain = load(path), load(tmp_path / "plain.toml")
    plain.name = read.name
    assert read == plain and read != load(CASE)
    path.write_bytes(b"\xef\xbb\xbf" + f"[flow]{ends}mach = 0.8{ends}mache = 0.8{ends}".encode())
    with pytest.raises(AeroSloshError, match=r"own\.toml, line 3"):
        load(path)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        ("[flow]\n".encode("utf-16"), ["UTF-16", "save it as UTF-8"]),
        ("[flow]\n".encode("utf-16-le"), ["UTF-16"]),
        ("[flow]\n# M\xfcller\n".encode("latin-1"), ["not UTF-8", "line 2"]),
    ],
)
def test_other_encodings_are_named(tmp_path: Path, data: bytes, words: list[str]) -> None:
    path = tmp_path / "own.toml"
    path.write_bytes(data)
    with pytest.raises(AeroSloshError) as caught:
        load(path)
    assert all(word in str(caught.value) for word in [*words, str(path)]) and caught.value.code == ExitCode.INPUT


def test_isogai_a_is_the_section_of_the_literature() -> None:
    case = load(CASE)
    s = case.section
    assert (s.elastic_axis, s.x_alpha, s.r2_alpha, s.frequency_ratio, s.mass_ratio) == (
        -0.5,
        1.8,
        3.48,
        1.0,
        60.0,
    )
    assert (case.flow.mach, case.flutter.V_f) == (0.825, 0.612)
    assert case.boundary.mach == [0.80, 0.825, 0.85]


def test_resolved_case_reads_back_the_same(tmp_path: Path) -> None:
    case = load(CASE, ["flow.mach=0.7", "aero.tolerance=1e-7", "boundary.mach=[0.5, 0.6]", "flow.airfoil=NACA 0012"])
    text = dump(case)
    again = tmp_path / f"{case.name}.toml"
    again.write_text(text)
    assert load(again) == case
    assert tomllib.loads(text)["aero"]["tolerance"] == 1e-7
    assert "[Pa]" in text


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[flow]\nmach = 0.8\nmachh = 0.8\n", ["bad.toml, line 3", "flow.machh", "did you mean 'mach'"]),
        ("[flutter]\nVf = 0.6\n", ["line 2", "Unknown key 'Vf'", "did you mean 'V_f'"]),
        ("\n[flaw]\nmach = 0.8\n", ["line 2", "Unknown table [flaw]", "did you mean 'flow'"]),
        ("[section]\nmass_ratio = -60.0\n", ["line 2", "section.mass_ratio", "-60.0", "above 0"]),
        ("[section]\nchord = 1\n\nfrequency_ratio = -1\n", ["line 4", "frequency_ratio", "from 0 to 100"]),
        ("[flow]\nmach = 3.0\n", ["line 2", "flow.mach = 3.0", "out of range", "from 0.05 to 0.98"]),
        ("[flow]\nmach = nan\n", ["line 2", "out of range"]),
        ('[flow]\nmach = "fast"\n', ["line 2", "wrong type", "'fast'", "give a number"]),
        ("[aero]\ncells_around = 168.5\n", ["line 2", "wrong type", "whole number"]),
        ('[aero]\ntolerance = "fine"\n', ["line 2", '"fine"', '"auto"']),
        ("[output]\npictures = 1\n", ["line 2", "true or false"]),
        ("[boundary]\nmach = 0.8\n", ["line 2", "list of numbers"]),
        ("[boundary]\nmach = [0.8, 3.0]\n", ["line 2", "3.0", "out of range"]),
        ("[boundary]\nV_f_range = [2.0, 1.0]\n", ["V_f_range", "[low, high]"]),
        ("[boundary]\nmach = [0.7, 0.8, 0.7]\n", ["boundary.mach", "0.7 twice", "once"]),
        ('[slosh]\nmodel = "water"\n', ["line 2", "slosh.model", "available: none, frozen, ems, rbf, vof"]),
        ("[slosh]\nfill_level = 1.5\n", ["line 2", "slosh.fill_level", "above 0 to 1"]),
        ('[slosh]\nparametric = "yes"\n', ["line 2", "slosh.parametric", '"auto"']),
        ('[coupling]\nscheme = "gauss"\n', ["line 2", "available: gauss-seidel, implicit, jacobi"]),
        ("[section]\nx_alpha = 1.8\nr2_alpha = 3.0\n", ["r2_alpha", "x_alpha^2", "not positive"]),
        ("[flutter]\nforced_cycles = 0.0\n", ["Nothing disturbs"]),
        ("[flutter]\ninitial_alpha_dot = 0.01\n", ["initial_alpha_dot", "forced_cycles"]),
        ("[flow\nmach = 0.8\n", ["not valid TOML", "line 1"]),
        ("flow = 3\n", ["line 1", "'flow' is a table"]),
    ],
)
def test_refusals_name_file_line_key_and_remedy(tmp_path: Path, text: str, says: list[str]) -> None:
    message = refused(tmp_path, text)
    assert "bad.toml" in message
    for part in says:
        assert part in message, message


def test_missing_file() -> None:
    with pytest.raises(AeroSloshError, match="cannot be read"):
        load(Path("nowhere.toml"))


@pytest.mark.parametrize("override", ["flow.mach", "mach=0.8", "flow.much=0.8", "flo.mach=0.8", "flow.mach=3", "flow.mach=x"])
def test_bad_overrides(override: str) -> None:
    with pytest.raises(AeroSloshError) as caught:
        apply_override(Case(), override)
    assert f"--set {override}" in str(caught.value)


def test_a_coordinate_file_is_found_beside_its_case(tmp_path: Path) -> None:
    (tmp_path / "section.dat").write_text("1 0\n0 0\n1 0\n")
    case = tmp_path / "case.toml"
    case.write_text('[flow]\nairfoil = "section.dat"\n')
    assert load(case).flow.airfoil == str(tmp_path / "section.dat")
    case.write_text('[flow]\nairfoil = "NACA 0012"\n')
    assert load(case).flow.airfoil == "NACA 0012"
