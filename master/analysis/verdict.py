"""What a free response means: damped, neutral, flutter, divergence, limit cycle or undetermined; and whether a longer march is
needed to say so.

A verdict needs exponentials that describe the response (a residual that is noise, and a forecast of its last part from the rest),
a growth rate known well enough, or an amplitude that has settled. A growth rate that changes is no limit cycle: two close modes
that beat do the same, and so does a shock whose damping depends on amplitude."""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from .damping import Fit, Mode, analyse, close

MORE_CYCLES = "add free cycles (flutter.free_cycles, flutter.max_free_cycles)"
RESIDUAL = 0.02  # exponentials that miss more of a response than this do not describe it
FORECAST = 0.10  # nor do those that miss more of its last part
AMPLITUDE_CHANGE = 1.3  # what a neutral response does not do
SETTLED = 0.02  # change of amplitude over the last periods that is none
LAST_PERIODS = 5  # whose amplitudes are compared
PART = 0.6  # of the response, tried where the whole is not described
CERTAIN = 2.0 / 3.0  # of a growth rate: what twice its standard deviation may be, three of them tell its sign
SMALL = 0.1  # of the critical mode's amplitude
SURE_STIFFNESS = 0.02  # relative pitch stiffness left by the steady flow that its sign is certain of
LARGE = 0.2  # share of a channel from which a growing real pole is motion and no drift of the mean


class Verdict(StrEnum):
    """The words of the JSON result."""

    DAMPED = "damped"
    NEUTRAL = "neutral"
    FLUTTER = "flutter"
    DIVERGENCE = "divergence"
    LIMIT_CYCLE = "limit cycle"
    UNDETERMINED = "undetermined"


@dataclass(frozen=True)
class Judgement:
    """A verdict, why, and whether more cycles could change it; `remedy` says what to do where there is none. `fit` is the one it
    rests on."""

    verdict: Verdict
    reason: str
    settled: bool
    fit: Fit | None
    remedy: str = ""


def judge(tau: np.ndarray, channels: np.ndarray, fit: Fit | None, neutral_band: float, stiffness: float = math.nan) -> Judgement:
    """The verdict on the free response `channels` (n_channels, n; the last one pitch) at equidistant `tau` (n,).

    neutral_band  growth rates within it are neutral
    stiffness     pitch stiffness that the steady flow leaves, over the structure's own: negative where the section diverges
                  statically, nan where it is not known"""
    if fit is None:
        return Judgement(Verdict.UNDETERMINED, "nothing could be fitted to the free response", False, None, "add free cycles")
    cycle = _settled_amplitude(tau, channels, fit)
    if cycle and not _died(fit) and not stiffness < -SURE_STIFFNESS:  # a section that diverges has no such limit
        return Judgement(Verdict.LIMIT_CYCLE, cycle, True, fit)
    whole = _by_fit(fit, neutral_band, stiffness)
    if whole.settled or describes(fit):
        return whole
    n = tau.size
    first, last = slice(0, round(PART * n)), slice(n - round(PART * n), n)
    early = analyse(tau[first], channels[:, first])
    if early is not None and describes(early):
        said = _by_fit(early, neutral_band, stiffness)
        if said.settled and said.verdict in (Verdict.FLUTTER, Verdict.DIVERGENCE):
            return Judgement(said.verdict, f"{said.reason}, at first: the rate then changes with the amplitude", True, early)
    late = analyse(tau[last], channels[:, last])
    if late is not None and describes(late):
        said = _by_fit(late, neutral_band, stiffness)
        if said.settled:
            return Judgement(said.verdict, f"{said.reason}, in its last part", True, late, said.remedy)
    missed = f"they miss {fit.residual:.1%} of it and {fit.forecast:.1%} of its last part"
    why = f"exponentials do not describe the free response: {missed}"
    remedy = "add free cycles (flutter.max_free_cycles); a smaller forced amplitude, if the response depends on it"
    return Judgement(Verdict.UNDETERMINED, why, False, fit, remedy)


def describes(fit: Fit) -> bool:
    """Whether the exponentials are what the response is made of."""
    return fit.residual <= RESIDUAL and fit.forecast <= FORECAST


