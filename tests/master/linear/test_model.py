"""The linear model of the thin-airfoil double: its eigenvalues and neutral V_f are known exactly."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.boundary import strategy as boundary_strategy
from aeroslosh.master.boundary.search import BoundaryPoint
from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.flutter.span import PERIODS, Span, slower_frequency
from aeroslosh.master.linear import model as linear_model
from aeroslosh.master.linear import rational_fit
from aeroslosh.master.linear.frequency_sweep import NODES, Record, chirp
from support import sections, theory
from support.paths import CASES
from support.processes import called

MACH = 0.3
CASE = CASES / "isogai_a.toml"


@pytest.fixture(scope="module")
def model(flutter_fmus: Path) -> linear_model.LinearModel:
    with FlutterSetup(Case(), find_fmus(flutter_fmus), MACH) as setup:
        return linear_model.identify(setup, 1.0)


def test_it_predicts_a_motion_it_was_not_fitted_to(model: linear_model.LinearModel) -> None:
    assert model.fit_error.max() < 5e-4 and model.check_error.max() < 5e-4
    assert model.note == ""


@pytest.mark.parametrize("V_f", [0.6, 1.0, 1.5, 2.4, 2.8])
def test_eigenvalues(model: linear_model.LinearModel, V_f: float) -> None:
    exact = theory.eigenvalues(model.case, MACH, V_f)
    ours = model.eigenvalues(V_f)
    for value in exact[:2]:
        if value.imag / (V_f * np.sqrt(60.0)) < linear_model.BAND:  # what was swept
            assert np.min(np.abs(ours - value)) < 1e-3 * abs(value)


def test_neutral_V_f(model: linear_model.LinearModel) -> None:
    expected = theory.neutral(model.case, MACH, 1.5, 3.0)
    [found] = model.crossings(0.5, 3.0)
    assert found.V_f == pytest.approx(expected, rel=1e-3)
    assert found.frequency == pytest.approx(theory.eigenvalues(model.case, MACH, expected)[0].imag, rel=1e-3)
    rates = [theory.eigenvalues(model.case, MACH, expected + d)[0].real for d in (-1e-3, 1e-3)]
    slope = (rates[1] - rates[0]) / 2e-3
    assert found.direction == "onset" and found.slope == pytest.approx(slope, rel=0.05)
    assert found.uncertainty < 2e-3 * expected


def test_it_predicts_how_long_a_march_must_be(flutter_fmus: Path) -> None:
    """Two close modes part within half a beat; the first look at a march is not before."""
    case = sections.named(0.35, 0.1, 0.25, 0.95, 300.0)
    fmus, V_f = find_fmus(flutter_fmus), 0.1
    with FlutterSetup(case, fmus, MACH) as setup:
        found = linear_model.identify(setup, 1.0)
        first, second = theory.eigenvalues(case, MACH, V_f)[:2]
        beat = np.pi / abs(first.imag - second.imag) / (2.0 * np.pi)
        assert found.cycles(V_f) == pytest.approx(beat, rel=0.02) and beat > 1.5
        case.flutter.free_cycles, case.flutter.max_free_cycles = 1.5, 40.0
        alone = Span.of(case, scales(case, MACH, V_f))
        setup.needed_cycles = found.cycles
        led = Span.of(case, scales(case, MACH, V_f), setup.needed_cycles(V_f))
        cycles = (led.planned - led.release) / scales(case, MACH, V_f).steps_per_cycle
        assert cycles == pytest.approx(beat, abs=0.03) and led.planned > alone.planned and led.most == alone.most
        march = flutter_march.march(setup, V_f)
    assert march.tau.size - 1 >= led.planned and march.settled


@pytest.mark.parametrize(("enough", "cycles"), [(0.5, "least"), (3.0, 3.0), (9.0, 5.0), (float("inf"), 5.0)])
def test_a_march_made_for_one_mode_is_as_long_as_that_needs(enough: float, cycles: float | str) -> None:
    """Never shorter than what shows the slower natural mode, never longer than the case says; what parts modes comes first."""
    case = Case()
    s = scales(case, MACH, 1.0)
    span, whole = Span.of(case, s, 0.0, enough), Span.of(case, s)
    wanted = span.least if cycles == "least" else span.release + round(float(cycles) * s.steps_per_cycle)
    assert abs(span.planned - wanted) <= 1 and span.most == whole.most
    assert Span.of(case, s, 4.0, enough).planned == max(span.planned, span.release + 4 * s.steps_per_cycle)


def test_both_inputs_have_the_same_steady_gain_that_of_the_thin_airfoil(model: linear_model.LinearModel) -> None:
    gain = model.aero.response(np.array([0.0]))[0]
    assert gain[:, 0] == pytest.approx(gain[:, 1], rel=1e-3)
    assert gain[0].real == pytest.approx(2.0 * np.pi, rel=0.01)


def test_a_face_without_motion_inputs_is_refused(flutter_fmus: Path) -> None:
    with FlutterSetup(Case(), find_fmus(flutter_fmus), MACH) as setup:
        del setup.aero.input_index["h_ddot"]
        with pytest.raises(AeroSloshError, match="no Real input h_ddot"):
            linear_model.identify(setup, 1.0)


def run(fmus: Path, out: Path, *arguments: str) -> tuple[int, dict]:
    words = ("boundary", CASE, *arguments, "--json", "--out", out)
    done = called(*words, AEROSLOSH_FMUS=str(fmus))
    assert done.stdout, done.stderr
    return done.returncode, json.loads(done.stdout)


def test_command_linear(flutter_fmus: Path, tmp_path: Path, model: linear_model.LinearModel) -> None:
    code, data = run(flutter_fmus, tmp_path / "run", "--mach", "0.3", "0.35", "--method", "linear")
    assert code == 0
    for point in data["points"]:
        expected = theory.neutral(model.case, point["mach"], 1.5, 3.0)
        [crossing] = point["crossings"]
        assert crossing["V_f"] == pytest.approx(expected, rel=1e-3) and crossing["source"] == "linear"
        assert point["converged"] and not point["marches"]
        assert point["linear"]["crossings"][0]["state"] == "not marched"
        assert max(point["linear"]["check_error"]) < 1e-3
    assert (tmp_path / "run" / "boundary.png").is_file()


def test_command_both_with_uncertainty(flutter_fmus: Path, tmp_path: Path, model: linear_model.LinearModel) -> None:
    """Three marches confirm the linear value; half the step, half the amplitude and a coarser mesh go into the error bar."""
    settings = ("--set", "flutter.steps_per_cycle=200", "--set", "coupling.scheme=implicit")
    code, data = run(flutter_fmus, tmp_path / "run", "--mach", "0.3", "--method", "both", "--uncertainty", *settings)
    assert code == 0
    [point] = data["points"]
    [crossing], [predicted] = point["crossings"], point["linear"]["crossings"]
    assert crossing["V_f"] == pytest.approx(theory.neutral(model.case, MACH, 1.5, 3.0), rel=1e-3)
    assert crossing["source"] == "march" and len(point["marches"]) <= 3
    assert predicted["state"] == "confirmed" and predicted["marched_V_f"] == crossing["V_f"]
    assert set(crossing["uncertainty_parts"]) == {"fit", "interpolation", "step", "amplitude", "mesh"}
    assert abs(crossing["uncertainty_parts"]["amplitude"]) < 1e-3
    assert abs(crossing["uncertainty_parts"]["mesh"]) < 1e-9  # the double has none
    assert crossing["V_f_uncertainty"] < 5e-3 * crossing["V_f"]


def test_a_failing_component_with_the_linear_model_alone(flutter_fmus: Path, tmp_path: Path) -> None:
    code, data = run(flutter_fmus, tmp_path / "run", "--mach", "0.3", "--method", "linear", "--set", "flow.airfoil=FAIL 20")
    assert code == 3
    assert data["points"][0]["outcome"].startswith("no linear model: Component 'aero' failed")


def test_an_answer_that_is_no_number_leaves_the_marches(flutter_fmus: Path, tmp_path: Path) -> None:
    code, data = run(flutter_fmus, tmp_path / "run", "--mach", "0.3", "--method", "linear", "--set", "flow.airfoil=NAN 20")
    assert code == 4
    assert "not a number in step 20" in data["points"][0]["outcome"]


def confirmed(
    fmus: Path, model: linear_model.LinearModel, monkeypatch: pytest.MonkeyPatch, high: float = 3.0
) -> tuple[BoundaryPoint, list[str]]:
    """What marches of the Isogai section make of `model`, whatever section it is of."""
    case, said = Case(), []
    case.boundary.V_f_range, case.boundary.companion = [0.5, high], False
    monkeypatch.setattr(linear_model, "identify", lambda *_: model)
    with FlutterSetup(case, find_fmus(fmus), MACH) as setup:
        strategy = boundary_strategy.Confirm(case, lambda mach: setup, lambda case, mach: setup, said.append, marching=True)
        return strategy(lambda V_f: flutter_march.march(setup, V_f), MACH, 1.0, 0.05), said


def test_a_prediction_that_holds_takes_one_march_as_long_as_its_mode_needs(
    flutter_fmus: Path, model: linear_model.LinearModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    point, _ = confirmed(flutter_fmus, model, monkeypatch)
    exact, [crossing], [march] = theory.neutral(model.case, MACH, 1.5, 3.0), point.crossings, point.marches
    assert point.converged and not crossing.bracketed and crossing.direction == "onset"
    assert crossing.V_f == pytest.approx(exact, rel=1e-3)  # the march's step
    cycles = (march.tau.size - 1 - march.release) / march.scales.steps_per_cycle
    assert cycles == pytest.approx(
        max(boundary_strategy.OWN_PERIODS / crossing.frequency, PERIODS / slower_frequency(Case())), rel=0.01
    )
    assert cycles < 5.0 and march.fit is not None


def test_a_prediction_that_is_ten_percent_off_is_put_right(
    flutter_fmus: Path, model: linear_model.LinearModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    section = replace(model.case.section, x_alpha=1.75)
    wrong = replace(model, case=replace(model.case, section=section))
    point, _ = confirmed(flutter_fmus, wrong, monkeypatch)
    exact = theory.neutral(model.case, MACH, 1.5, 3.0)
    [prediction] = point.predictions
    assert abs(prediction.crossing.V_f / exact - 1.0) > 0.02
    assert prediction.state == "confirmed" and point.converged
    assert point.crossings[0].V_f == pytest.approx(exact, rel=3e-3)


def test_a_prediction_that_marches_contradict_is_recorded(
    flutter_fmus: Path, model: linear_model.LinearModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A model whose aerodynamics are three times too strong predicts an onset far below the true one."""
    strong = replace(
        model, aero=replace(model.aero, residues=3.0 * model.aero.residues, feedthrough=3.0 * model.aero.feedthrough)
    )
    point, _ = confirmed(flutter_fmus, strong, monkeypatch)
    assert {p.state for p in point.predictions} == {"contradicted"}
    assert not point.crossings and not point.converged
    assert "not confirmed" in point.outcome and "(sweeps of 1°)" in point.outcome


