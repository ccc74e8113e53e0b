"""The flutter protocol and the boundary on section + thin airfoil, whose eigenvalues are the reference."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.analysis.verdict import Verdict
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.boundary.search import Limits, boundary, search
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from support import theory

MACH = 0.3


def make_case(**values: object) -> Case:
    case = Case()
    case.flow.mach = MACH
    case.coupling.scheme = "implicit"
    for name, value in values.items():
        table, key = name.split("__")
        setattr(getattr(case, table), key, value)
    return case


@pytest.fixture(scope="module")
def fmus(flutter_fmus: Path) -> dict[str, Path]:
    return find_fmus(flutter_fmus)


@pytest.mark.parametrize(("V_f", "verdict"), [(0.6, Verdict.DAMPED), (1.0, Verdict.DAMPED), (2.4, Verdict.FLUTTER)])
def test_growth_rate_and_frequency_are_the_eigenvalue(fmus: dict[str, Path], V_f: float, verdict: Verdict) -> None:
    """Richardson on two steps removes the coupling's second-order error: what remains is the damping fit."""
    case = make_case()
    expected = theory.eigenvalues(case, MACH, V_f)[0]
    found = []
    with FlutterSetup(case, fmus, MACH) as setup:
        for steps in (200, 400):
            case.flutter.steps_per_cycle = steps
            march = flutter_march.march(setup, V_f)
            assert march.fit is not None
            assert march.verdict is verdict, march.reason
            found.append(complex(march.fit.growth_rate, march.fit.frequency))
    assert abs(found[1] - expected) < 2e-3
    assert abs((4.0 * found[1] - found[0]) / 3.0 - expected) < 5e-5


@pytest.mark.parametrize(("scheme", "limit"), [("gauss-seidel", 1.5e-3), ("implicit", 1.5e-4)])
def test_default_step_is_accurate_enough(fmus: dict[str, Path], scheme: str, limit: float) -> None:
    case = make_case(coupling__scheme=scheme)
    expected = theory.eigenvalues(case, MACH, 0.6)[0]
    with FlutterSetup(case, fmus, MACH) as setup:
        fit = flutter_march.march(setup, 0.6).fit
    assert fit is not None
    assert abs(complex(fit.growth_rate, fit.frequency) - expected) < limit


def test_gauss_seidel_growth_rate_is_second_order(fmus: dict[str, Path]) -> None:
    case = make_case(coupling__scheme="gauss-seidel", coupling__predictor_order=1)
    expected = theory.eigenvalues(case, MACH, 0.6)[0]
    errors = []
    with FlutterSetup(case, fmus, MACH) as setup:
        for steps in (48, 96, 192):
            case.flutter.steps_per_cycle = steps
            fit = flutter_march.march(setup, 0.6).fit
            assert fit is not None
            errors.append(abs(complex(fit.growth_rate, fit.frequency) - expected))
    assert errors[0] / errors[1] == pytest.approx(4.0, abs=0.3)
    assert errors[1] / errors[2] == pytest.approx(4.0, abs=0.3)


def test_marches_repeat_to_the_last_bit_after_a_rewind(fmus: dict[str, Path]) -> None:
    case = make_case(coupling__scheme="gauss-seidel")
    with FlutterSetup(case, fmus, MACH) as setup:
        first, other, again = (flutter_march.march(setup, V_f) for V_f in (0.6, 1.5, 0.6))
    assert (first.history["alpha"] == again.history["alpha"]).all()
    assert (first.history["lift"] == again.history["lift"]).all()
    assert other.history["alpha"].size != first.history["alpha"].size


def test_steady_load_at_incidence_is_trimmed_out(fmus: dict[str, Path]) -> None:
    """With mean incidence the linear section's motion is the same; its lift is not."""
    marches = []
    for degrees in (0.0, 2.0):
        case = make_case(flow__mean_alpha_deg=degrees, coupling__scheme="gauss-seidel")
        with FlutterSetup(case, fmus, MACH) as setup:
            marches.append(flutter_march.march(setup, 0.6))
    level, raised = (m.history for m in marches)
    assert np.max(np.abs(level["alpha"] - raised["alpha"])) < 1e-9
    assert raised["C_L"][0] == pytest.approx(2.0 * np.pi * np.radians(2.0), rel=1e-9)


def test_free_start_by_an_initial_rate(fmus: dict[str, Path]) -> None:
    case = make_case(flutter__forced_cycles=0.0, flutter__initial_alpha_dot=0.01, flutter__steps_per_cycle=200)
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    assert march.release == 0
    assert march.history["alpha_dot"][0] == pytest.approx(0.01 * march.scales.omega_alpha)
    assert march.fit is not None
    assert march.fit.growth_rate == pytest.approx(theory.eigenvalues(case, MACH, 0.6)[0].real, abs=2e-4)


def test_neutral_V_f_is_the_eigenvalue_s(fmus: dict[str, Path]) -> None:
    case = make_case(flutter__steps_per_cycle=300)
    expected = theory.neutral(case, MACH, 1.5, 3.0)
    assert expected == pytest.approx(2.373, rel=0.01)  # Theodorsen's function; ours is Jones's approximation of it
    with FlutterSetup(case, fmus, MACH) as setup:
        point = search(lambda V_f: flutter_march.march(setup, V_f), MACH, 2.2, Limits(0.5, 3.0, 0.005, 12))
    assert point.converged and len(point.crossings) == 1
    found = point.crossings[0]
    assert found.V_f == pytest.approx(expected, rel=1e-3)
    assert found.frequency == pytest.approx(theory.eigenvalues(case, MACH, expected)[0].imag, rel=2e-3)
    assert found.direction == "onset" and found.bracketed
    assert len(point.marches) <= 5


