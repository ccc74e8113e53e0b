"""boundary.csv: every neutral V_f of every Mach number, numbers to the bit."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

from aeroslosh.master.results import boundary_table
from support.processes import called


def test_a_row_a_crossing_in_order_and_one_for_a_mach_number_without() -> None:
    crossing = {
        "frequency": 0.9,
        "V_f_uncertainty": 0.1 + 0.2,
        "kind": "flutter",
        "source": "march",
        "by_value": {"margin": 1.25},
    }
    points = [
        {"mach": 0.8, "outcome": "two", "slosh": "ems", "by_value": {"airspeed": 270.0, "margin": 9.0},
         "crossings": [crossing | {"V_f": 2.0, "direction": "recovery"}, crossing | {"V_f": 0.7, "direction": "onset"}]},
        {"mach": 0.7, "outcome": "no neutral V_f", "slosh": "ems", "by_value": None, "crossings": []},
    ]  # fmt: skip
    rows = list(csv.DictReader(io.StringIO(boundary_table.as_csv(points).decode())))
    assert [(r["mach"], r["V_f"], r["direction"]) for r in rows] == [
        ("0.7", "", ""),
        ("0.8", "0.7", "onset"),
        ("0.8", "2.0", "recovery"),
    ]
    assert rows[0]["outcome"] == "no neutral V_f" and rows[0]["airspeed"] == ""
    assert float(rows[1]["V_f_uncertainty"]) == 0.1 + 0.2 and rows[1]["margin"] == "1.25" and rows[1]["airspeed"] == "270.0"


def test_boundaries_of_two_runs_in_one_picture(boundary_run: Callable[..., Path], tmp_path: Path) -> None:
    dry = boundary_run("dry", {0.7: [(1.0, 0.01, "onset"), (1.5, 0.01, "recovery")], 0.8: [(0.8, 0.01, "onset")]})
    wet = boundary_run("wet", {0.7: [(0.9, 0.01, "onset")], 0.75: [(0.85, 0.01, "onset")]})
    done = called("overlay", dry, wet, "--out", tmp_path / "o.png")
    assert done.returncode == 0, done.stderr
    assert "Mach 0.7    lowest neutral V_f: dry 1.0000, wet 0.9000 (-10.0 %)" in done.stdout and "0.8    lowest" in done.stdout
    assert (tmp_path / "o.png").read_bytes().startswith(b"\x89PNG")
    told = json.loads(called("overlay", dry, wet, "--json", "--out", tmp_path / "o.png", "--names", "a", "b").stdout)
    assert told["lowest_V_f"] == {"a": {"0.7": 1.0, "0.8": 0.8}, "b": {"0.7": 0.9, "0.75": 0.85}}
    done = called("overlay", dry, wet, "--names", "a", "--out", tmp_path / "o.png")
    assert done.returncode == 2 and "2 different names" in done.stderr


def test_runs_without_a_common_mach_number_are_all_told(boundary_run: Callable[..., Path], tmp_path: Path) -> None:
    low, high = boundary_run("low", {0.3: [(1.0, 0.01, "onset")]}), boundary_run("high", {0.6: [(0.9, 0.01, "onset")]})
    done = called("overlay", low, high, "--out", tmp_path / "o.png")
    assert done.returncode == 0, done.stderr
    assert "Mach 0.3    lowest neutral V_f: low 1.0000, high –" in done.stdout
    assert "Mach 0.6    lowest neutral V_f: low –, high 0.9000" in done.stdout


def test_limit_cycles_of_two_runs_in_one_picture(boundary_run: Callable[..., Path], tmp_path: Path) -> None:
    cycle = {"amplitude_deg": 0.3, "std_deg": 0.02, "stable": True, "slope": -0.01, "confirmed": "both"}
    rows = [{"V_f": 0.8, "marches": [], "cycles": [cycle], "curve": []}]
    runs = []
    for name, mach, slosh in (("a", 0.8, "rbf"), ("b", 0.8, "vof"), ("c", 0.7, "vof")):
        runs.append(tmp_path / name)
        runs[-1].mkdir()
        data = {"mach": mach, "slosh": slosh, "free_cycles": 20.0, "speeds": rows}
        (runs[-1] / "result.json").write_text(json.dumps(data), encoding="utf-8")
    done = called("overlay", *runs[:2], "--out", tmp_path / "o.png")
    assert done.returncode == 0, done.stderr
    assert "V_f 0.8: stable limit cycle at 0.3 ± 0.02 deg (marched from both)" in done.stdout
    assert (tmp_path / "o.png").read_bytes().startswith(b"\x89PNG")
    told = json.loads(called("overlay", *runs[:2], "--json", "--names", "x", "y", "--out", tmp_path / "o.png").stdout)
    assert told["speeds"] == {"x": rows, "y": rows}
    done = called("overlay", *runs, "--names", "a", "b", "c", "--out", tmp_path / "p.png")
    assert done.returncode == 2 and "several Mach numbers" in done.stderr and not (tmp_path / "p.png").exists()
    other = boundary_run("dry", {0.7: [(1.0, 0.01, "onset")]})
    done = called("overlay", runs[0], other)
    assert done.returncode == 2 and "of `aeroslosh amplitude` alone" in done.stderr