def test_no_crossing_predicted_is_checked_by_marches(
    flutter_fmus: Path, model: linear_model.LinearModel, monkeypatch: pytest.MonkeyPatch
) -> None:
    point, said = confirmed(flutter_fmus, model, monkeypatch, high=2.0)
    assert point.converged and not point.crossings and 3 <= len(point.marches) <= 5
    assert point.outcome.startswith("no crossing: damped") and "no crossing in range; marches at" in said[-1]


def test_slopes_of_the_fit_are_those_of_its_basis() -> None:
    """What a pole's change does to the fitted loads, beside differences; through the fit itself too, which is found again."""
    rng = np.random.default_rng(5)
    s = 0.4 * np.arange(301)
    curves = rational_fit_motions(s)
    poles = np.array([-0.05, -0.3 + 0.2j, -0.9])
    made = [Record(s, motion, rng.standard_normal((2, s.size)), between) for motion, between in curves]
    weight, steady = np.array([0.7, 2.0]), np.array([6.0, 0.4])
    matrix = rational_fit._matrix(made, poles, weight, steady)
    weights = rng.standard_normal((matrix.shape[1], 2))
    for n, by in ((0, 1.0), (1, 1.0), (1, 1j), (2, 1.0)):
        ahead, back = poles.copy(), poles.copy()
        ahead[n] += 1e-6 * by
        back[n] -= 1e-6 * by
        found = rational_fit._change(made, poles, n, by, weights, steady)
        change = rational_fit._matrix(made, ahead, weight, steady) - rational_fit._matrix(made, back, weight, steady)
        np.testing.assert_allclose(found, change @ weights / 2e-6, rtol=2e-6, atol=1e-7)
    weights[6], weights[9:] = weights[0], weights[2:6]  # both inputs with the same steady gain, as a fit expects
    truth = matrix @ weights
    loads = np.split(truth[: 2 * s.size] * np.sqrt(s.size), 2)
    exact = [Record(s, r.motion, y.T / weight[:, None], r.between) for r, y in zip(made, loads, strict=True)]
    again = rational_fit.fit(exact, 4, 0.02, 2.0)
    assert max(float(np.max(again.error(r))) for r in exact) < 1e-6
    beside = rational_fit.with_poles(exact, poles)
    assert max(float(np.max(beside.error(r))) for r in exact) < 1e-9 and np.array_equal(beside.poles, poles)


def rational_fit_motions(s: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """Motion (2, 4, n) and values between the samples of a plunge and of a pitch sweep."""
    sweep = chirp(0.02, 0.0, 100.0, (0.02, 1.0), 0.8)
    inner = np.stack([sweep(s[:-1] + node * 0.4)[1] for node in NODES])
    moved, rest, quiet = sweep(s), np.zeros((4, s.size)), np.zeros_like(inner)
    return [(np.stack([moved, rest]), np.stack([inner, quiet])), (np.stack([rest, moved]), np.stack([quiet, inner]))]
