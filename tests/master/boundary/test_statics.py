"""Static divergence, marches that go on, apparent mass, V–g curves: on the thin-airfoil double, where all of it is known."""

from __future__ import annotations

import csv
import dataclasses
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.analysis.verdict import Verdict
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.boundary import modes as boundary_modes
from aeroslosh.master.boundary import solve
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import apparent_mass, span
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.results import summary
from support import sections, theory

DIVERGING = (0.4, -0.1, 0.25, 0.5, 20.0)  # axis, x_alpha, r2, frequency ratio, mass ratio


@pytest.fixture(scope="module")
def fmus(flutter_fmus: Path) -> dict[str, Path]:
    return find_fmus(flutter_fmus, "ems")


def test_steady_slopes_and_divergence_are_the_thin_airfoil_s(fmus: dict[str, Path]) -> None:
    case = sections.named(*DIVERGING)
    with FlutterSetup(case, fmus, 0.3) as setup:
        slopes = setup.slopes()
        assert slopes is not None
        assert pytest.approx(2.0 * np.pi, rel=1e-9) == slopes.C_L
        assert pytest.approx(0.3 * np.pi, rel=1e-9) == slopes.C_M  # pi (a + 1/2), a = -0.2
        assert setup.divergence() == pytest.approx(theory.divergence(case), rel=1e-9) == pytest.approx(0.6455, rel=1e-4)
        assert setup.stiffness(setup.divergence()) == pytest.approx(0.0, abs=1e-9)
    case.section.elastic_axis = 0.2
    with FlutterSetup(case, fmus, 0.3) as setup:
        assert setup.divergence() == np.inf and setup.stiffness(3.0) > 1.0


def test_liquid_at_rest_takes_or_gives_stiffness(fmus: dict[str, Path]) -> None:
    """Fuel above the axis topples: the section diverges earlier, and earlier still when the surface stays level."""
    case = sections.named(*DIVERGING)
    s = case.slosh
    s.tank_length, s.tank_height, s.fill_level, s.tank_y, s.liquid_density = 0.5, 0.15, 0.5, 0.05, 800.0
    found = []
    for model in ("none", "frozen", "ems"):
        s.model = model
        with FlutterSetup(case, fmus, 0.3) as setup:
            found.append(setup.divergence())
    dry, frozen, level = found
    assert abs(frozen / dry - 1.0) < 0.01 and level < frozen
    q = 0.5 * 101325.0 / (287.05 * 288.15) * (0.3 * np.sqrt(1.4 * 287.05 * 288.15)) ** 2
    taken = 800.0 * 9.81 * 0.5**3 / 12.0 / q  # of the surface, as C_M
    expected = frozen / np.sqrt(1.0 + taken / (0.3 * np.pi) * (frozen / dry) ** 2)
    assert level == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(("factor", "verdict"), [(0.9, Verdict.DAMPED), (1.0, Verdict.NEUTRAL), (1.05, Verdict.DIVERGENCE)])
def test_point_about_divergence(fmus: dict[str, Path], factor: float, verdict: Verdict) -> None:
    case = sections.named(*DIVERGING)
    V_f = factor * theory.divergence(case)
    with FlutterSetup(case, fmus, 0.3) as setup:
        march = flutter_march.march(setup, V_f)
    assert march.verdict is verdict, march.reason
    data = summary.march_data(march)
    if verdict is Verdict.DIVERGENCE:
        exact = theory.spectrum(case, 0.3, V_f)[0]
        assert exact.imag == 0.0 and data["growth_rate"] == pytest.approx(exact.real, rel=0.02)
        assert data["frequency"] == 0.0 and data["damping_ratio"] is None
        assert "0 (static)" in summary.march_summary(data)
    assert data["static_stiffness"] == pytest.approx(1.0 - factor**2, abs=1e-9)


@pytest.mark.parametrize("method", ["both", "march", "linear"])
def test_boundary_names_divergence_whatever_the_method(fmus: dict[str, Path], method: str) -> None:
    case = sections.named(*DIVERGING)
    case.boundary.mach, case.boundary.method, case.boundary.V_f_range = [0.3], method, [0.2, 0.9]
    [point] = solve.solve(case, fmus, lambda text: None)
    static = [c for c in point.crossings if c.kind == "divergence"]
    assert len(static) == 1 and static[0].V_f == pytest.approx(theory.divergence(case), rel=5e-3)
    assert static[0].frequency == 0.0 and "divergence at V_f" in point.outcome
    assert point.divergence == pytest.approx(theory.divergence(case), rel=1e-6)
    data = summary.point_data(point)
    assert data["kind"] == "divergence" and data["static_divergence_V_f"] == pytest.approx(0.6455, rel=1e-4)
    assert "statics: divergence at V_f = 0.645" in summary.boundary_summary([data | {"slosh": "none"}])


