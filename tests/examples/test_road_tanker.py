"""The worked example runs as its users run it, and what it says is right where theory knows the answer."""

from __future__ import annotations

import ast
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from support.paths import ROOT

SCRIPT = ROOT / "examples" / "road_tanker.py"
MASS, LIQUID, GRAVITY, BRAKING = 8000.0, 5.0 * 0.75 * 2.3 * 840.0, 9.81, 0.4 * 9.81


@pytest.fixture(scope="module")
def results(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, float]]:
    """summary.json of a quick run."""
    out, fmus = tmp_path_factory.mktemp("tanker"), tmp_path_factory.mktemp("tanker_fmus")
    for name in ("slosh_ems", "slosh_vof"):
        (fmus / f"{name}.fmu").symlink_to(fmu(name))
    command = [sys.executable, str(SCRIPT), "--quick", "--fmus", str(fmus), "--out", str(out)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    assert {"loads.png", "tank.png"} <= {path.name for path in out.iterdir()}
    return dict(json.loads((out / "summary.json").read_text(encoding="utf-8")))


def test_frozen_cargo_is_the_textbook(results: dict[str, dict[str, float]]) -> None:
    found = results["frozen cargo"]
    turning = -0.8 * MASS * GRAVITY - 1.0 * MASS * BRAKING - (1.9 - 0.375) * LIQUID * BRAKING
    assert found["front_axle_max"] == pytest.approx((2.4 * (MASS + LIQUID) * GRAVITY - turning) / 5.4)
    assert found["stopping_time"] == pytest.approx(15.0 / BRAKING + 0.5 * 0.4, abs=0.02)  # the pedal ramp costs half its time


def test_the_liquid_gives_its_momentum_to_the_truck(results: dict[str, dict[str, float]]) -> None:
    """What still sloshes at the end is a few percent of it."""
    for name, found in results.items():
        assert found["impulse"] == pytest.approx(1.0, abs=0.06), name


def test_slosh_loads_the_front_axle_and_baffles_help(results: dict[str, dict[str, float]]) -> None:
    frozen, flow, baffled = (results[name] for name in ("frozen cargo", "two-phase flow", "with two baffles"))
    assert flow["front_axle_max"] > 1.1 * frozen["front_axle_max"]
    assert baffled["front_axle_max"] < flow["front_axle_max"]
    assert baffled["rear_axle_min"] > flow["rear_axle_min"]
    assert results["linear waves"]["validity"] > 3.0  # the model says itself that this is not for it


def test_it_needs_fmpy_numpy_and_matplotlib_only() -> None:
    tree = ast.parse(SCRIPT.read_text(encoding="utf-8"))
    names = {a.name.split(".")[0] for node in ast.walk(tree) if isinstance(node, ast.Import) for a in node.names}
    names |= {str(node.module).split(".")[0] for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
    assert names - set(sys.stdlib_module_names) == {"fmpy", "numpy", "matplotlib"}


def test_missing_fmus_are_a_clear_error(tmp_path: Path) -> None:
    done = subprocess.run([sys.executable, str(SCRIPT), "--fmus", str(tmp_path)], capture_output=True, text=True, cwd=tmp_path)
    assert done.returncode == 2
    assert "make fmus" in done.stderr
    assert not (tmp_path / "runs").exists()
