"""The damping fit on signals whose poles are known."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroslosh.master.analysis.damping import Fit, Mode, _critical, analyse
from aeroslosh.master.analysis.verdict import Verdict, describes, judge

STEPS, CYCLES = 50, 5


def tau(cycles: float = CYCLES) -> np.ndarray:
    """Samples at STEPS a period 2π."""
    return np.arange(round(STEPS * cycles) + 1) * 2.0 * np.pi / STEPS


def two_modes(t: np.ndarray, sigma: float, omega: float = 0.86, second: float = 0.04) -> np.ndarray:
    """h/b and alpha of a flutter mode and a quickly damped second one, with an offset. Shape: (2, n)."""
    quick = second * np.exp(-0.35 * t)
    grow = np.exp(sigma * t)
    alpha = grow * np.cos(omega * t + 0.3) + quick * np.cos(5.3 * t + 1.0) + 0.05
    h = 2.1 * grow * np.cos(omega * t - 1.3) + 2.1 * quick * np.cos(5.3 * t + 2.0) - 0.02
    return 0.017 * np.vstack([h, alpha])


def fitted(t: np.ndarray, y: np.ndarray) -> Fit:
    fit = analyse(t, y)
    assert fit is not None
    return fit


@pytest.mark.parametrize("sigma", [-0.05, -0.008, 0.0, 0.0015, 0.05])
def test_exact_signals_give_exact_poles(sigma: float) -> None:
    fit = fitted(tau(), two_modes(tau(), sigma))
    assert fit.growth_rate == pytest.approx(sigma, abs=1e-10)
    assert fit.frequency == pytest.approx(0.86, abs=1e-10)
    assert len(fit.modes) == 2 and fit.forecast < 1e-6


@pytest.mark.parametrize("sigma", [-0.02, 0.0015])
def test_noisy_five_cycles_recover_sigma_to_1e_5(sigma: float) -> None:
    """0.1 % noise, a second mode of 4 %: 1e-5 in the growth rate."""
    errors = []
    for seed in range(5):
        y = two_modes(tau(), sigma)
        noise = 1e-3 * 0.017 * np.random.default_rng(seed).standard_normal(y.shape)
        errors.append(fitted(tau(), y + noise).growth_rate - sigma)
    assert np.sqrt(np.mean(np.square(errors))) < 1e-5


def test_uncertainty_is_honest_over_noise_seeds() -> None:
    """Errors divided by their stated uncertainty have an rms near 1: neither boast nor fear."""
    ratios = []
    for seed in range(40):
        y = two_modes(tau(), 0.0015)
        y = y + 0.005 * 0.017 * np.random.default_rng(seed).standard_normal(y.shape)
        fit = fitted(tau(), y)
        ratios.append((fit.growth_rate - 0.0015) / fit.growth_rate_uncertainty)
    assert 0.4 < np.sqrt(np.mean(np.square(ratios))) < 1.3
    assert np.max(np.abs(ratios)) < 4.0


def test_the_wake_s_slow_decay_is_no_bias() -> None:
    """A real exponential (the wake's memory) beside the oscillations, as after every release."""
    t = tau()
    y = two_modes(t, -0.01) + 0.017 * np.outer([0.4, 0.1], np.exp(-0.21 * t))
    fit = fitted(t, y)
    assert fit.growth_rate == pytest.approx(-0.01, abs=1e-7)


def test_two_close_slow_modes_are_told_apart() -> None:
    """The flutter mode is the less damped one though it starts smaller."""
    t = tau(8)
    y = np.vstack(
        [
            np.exp(-0.03 * t) * np.cos(0.75 * t) + 0.3 * np.exp(0.01 * t) * np.cos(1.2 * t + 1.0),
            0.5 * np.exp(-0.03 * t) * np.cos(0.75 * t + 0.4) + 0.4 * np.exp(0.01 * t) * np.cos(1.2 * t),
        ]
    )
    fit = fitted(t, y)
    assert fit.growth_rate == pytest.approx(0.01, abs=1e-8)
    assert fit.frequency == pytest.approx(1.2, abs=1e-8)


def test_longer_and_finer_records_stay_cheap_and_exact() -> None:
    t = np.arange(20 * 400) * 2.0 * np.pi / 400
    fit = fitted(t, two_modes(t, 0.003))
    assert fit.growth_rate == pytest.approx(0.003, abs=1e-9)


def limited(t: np.ndarray, rate: float) -> np.ndarray:
    """An oscillation that grows at `rate` and saturates at 1 (Stuart–Landau), pitch lagging plunge."""
    a0 = 0.1
    amplitude = 1.0 / np.sqrt(1.0 + (1.0 / a0**2 - 1.0) * np.exp(-2.0 * rate * t))
    return np.vstack([amplitude * np.cos(0.9 * t), 0.6 * amplitude * np.cos(0.9 * t - 0.7)])


def said(t: np.ndarray, y: np.ndarray, stiffness: float = float("nan")) -> Verdict:
    """The verdict, which must be settled."""
    judgement = judge(t, y, analyse(t, y), 5e-4, stiffness)
    assert judgement.settled, judgement.reason
    return judgement.verdict


def test_limit_cycle_is_named_when_its_amplitude_has_settled() -> None:
    assert said(tau(25), limited(tau(25), 0.12)) is Verdict.LIMIT_CYCLE


def test_growth_that_slows_down_is_no_limit_cycle_yet() -> None:
    """Eight cycles of a growth that dies out: small motions grow, and no more is known."""
    t = tau(8)
    judgement = judge(t, limited(t, 0.12), analyse(t, limited(t, 0.12)), 5e-4)
    assert judgement.verdict in (Verdict.FLUTTER, Verdict.UNDETERMINED), judgement.reason
    if judgement.verdict is Verdict.UNDETERMINED:
        assert not judgement.settled and "cycles" in judgement.remedy


def test_limit_cycle_reached_long_ago_is_no_neutral_response() -> None:
    """Forty cycles of which the first five grow: the fit sees the cycle alone, the amplitude tells."""
    t = tau(40)
    y = limited(t, 0.2)
    assert said(t, y) is Verdict.LIMIT_CYCLE
    assert said(t, limited(t + 200.0, 0.2)) is Verdict.NEUTRAL


def beat(t: np.ndarray, first: float, second: float, ratio: float = 0.9) -> np.ndarray:
    """Two close modes of equal size at growth rates `first` (frequency 1) and `second` (frequency `ratio`)."""
    one, two = np.exp(first * t), np.exp(second * t)
    h = one * np.cos(t) + two * np.cos(ratio * t + 0.4)
    return 0.01 * np.vstack([h, 0.8 * one * np.cos(t + 0.5) - 0.7 * two * np.cos(ratio * t + 1.0)])


@pytest.mark.parametrize("cycles", [5, 8, 12])
@pytest.mark.parametrize(
    ("first", "second", "verdict"), [(-0.01, -0.05, "damped"), (0.005, -0.05, "flutter"), (-0.004, -0.005, "damped")]
)
def test_close_modes_are_no_limit_cycle_in_any_part_of_their_beat(cycles: int, first: float, second: float, verdict: str) -> None:
    """Half a beat and more: the exact answer, where a growth rate of pieces rises and falls with the beat."""
    t = tau(cycles)
    fit = analyse(t, beat(t, first, second))
    assert fit is not None and fit.growth_rate == pytest.approx(max(first, second), abs=1e-7)
    assert said(t, beat(t, first, second)) == verdict


@pytest.mark.parametrize("rate", [-0.03, 0.004, 0.06])
def test_real_poles_of_any_sign_are_seen(rate: float) -> None:
    """A slow real pole beside an oscillation: its rate to 1e-7; divergence where it grows."""
    t = tau()
    y = two_modes(t, -0.05, second=0.0) - 0.017 * np.array([[-0.02], [0.05]]) + 0.017 * np.outer([0.02, 0.3], np.exp(rate * t))
    fit = fitted(t, y)
    assert min(abs(m.growth_rate - rate) for m in fit.reals) < 1e-7
    assert said(t, y, -1.0 if rate > 0.0 else 1.0) is (Verdict.DIVERGENCE if rate > 0.0 else Verdict.DAMPED)


def test_the_steady_flow_tells_a_divergence_that_has_not_grown_yet() -> None:
    """A real pole that starts at a ten-thousandth of the motion: nothing of it is seen, and damped would be wrong."""
    t = tau()
    y = two_modes(t, -0.01) + 0.017e-4 * np.outer([0.0, 1.0], np.exp(0.01 * t))
    assert said(t, y, -0.05) is Verdict.DIVERGENCE
    assert said(t, two_modes(t, -0.01), +0.05) is Verdict.DAMPED
    assert said(t, two_modes(t, +0.01), -0.05) is Verdict.FLUTTER


def test_exponentials_that_do_not_describe_the_response_give_no_verdict() -> None:
    """A damping that falls with the amplitude (a shock's): the fit misses the last part when told from the first."""
    t = tau()
    phase = 0.9 * t + 6.0 * np.sin(0.4 * t) + 3.0 * np.sin(0.23 * t)
    y = 0.01 * np.vstack([np.cos(phase), np.sin(phase) + 0.3 * np.cos(1.7 * phase)])
    fit = fitted(t, y)
    judgement = judge(t, y, fit, 5e-4)
    assert not describes(fit) and not judgement.settled and judgement.verdict is Verdict.UNDETERMINED
    assert "flutter.max_free_cycles" in judgement.remedy


def test_harmonics_of_a_nonlinear_response_are_not_its_growth_rate() -> None:
    """Three times the frequency, three times the growth: the fundamental's rate is reported."""
    t = tau(8)
    base = np.exp(0.01 * t) * np.cos(0.9 * t)
    third = 0.03 * np.exp(0.03 * t) * np.cos(2.7 * t + 0.2)
    fit = fitted(t, 0.01 * np.vstack([base + third, 0.56 * base + np.exp(0.01 * t) * np.sin(0.9 * t)]))
    assert fit.growth_rate == pytest.approx(0.01, abs=1e-6)


def test_a_harmonic_may_grow_faster_than_twice_its_mode() -> None:
    """As of a NACA 64A204 at Mach 0.75, far above onset: a small part near twice the frequency grows at more than three times the
    rate of the motion that it is made by."""
    t = tau(4.0)
    strong = 0.01 * np.exp(0.088 * t) * np.array([np.cos(0.555 * t), 1.3 * np.cos(0.555 * t - 0.7)])
    small = 3e-6 * np.exp(0.331 * t) * np.array([np.cos(1.1156 * t), 1.7 * np.cos(1.1156 * t - 0.4)])
    fit = fitted(t, strong + small)
    assert max(m.growth_rate for m in fit.modes) == pytest.approx(0.331, abs=0.01)
    assert max(m.share for m in fit.modes if m.frequency > 1.0) > 0.02
    assert fit.growth_rate == pytest.approx(0.088, abs=1e-3) and fit.frequency == pytest.approx(0.555, abs=1e-3)
    decaying = 0.01 * np.exp(-0.02 * t) * np.array([np.cos(0.555 * t), 1.3 * np.cos(0.555 * t - 0.7)])
    assert fitted(t, decaying + small).growth_rate == pytest.approx(0.331, abs=0.01)  # nothing grows that could make it


def test_the_motion_itself_is_critical_however_badly_its_rate_is_known() -> None:
    """As of fuel that breaks between ribs: two close oscillations whose rates have large error bars make the motion, and a part
    of three percent, quickly damped and well known, is not its growth rate."""
    modes = [
        Mode(rate, frequency, np.ones(2, complex), share, std, 0.001)
        for rate, frequency, share, std in ((-0.181, 5.32, 0.03, 0.01), (-0.0227, 0.8865, 1.01, 0.06), (0.037, 0.957, 0.12, 0.08))
    ]
    assert _critical(modes, []).growth_rate == -0.0227
    known = [replace(m, growth_rate_std=0.01) for m in modes]
    assert _critical(known, []).growth_rate == 0.037
    assert _critical([modes[0], replace(modes[1], share=0.05)], []).growth_rate == -0.181  # not much more than the known one


def test_a_mode_that_outgrows_linear_motion_is_read_by_its_strongest_pole() -> None:
    """As at Mach 0.6, V_f 1.954: one mode fitted by two close growing poles, and a harmonic between their multiples."""
    t = tau(3)
    base = np.exp(0.074 * t) * np.cos(1.94 * t)
    change = 0.1 * np.exp(0.1 * t) * np.cos(1.97 * t + 1.0)
    third = 2e-3 * np.exp(0.25 * t) * np.cos(5.88 * t + 0.5)
    fit = fitted(t, 0.01 * np.vstack([base + change + third, 0.56 * base - 0.3 * change + 0.8 * third]))
    assert fit.growth_rate == pytest.approx(0.074, abs=2e-3)
    assert fit.frequency == pytest.approx(1.94, abs=2e-3)


@pytest.mark.parametrize(
    ("sigma", "verdict"),
    [(-0.01, Verdict.DAMPED), (0.0002, Verdict.NEUTRAL), (0.01, Verdict.FLUTTER), (0.08, Verdict.FLUTTER)],
)
def test_verdicts(sigma: float, verdict: Verdict) -> None:
    assert said(tau(), two_modes(tau(), sigma)) is verdict


def test_noise_alone_is_undetermined() -> None:
    y = np.random.default_rng(1).standard_normal((2, 251))
    fit = analyse(tau(), y)
    assert judge(tau(), y, fit, 5e-4).verdict is Verdict.UNDETERMINED


def test_nothing_to_fit() -> None:
    assert analyse(tau(), np.zeros((2, 251))) is None
    assert analyse(tau(), np.full((2, 251), np.nan)) is None
    assert analyse(tau()[:10], two_modes(tau(), 0.0)[:, :10]) is None
    assert judge(tau(), np.zeros((2, 251)), None, 5e-4).verdict is Verdict.UNDETERMINED


def test_fit_reproduces_curve_and_envelope() -> None:
    t, y = tau(), two_modes(tau(), -0.02)
    fit = fitted(t, y)
    inside = t >= fit.start
    assert np.max(np.abs(fit.curve(t[inside]) - y[:, inside])) < 1e-9
    assert fit.envelope(np.array([10.0]))[1, 0] == pytest.approx(0.017 * np.exp(-0.2), rel=1e-8)


def test_a_neutral_mode_beside_one_that_dies_is_no_limit_cycle() -> None:
    """The amplitude falls and settles, as in a limit cycle reached from above; two linear modes explain it."""
    t = tau(25)
    y = beat(t, 0.0, -0.08, ratio=0.8)
    assert said(t, y) is Verdict.NEUTRAL
