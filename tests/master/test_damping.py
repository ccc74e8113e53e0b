"""The damping fit on signals whose poles are known."""

from __future__ import annotations

import numpy as np
import pytest

from master.damping import Fit, analyse, local_rates
from master.verdict import Verdict, judge

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
    assert len(fit.modes) == 2


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


def test_limit_cycle_is_named() -> None:
    t = tau(8)
    y = limited(t, 0.12)
    fit = analyse(t, y)
    verdict, reason = judge(t, y, fit, 5e-4)
    assert verdict is Verdict.LIMIT_CYCLE, reason
    assert fit is not None
    rates = local_rates(t, y, fit, 3)
    assert rates[0] > 0.05 and abs(rates[-1]) < 0.02
    # one number cannot describe this response, and its uncertainty must say so
    assert fit.growth_rate_uncertainty > 1e-3


def test_limit_cycle_reached_long_ago_is_no_neutral_response() -> None:
    """Forty cycles of which the first five grow: the fit sees the cycle alone, the amplitude tells."""
    t = tau(40)
    y = limited(t, 0.2)
    verdict, reason = judge(t, y, analyse(t, y), 5e-4)
    assert verdict is Verdict.LIMIT_CYCLE, reason
    steady = limited(t + 200.0, 0.2)
    assert judge(t, steady, analyse(t, steady), 5e-4)[0] is Verdict.NEUTRAL


@pytest.mark.parametrize(
    ("sigma", "verdict"),
    [(-0.01, Verdict.DAMPED), (0.0002, Verdict.NEUTRAL), (0.01, Verdict.FLUTTER), (0.08, Verdict.FLUTTER)],
)
def test_verdicts(sigma: float, verdict: Verdict) -> None:
    y = two_modes(tau(), sigma)
    assert judge(tau(), y, analyse(tau(), y), 5e-4)[0] is verdict


def test_noise_alone_is_undetermined() -> None:
    y = np.random.default_rng(1).standard_normal((2, 251))
    fit = analyse(tau(), y)
    assert judge(tau(), y, fit, 5e-4)[0] is Verdict.UNDETERMINED


def test_nothing_to_fit() -> None:
    assert analyse(tau(), np.zeros((2, 251))) is None
    assert analyse(tau(), np.full((2, 251), np.nan)) is None
    assert analyse(tau()[:10], two_modes(tau(), 0.0)[:, :10]) is None
    assert judge(tau(), np.zeros((2, 251)), None, 5e-4)[0] is Verdict.UNDETERMINED


def test_fit_reproduces_curve_and_envelope() -> None:
    t, y = tau(), two_modes(tau(), -0.02)
    fit = fitted(t, y)
    inside = t >= fit.start
    assert np.max(np.abs(fit.curve(t[inside]) - y[:, inside])) < 1e-9
    assert fit.envelope(np.array([10.0]))[1, 0] == pytest.approx(0.017 * np.exp(-0.2), rel=1e-8)
