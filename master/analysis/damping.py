"""Growth rates and frequencies of a free response, with uncertainties.

Plunge and pitch are fitted together by exponentials with shared poles (module `exponentials`): oscillations and real poles of any
sign.
1. How many of each, and whether a constant goes with them, is what an information criterion prefers, among all that matrix
   pencils of every order suggest.
2. The part just after the release, where quickly damped aerodynamic modes live, is skipped when that halves the residual's
   variance.
3. The critical pole is the least stable one that stands out of the residual; harmonics of a stronger mode are none of their own.
4. Uncertainty (one standard deviation): residual covariance, widened for correlated residuals; and what of the change under
   another window (first or last part dropped) or a richer model exceeds that noise.
5. Forecast: what a fit of the first 70 % of the window says of the rest. Exponentials that fit a response without describing it
   (an amplitude limit, a beat not yet seen) fail there.
Times are τ = ω_α t, rates σ/ω_α, frequencies ω/ω_α: all dimensionless.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np

from .exponentials import Solution, refine
from .model_order import MOST, best_order, choose, has_close_pair
from .pencil import pencil

VISIBLE = 0.02  # a pole counts when it makes this share of a channel
SUSPECT = 1e-3, 10.0, 5.0  # a smaller one may yet: share, share over residual, growth rate over its noise at least
HARMONIC = 0.005  # relative distance from a multiple of a stronger mode's pole within which a weaker one is its harmonic
CLOSE = 0.03  # relative distance in frequency within which two poles may be one mode that changes with its amplitude
FORECAST_SHARE = 2e-3  # a pole with less may be left out of a forecast
MAIN = 2.0  # times the share of every pole whose rate is known: the motion itself, however badly its own is
GROWN, PARTLY = 0.02, 0.05  # growth rate of such a motion at least, and that over a smaller part's
DEAD = 0.05  # of the whole rms: what is left of a motion that has died
SAMPLES = 1500  # longer signals are thinned to this many for the fit


@dataclass(frozen=True)
class Mode:
    """One pole: growth rate, frequency (0 for a real pole), and its part of each channel at the start of the window."""

    growth_rate: float
    frequency: float
    amplitudes: np.ndarray  # complex p - i q at the window's first sample, shape (n_channels,)
    share: float  # largest share of a channel's rms
    growth_rate_std: float  # from the residuals alone
    frequency_std: float

    @property
    def damping_ratio(self) -> float:
        """zeta = -sigma / omega; nan for a real pole."""
        return -self.growth_rate / self.frequency if self.frequency else float("nan")


@dataclass(frozen=True)
class Fit:
    """A fitted free response. `growth_rate`, `frequency` belong to the critical mode: the least damped oscillation that counts,
    or a growing real pole (frequency 0)."""

    modes: list[Mode]  # oscillations
    reals: list[Mode]  # real poles: wake, slow plunge, divergence
    flutter: Mode  # the critical one
    growth_rate: float
    growth_rate_uncertainty: float
    frequency: float
    frequency_uncertainty: float
    constants: np.ndarray  # (n_channels,)
    start: float  # tau of the window's first sample
    end: float
    residual: float  # rms of the residual / rms of the signal, all channels
    forecast: float  # rms of what a fit of the first 70 % misses of the rest / rms of the rest; inf when there is none
    constant_share: float = 0.0  # largest share of a channel's rms
    contributions: dict[str, float] = field(default_factory=dict)  # parts of the growth rate's uncertainty

    @property
    def oscillation(self) -> Mode | None:
        """The least damped oscillation that counts; None when the response does not oscillate."""
        if self.flutter.frequency or not self.modes:
            return self.flutter if self.flutter.frequency else None
        return _critical(self.modes, [])

    @property
    def suspects(self) -> list[Mode]:
        """Poles too small to count that grow: a longer window shows whether they are motion."""
        share, residuals, sure = SUSPECT
        least = max(share, residuals * self.residual)
        small = [m for m in [*self.modes, *self.reals] if least <= m.share < VISIBLE]
        return [m for m in small if m.growth_rate > sure * m.growth_rate_std and not _harmonic(m, self.modes)]

    def curve(self, tau: np.ndarray) -> np.ndarray:
        """The model at `tau`. Shape: (n_channels, n)."""
        t = tau - self.start
        total = np.repeat(self.constants[:, None], t.size, axis=1)
        for mode in [*self.modes, *self.reals]:
            total = total + (mode.amplitudes[:, None] * np.exp((mode.growth_rate + 1j * mode.frequency) * t)).real
        return total

    def envelope(self, tau: np.ndarray) -> np.ndarray:
        """Amplitude of the critical mode at `tau`. Shape: (n_channels, n)."""
        return np.abs(self.flutter.amplitudes)[:, None] * np.exp(self.growth_rate * (tau - self.start))


def analyse(tau: np.ndarray, channels: np.ndarray) -> Fit | None:
    """Fit the free response `channels` (n_channels, n) sampled at equidistant `tau` (n,). None when nothing fits."""
    y = np.atleast_2d(np.asarray(channels, dtype=float))
    if tau.size < 24 or not np.all(np.isfinite(y)):
        return None
    stride = max(1, (tau.size - 1) // SAMPLES)
    last = (tau.size - 1) % stride  # the end counts: growth shows there
    tau, y = tau[last::stride], y[:, last::stride]
    spread = np.std(y, axis=1)
    if not np.any(spread > 0.0):
        return None
    scale = np.where(spread > 0.0, spread, 1.0)
    z = y / scale[:, None]
    base, start = choose(tau, z)
    if base is None:
        return None
    tau, z = tau[start:], z[:, start:]
    modes, reals = _modes(base, scale)
    residual = float(np.sqrt(base.variance))
    critical = _critical(modes, reals)
    extra, parts = _sensitivity(tau, z, base, critical)
    parts = {"residual": critical.growth_rate_std} | parts
    constant = float(np.max(np.abs(base.constants) / np.maximum(np.std(z, axis=1), 1e-300)))
    return Fit(
        modes,
        reals,
        critical,
        critical.growth_rate,
        float(np.hypot(critical.growth_rate_std, extra[0])),
        critical.frequency,
        float(np.hypot(critical.frequency_std, extra[1])),
        base.constants * scale,
        float(tau[0]),
        float(tau[-1]),
        residual,
        _forecast(tau, z, base),
        constant,
        parts,
    )


def _modes(base: Solution, scale: np.ndarray) -> tuple[list[Mode], list[Mode]]:
    """Oscillations and real poles of a solution whose channels were divided by `scale`."""
    oscillations = [
        Mode(float(p[0]), float(p[1]), a * scale, float(s), float(e[0]), float(e[1]))
        for p, a, s, e in zip(base.poles.oscillations, base.amplitudes, base.shares, base.std, strict=True)
    ]
    reals = [
        Mode(float(p), 0.0, a * scale, float(s), float(e), 0.0)
        for p, a, s, e in zip(base.poles.reals, base.real_amplitudes, base.real_shares, base.real_std, strict=True)
    ]
    return oscillations, reals


def _critical(modes: list[Mode], reals: list[Mode]) -> Mode:
    """The least stable pole that counts and whose rate is known: an oscillation, unless a real pole grows more."""
    own = [m for m in modes if not _harmonic(m, modes)]
    known = [m for m in own if m.share >= VISIBLE and m.growth_rate_std < 0.05]
    best: Mode | None
    strongest = max(own, key=lambda m: m.share, default=None)
    if strongest is not None and all(strongest.share > MAIN * m.share for m in known):
        best = strongest  # a rate badly known of nearly all that moves tells more than a good one of next to nothing
    else:
        best = max(known, key=lambda m: m.growth_rate, default=None)
    if best is not None and best.growth_rate > 0.0:  # growing all of them: what is read of it is the strongest
        alike = [m for m in known if m.growth_rate > 0.0 and (close(m, best) or _outgrown(best, m))]
        best = max(alike, key=lambda m: m.share, default=best)
    rising = [m for m in reals if m.share >= VISIBLE and m.growth_rate > SUSPECT[2] * m.growth_rate_std]
    real = max(rising if best is not None else reals, key=lambda m: m.growth_rate, default=None)
    if best is None:
        assert real is not None  # a solution has poles
        return real
    return real if real is not None and real.growth_rate > max(best.growth_rate, 0.0) and not _outgrown(real, best) else best


def _outgrown(small: Mode, strong: Mode) -> bool:
    """Whether `small` may make up for what exponentials miss where a motion, `strong`, grows out of linear response: harmonics,
    the mean, a rate that changes. The verdict is the strong one's then, which surely grows, by GROWN at least."""
    sure = strong.growth_rate > max(GROWN, PARTLY * small.growth_rate, SUSPECT[2] * strong.growth_rate_std)
    return sure and strong.share > MAIN * small.share


