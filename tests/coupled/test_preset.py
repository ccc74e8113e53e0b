"""Preset S (cases/paper_s.toml) in linear subsonic flow: how much fuel moves the flutter boundary, dry, frozen and sloshing."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.special import hankel2

from aeroslosh.master.boundary.search import Limits, search
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from support import liquid, possio
from support.paths import CASES

CASE = CASES / "paper_s.toml"
# neutral V_f by Mach number and place of the tank x_T/b, by another solution of Possio's equation that claims 0.5 %
DRY = {0.7: 1.6785, 0.8: 1.3514}
FROZEN = {(0.7, 1.2): 1.6917, (0.7, 1.8): 1.6314, (0.7, 2.4): 1.5413, (0.8, 1.2): 1.3413, (0.8, 1.8): 1.2897, (0.8, 2.4): 1.2214}
EMS = {(0.7, 1.2): 1.6920, (0.7, 1.8): 1.6317, (0.7, 2.4): 1.5416, (0.8, 1.2): 1.3415, (0.8, 1.8): 1.2899, (0.8, 2.4): 1.2216}


def case(model: str, x: float = 1.8) -> Case:
    return cases.load(CASE, [f"slosh.model={model}", f"slosh.tank_x={x}"])


def stiffness(model: str, x: float) -> possio.Liquid:
    """Dynamic stiffness of the preset's liquid in (h, alpha), without the section."""
    none = {"mass": 0.0, "static_imbalance": 0.0, "inertia": 0.0, "omega_h": 0.0, "omega_alpha": 0.0}
    M, C, K = liquid.system(none, liquid.TANK | {"tank_x": x, "modes": 8})
    m, y = 30.0, -0.0375
    carried = m * np.array([[1.0, x], [x, x**2 + y**2 + (0.5**2 + 0.075**2) / 12.0]])

    def of(omega: float) -> np.ndarray:
        if model == "none":
            return np.zeros((2, 2))
        if model == "frozen":
            return np.diag([0.0, -m * 9.81 * y]) - omega**2 * carried
        D = K - omega**2 * M + 1j * omega * C
        return D[:2, :2] - D[:2, 2:] @ np.linalg.solve(D[2:, 2:], D[2:, :2])

    return of


def expected(model: str, mach: float, x: float) -> float:
    return DRY[mach] if model == "none" else {"frozen": FROZEN, "ems": EMS}[model][mach, x]


def test_the_plate_is_thin_airfoil_theory() -> None:
    """Steady flow, Theodorsen's function at Mach 0, and no change with more points."""
    assert possio.coefficients(0.7, 1e-4, -2.0)[0] == pytest.approx(2.0 * np.pi / np.sqrt(0.51), rel=3e-3)
    k, a = 0.2, -2.0
    C = hankel2(1, k) / (hankel2(1, k) + 1j * hankel2(0, k))
    by_rate = 2.0 * np.pi * C + np.pi * 1j * k
    by_pitch = np.pi * (1j * k + a * k**2) + 2.0 * np.pi * C * (1.0 + 1j * k * (0.5 - a))
    assert possio.coefficients(1e-3, k, a)[0] == pytest.approx(np.array([by_rate, by_pitch]), rel=2e-6)
    np.testing.assert_allclose(possio.coefficients(0.8, k, a, 20), possio.coefficients(0.8, k, a, 80), rtol=1e-4)


@pytest.mark.parametrize("mach", [0.7, 0.8])
@pytest.mark.parametrize("x", [1.2, 1.8, 2.4])
def test_neutral_V_f_of_the_equations(mach: float, x: float) -> None:
    """Mass matrices and slosh modes against Possio's air, without FMUs."""
    found = {m: possio.neutral(case(m, x), mach, stiffness(m, x), DRY[mach]) for m in ("none", "frozen", "ems")}
    for model, value in found.items():
        assert value == pytest.approx(expected(model, mach, x), rel=5e-3)
    # the shifts are much better known than the values
    shift = expected("frozen", mach, x) / DRY[mach]
    assert found["frozen"] / found["none"] == pytest.approx(shift, abs=3e-4)
    assert 0.0 < found["ems"] / found["frozen"] - 1.0 < 3e-4


@pytest.fixture(scope="module")
def plates(tmp_path_factory: pytest.TempPathFactory) -> dict[float, Path]:
    """The rational model's file of each Mach number."""
    folder, files = tmp_path_factory.mktemp("plates"), {}
    for mach in DRY:
        model = possio.rational(mach, -2.0)
        assert model["error"] < 3e-3
        files[mach] = folder / f"plate_{mach}.json"
        files[mach].write_text(json.dumps(model))
    return files


@pytest.mark.parametrize("mach", [0.7, 0.8])
@pytest.mark.parametrize("model", ["none", "frozen", "ems"])
def test_neutral_V_f_marched(plate_fmus: Path, plates: dict[float, Path], mach: float, model: str) -> None:
    """The whole way: structure, air and slosh FMU, master, search."""
    settings = case(model)
    settings.flow.airfoil = str(plates[mach])
    settings.flutter.steps_per_cycle = 288
    with FlutterSetup(settings, find_fmus(plate_fmus, model), mach) as setup:
        point = search(lambda V_f: march.march(setup, V_f), mach, DRY[mach], Limits(0.5, 3.0, 0.003, 12))
    print(f"\nMach {mach}, {model}: V_f {point.outcome}", end="")
    assert point.converged and point.marches[0].slosh == model
    [found] = point.crossings
    assert found.V_f == pytest.approx(expected(model, mach, 1.8), rel=5e-3)
    assert found.V_f == pytest.approx(possio.neutral(settings, mach, stiffness(model, 1.8), DRY[mach]), rel=1.5e-3)
