"""Section and liquid coupled through the FMUs and the master, against the same system solved as one."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.kit.interfaces import TANK
from aeroslosh.master.analysis.exponentials import Poles, refine
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.case import case as cases
from aeroslosh.master.case import fuel_tank
from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales
from aeroslosh.master.cosim.implicit import Criteria, Implicit
from aeroslosh.master.cosim.scheme import GaussSeidel, Jacobi, Scheme
from aeroslosh.master.flutter import march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.fmi.component import Component
from aeroslosh.master.linear import model as linear_model
from support import liquid
from support.paths import CASES

CASE = CASES / "paper_s.toml"
ACADEMIC = 6.2831  # omega_alpha [rad/s] at which the section meets the liquid's waves
START = np.array([0.01, 0.01])
EXACT = Implicit(1, Criteria(1e-12, max_iterations=60))


def section(omega: float = ACADEMIC) -> dict[str, float]:
    return liquid.SECTION | {"omega_h": omega, "omega_alpha": omega, "initial_h": START[0], "initial_alpha": START[1]}


def exact(times: np.ndarray) -> np.ndarray:
    """(h, alpha) of the whole system, released from START with a level surface. Shape: (2, times)."""
    M, C, K = liquid.system(section(), liquid.TANK)
    waves = np.diag(K)[2:] / np.diag(M)[2:]
    return liquid.motion(M, C, K, np.concatenate([START, 9.81 * START[1] / waves]), times)[:2]


@pytest.mark.parametrize(
    ("scheme", "split", "steps"), [(GaussSeidel(1), "frozen", 128), (EXACT, "frozen", 64), (EXACT, "none", 64)]
)
def test_eigenvalues(fmu: liquid.Fmu, scheme: Scheme, split: str, steps: int) -> None:
    """All five modes, section at resonance with the waves: frequency and damping to 1e-5; `steps` of the fastest period."""
    expected = liquid.eigenvalues(*liquid.system(section(), liquid.TANK))
    dt = 2.0 * np.pi / expected[-1].imag / steps
    run = liquid.march(fmu, scheme, dt, round(6.0 / dt), section(), liquid.TANK, split)
    channels = ("structure.h", "structure.alpha", "slosh.force_x", "slosh.moment_residual")
    sample = slice(None, None, steps // 8)
    seen = np.array([run[name][sample] / np.std(run[name]) for name in channels])
    fit = refine(run["time"][sample], seen, Poles(np.column_stack([expected.real, expected.imag]), np.zeros(0), constant=True))
    assert fit is not None
    poles = fit.poles.oscillations
    found = poles[np.argsort(poles[:, 1])]
    np.testing.assert_allclose(found[:, 1], expected.imag, rtol=1e-5)
    np.testing.assert_allclose(found[:, 0] / found[:, 1], expected.real / expected.imag, atol=1e-5)


def test_every_route_ends_at_the_same_motion(fmu: liquid.Fmu) -> None:
    """Split or whole load, one pass or iterated: second order, towards the system solved as one."""
    period = 2.0 * np.pi / liquid.eigenvalues(*liquid.system(section(), liquid.TANK))[-1].imag
    for scheme, split, worst in (
        (GaussSeidel(1), "frozen", 2e-4),
        (EXACT, "frozen", 3e-5),
        (EXACT, "none", 2e-4),
        (GaussSeidel(1), "none", 2e-3),
    ):
        errors = []
        for steps in (50, 100):
            run = liquid.march(fmu, scheme, period / steps, 5 * steps, section(), liquid.TANK, split)
            gap = np.stack([run["structure.h"], run["structure.alpha"]]) - exact(run["time"])
            errors.append(float(np.max(np.abs(gap) / START[:, None])))
        assert errors[1] < worst, (scheme.name, split, errors)
        assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.8), (scheme.name, split, errors)


@pytest.mark.parametrize("split", ["frozen", "none"])
def test_the_static_load_moves_nothing(fmu: liquid.Fmu, split: str) -> None:
    """300 N of fuel aft of the axis: a section at rest stays at rest, to rounding."""
    run = liquid.march(fmu, GaussSeidel(1), 0.01, 200, section() | {"initial_h": 0.0, "initial_alpha": 0.0}, liquid.TANK, split)
    assert run["slosh.force_y"][0] == pytest.approx(-30.0 * 9.81)
    assert max(np.max(np.abs(run[f"structure.{name}"])) for name in ("h", "alpha")) < 1e-14


def decay(fmu: liquid.Fmu, scheme: Scheme, split: str, ratio: float, steps: int) -> float:
    """Damping ratio of a plunging section of 100 kg/m with a full tank of `ratio` times its mass: exactly none."""
    omega = 10.0
    plunge = {
        "mass": 100.0,
        "static_imbalance": 0.0,
        "inertia": 50.0,
        "omega_h": omega * np.sqrt(1.0 + ratio),
        "omega_alpha": 40.0,
    }
    tank = {"fill_level": 1.0, "liquid_density": ratio * 100.0 / 0.075}
    run = liquid.march(fmu, scheme, 2.0 * np.pi / omega / steps, 12 * steps, plunge | {"initial_h": 0.01}, tank, split)
    half = run["time"] > run["time"][-1] / 4.0
    first = Poles(np.array([[0.0, 1.0]]), np.zeros(0), constant=True)
    fit = refine(omega * run["time"][half], run["structure.h"][half][None] / 0.01, first)
    assert fit is not None
    [[sigma, omega]] = fit.poles.oscillations
    return float(-sigma / omega)


def test_artificial_damping_of_lagged_loads_is_what_theory_says(fmu: liquid.Fmu) -> None:
    """A load of ratio e that comes d steps late: e/(1+e)/2 omega d dt; none where the structure carries the frozen liquid."""
    steps, ratio = 200, 0.13
    late = 0.5 * ratio / (1.0 + ratio) * 2.0 * np.pi / steps
    assert decay(fmu, GaussSeidel(0), "none", ratio, steps) == pytest.approx(late, rel=0.02)
    assert decay(fmu, Jacobi(0), "none", ratio, steps) == pytest.approx(2.0 * late, rel=0.03)
    assert abs(decay(fmu, GaussSeidel(1), "none", ratio, steps)) < 0.05 * late
    assert abs(decay(fmu, GaussSeidel(1), "frozen", 10.0, 25)) < 1e-10
    assert abs(decay(fmu, Implicit(1, Criteria(1e-12, max_iterations=60)), "none", 10.0, 50)) < 1e-8


@pytest.mark.parametrize(("ratio", "steps", "most"), [(1.0, 100, 5e-5), (10.0, 100, 1e-4), (10.0, 25, 5e-3)])
def test_the_frozen_split_in_pitch(fmu: liquid.Fmu, ratio: float, steps: int, most: float) -> None:
    """A half-full tank of `ratio` times the section's inertia, in one pass: stable, and hardly any damping but the waves'."""
    inertia = 0.5 * 0.075 * ((0.5**2 + 0.075**2) / 12.0 + 0.0375**2)  # of the frozen liquid per density
    tank = liquid.TANK | {"tank_x": 0.0, "liquid_density": ratio / inertia}
    pitching = {"mass": 1e3, "static_imbalance": 0.0, "inertia": 1.0, "omega_h": 1.0, "omega_alpha": 50.0 * np.sqrt(1.0 + ratio)}
    expected = liquid.eigenvalues(*liquid.system(pitching, tank))[1:]  # the first is the plunge's, which does not move
    fast = expected[-1].imag
    run = liquid.march(fmu, GaussSeidel(1), 2.0 * np.pi / fast / steps, 30 * steps, pitching | {"initial_alpha": 0.01}, tank)
    part = slice(2 * steps, None, steps // 25)
    poles = np.column_stack([expected.real, expected.imag]) / fast
    fit = refine(fast * run["time"][part], run["structure.alpha"][None, part] / 0.01, Poles(poles, np.zeros(0), constant=True))
    assert fit is not None
    found = fit.poles.oscillations
    sigma, omega = found[np.argmax(found[:, 1])]
    assert abs(sigma / omega - expected[-1].real / fast) < most


def test_one_pass_with_the_whole_load_of_a_heavy_liquid_explodes(fmu: liquid.Fmu) -> None:
    with np.errstate(all="ignore"):
        run = liquid.march(fmu, GaussSeidel(1), 0.005, 40, section(), liquid.TANK | {"liquid_density": 8000.0}, "none")
    assert np.max(np.abs(run["structure.h"])) > 1.0


# the set-up of a flutter run


def test_the_case_has_the_tank_of_the_fmus() -> None:
    """Same names, same start values as the parameters of every slosh FMU."""
    defaults = Case().slosh
    assert {name: getattr(defaults, name) for name in TANK} == {name: row[0] for name, row in TANK.items()}


def test_preset_S_is_the_one_of_the_page() -> None:
    case = cases.load(CASE)
    with_fuel = case.slosh.liquid_density * case.slosh.tank_length * case.slosh.fill_level * case.slosh.tank_height
    s = scales(case, 0.8, 0.8)
    assert (s.mass, s.static_imbalance, s.inertia) == pytest.approx((230.90, 415.6, 803.5), rel=1e-3)
    assert s.omega_alpha == pytest.approx(43.93, rel=1e-3)
    assert with_fuel / s.mass == pytest.approx(0.1299, rel=1e-3)


def run(fmus: Path, model: str, **slosh_keys: object) -> march.March:
    case = cases.load(CASE, [f"slosh.{name}={value}" for name, value in slosh_keys.items()])
    case.slosh.model, case.flow.airfoil, case.flow.mach = model, "NACA 0012", 0.3
    if slosh_keys.get("split") == "none":
        case.coupling.scheme, case.coupling.tolerance = "implicit", 1e-8
    with FlutterSetup(case, find_fmus(fmus, model), 0.3) as setup:
        return march.march(setup, 1.5)


def test_split_and_whole_load_march_alike(flutter_fmus: Path) -> None:
    split, whole, frozen, dry = (
        run(flutter_fmus, *a, **k) for a, k in ((["ems"], {}), (["ems"], {"split": "none"}), (["frozen"], {}), (["none"], {}))
    )
    for name in ("growth_rate", "frequency"):
        assert getattr(split.fit, name) == pytest.approx(getattr(whole.fit, name), abs=1e-3)
        assert getattr(split.fit, name) == pytest.approx(getattr(frozen.fit, name), abs=1e-3)
    assert frozen.fit is not None and dry.fit is not None
    assert abs(frozen.fit.frequency - dry.fit.frequency) > 0.01
    assert whole.history["slosh_force_y"][0] == pytest.approx(-30.0 * 9.81)
    assert "slosh_moment_residual" in split.history and "slosh_moment_residual" not in frozen.history
    assert [m.slosh for m in (split, frozen, dry)] == ["ems", "frozen", "none"]


def test_a_linear_model_predicts_the_loads_of_the_flow(flutter_fmus: Path, fmu: liquid.Fmu, tmp_path: Path) -> None:
    """Fuel of 0.65 of the section's mass: its whole load, exchanged once a step, explodes; predicted by slosh_ems it is carried
    in one pass, as the frozen split carries it (measured 3e-5 apart: what one of them extrapolates the other predicts)."""
    for file in (*flutter_fmus.glob("*.fmu"), fmu("slosh_vof")):
        shutil.copy(file, tmp_path)
    marches = {}
    for split, predictor in (("none", "none"), ("none", "ems"), ("frozen", "none")):
        words = ["slosh.cells_x=32", "slosh.cells_y=16", "slosh.liquid_density=4000", f"slosh.split={split}", "slosh.model=vof"]
        words += [f"slosh.predictor={predictor}", "flutter.forced_amplitude_deg=0.05", "flutter.free_cycles=3"]
        case = cases.load(CASE, [*words, "flow.mach=0.3", "flow.airfoil=NACA 0012", "flutter.steps_per_cycle=120"])
        with FlutterSetup(case, find_fmus(tmp_path, "vof", "ems"), 0.3) as setup:
            marches[split, predictor] = march.march(setup, 1.5)
    assert marches["none", "none"].failure is not None
    predicted, carried = marches["none", "ems"], marches["frozen", "none"]
    assert predicted.failure is None and carried.fit is not None and predicted.fit is not None
    for name in ("growth_rate", "frequency"):
        assert getattr(predicted.fit, name) == pytest.approx(getattr(carried.fit, name), abs=1e-4)
    assert "slosh_predictor" in predicted.cost.cpu


def test_the_linear_model_carries_the_liquid_frozen(flutter_fmus: Path) -> None:
    case = cases.load(CASE)
    case.flow.airfoil = "NACA 0012"
    with FlutterSetup(case, find_fmus(flutter_fmus, "ems"), 0.3) as setup:
        model = linear_model.identify(setup, 1.0)
        fit = march.march(setup, 1.5).fit
    assert model.liquid is not None and model.liquid.mass == pytest.approx(30.0) and fit is not None
    assert np.min(np.abs(model.eigenvalues(1.5) - complex(fit.growth_rate, fit.frequency))) < 2e-3


def test_what_is_missing_is_said(flutter_fmus: Path, doubles: Path) -> None:
    with pytest.raises(AeroSloshError, match=r"slosh_rbf\.fmu"):
        find_fmus(flutter_fmus, "rbf")
    with pytest.raises(AeroSloshError, match=r"slosh_vof\.fmu"):
        find_fmus(flutter_fmus, "vof")
    case = cases.load(CASE)
    with pytest.raises(AeroSloshError, match="no Real output liquid_mass"):
        fuel_tank.Tank(case.slosh, {"slosh_ems": doubles / "link.fmu"})


def test_settings_reach_the_models_that_have_them(flutter_fmus: Path) -> None:
    case = cases.load(CASE, ["slosh.modes=5", "slosh.cells_x=64"])
    component = Component(flutter_fmus / "slosh_ems.fmu", "slosh")
    found = fuel_tank.parameters(case.slosh, component.variables)
    component.close()
    assert found["modes"] == 5 and found["tank_x"] == 1.8
    assert not {"cells_x", "model", "split", "parametric", "surface_tension"} & set(found)
