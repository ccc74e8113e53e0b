"""Steady flows against exact results, marches against themselves: symmetry, rollback, order, failure."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.aero import march
from aeroslosh.fmus.aero.control import MarchError, Settings
from aeroslosh.fmus.aero.field import Motion
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import Mesh, o_mesh


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return o_mesh("64A010", 96, 32, 25.0)


@pytest.fixture(scope="module")
def transonic(mesh: Mesh) -> Flow:
    flow = Flow(mesh, 0.8, 0.25)
    assert flow.solve_steady(0.0).converged
    return flow


def test_lift_at_low_speed_is_that_of_the_exact_map(mesh: Mesh) -> None:
    alpha, mach = np.radians(2.0), 0.2
    flow = Flow(mesh, mach, 0.25)
    flow.solve_steady(alpha)
    exact = mesh.circle.lift_coefficient(alpha) / np.sqrt(1 - mach**2)
    assert flow.coefficients.lift == pytest.approx(exact, rel=0.006)
    # the centre of pressure of a 10 percent section is near the quarter chord, no drag without shocks
    assert abs(flow.coefficients.moment) < 0.02 * exact
    assert abs(flow.coefficients.drag) < 1e-3


def test_symmetric_section_at_no_incidence_has_no_lift_but_wave_drag(transonic: Flow) -> None:
    lift, drag, moment = transonic.coefficients
    assert abs(lift) < 1e-4
    assert abs(moment) < 1e-4
    assert 5e-4 < drag < 3e-3


def test_steady_flow_stays_steady_in_a_march(transonic: Flow) -> None:
    transonic.solve_steady(0.0)
    before = transonic.coefficients
    for _ in range(5):
        assert transonic.step(Motion(), 0.0, 0.3).retries == 0
    assert np.abs(np.subtract(transonic.coefficients, before)).max() < 2e-5


def pitching(flow: Flow, steps: int, start: int = 0, dt: float = 0.3) -> list[tuple[float, ...]]:
    """Coefficients of a pitch oscillation of one degree, each step."""
    omega = 0.32
    result = []
    for k in range(start + 1, start + steps + 1):
        t = k * dt
        a = np.radians(1.0) * np.array([1 - np.cos(omega * t), omega * np.sin(omega * t), omega**2 * np.cos(omega * t)])
        flow.step(Motion(alpha=a[0], alpha_dot=a[1], alpha_ddot=a[2]), float(a[0]), dt)
        result.append(tuple(float(v) for v in flow.coefficients))
    return result


def test_single_precision_moves_loads_less_than_subiterations_do(mesh: Mesh, monkeypatch: pytest.MonkeyPatch) -> None:
    """The accuracy gate of fluxes in single precision: a motion of a degree, against the same in double precision, both with the
    default tolerance, which leaves more."""
    kinds: list[type] = []
    evaluate, default = Flow.evaluate, march.SINGLE

    def noted(self: Flow, kind: type = np.float64) -> None:
        kinds.append(kind)
        evaluate(self, kind)

    monkeypatch.setattr(Flow, "evaluate", noted)

    def loads(threshold: float, tolerance: float) -> np.ndarray:
        monkeypatch.setattr(march, "SINGLE", threshold)
        flow = Flow(mesh, 0.8, 0.25, Settings(tolerance=tolerance))
        flow.solve_steady(0.0)
        kinds.clear()
        return np.array(pitching(flow, 60))[20:, [0, 2]]

    double, tight = loads(np.inf, 1e-2), loads(np.inf, 1e-4)
    assert set(kinds) == {np.float64}
    single = loads(default, 1e-2)
    assert kinds.count(np.float32) > 0.9 * len(kinds)
    scale = double.std(axis=0)
    lost, left = (single - double).std(axis=0) / scale, (double - tight).std(axis=0) / scale
    assert (lost < 0.2 * left).all() and lost[0] < 2e-4, (lost, left)
    loads(default, 1e-4)  # such a tolerance is too near to the rounding
    assert kinds.count(np.float32) < 0.1 * len(kinds)


def test_rollback_repeats_to_the_last_bit_across_a_new_linearisation(mesh: Mesh) -> None:
    flow = Flow(mesh, 0.8, 0.25)
    flow.solve_steady(0.0)
    pitching(flow, 4)
    state = flow.save()
    count = flow.refactorings
    flow._refresh = True
    state_refresh = flow.save()
    first = pitching(flow, 6, start=4)
    assert flow.refactorings > count == 1
    flow.restore(state_refresh)
    assert pitching(flow, 6, start=4) == first
    # a flow that never saw this march: factors are made again from the recipe
    other = Flow(mesh, 0.8, 0.25)
    other.restore(state)
    flow.restore(state)
    assert pitching(other, 6, start=4) == pitching(flow, 6, start=4)


def test_plunge_and_pitch_give_the_same_quasi_steady_lift(mesh: Mesh) -> None:
    """Slow constant plunge rate w is an incidence w/U: the frame's velocity enters the flux with the right sign."""
    mach, alpha = 0.5, np.radians(0.5)
    pitched = Flow(mesh, mach, 0.25)
    pitched.solve_steady(alpha)
    sinking = Flow(mesh, mach, 0.25)
    sinking.solve_steady(0.0)
    h_dot = mach * np.tan(alpha)
    h = 0.0
    for k in range(200):
        share = min((k + 1) / 40, 1.0)
        h += 0.6 * h_dot * share
        sinking.step(Motion(h=h, h_dot=h_dot * share, h_ddot=h_dot / 24 if share < 1 else 0.0), 0.0, 0.6)
    assert sinking.coefficients.lift == pytest.approx(pitched.coefficients.lift, rel=0.03)


def test_impossible_step_is_an_error_with_a_remedy(transonic: Flow) -> None:
    transonic.solve_steady(0.0)
    with pytest.raises(MarchError, match=r"diverged.*Remedy"):
        transonic.step(Motion(h_dot=50.0, alpha_dot=80.0), 1.5, 0.5)


def test_march_goes_on_after_a_failed_step(transonic: Flow) -> None:
    transonic.solve_steady(0.0)
    state = transonic.save()
    with pytest.raises(MarchError):
        transonic.step(Motion(h_dot=50.0, alpha_dot=80.0), 1.5, 0.5)
    transonic.restore(state)
    assert abs(pitching(transonic, 2)[-1][0]) < 0.01


def test_steady_flow_that_is_given_too_few_iterations_says_so(mesh: Mesh) -> None:
    flow = Flow(mesh, 0.8, 0.25, Settings(steady_iterations=20))
    with pytest.raises(MarchError, match=r"Mach 0.8.*after 20 iterations.*Remedy"):
        flow.solve_steady(0.02)
