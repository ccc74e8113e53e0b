"""What a free response means: damped, neutral, flutter, limit cycle or undetermined."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from master.damping import Fit, local_rates

LIMIT_CYCLE_RESIDUAL = 0.01  # exponentials that fit better leave nothing for an amplitude limit to explain
NOISE_RESIDUAL = 0.6  # and where they explain next to nothing, there is no oscillation to be limited


AMPLITUDE_CHANGE = 1.3  # what a neutral response does not do between its second and its last period


class Verdict(StrEnum):
    """The words of the JSON result."""

    DAMPED = "damped"
    NEUTRAL = "neutral"
    FLUTTER = "flutter"
    LIMIT_CYCLE = "limit cycle"
    UNDETERMINED = "undetermined"


def judge(tau: np.ndarray, channels: np.ndarray, fit: Fit | None, neutral_band: float) -> tuple[Verdict, str]:
    """The verdict on the free response `channels` (n_channels, n) and the reason in one sentence.

    Limit cycle: the growth rate of the window's pieces goes from clearly growing (or decaying) to a small
    part of that, and exponentials do not describe the response; or the amplitude first changed a lot and then stays, more
    than the fitted growth rate could have made of it. Otherwise the fitted growth rate decides against the neutral band and
    twice its uncertainty.
    """
    if fit is None:
        return Verdict.UNDETERMINED, "no oscillation could be fitted to the free response"
    rate, doubt = fit.growth_rate, 2.0 * fit.growth_rate_uncertainty
    pieces = local_rates(tau, channels, fit, parts=3)
    if np.all(np.isfinite(pieces)) and LIMIT_CYCLE_RESIDUAL < fit.residual < NOISE_RESIDUAL:
        first, last = pieces[0], pieces[-1]
        if abs(first) > 5.0 * neutral_band and abs(last) < 0.3 * abs(first):
            return (
                Verdict.LIMIT_CYCLE,
                f"the growth rate falls from {first:+.4f} to {last:+.4f} within the free response",
            )
    if doubt > max(5.0 * neutral_band, abs(rate)):
        return (
            Verdict.UNDETERMINED,
            f"growth rate {rate:+.5f} is known only to {doubt / 2.0:.5f}; add free cycles",
        )
    if abs(rate) <= max(neutral_band, doubt):
        second, last = _amplitudes(tau, channels, fit)
        linear = np.exp(max(abs(rate), doubt) * (tau[-1] - tau[0]))
        if max(second, last) > AMPLITUDE_CHANGE * linear * min(second, last):
            return Verdict.LIMIT_CYCLE, f"the amplitude of pitch goes from {second:.4f} to {last:.4f} rad and stays there"
        return Verdict.NEUTRAL, f"|growth rate| {abs(rate):.5f} is within {max(neutral_band, doubt):.5f}"
    if rate > 0.0:
        return Verdict.FLUTTER, f"the free response grows at {rate:+.5f} omega_alpha"
    return Verdict.DAMPED, f"the free response decays at {rate:+.5f} omega_alpha"


def _amplitudes(tau: np.ndarray, channels: np.ndarray, fit: Fit) -> tuple[float, float]:
    """Half the span of the last channel (pitch) in the second and in the last period of the flutter mode."""
    period = 2.0 * np.pi / fit.frequency
    early = (tau >= tau[0] + period) & (tau < tau[0] + 2.0 * period)
    late = tau > tau[-1] - period
    if not early.any() or tau[-1] - tau[0] < 3.0 * period:
        return 1.0, 1.0
    return float(0.5 * np.ptp(channels[-1, early])), float(0.5 * np.ptp(channels[-1, late]))
