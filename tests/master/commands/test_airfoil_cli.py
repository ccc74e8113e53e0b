"""An airfoil on the command line: refused before anything starts, told, drawn, and found again from elsewhere."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.aero.airfoil import contour
from support.paths import CASES
from support.processes import Done, called

SMALL = ("aero.cells_around=64", "aero.cells_normal=16", "flutter.forced_cycles=1.0", "flutter.steps_per_cycle=72",
         "flutter.free_cycles=1.5", "output.fields=false")  # fmt: skip

SECTION = """[section]
elastic_axis = 0.35
x_alpha = 0.2
r2_alpha = 0.25
frequency_ratio = 0.4
mass_ratio = 75.0
[flutter]
V_f = 0.3
[boundary]
mach = [0.5]
"""


@pytest.fixture(scope="module")
def fmus(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the product's structure.fmu and aero.fmu."""
    folder = tmp_path_factory.mktemp("product")
    for name in ("structure", "aero"):
        shutil.copy(fmu(name), folder)
    return folder


def aeroslosh(folder: Path, fmus: Path, *words: str) -> Done:
    """The command in `folder`."""
    return called(*words, "--fmus", fmus, cwd=folder)


def written(folder: Path, airfoil: str) -> str:
    (folder / "own.toml").write_text(f'[flow]\nmach = 0.5\nairfoil = "{airfoil}"\n{SECTION}')
    return "own.toml"


@pytest.mark.parametrize(
    ("command", "words", "where"),
    [
        ("point", (), "own.toml, line 3, key flow.airfoil"),
        ("boundary", (), "own.toml, line 3, key flow.airfoil"),
        ("sweep", ("--grid", "flow.mach=0.5,0.6"), "own.toml, line 3, key flow.airfoil"),
        ("point", ("--set", "flow.airfoil=naca0O12"), "--set flow.airfoil=naca0O12"),
        ("sweep", ("--grid", "flow.airfoil=NACA 0012,naca0O12"), "--grid flow.airfoil="),
    ],
)
def test_an_unknown_airfoil_is_bad_input(tmp_path: Path, fmus: Path, command: str, words: tuple[str, ...], where: str) -> None:
    done = aeroslosh(tmp_path, fmus, command, written(tmp_path, "NACA 0O12"), *words, "--out", "out")
    assert done.returncode == 2, done.stderr
    assert where in done.stderr and "did you mean 'NACA 0012'?" in done.stderr and "steady flow" not in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_no_section_is_bad_input(tmp_path: Path, fmus: Path) -> None:
    rows = [f"{x:.6f} {y:.6f}" for x, y in contour("0012")[::10]]
    (tmp_path / "two.dat").write_text("\n".join([*rows, "999.0 999.0", *rows]))
    done = aeroslosh(tmp_path, fmus, "point", written(tmp_path, "two.dat"), "--out", "out")
    assert done.returncode == 2, done.stderr
    for word in ("two.dat', line 81", "second element", "one element a file"):
        assert word in done.stderr
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("command", ["point", "boundary"])
def test_what_was_done_to_the_file_is_told_kept_and_drawn(tmp_path: Path, fmus: Path, command: str) -> None:
    points = contour("0012")[::21].copy()
    points[:, 1] += 0.001 * np.where(np.arange(len(points)) < len(points) // 2, 1.0, -1.0) * points[:, 0]
    (tmp_path / "blunt.dat").write_text("blunt\n" + "\n".join(f"{x:.6f} {y:.6f}" for x, y in points))
    words = [word for setting in (*SMALL, "boundary.max_marches=2") for word in ("--set", setting)]
    more = ("--method", "march", "--mach", "0.5") if command == "boundary" else ()
    done = aeroslosh(tmp_path, fmus, command, written(tmp_path, "blunt.dat"), *words, *more, "--out", "out")
    assert done.returncode in (0, 4), done.stderr
    line = next(line for line in done.stdout.splitlines() if line.startswith("  airfoil      "))
    assert "blunt.dat: 39 points, base 0.20% closed by a wedge over the chord; thickness 1" in line
    assert json.loads((tmp_path / "out" / "result.json").read_text())["airfoil_summary"] in line
    assert (tmp_path / "out" / "airfoil.png").stat().st_size > 20_000
    with (tmp_path / "out" / "airfoil.csv").open(newline="") as file:
        table = list(csv.DictReader(file))
    assert [row["what"] for row in table].count("file") == 39
    assert [row["what"] for row in table].count("mesh") == 65


def test_a_sweep_with_a_relative_file_is_resumed_from_elsewhere(flutter_fmus: Path, tmp_path: Path) -> None:
    here, elsewhere = tmp_path / "here", tmp_path / "elsewhere"
    for folder in (here, elsewhere):
        folder.mkdir()
    (here / "foil.dat").write_text("1 0\n")
    case = str(CASES / "isogai_a.toml")
    words = ["sweep", case, "--grid", "flutter.V_f=0.5,0.6", "--no-pictures", "--workers", "1", "--out", str(tmp_path / "out")]
    for setting in ("flow.mach=0.3", "flutter.steps_per_cycle=72", "flutter.free_cycles=2.0", "flow.airfoil=foil.dat"):
        words += ["--set", setting]
    first = aeroslosh(here, flutter_fmus, *words)
    assert first.returncode in (0, 4), first.stderr
    assert f'airfoil = "{here}/foil.dat"' in (tmp_path / "out" / "case.toml").read_text()
    for again in (words, ["sweep", str(tmp_path / "out" / "case.toml"), "--no-pictures", "--out", str(tmp_path / "out")]):
        done = aeroslosh(elsewhere, flutter_fmus, *again, "--resume")
        assert done.returncode == first.returncode, done.stderr
        assert "2 of 2 points done" in done.stdout
    (elsewhere / "foil.dat").write_text("1 0\n0 0\n")
    other = aeroslosh(elsewhere, flutter_fmus, *words, "--resume")
    assert other.returncode == 2, other.stderr