def test_boundary_hands_the_guess_on(fmus: dict[str, Path]) -> None:
    """The second Mach number starts at the first one's result and needs fewer marches; a closed setup is no harm."""
    case = make_case(coupling__scheme="gauss-seidel")

    def marcher_at(mach: float) -> tuple[object, object]:
        setup = FlutterSetup(case, fmus, mach)
        return (lambda V_f: flutter_march.march(setup, V_f)), setup.close

    points = boundary(marcher_at, [0.3, 0.32], 2.0, Limits(0.5, 3.0, 0.005, 12))  # type: ignore[arg-type]
    assert [p.converged for p in points] == [True, True]
    assert len(points[1].marches) <= len(points[0].marches)
    assert points[1].crossings[0].V_f == pytest.approx(points[0].crossings[0].V_f, rel=5e-3)


def test_no_crossing_in_range_is_an_outcome(fmus: dict[str, Path]) -> None:
    case = make_case(coupling__scheme="gauss-seidel")
    with FlutterSetup(case, fmus, MACH) as setup:
        point = search(lambda V_f: flutter_march.march(setup, V_f), MACH, 0.6, Limits(0.5, 0.8, 0.005, 12))
    assert not point.converged and not point.crossings
    assert point.outcome.startswith("no crossing in range: damped")


def test_a_failure_mid_march_keeps_the_history(fmus: dict[str, Path]) -> None:
    case = make_case(flow__airfoil="FAIL 60", coupling__scheme="gauss-seidel")
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    assert march.failure is not None and "told to fail" in march.failure.what
    assert march.verdict is Verdict.UNDETERMINED
    assert march.tau.size == 60 and np.isfinite(march.history["alpha"]).all()


def test_a_late_failure_still_gives_the_growth_rate(fmus: dict[str, Path]) -> None:
    case = make_case(flow__airfoil="FAIL 300", coupling__scheme="gauss-seidel")
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    assert march.failure is not None
    assert march.fit is not None and march.verdict is Verdict.DAMPED


def test_not_a_number_is_an_outcome(fmus: dict[str, Path]) -> None:
    case = make_case(flow__airfoil="NAN 60", coupling__scheme="gauss-seidel")
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    assert "aero.lift is not a finite number at step 60" in march.stopped and "smaller step" in march.remedy
    assert march.verdict is Verdict.UNDETERMINED
    assert np.isfinite(march.history["alpha"]).all()


def test_amplitude_limit_gives_a_limit_cycle(fmus: dict[str, Path]) -> None:
    """A cubic restoring moment limits growth at V_f 2.6."""
    case = make_case(flow__airfoil="CUBIC 40", flutter__free_cycles=8.0, coupling__predictor_order=2)
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 2.6)
    assert march.verdict is Verdict.LIMIT_CYCLE, march.reason


def test_growth_past_the_largest_angle_stops_and_is_flutter(fmus: dict[str, Path]) -> None:
    case = make_case(flutter__max_alpha_deg=3.0)
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, 2.6)
    assert "max_alpha_deg" in march.stopped
    assert march.verdict is Verdict.FLUTTER, march.reason


def test_an_unconverged_start_is_refused(fmus: dict[str, Path]) -> None:
    with pytest.raises(AeroSloshError, match="did not converge"):
        FlutterSetup(make_case(flow__airfoil="UNSTEADY"), fmus, MACH)


def test_missing_fmus_name_the_remedy(tmp_path: Path) -> None:
    with pytest.raises(AeroSloshError, match="make fmus"):
        find_fmus(tmp_path)


class _Seen:
    """In place of `Fields`: the steps at which fields are asked for."""

    def __init__(self, aero: object, folder: Path | None) -> None:
        self.wanted, self.steps = True, [0]
        _Seen.last = self

    last: _Seen

    def again(self, steps: Iterable[int]) -> None:
        self.steps = list(steps)

    def before(self, step: int) -> None:
        assert step < min(self.steps, default=step + 1) or step <= max(self.steps)

    def end(self, done: int, failed: bool) -> list[tuple[int, Path]]:
        return []


@pytest.mark.parametrize("V_f", [0.6, 2.0])
def test_flow_fields_lie_a_quarter_of_the_mode_s_own_period_apart(
    fmus: dict[str, Path], V_f: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = make_case(flutter__steps_per_cycle=200, flutter__free_cycles=6.0)
    with FlutterSetup(case, fmus, MACH) as setup:
        plain = flutter_march.march(setup, V_f)
        monkeypatch.setattr(flutter_march, "Fields", _Seen)
        watched = flutter_march.march(setup, V_f)
    assert plain.fit is not None and watched.fit is not None
    np.testing.assert_array_equal(plain.history["alpha"], watched.history["alpha"])  # what is looked at stays as it is
    steps = _Seen.last.steps
    assert steps[-1] == plain.tau.size - 1
    quarter = 0.25 * 200 / plain.fit.frequency
    assert np.diff(steps) == pytest.approx([quarter] * 3, abs=1.0 + 0.02 * quarter)
    assert abs(plain.fit.frequency - 1.0) > 0.05  # else nothing was shown
