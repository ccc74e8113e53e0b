"""`aeroslosh drive` on the structure FMU."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np

from support.processes import Done, called


def drive(fmus: Path, *arguments: str) -> Done:
    return called("drive", fmus / "structure.fmu", *arguments)


def test_a_slow_load_gives_the_static_deflection(flutter_fmus: Path, tmp_path: Path) -> None:
    """A lift that rises over many periods: h = −lift/K_h; the outputs, the picture and the JSON are there."""
    motion = tmp_path / "load.csv"
    motion.write_text("time,lift\n0,0\n4,1000\n")
    done = drive(
        flutter_fmus, "--input", str(motion), "--step", "0.002", "--json",
        *("--set", "damping_ratio_h=0.05", "--set", "damping_ratio_alpha=0.05"),
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    assert report["steps"] == 2000
    outputs, picture = (Path(name) for name in report["files"])
    assert picture.stat().st_size > 5000
    with outputs.open() as file:
        last = list(csv.DictReader(file))[-1]
    assert float(last["time"]) == 4.0
    np.testing.assert_allclose(float(last["h"]), -1000 / (57.73 * 100**2), rtol=1e-3)
    assert float(last["released"]) == 1.0


def test_bad_input_names_what_where_and_remedy(flutter_fmus: Path, tmp_path: Path) -> None:
    motion = tmp_path / "load.csv"
    motion.write_text("time,lifft\n0,0\n1,1\n")
    done = drive(flutter_fmus, "--input", str(motion))
    assert done.returncode == 2
    assert "'lifft' is no Real input" in done.stderr and "lift, moment" in done.stderr
    motion.write_text("time,lift\n0,0\n1,1\n")
    done = drive(flutter_fmus, "--input", str(motion), "--set", "mas=3")
    assert done.returncode == 2 and "sets no parameter" in done.stderr
    done = drive(flutter_fmus, "--input", str(motion), "--set", "mass=-3")
    assert done.returncode == 3 and "'mass' = -3.0" in done.stderr


def test_a_name_of_an_fmu_and_a_place_that_takes_no_file(flutter_fmus: Path, tmp_path: Path) -> None:
    motion = tmp_path / "load.csv"
    motion.write_text("time,lift\n0,0\n0.1,1\n")
    named = called("drive", "structure", "--input", motion, "--no-pictures", AEROSLOSH_FMUS=str(flutter_fmus))
    assert named.returncode == 0 and (tmp_path / "load_structure.csv").is_file(), named.stderr
    (tmp_path / "plain").write_text("no folder")
    done = drive(flutter_fmus, "--input", str(motion), "--no-pictures", "--out", str(tmp_path / "plain" / "x.csv"))
    assert done.returncode == 2 and "cannot be made" in done.stderr and "Traceback" not in done.stderr
    done = called("drive", "structur", "--input", motion)
    assert done.returncode == 2 and "no FMU 'structur'" in done.stderr
