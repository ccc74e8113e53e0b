"""`aeroslosh train`: what it refuses, and one training on a coarse grid from records to report."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from aeroslosh.fmus.slosh_rbf.feedback_tank import read
from support.paths import CASES
from support.processes import Done, called

CASE = CASES / "slosh_rbf.toml"


def train(case: Path, fmus: Path, *words: object) -> Done:
    return called("train", case, "--fmus", fmus, *words)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[training]\nseed = 3\n", ["line 2", "did you mean 'seeds'"]),
        ("[training]\nlargest_D = -1.0\n", ["training.largest_D", "above 0"]),
        ("[training]\ncentres = [0]\n", ["training.centres", "from 1"]),
        ("[slosh]\nfill_level = 2.0\n", ["slosh.fill_level"]),
        ("[flow]\nmach = 0.8\n", ["Unknown table [flow]"]),
        (CASE.read_text().replace("fill_level = 0.5", "fill_level = 1.0"), ["slosh.fill_level = 1", "below 1"]),
    ],
)
def test_bad_files_are_refused(tmp_path: Path, text: str, says: list[str]) -> None:
    case = tmp_path / "bad.toml"
    case.write_text(text)
    done = train(case, tmp_path, "--out", tmp_path / "run")
    assert done.returncode == 2 and "Traceback" not in done.stderr
    for part in says:
        assert part in done.stderr, done.stderr
    assert not (tmp_path / "run").exists()


def test_a_missing_solver_is_said(tmp_path: Path) -> None:
    done = train(CASE, tmp_path, "--out", tmp_path / "run", "--records", tmp_path / "records")
    assert done.returncode == 2 and "slosh_vof.fmu" in done.stderr and "make fmus" in done.stderr


@pytest.mark.validation
def test_a_training_from_records_to_report(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """32 x 16 cells: the network is no worse than the equations it corrects; a second training takes the records there are."""
    fmus = tmp_path / "fmus"
    fmus.mkdir()
    shutil.copy(fmu("slosh_vof"), fmus)
    words = [
        "--quick",
        "--set",
        "training.cells_x=32",
        "--set",
        "training.cells_y=16",
        "--records",
        tmp_path / "records",
        "--json",
    ]
    done = train(CASE, fmus, *words, "--out", tmp_path / "run")
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)["calm"]
    assert found["rbf"]["mean_fx"] <= found["bilinear"]["mean_fx"] < found["arx"]["mean_fx"] * 2.0
    names = {p.name for p in (tmp_path / "run").iterdir()}
    assert {"case.toml", "result.json", "report.md", "slosh_rbf.npz", "quadratic.npz", "arx.npz", "rbf_feedback.npz"} <= names
    assert read(tmp_path / "run" / "slosh_rbf.npz").shape == pytest.approx(0.15)
    times = {p.name: p.stat().st_mtime_ns for p in (tmp_path / "records").glob("*.nc")}
    assert train(CASE, fmus, *words, "--out", tmp_path / "again").returncode == 0
    assert times == {p.name: p.stat().st_mtime_ns for p in (tmp_path / "records").glob("*.nc")}
