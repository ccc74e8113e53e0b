"""Growth rate and frequency of a free response, with uncertainties.

Plunge and pitch are fitted together by exponentials with shared poles (module `poles`).
1. The number of modes, and whether a real decay goes with them, is what the Bayesian information criterion prefers.
2. The part just after the release, where quickly damped aerodynamic modes live, is skipped when that
   halves the residual's variance.
3. The flutter mode is the least damped one that makes a visible share of a channel.
4. Uncertainty (one standard deviation): residual covariance, widened for correlated residuals; and what
   of the change under another window (first or last cycle dropped) or a richer model exceeds that noise.
Times are τ = ω_α t, rates σ/ω_α, frequencies ω/ω_α: all dimensionless.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from master.poles import Solution, pencil, refine

MAX_MODES = 4
SIGNIFICANT = 0.02  # a mode counts when it makes this share of a channel's rms


@dataclass(frozen=True)
class Mode:
    """One mode: growth rate, frequency, and its part of each channel at the start of the window."""

    growth_rate: float
    frequency: float
    amplitudes: np.ndarray  # complex p - i q at the window's first sample, shape (n_channels,)
    share: float  # largest share of a channel's rms
    growth_rate_std: float  # from the residuals alone
    frequency_std: float

    @property
    def damping_ratio(self) -> float:
        """zeta = -sigma / omega."""
        return -self.growth_rate / self.frequency


@dataclass(frozen=True)
class Fit:
    """A fitted free response. `growth_rate`, `frequency` belong to the flutter mode (the least damped
    that counts)."""

    modes: list[Mode]
    flutter: Mode
    growth_rate: float
    growth_rate_uncertainty: float
    frequency: float
    frequency_uncertainty: float
    constants: np.ndarray  # (n_channels,)
    start: float  # tau of the window's first sample
    end: float
    residual: float  # rms of the residual / rms of the signal, all channels
    decays: list[tuple[float, np.ndarray]] = field(default_factory=list)  # rate, amplitudes (n_channels,)
    contributions: dict[str, float] = field(default_factory=dict)  # parts of the growth rate's uncertainty

    def curve(self, tau: np.ndarray) -> np.ndarray:
        """The model at `tau`. Shape: (n_channels, n)."""
        t = tau - self.start
        total = np.repeat(self.constants[:, None], t.size, axis=1)
        for mode in self.modes:
            total += (mode.amplitudes[:, None] * np.exp((mode.growth_rate + 1j * mode.frequency) * t)).real
        for rate, amplitudes in self.decays:
            total += amplitudes[:, None] * np.exp(rate * t)
        return total

    def envelope(self, tau: np.ndarray) -> np.ndarray:
        """Amplitude of the flutter mode at `tau`. Shape: (n_channels, n)."""
        return np.abs(self.flutter.amplitudes)[:, None] * np.exp(self.growth_rate * (tau - self.start))


def analyse(tau: np.ndarray, channels: np.ndarray) -> Fit | None:
    """Fit the free response `channels` (n_channels, n) sampled at equidistant `tau` (n,). None when nothing fits."""
    y = np.atleast_2d(np.asarray(channels, dtype=float))
    if tau.size < 24 or not np.all(np.isfinite(y)):
        return None
    spread = np.std(y, axis=1)
    if not np.any(spread > 0.0):
        return None
    scale = np.where(spread > 0.0, spread, 1.0)
    z = y / scale[:, None]
    base, start = _choose(tau, z)
    if base is None:
        return None
    k = _flutter_mode(base)
    std = np.sqrt(np.diag(base.covariance)).reshape(-1, 2)
    extra, parts = _sensitivity(tau, z, base, start, k)
    uncertainty = np.hypot(std[k], extra)
    modes = [
        Mode(float(p[0]), float(p[1]), a * scale, float(s), float(e[0]), float(e[1]))
        for p, a, s, e in zip(base.poles, base.amplitudes, base.shares, std, strict=True)
    ]
    parts = {"residual": float(std[k, 0])} | parts
    return Fit(
        modes,
        modes[k],
        float(base.poles[k, 0]),
        float(uncertainty[0]),
        float(base.poles[k, 1]),
        float(uncertainty[1]),
        base.constants * scale,
        float(tau[start]),
        float(tau[-1]),
        float(np.sqrt(base.variance)),
        [(float(r), a * scale) for r, a in zip(base.decays, base.decay_amplitudes, strict=True)],
        parts,
    )


def local_rates(tau: np.ndarray, channels: np.ndarray, fit: Fit, parts: int = 2) -> np.ndarray:
    """Growth rate of the flutter mode in `parts` equal pieces of the window, one mode each. Shape:
    (parts,); may be nan.

    Tells a limit cycle (growth that dies out) from growth: there the pieces differ.
    """
    inside = np.flatnonzero(tau >= fit.start - 1e-9)
    # near ones stay: they may be how the whole window's fit imitates a limit
    other = [m for m in fit.modes if abs(m.frequency - fit.frequency) > 0.5 * fit.frequency]
    rates = np.full(parts, np.nan)
    one = np.array([[fit.growth_rate, fit.frequency]])
    for i, piece in enumerate(np.array_split(inside, parts)):
        y = channels[:, piece].astype(float)
        for mode in other:  # what the whole window says of the other modes is taken away first
            y = y - (mode.amplitudes[:, None] * np.exp((mode.growth_rate + 1j * mode.frequency) * (tau[piece] - fit.start))).real
        spread = np.std(y, axis=1)
        if piece.size < 12 or not np.all(spread > 0.0):
            continue
        raw = refine(tau[piece], y / spread[:, None], one, np.empty(0))
        if raw is not None:
            rates[i] = raw.poles[0, 0]
    return rates


def _choose(tau: np.ndarray, z: np.ndarray) -> tuple[Solution | None, int]:
    """The number of modes and the first sample of the window."""
    best, start = _best_order(tau, z), 0
    if best is None:
        return None, 0
    frequency = best.poles[_flutter_mode(best), 1]
    cycle = 2.0 * np.pi / (frequency * (tau[1] - tau[0]))
    for skip in (0.25, 0.5, 0.75):
        first = round(skip * cycle)
        if tau.size - first < max(2.5 * cycle, 24):
            break
        for decays in {best.decays.size: best.decays, 0: best.decays[:0]}.values():
            trial = refine(tau[first:], z[:, first:], best.poles, decays)
            # a later window must pay for the samples it leaves out: half the residual variance
            if trial is not None and trial.variance < 0.5 * best.variance:
                best, start = trial, first
    return best, start


def _best_order(tau: np.ndarray, z: np.ndarray) -> Solution | None:
    """The fit with the lowest information criterion: 1 to MAX_MODES oscillations, without or with a decay."""
    span = float(tau[-1] - tau[0])
    fits: list[Solution] = []
    for poles in pencil(float(tau[1] - tau[0]), z, MAX_MODES):
        new = [raw for decays in (np.empty(0), np.array([-10.0 / span])) if (raw := refine(tau, z, poles, decays)) is not None]
        better = not fits or not new or min(r.score for r in new) < min(r.score for r in fits)
        fits += new
        if not better:
            break
    return min(fits, key=lambda raw: raw.score, default=None)


def _flutter_mode(raw: Solution) -> int:
    """Index of the least damped mode that makes a significant share of a channel and whose rate is known."""
    known = np.sqrt(np.maximum(np.diag(raw.covariance)[0::2], 0.0)) < 0.05
    counts = np.flatnonzero((raw.shares >= SIGNIFICANT) & known)
    if counts.size == 0:
        return int(np.argmax(raw.shares))
    return int(counts[np.argmax(raw.poles[counts, 0])])


def _sensitivity(tau: np.ndarray, z: np.ndarray, base: Solution, start: int, k: int) -> tuple[np.ndarray, dict[str, float]]:
    """What window and order change in (sigma, omega) of mode k beyond noise: (2,), and the parts for sigma.

    A sub-window's estimate scatters about the whole window's with variance var_sub − var_whole when only
    noise is at work; just the excess counts.
    """
    omega = base.poles[k, 1]
    cycle = round(2.0 * np.pi / (omega * (tau[1] - tau[0])))
    whole = np.diag(base.covariance)[2 * k : 2 * k + 2]
    trials: dict[str, Solution | None] = {}
    if tau.size - start - cycle >= max(24, round(1.5 * cycle)):
        trials["first_cycle"] = refine(tau[start + cycle :], z[:, start + cycle :], base.poles, base.decays)
        trials["last_cycle"] = refine(tau[start : tau.size - cycle], z[:, start : tau.size - cycle], base.poles, base.decays)
    larger = len(base.poles) + 1
    for more in pencil(float(tau[1] - tau[0]), z[:, start:], larger):
        if len(more) == larger:
            trials["order"] = refine(tau[start:], z[:, start:], more, base.decays)
    if not base.decays.size:
        slow = np.array([-10.0 / (tau[-1] - tau[start])])
        trials["decay"] = refine(tau[start:], z[:, start:], base.poles, slow)
    total, parts = np.zeros(2), {}
    for name, trial in trials.items():
        if trial is None:
            continue
        j = int(np.argmin(np.abs(trial.poles[:, 1] - omega)))
        change = trial.poles[j] - base.poles[k]
        if abs(change[1]) > 0.2 * omega:
            continue  # not the same mode
        noise = np.maximum(np.diag(trial.covariance)[2 * j : 2 * j + 2] - whole, 0.0)
        excess = np.maximum(change**2 - noise, 0.0)
        # the two windows bracket the whole one: half of each change is the wider of two readings
        weight = 0.25 if name.endswith("cycle") else 1.0
        total += weight * excess
        parts[name] = float(np.sqrt(weight * excess[0]))
    return np.sqrt(total), parts