def _harmonic(mode: Mode, modes: list[Mode]) -> bool:
    """Whether `mode` is what a nonlinear response adds at twice or three times a stronger mode's pole.

    A mode that changes with its amplitude shows as several close poles: its harmonics lie among their multiples."""
    for other in modes:
        if other.share <= 5.0 * mode.share:
            continue
        own = [m for m in modes if close(m, other) and m.share > mode.share]
        frequencies, rates = [m.frequency for m in own], [m.growth_rate for m in own]
        for n in (2, 3):
            near = max(3.0 * (mode.frequency_std + n * other.frequency_std), HARMONIC * mode.frequency)
            far = max(near, 3.0 * mode.growth_rate_std)
            same = n * min(frequencies) - near < mode.frequency < n * max(frequencies) + near
            if same and n * min(rates) - far < mode.growth_rate < n * max(rates) + far:
                return True
    return False


def close(a: Mode, b: Mode) -> bool:
    """Whether two poles may be one mode that changes with its amplitude."""
    return abs(a.frequency - b.frequency) <= CLOSE * b.frequency


def _forecast(tau: np.ndarray, z: np.ndarray, base: Solution) -> float:
    """What the same poles, or those that can be seen there, fitted to the first 70 % of the window, miss of the rest, relative
    to its rms, or to a part of the whole's where the motion has died."""
    cut = round(0.7 * tau.size)
    poles, least = base.poles, FORECAST_SHARE
    large = replace(poles, oscillations=poles.oscillations[base.shares > least], reals=poles.reals[base.real_shares > least])
    first = tau[:cut], z[:, :cut]
    part = refine(*first, poles) or refine(*first, large) or best_order(*first)  # some poles need the whole window
    if part is None:
        return float("inf")
    rest = z[:, cut:]
    with np.errstate(over="ignore", invalid="ignore"):
        missed = part.curve(tau[cut:] - tau[0]) - rest
    value = float(np.sqrt(np.mean(missed**2) / max(np.mean(rest**2), DEAD**2 * np.mean(z**2), 1e-300)))
    return value if np.isfinite(value) else float("inf")


