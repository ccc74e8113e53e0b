"""Exponentials in sampled signals: least squares on the poles alone (module `pencil` gives the first ones).

Model: every channel c is  y_c(t) = d_c + Σ_k e^{σ_k t} (p_ck cos ω_k t + q_ck sin ω_k t) + Σ_r g_cr e^{ρ_r t}
with the poles σ_k ± iω_k (oscillations) and ρ_r of any sign (a decay: the wake's memory, or slow plunge; growth: static
divergence) shared by all channels; the constants d_c (an offset of the mean) only where they are asked for: a slow real pole
and a constant are nearly the same thing. Variable projection (d, p, q, g eliminated): Golub and Pereyra, Inverse Problems 19,
2003, doi 10.1088/0266-5611/19/2/201, with Kaufman's Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

FASTEST = 100.0  # a pole that decays quicker than this over the window is invisible in it [1/span]
STEEPEST = 40.0  # and one that grows more is no part of a computed signal [1/span]
FEWEST = 0.5  # periods within the window that an oscillation needs: slower ones are real poles in disguise
APART = 0.1  # least distance of two real poles [1/span]
LATE = 2.0 / 3.0  # of the window: from there on shares are looked at once more, growth shows late
LEAST_LATE = 0.01  # a last third smaller than this share of the whole has no shares of its own
EXPONENTS = -80.0, 50.0  # of the columns: smaller ones would become denormal numbers, which are slow
FLOOR = 1e-26  # least variance of a residual: double precision, squared


@dataclass
class Poles:
    """Poles of a signal, and whether a constant goes with them."""

    oscillations: np.ndarray  # (n_modes, 2): sigma, omega
    reals: np.ndarray  # (n_reals,)
    constant: bool

    @property
    def size(self) -> int:
        """Real parameters of the poles."""
        return self.oscillations.size + self.reals.size

    @property
    def columns(self) -> int:
        """Basis functions, each with one amplitude a channel."""
        return self.size + self.constant

    def vector(self) -> np.ndarray:
        """All parameters. Shape: (size,)."""
        return np.concatenate([self.oscillations.ravel(), self.reals])

    def like(self, p: np.ndarray) -> Poles:
        """As many poles, with the parameters `p` (size,)."""
        n = self.oscillations.size
        return Poles(p[:n].reshape(-1, 2), p[n:], self.constant)

    def basis(self, t: np.ndarray) -> np.ndarray:
        """Columns e^{σt}cos ωt, e^{σt}sin ωt of each oscillation; each real pole; one. Shape: (n, columns).

        A growing column is referred to the end of `t`, where it is largest: all stay of order one."""
        with np.errstate(over="ignore", under="ignore"):
            columns = []
            for sigma, omega in self.oscillations:
                e = np.exp(np.clip(sigma * (t - reference(t, sigma)), *EXPONENTS))
                columns += [e * np.cos(omega * t), e * np.sin(omega * t)]
            columns += [np.exp(np.clip(rate * (t - reference(t, rate)), *EXPONENTS)) for rate in self.reals]
            if self.constant:
                columns.append(np.ones_like(t))
        return np.column_stack(columns)


def reference(t: np.ndarray, rate: float) -> float:
    """The instant at which a column of that `rate` is 1."""
    return float(t[-1] if rate > 0.0 else t[0])


@dataclass
class Solution:
    """A least-squares solution on one window."""

    poles: Poles
    covariance: np.ndarray  # (size, size), of poles.vector()
    amplitudes: np.ndarray  # (n_modes, n_channels) complex, at the window's start
    real_amplitudes: np.ndarray  # (n_reals, n_channels), at the window's start
    constants: np.ndarray  # (n_channels,), zero without a constant
    variance: float  # of the residual, channels scaled to unit rms
    correlation: float  # of neighbouring residuals, 0 to 0.98
    shares: np.ndarray  # (n_modes,): largest part of a channel's rms; of growing ones in the last third, if larger
    real_shares: np.ndarray  # (n_reals,)
    score: float  # information criterion: the lower the better
    span: float  # length of the window

    def curve(self, t: np.ndarray) -> np.ndarray:
        """The model at `t` after the window's start. Shape: (n_channels, n)."""
        total = np.repeat(self.constants[:, None], t.size, axis=1)
        for (sigma, omega), a in zip(self.poles.oscillations, self.amplitudes, strict=True):
            total = total + (a[:, None] * np.exp((sigma + 1j * omega) * t)).real
        for rate, a in zip(self.poles.reals, self.real_amplitudes, strict=True):
            total = total + a[:, None] * np.exp(rate * t)
        return total

    @property
    def std(self) -> np.ndarray:
        """Standard deviations of the oscillations' (sigma, omega). Shape: (n_modes, 2)."""
        n = self.poles.oscillations.size
        return np.sqrt(np.maximum(np.diag(self.covariance)[:n], 0.0)).reshape(-1, 2)

    @property
    def real_std(self) -> np.ndarray:
        """Standard deviations of the real poles. Shape: (n_reals,)."""
        return np.sqrt(np.maximum(np.diag(self.covariance)[self.poles.oscillations.size :], 0.0))


