"""The slosh_rbf FMU through FMPy: the surrogate behind the face, rollback, restart, what it refuses."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from aeroslosh.fmus.build.archive import ROOT
from aeroslosh.fmus.slosh_rbf.feedback_tank import in_tank
from aeroslosh.fmus.slosh_rbf.network import load, untrained
from aeroslosh.fmus.slosh_rbf.violent_network import load as read_branch
from aeroslosh.fmus.tank.liquid import Tank

Fmu = Callable[[str], Path]
Host = Callable[..., Any]
ERROR = 3  # fmi2Error
LOADS = ["force_x", "force_y", "moment"]
WAVES = {"h": [1e-3, 60.0, 0.3], "alpha": [4e-3, 45.0, 0.0], "x": [5e-4, 30.0, 1.0]}
NETWORKS = {
    "default": load(ROOT / "slosh_rbf" / "weights" / "default.npz"),
    "bilinear": untrained("bilinear", True),
    "ems": untrained("ems", False),
}
BRANCH = read_branch(ROOT / "slosh_rbf" / "weights" / "branches" / "default.npz")


def motions(times: np.ndarray) -> np.ndarray:
    """What host.py feeds: shape (n, 9)."""
    columns = []
    for name in ("h", "alpha", "x"):
        size, omega, phase = WAVES[name]
        s, c = np.sin(omega * times + phase), np.cos(omega * times + phase)
        columns += [size * s, size * omega * c, -size * omega**2 * s]
    return np.stack(columns, axis=1)


def test_description_has_no_problems_and_no_need_of_torch(fmu: Fmu) -> None:
    assert validate_fmu(str(fmu("slosh_rbf"))) == []
    with ZipFile(fmu("slosh_rbf")) as archive:
        needed = archive.read("resources/requirements.txt").decode()
        names = archive.namelist()
    assert "torch" not in needed and "scipy" not in needed
    assert any(name.endswith("weights/default.npz") for name in names)
    assert not any(name.endswith(("training.py", "dataset.py", "tuning.py")) for name in names)


@pytest.mark.parametrize("name", list(NETWORKS))
def test_the_face_gives_what_the_surrogate_gives(fmu: Fmu, host: Host, name: str) -> None:
    """1e-9: kernels compiled on their own or in one may add in another order."""
    values = {"network": name, "tank_x": 1.8, "tank_y": 0.1, "liquid_density": 800.0}
    rows = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), values, WAVES, 2e-3, 200, LOADS))
    tank = Tank(0.5, 0.15, 1.0, 0.5, 1.8, 0.1, 800.0, 9.81)
    branch = BRANCH if name == "default" else None  # D reaches 1.9: the surface begins to break
    true = in_tank(NETWORKS[name], tank, 1e-6, 1.2, branch).run(motions(2e-3 * np.arange(201)), 2e-3)
    assert np.max(np.abs(rows - true) / np.abs(true).max(axis=0)) < 1e-9


def test_compiled_or_read_from_the_cache_a_kernel_gives_the_same_bits(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """The first process compiles every kernel, the second finds them; a copy of a callee, optimised otherwise, would show."""
    words = str(fmu("slosh_rbf")), {"tank_x": 1.8}, WAVES, 2e-3, 100, LOADS
    place = {"XDG_CACHE_HOME": str(tmp_path), "LOCALAPPDATA": str(tmp_path)}
    first = host("slosh_harmonic", *words, **place)
    kept = {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")}
    assert kept
    assert host("slosh_harmonic", *words, **place) == first
    assert {path: path.stat().st_mtime_ns for path in tmp_path.rglob("*.nbc")} == kept


def test_rollback_and_restart_in_a_new_process_are_exact_to_the_bit(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    kept, path = str(tmp_path / "state"), str(fmu("slosh_rbf"))
    seen = host("slosh_rollback", path, {"tank_x": 0.4}, 2e-3, kept)
    assert seen["first"] == seen["second"]
    assert seen["first"][0] != seen["first"][-1]
    assert host("slosh_resume", path, 2e-3, kept) == seen["first"]


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"network": "nonesuch"}, ["no network 'nonesuch'", "default", "bilinear", "ems"]),
        ({"fill_level": 0.2}, ["depth/length", "Remedy"]),
        ({"network": "quadratic", "fill_level": 0.3}, ["depth/length", "Remedy"]),
        ({"tank_length": 1.0}, ["depth/length"]),
        ({"tank_height": 0.1, "fill_level": 0.75}, ["roof"]),
        ({"fill_level": 1.2}, ["'fill_level' = 1.2", "at most 1.0"]),
        ({"network": "../weights/default"}, ["no network"]),
        ({"network": "x" * 300}, ["no network"]),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_what_a_network_does_not_know_is_refused(fmu: Fmu, host: Host, values: dict[str, Any], words: list[str]) -> None:
    seen = host("bad_start", str(fmu("slosh_rbf")), values)
    assert seen["failed"] is True
    assert seen["status"] == ERROR
    for word in words:
        assert word in seen["error"]


def test_a_tank_of_another_size_and_fill_for_the_equations(fmu: Fmu, host: Host) -> None:
    """Twice the size with the default network, another fill with the equations alone: both run."""
    for values in ({"tank_length": 1.0, "tank_height": 0.3}, {"network": "bilinear", "fill_level": 0.8}):
        rows = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), values, WAVES, 2e-3, 50, LOADS))
        assert np.isfinite(rows).all() and np.ptp(rows[:, 0]) > 0.0


def test_trust_is_told(fmu: Fmu, host: Host) -> None:
    """Gentle motion lies inside the training data; two g lie outside, for good: validity does not fall again."""
    wanted = ["validity", "extrapolation", "unevenness", "wave_growth"]
    calm = {"h": [2e-4, 60.0, 0.0], "alpha": [1e-3, 45.0, 0.0]}
    inside = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), {}, calm, 2e-3, 150, wanted))
    assert 0.0 < inside[:, 0].max() < 1.0 and inside[:, 1].max() < 1.0
    violent = {"h": [6e-3, 60.0, 0.0], "alpha": [1e-3, 45.0, 0.0]}
    outside = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), {}, violent, 2e-3, 150, wanted))
    assert outside[-1, 0] > 1.0 and outside[:, 2].max() == pytest.approx(6e-3 * 3600.0 / 9.81, rel=0.25)
    assert (np.diff(outside[:, 0]) >= 0.0).all() and outside[-1, 3] > 1.0


def test_a_broken_surface_is_told_on_average(fmu: Fmu, host: Host) -> None:
    """What validity means, the edge of a network with a branch and of one without, and the deviation that single runs have."""
    wanted = ["validity", "validity_edge", "force_y_deviation"]
    violent = {"h": [12e-3, 60.0, 0.0], "alpha": [1e-3, 45.0, 0.0]}
    for fill in (0.5, 0.4):
        rows = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), {"fill_level": fill}, violent, 2e-3, 500, wanted))
        assert 1.0 < rows[-1, 0] <= 2.0 and (rows[:, 1] == 2.0).all()
        assert rows[0, 2] == 0.0 and rows[-1, 2] > 0.02 * 4.4 * 9.81 * 1000.0 * 0.075 * fill
    rows = np.array(host("slosh_harmonic", str(fmu("slosh_rbf")), {"network": "quadratic"}, violent, 2e-3, 500, wanted))
    assert rows[-1, 0] > 1.0 and (rows[:, 1] == 1.0).all() and (rows[:, 2] == 0.0).all()