def test_vg_table_has_every_mode_and_the_marches(fmus: dict[str, Path], tmp_path: Path) -> None:
    case = sections.named(0.35, 0.25, 0.75, 1.0, 75.0)
    case.boundary.mach = [0.3]
    [point] = solve.solve(case, fmus, lambda text: None)
    assert point.linear is not None
    boundary_modes.write(point, 0.1, 1.0, tmp_path / "modes.csv")
    with (tmp_path / "modes.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for V_f in (0.2, 0.4, 0.6):
        for exact in theory.eigenvalues(case, 0.3, V_f)[:2]:
            near = [r for r in rows if r["source"] == "linear" and abs(float(r["V_f"]) / V_f - 1.0) < 0.02]
            away = min(abs(complex(float(r["growth_rate"]), float(r["frequency"])) - exact) for r in near)
            assert away < 0.02  # the table's steps of V_f
    marched = [r for r in rows if r["source"] == "march"]
    assert len(marched) >= 2 * len(point.marches)
    assert all(float(r["damping"]) == pytest.approx(2 * float(r["growth_rate"]) / float(r["frequency"])) for r in marched)
    assert len(boundary_modes.as_data(point.linear, 0.1, 1.0)) >= 2


def test_a_march_goes_on_until_its_verdict_is_settled_and_no_further(fmus: dict[str, Path]) -> None:
    """A slow plunge mode: five periods of pitch show half a period of it."""
    case = sections.named(0.35, 0.1, 0.4, 0.1, 60.0)
    case.flutter.free_cycles = 3.0
    with FlutterSetup(case, fmus, 0.3) as setup:
        march = flutter_march.march(setup, 0.3)
        case.flutter.max_free_cycles = 4.0
        short = flutter_march.march(setup, 0.3)
    cycles = (march.tau.size - 1 - march.release) / march.scales.steps_per_cycle
    assert 1.25 / span.slower_frequency(case) <= cycles <= 40.0 and march.settled
    assert march.verdict is Verdict.DAMPED
    assert short.verdict is Verdict.UNDETERMINED and not short.settled and "flutter.max_free_cycles" in short.remedy
    assert (short.history["alpha"] == march.history["alpha"][: short.tau.size]).all()  # going on changes nothing of what was


def test_apparent_mass_couples_implicitly_unless_the_case_chooses(fmus: dict[str, Path]) -> None:
    case = sections.named(0.32, -0.19, 0.11, 1.79, 5.0)
    assert apparent_mass.ratio(case, 0.3) > apparent_mass.STABLE[1]
    with FlutterSetup(case, fmus, 0.3) as setup:
        march = flutter_march.march(setup, 0.15)
    assert march.verdict is Verdict.DAMPED and "coupled implicitly" in march.note
    exact = theory.eigenvalues(case, 0.3, 0.15)[0]
    assert march.fit is not None and march.fit.growth_rate == pytest.approx(exact.real, abs=2e-3)
    case.given.add("coupling.scheme")
    with FlutterSetup(case, fmus, 0.3) as setup, pytest.raises(AeroSloshError, match="diverges"):
        flutter_march.march(setup, 0.15)


def test_ordinary_sections_keep_their_scheme_and_extrapolate_loads_by_a_parabola() -> None:
    assert apparent_mass.coupling(Case(), 0.8) == (dataclasses.replace(Case().coupling, predictor_order=2), "")
    chosen = Case()
    chosen.coupling.predictor_order = 1
    assert apparent_mass.coupling(chosen, 0.8) == (chosen.coupling, "")


def test_a_parabola_at_the_default_step_is_as_good_as_many_steps(fmus: dict[str, Path]) -> None:
    """Growth rates of a line, a parabola and implicit coupling against the exact eigenvalues of the thin-airfoil double."""
    case = sections.named(0.35, 0.2, 0.4, 0.6, 40.0)
    exact = theory.eigenvalues(case, 0.3, 0.6)[0].real
    errors = {}
    for order in (1, 2):
        case.coupling.predictor_order = order
        with FlutterSetup(case, fmus, 0.3) as setup:
            march = flutter_march.march(setup, 0.6)
        assert march.fit is not None
        errors[order] = abs(march.fit.growth_rate - exact)
    assert errors[2] < 0.25 * errors[1], errors
