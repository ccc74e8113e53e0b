"""What a free response means: damped, neutral, flutter, limit cycle or undetermined."""

from __future__ import annotations

from enum import StrEnum

import numpy as np

from master.damping import Fit, local_rates

LIMIT_CYCLE_RESIDUAL = 0.01  # exponentials that fit better leave nothing for an amplitude limit to explain
NOISE_RESIDUAL = 0.6  # and where they explain next to nothing, there is no oscillation to be limited


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
    part of that, and exponentials do not describe the response. Otherwise the fitted growth rate decides
    against the neutral band and twice its uncertainty.
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
        return Verdict.NEUTRAL, f"|growth rate| {abs(rate):.5f} is within {max(neutral_band, doubt):.5f}"
    if rate > 0.0:
        return Verdict.FLUTTER, f"the free response grows at {rate:+.5f} omega_alpha"
    return Verdict.DAMPED, f"the free response decays at {rate:+.5f} omega_alpha"