def refine(tau: np.ndarray, z: np.ndarray, first: Poles) -> Solution | None:
    """Variable projection from the poles `first` on the window `tau` (n,), `z` (n_channels, n).

    None when the solution has a pole that the window cannot show (too quick, too slow, two poles in one place)."""
    t = tau - tau[0]
    target = z.T  # (n, n_channels)
    if first.size == 0 or t.size * len(z) <= first.size + first.columns * len(z):
        return None

    latest: dict[bytes, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}

    def parts(p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        key = p.tobytes()  # the residual and its Jacobian are asked for at the same place
        if key not in latest:
            phi = first.like(p).basis(t)
            q, r = np.linalg.qr(phi)
            latest.clear()
            latest[key] = phi, q, np.linalg.lstsq(r, q.T @ target, rcond=None)[0]
        return latest[key]

    def residual(p: np.ndarray) -> np.ndarray:
        phi, _, c = parts(p)
        return (phi @ c - target).T.ravel()

    def jacobian(p: np.ndarray) -> np.ndarray:
        phi, q, c = parts(p)
        poles, columns = first.like(p), []
        for k, (sigma, _) in enumerate(poles.oscillations):
            i = 2 * k
            columns.append((t - reference(t, sigma))[:, None] * (phi[:, i : i + 2] @ c[i : i + 2]))
            columns.append(t[:, None] * (np.outer(-phi[:, i + 1], c[i]) + np.outer(phi[:, i], c[i + 1])))
        for k, rate in enumerate(poles.reals):
            i = poles.oscillations.size + k
            columns.append((t - reference(t, rate))[:, None] * np.outer(phi[:, i], c[i]))
        return np.column_stack([(d - q @ (q.T @ d)).T.ravel() for d in columns])

    try:
        solution = least_squares(residual, first.vector(), jacobian, method="lm", xtol=1e-10, ftol=1e-12, gtol=1e-12, max_nfev=30)
        p = solution.x
        if not np.all(np.isfinite(p)) or not _visible(first.like(p), t):
            return None
        return _summary(t, target, first.like(p), jacobian(p), parts(p))
    except (np.linalg.LinAlgError, ValueError):
        return None


def _visible(poles: Poles, t: np.ndarray) -> bool:
    """Whether the window `t` can show these poles, and tell each from the others."""
    span, dt = float(t[-1]), float(t[1] - t[0])
    sigma, omega = poles.oscillations.T
    rates = np.concatenate([sigma, poles.reals])
    gaps = np.diff(np.sort(poles.reals)) * span
    return bool(
        np.all(gaps > APART)  # nearer ones are a slow oscillation, seen for less than half a period
        and np.all((rates > -FASTEST / span) & (rates < STEEPEST / span))
        and np.all((np.abs(omega) > 2.0 * np.pi * FEWEST / span) & (np.abs(omega) < 0.8 * np.pi / dt))
    )


def _summary(
    t: np.ndarray, target: np.ndarray, poles: Poles, jac: np.ndarray, parts: tuple[np.ndarray, np.ndarray, np.ndarray]
) -> Solution:
    """Covariance, amplitudes at the window's start, shares and information criterion of the solution."""
    phi, _, c = parts
    n, channels = target.shape
    rest = target - phi @ c
    parameters = poles.size + c.size
    variance = max(float(np.sum(rest**2)) / max(1, n * channels - parameters), FLOOR)
    # neighbouring residuals of a computed signal are alike: fewer of them are independent
    lag = float(np.clip(np.sum(rest[1:] * rest[:-1]) / max(np.sum(rest**2), 1e-300), 0.0, 0.98))
    covariance = np.linalg.pinv(jac.T @ jac) * variance * (1.0 + lag) / (1.0 - lag)
    late = t >= t[0] + LATE * (t[-1] - t[0])
    whole = np.maximum(np.std(target, axis=0), 1e-300)
    total = np.vstack([whole, np.maximum(np.sqrt(np.mean(target[late] ** 2, axis=0)), LEAST_LATE * whole)])

    def share(part: np.ndarray, rate: float) -> float:
        """The largest share of a channel that `part` (n, n_channels) has in the window or, where it grows, in its last third."""
        sizes = np.sqrt([np.mean(part**2, axis=0), np.mean(part[late] ** 2, axis=0)]) / total
        return float(np.max(sizes if rate > 0.0 else sizes[0]))

    modes = len(poles.oscillations)
    amplitudes, shares = np.empty((modes, channels), dtype=complex), np.empty(modes)
    for k, (sigma, _) in enumerate(poles.oscillations):
        i = 2 * k
        amplitudes[k] = (c[i] - 1j * c[i + 1]) * np.exp(-sigma * reference(t, sigma))
        shares[k] = share(phi[:, i : i + 2] @ c[i : i + 2], sigma)
    real, at = c[2 * modes : 2 * modes + poles.reals.size], phi[:, 2 * modes : 2 * modes + poles.reals.size]
    back = np.array([np.exp(-rate * reference(t, rate)) for rate in poles.reals])
    real_shares = np.array([share(np.outer(at[:, r], real[r]), rate) for r, rate in enumerate(poles.reals)])
    constants = c[-1] if poles.constant else np.zeros(channels)
    score = n * channels * np.log(variance) + parameters * np.log(n * channels)
    flipped = poles.oscillations * np.array([1.0, 0.0]) + np.abs(poles.oscillations) * np.array([0.0, 1.0])
    negative = poles.oscillations[:, 1] < 0.0
    amplitudes[negative] = amplitudes[negative].conj()
    return Solution(
        Poles(flipped, poles.reals, poles.constant),
        covariance,
        amplitudes,
        real * back[:, None],
        constants,
        variance,
        lag,
        shares,
        real_shares,
        float(score),
        float(t[-1]),
    )