def _sensitivity(tau: np.ndarray, z: np.ndarray, base: Solution, critical: Mode) -> tuple[np.ndarray, dict[str, float]]:
    """What window and order change in (sigma, omega) of the critical mode beyond noise: (2,), and the parts for sigma.

    A sub-window's estimate scatters about the whole window's with variance var_sub − var_whole when only
    noise is at work; just the excess counts.
    """
    dt = tau[1] - tau[0]
    cycle = round(2.0 * np.pi / (critical.frequency * dt)) if critical.frequency else tau.size // 5
    whole = np.array([critical.growth_rate_std, critical.frequency_std]) ** 2
    trials: dict[str, Solution | None] = {}
    if tau.size - cycle >= max(24, round(1.5 * cycle)):
        trials["first_cycle"] = refine(tau[cycle:], z[:, cycle:], base.poles)
        trials["last_cycle"] = refine(tau[:-cycle], z[:, :-cycle], base.poles)
    size = base.poles.size
    richer = [p for p in pencil(float(dt), z, min(MOST, size + 3)) if p.size in (size + 1, size + 2)]
    if richer:
        trials["order"] = refine(tau, z, replace(richer[-1], constant=base.poles.constant))
    trials["constant"] = refine(tau, z, replace(base.poles, constant=not base.poles.constant))
    total, parts = np.zeros(2), {}
    for name, trial in trials.items():
        doubtful = trial is not None and name in ("order", "constant") and has_close_pair(trial)
        found = _nearest(trial, critical) if trial is not None and not doubtful else None
        if found is None:
            continue
        value, variance = found
        change = value - np.array([critical.growth_rate, critical.frequency])
        excess = np.maximum(change**2 - np.maximum(variance - whole, 0.0), 0.0)
        # the two windows bracket the whole one: half of each change is the wider of two readings
        weight = 0.25 if name.endswith("cycle") else 1.0
        total += weight * excess
        parts[name] = float(np.sqrt(weight * excess[0]))
    return np.sqrt(total), parts


def _nearest(trial: Solution, mode: Mode) -> tuple[np.ndarray, np.ndarray] | None:
    """(sigma, omega) and their variances of the pole of `trial` that is `mode`; None when none is."""
    if mode.frequency:
        poles, std = trial.poles.oscillations, trial.std
    else:
        reals = trial.poles.reals
        poles, std = np.column_stack([reals, 0.0 * reals]), np.column_stack([trial.real_std, 0.0 * reals])
    if not len(poles):
        return None
    j = int(np.argmin(np.hypot(poles[:, 0] - mode.growth_rate, poles[:, 1] - mode.frequency)))
    if abs(poles[j, 1] - mode.frequency) > 0.2 * mode.frequency:
        return None
    return poles[j], std[j] ** 2
