"""Exponentials in sampled signals: first poles by matrix pencil, then least squares on the poles alone.

Model: every channel c is  y_c(t) = d_c + Σ_k e^{σ_k t} (p_ck cos ω_k t + q_ck sin ω_k t) + Σ_r g_cr e^{ρ_r t}
with the poles σ_k ± iω_k (oscillations) and ρ_r < 0 (decays: the wake's memory) shared by all channels.
Matrix pencil: Hua and Sarkar, IEEE Trans. ASSP 38(5), 1990, doi 10.1109/29.56027, on the block Hankel
matrix of all channels. Variable projection (d, p, q, g eliminated): Golub and Pereyra, Inverse Problems 19,
2003, doi 10.1088/0266-5611/19/2/201, with Kaufman's Jacobian.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eigh
from scipy.optimize import least_squares

WIDTH = 160  # longest pencil [samples]
RESOLUTION = 1.25  # least beats of two modes within the window


@dataclass
class Solution:
    """A least-squares solution on one window."""

    poles: np.ndarray  # (n_modes, 2): sigma, omega
    decays: np.ndarray  # (n_decays,): real poles
    covariance: np.ndarray  # of poles.ravel()
    amplitudes: np.ndarray  # (n_modes, n_channels) complex, at the window's start
    decay_amplitudes: np.ndarray  # (n_decays, n_channels)
    constants: np.ndarray  # (n_channels,)
    variance: float  # of the residual, channels scaled to unit rms
    shares: np.ndarray  # (n_modes,)
    score: float  # Bayesian information criterion


def pencil(dt: float, z: np.ndarray, most: int) -> list[np.ndarray]:
    """First poles (sigma, omega) for 1, 2, … `most` oscillations, each array of shape (n_modes, 2).

    `dt` in units of 1/omega_alpha: finer samples than 48 a period 2π are thinned, and the pencil is at most
    WIDTH samples long, which is enough for a start and keeps the cost at milliseconds.
    """
    stride = max(1, int(2.0 * np.pi / 48.0 / dt))
    x, dt = z[:, ::stride], dt * stride
    n = x.shape[1]
    width = min(n // 2, WIDTH)
    x = x - x.mean(axis=1, keepdims=True)
    hankel = np.vstack([np.lib.stride_tricks.sliding_window_view(c, width) for c in x])
    # the row space of the Hankel matrix is spanned by the modes; its small Gram matrix has the same one
    v = eigh(hankel.T @ hankel, subset_by_index=(max(0, width - 2 * most - 2), width - 1))[1][:, ::-1]
    span = n * dt
    found = []
    for modes in range(1, most + 1):
        basis = v[:, : 2 * modes + 2]  # and a constant, and a decay
        roots = np.linalg.eigvals(np.linalg.lstsq(basis[:-1], basis[1:], rcond=None)[0]).astype(complex)
        s = np.log(np.where(np.abs(roots) > 1e-12, roots, 1e-12)) / dt
        # at least half a period in the window, at least four samples a period, not a mere spike
        keep = (s.imag > np.pi / span) & (s.imag < 0.5 * np.pi / dt) & (np.abs(s.real) < 1.5 * np.abs(s.imag))
        s = s[keep]
        if s.size > modes:
            s = s[np.argsort(-_energies(x, s * dt))[:modes]]
        if s.size == modes:
            found.append(np.column_stack([s.real, s.imag]))
    return found


def _energies(x: np.ndarray, s: np.ndarray) -> np.ndarray:
    """Energy of each oscillation e^{s n} (n = sample number) in the channels `x`. Shape: (n_s,)."""
    basis = np.exp(np.outer(np.arange(x.shape[1]), s))
    both = np.hstack([basis, basis.conj(), np.ones((x.shape[1], 1))])
    weight = np.linalg.lstsq(both, x.T.astype(complex), rcond=None)[0][: s.size]
    return np.sum(np.abs(weight) ** 2, axis=1) * np.sum(np.abs(basis) ** 2, axis=0)


def _basis(t: np.ndarray, poles: np.ndarray, decays: np.ndarray) -> np.ndarray:
    """Columns 1; e^{σt}cos ωt, e^{σt}sin ωt of each mode; each decay. Shape: (n, 1 + 2 modes + decays)."""
    columns = [np.ones_like(t)]
    for sigma, omega in poles:
        # referred to the end where it is largest: growing modes stay of order one
        e = np.exp(sigma * (t - (t[-1] if sigma > 0.0 else t[0])))
        columns += [e * np.cos(omega * t), e * np.sin(omega * t)]
    columns += [np.exp(rate * t) for rate in decays]
    return np.column_stack(columns)


def refine(tau: np.ndarray, z: np.ndarray, poles: np.ndarray, decays: np.ndarray) -> Solution | None:
    """Variable projection from `poles` (n_modes, 2) and `decays` (n_decays,); None when modes collide."""
    t = tau - tau[0]
    target = z.T  # (n, n_channels)
    shape, size = poles.shape, poles.size

    def parts(p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        phi = _basis(t, p[:size].reshape(shape), p[size:])
        q, r = np.linalg.qr(phi)
        return phi, q, np.linalg.lstsq(r, q.T @ target, rcond=None)[0]

    def residual(p: np.ndarray) -> np.ndarray:
        phi, _, c = parts(p)
        return (phi @ c - target).T.ravel()

    def jacobian(p: np.ndarray) -> np.ndarray:
        phi, q, c = parts(p)
        columns = []
        for k, (sigma, _) in enumerate(p[:size].reshape(shape)):
            i = 1 + 2 * k
            reference = t[-1] if sigma > 0.0 else t[0]
            by_sigma = (t - reference)[:, None] * (phi[:, i : i + 2] @ c[i : i + 2])
            by_omega = t[:, None] * (np.outer(-phi[:, i + 1], c[i]) + np.outer(phi[:, i], c[i + 1]))
            columns += [by_sigma, by_omega]
        columns += [t[:, None] * np.outer(phi[:, i], c[i]) for i in range(1 + size, phi.shape[1])]
        return np.column_stack([(d - q @ (q.T @ d)).T.ravel() for d in columns])

    span, dt = float(t[-1]), float(t[1] - t[0])
    # quicker decay than this is invisible over the window, slower is the constant's
    low = np.r_[np.tile([-60.0 / span, np.pi / span], len(poles)), np.full(decays.size, -100.0 / span)]
    high = np.r_[np.tile([10.0 / span, 0.6 * np.pi / dt], len(poles)), np.full(decays.size, -2.0 / span)]
    first = np.clip(np.r_[poles.ravel(), decays], low + 1e-9, high - 1e-9)
    try:
        solution = least_squares(residual, first, jacobian, bounds=(low, high), xtol=1e-12, ftol=1e-12, gtol=1e-12, max_nfev=40)
    except (np.linalg.LinAlgError, ValueError):
        return None
    at_bound = np.any((solution.x - low < 1e-6) | (high - solution.x < 1e-6))
    if at_bound or not _separate(solution.x[:size].reshape(shape), span):
        return None
    return _summary(t, target, shape, solution.x, solution.jac, parts(solution.x))


def _separate(poles: np.ndarray, span: float) -> bool:
    """True when no two modes are closer in frequency than the window can tell apart.

    Closer ones are sidebands that imitate an amplitude limit.
    """
    omega = np.sort(poles[:, 1])
    return bool(np.all(np.diff(omega) > 2.0 * np.pi * RESOLUTION / span))


def _summary(
    t: np.ndarray,
    target: np.ndarray,
    shape: tuple[int, ...],
    p: np.ndarray,
    jac: np.ndarray,
    parts: tuple[np.ndarray, np.ndarray, np.ndarray],
) -> Solution:
    """Covariance, amplitudes at the window's start, shares and information criterion of the solution `p`."""
    phi, _, c = parts
    n, channels = target.shape
    size = shape[0] * shape[1]
    poles, decays = p[:size].reshape(shape), p[size:]
    rest = target - phi @ c
    parameters = p.size + c.size
    variance = max(float(np.sum(rest**2)) / max(1, n * channels - parameters), 1e-28)
    # neighbouring residuals of a computed signal are alike: fewer of them are independent
    lag = float(np.sum(rest[1:] * rest[:-1]) / max(np.sum(rest**2), 1e-300))
    lag = float(np.clip(lag, 0.0, 0.95))
    covariance = (np.linalg.pinv(jac.T @ jac) * variance * (1.0 + lag) / (1.0 - lag))[:size, :size]
    amplitudes = np.empty((len(poles), channels), dtype=complex)
    shares = np.empty(len(poles))
    total = np.std(target, axis=0)
    for k, (sigma, _) in enumerate(poles):
        i = 1 + 2 * k
        back = np.exp(-sigma * (t[-1] if sigma > 0.0 else 0.0))
        amplitudes[k] = (c[i] - 1j * c[i + 1]) * back
        shares[k] = float(np.max(np.std(phi[:, i : i + 2] @ c[i : i + 2], axis=0) / np.where(total > 0, total, 1.0)))
    score = n * channels * np.log(variance) + parameters * np.log(n * channels)
    return Solution(poles, decays, covariance, amplitudes, c[1 + size :], c[0], variance, shares, float(score))