def _by_fit(fit: Fit, neutral_band: float, stiffness: float) -> Judgement:
    """What the critical pole says, and the steady flow's stiffness."""
    critical = fit.flutter
    if critical.frequency == 0.0 and stiffness > SURE_STIFFNESS and critical.share < LARGE and fit.modes:
        critical = max(fit.modes, key=lambda m: m.growth_rate if m.share > 0.02 else -math.inf)  # a drift of the mean
    rate, std = critical.growth_rate, fit.growth_rate_uncertainty if critical is fit.flutter else critical.growth_rate_std
    doubt = 2.0 * std
    known, certain = describes(fit), doubt <= max(neutral_band, CERTAIN * abs(rate))
    if stiffness < -SURE_STIFFNESS or (critical.frequency == 0.0 and rate > max(neutral_band, doubt)):
        return _static(fit, critical, rate, doubt, stiffness, known and certain)
    if doubt > max(5.0 * neutral_band, abs(rate)):
        reason = f"growth rate {rate:+.5f} is known only to {doubt / 2.0:.5f}"
        return Judgement(Verdict.UNDETERMINED, reason, False, fit, MORE_CYCLES)
    suspect = [m for m in fit.suspects if m.frequency or not stiffness > SURE_STIFFNESS]
    settled = known and certain
    if suspect and rate <= max(neutral_band, doubt):
        worst = max(suspect, key=lambda m: m.growth_rate)
        motion = f"a motion of {worst.share:.1%} of the response, at {worst.frequency:.3f} omega_alpha,"
        reason = f"{motion} may grow at {worst.growth_rate:+.5f}"
        return Judgement(Verdict.UNDETERMINED, reason, False, fit, MORE_CYCLES)
    if abs(rate) <= max(neutral_band, doubt):
        change = _own_change(fit, critical)
        if max(change, 1.0 / change) > AMPLITUDE_CHANGE * math.exp(max(abs(rate), doubt) * (fit.end - fit.start)):
            reason = f"the amplitude has changed by a factor {change:.2f} and has not been steady for {LAST_PERIODS} periods yet"
            return Judgement(Verdict.UNDETERMINED, reason, False, fit, MORE_CYCLES)
        return Judgement(Verdict.NEUTRAL, f"|growth rate| {abs(rate):.5f} is within {max(neutral_band, doubt):.5f}", settled, fit)
    if rate > 0.0:
        return Judgement(Verdict.FLUTTER, f"the free response grows at {rate:+.5f} omega_alpha", settled, fit)
    if stiffness < SURE_STIFFNESS:
        reason = f"no pitch stiffness is left by the steady flow ({stiffness:+.3f} of the structure's)"
        return Judgement(Verdict.NEUTRAL, reason, settled, fit)
    return Judgement(Verdict.DAMPED, f"the free response decays at {rate:+.5f} omega_alpha", settled, fit)


def _static(fit: Fit, critical: Mode, rate: float, doubt: float, stiffness: float, settled: bool) -> Judgement:
    """A section that diverges statically, or whose response grows without oscillating."""
    steady = "" if math.isnan(stiffness) else f"the steady flow leaves {stiffness:+.3f} of the pitch stiffness"
    sure = stiffness < -SURE_STIFFNESS
    if critical.frequency and doubt < rate < critical.frequency and settled:  # a quicker one does not live to oscillate
        return Judgement(Verdict.FLUTTER, f"the free response grows at {rate:+.5f} omega_alpha; {steady}", True, fit)
    if critical.frequency:  # growth not seen yet, or not alone
        return Judgement(Verdict.DIVERGENCE, f"{steady}: the section diverges statically", True, fit)
    reason = f"the free response grows without oscillating at {rate:+.5f} omega_alpha"
    return Judgement(Verdict.DIVERGENCE, "; ".join(filter(None, [reason, steady])), settled or sure, fit)


def _died(fit: Fit) -> bool:
    """Whether a linear response explains an amplitude that changes and settles: the other mode has died beside a neutral
    one. What a limit cycle adds to a fit comes in several modes on both sides of it."""
    critical = fit.flutter
    if not describes(fit) or not critical.frequency or max(c := _own_change(fit, critical), 1.0 / c) > AMPLITUDE_CHANGE:
        return False
    size = [abs(m.amplitudes[-1]) / abs(critical.amplitudes[-1]) for m in fit.modes if m is not critical]
    return sum(s > SMALL for s in size) == 1


def _own_change(fit: Fit, critical: Mode) -> float:
    """Amplitude of pitch at the window's end over that a period after its start, of the poles of the critical frequency."""
    own = [m for m in fit.modes if close(m, critical)]
    t = np.array([2.0 * np.pi / critical.frequency, fit.end - fit.start])
    with np.errstate(under="ignore"):
        size = np.abs(sum(m.amplitudes[-1] * np.exp((m.growth_rate + 1j * m.frequency) * t) for m in own))
    return float(size[1] / max(size[0], 1e-300))


def _settled_amplitude(tau: np.ndarray, channels: np.ndarray, fit: Fit) -> str:
    """What to say of a response whose amplitude has changed and then settled; nothing of any other.

    The last periods must have one amplitude, each alone and as a trend, and more of them than the change took: an extremum of a
    beat is no limit."""
    main = max(fit.modes, key=lambda m: m.share * math.exp(min(m.growth_rate * (fit.end - fit.start), 50.0)), default=None)
    if main is None:
        return ""
    period = 2.0 * np.pi / main.frequency
    periods = int((tau[-1] - tau[0]) / period)
    if periods < 2 * LAST_PERIODS:
        return ""
    ends = tau[-1] - period * np.arange(periods, -1, -1)
    spans = np.array([0.5 * np.ptp(channels[-1, (tau >= a - 1e-9) & (tau <= b + 1e-9)]) for a, b in itertools.pairwise(ends)])
    last = spans[-1]
    near = np.abs(spans / last - 1.0) <= SETTLED if last > 0.0 else np.zeros(periods, dtype=bool)
    steady = periods - 1 - int(np.flatnonzero(~near)[-1]) if not near.all() else periods
    if steady < max(LAST_PERIODS, periods // 2) or steady == periods:
        return ""
    trend = np.polyfit(np.arange(steady), spans[-steady:], 1)[0] * steady / last
    ratio = spans[0] / last
    if abs(trend) > SETTLED or max(ratio, 1.0 / max(ratio, 1e-300)) < AMPLITUDE_CHANGE:
        return ""
    return f"the amplitude of pitch goes from {spans[0]:.4f} to {last:.4f} rad and has stayed there for {steady} periods"
