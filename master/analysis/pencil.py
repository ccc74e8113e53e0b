"""First poles of a sampled signal by matrix pencil: Hua and Sarkar, IEEE Trans. ASSP 38(5), 1990, doi 10.1109/29.56027, on the
block Hankel matrix of all channels. Oscillations and real poles of any sign come out together, of each order up to the most."""

from __future__ import annotations

import numpy as np
from scipy.linalg import eigh

from .exponentials import FASTEST, FEWEST, STEEPEST, Poles

WIDTH = 100  # longest pencil [samples]
PER_PERIOD = 48.0  # finest samples a period 2π
FEWEST_SAMPLES = 80  # that thinning leaves


def pencil(dt: float, z: np.ndarray, most: int, coarse: bool = False) -> list[Poles]:
    """Poles for 1, 2, … `most` dimensions of the signal's space (two an oscillation, one a real pole), without a constant.

    `dt` in units of 1/omega_alpha, `z` (n_channels, n): finer samples than 48 a period 2π are thinned; `coarse` ones so far
    that the pencil spans half the window, which tells slow poles from each other."""
    stride = max(1, min(int(2.0 * np.pi / PER_PERIOD / dt), z.shape[1] // FEWEST_SAMPLES))
    if coarse:
        stride = max(stride, z.shape[1] // (3 * WIDTH))
    x, dt = z[:, ::stride], dt * stride
    width = min(x.shape[1] // 2, WIDTH)
    if width < most + 2:
        return []
    hankel = np.vstack([np.lib.stride_tricks.sliding_window_view(c, width) for c in x])
    # the row space of the Hankel matrix is spanned by the modes; its small Gram matrix has the same one
    v = eigh(hankel.T @ hankel, subset_by_index=(width - most, width - 1))[1][:, ::-1]
    span = x.shape[1] * dt
    shifts = (np.linalg.lstsq(v[:-1, :p], v[1:, :p], rcond=None)[0] for p in range(1, most + 1))
    return [_poles(np.linalg.eigvals(shift), dt, span) for shift in shifts]


def _poles(roots: np.ndarray, dt: float, span: float) -> Poles:
    """Roots z = e^{s dt} as poles that a window of length `span` can show."""
    roots = roots.astype(complex)
    s = np.log(np.where(np.abs(roots) > 1e-12, roots, 1e-12)) / dt
    s = s[(s.real < 0.9 * STEEPEST / span) & (s.real > -0.9 * FASTEST / span) & (s.imag >= 0.0) & (s.imag < 0.79 * np.pi / dt)]
    slow = s.imag < 2.1 * np.pi * FEWEST / span
    pairs = s[~slow]
    return Poles(np.column_stack([pairs.real, pairs.imag]), np.sort(s[slow].real), False)
