"""Signals of one coordinate: a value with its first two derivatives in time, in closed form, so that all three belong together.

A Signal has shape (3, n): q, q', q'' at n instants. Products keep the derivatives exact (Leibniz); noise is a trigonometric
polynomial, whose derivatives are known to rounding, not a filtered series with differences taken of it.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_BLOCK = 4096  # instants at a time: bounds the table of exponentials to some tens of MB


def instants(duration: float, step: float) -> Array:
    """Equal steps from 0 to `duration` [s], shape (n,); multiples, not sums, of `step` [s]."""
    return step * np.arange(round(duration / step) + 1.0)


def harmonics(times: Array, omega: Array, coefficients: Complex) -> Array:
    """Re Σ_k c_k exp(i omega_k t) for several coordinates. omega [rad/s] (k,), coefficients (k, m); returns (m, 3, n)."""
    turn = 1j * omega[:, None]
    stacked = np.concatenate([coefficients, turn * coefficients, turn**2 * coefficients], axis=1)
    out = np.empty((stacked.shape[1], times.size))
    for first in range(0, times.size, _BLOCK):
        part = slice(first, first + _BLOCK)
        out[:, part] = (np.exp(np.outer(times[part], turn[:, 0])) @ stacked).real.T
    return out.reshape(3, -1, times.size).transpose(1, 0, 2)


def oscillation(times: Array, rate: complex, amplitude: complex = -1j) -> Array:
    """Re(amplitude exp(rate t)); rate = growth + i omega [1/s, rad/s]. With the amplitude −i: exp(growth t) sin(omega t)."""
    z = amplitude * np.exp(rate * times)
    return np.stack([z.real, (rate * z).real, (rate**2 * z).real])


def sweep(times: Array, start: float, end: float, phase: float, power: float) -> Array:
    """sin of a phase whose rate goes linearly from `start` to `end` [rad/s], times (rate/start)^−power: 2 keeps accelerations."""
    slope = (end - start) / (times[-1] - times[0])
    t = times - times[0]
    omega, angle = start + slope * t, phase + start * t + 0.5 * slope * t**2
    sin, cos = np.sin(angle), np.cos(angle)
    size = (omega / start) ** -power
    fall = -power * slope / omega
    return product(
        np.stack([sin, omega * cos, slope * cos - omega**2 * sin]),
        np.stack([size, fall * size, power * (power + 1.0) * (slope / omega) ** 2 * size]),
    )


def rise(times: Array, start: float, duration: float) -> Array:
    """From 0 to 1 within `duration` [s] after `start` [s], with three continuous derivatives; 0 s: a jump, without any."""
    if duration <= 0.0:
        # instants are multiples of a step: one that falls on the jump must not miss it by rounding
        value = (times >= start - 1e-9).astype(float)
        return np.stack([value, np.zeros_like(value), np.zeros_like(value)])
    s = np.clip((times - start) / duration, 0.0, 1.0)
    rest = 1.0 - s
    value = s**4 * (35.0 - 84.0 * s + 70.0 * s**2 - 20.0 * s**3)
    return np.stack([value, 140.0 * (s * rest) ** 3 / duration, 420.0 * (s * rest) ** 2 * (rest - s) / duration**2])


def hump(times: Array, start: float, duration: float) -> Array:
    """sin⁴ from 0 over 1 to 0 within `duration` [s] after `start` [s]; three continuous derivatives."""
    inside = (times > start) & (times < start + duration)
    angle = np.where(inside, np.pi * (times - start) / duration, 0.0)
    sin, cos, turn = np.sin(angle), np.cos(angle), np.pi / duration
    return np.stack([sin**4, 4.0 * turn * sin**3 * cos, 4.0 * turn**2 * sin**2 * (3.0 * cos**2 - sin**2)])


def product(a: Array, b: Array) -> Array:
    """The product of two signals, each (3, n)."""
    return np.stack([a[0] * b[0], a[1] * b[0] + a[0] * b[1], a[2] * b[0] + 2.0 * a[1] * b[1] + a[0] * b[2]])


def to_peak(signal: Array, peak: float) -> Array:
    """Scaled so that its largest magnitude at its instants is `peak`; nothing stays nothing."""
    largest = float(np.max(np.abs(signal[0])))
    return signal * (peak / largest) if largest > 0.0 else signal


def plateaus(rng: np.random.Generator, count: int, keep: float, normal: bool) -> Array:
    """Levels of `count` plateaus: each keeps the level before it with probability `keep`, else is drawn afresh (unit normal, or
    uniform from −1 to 1). Shape: (count,)."""
    fresh = rng.standard_normal(count) if normal else 2.0 * rng.random(count) - 1.0
    changes = rng.random(count) >= keep
    changes[0] = True
    return fresh[np.maximum.accumulate(np.where(changes, np.arange(count), 0))]


def stairs(omega: Array, levels: Array, hold: float) -> Complex:
    """Fourier coefficients, for `harmonics`, of the periodic stairs of `levels` (m,), each held for `hold` [s].

    omega [rad/s] (k,): multiples of 2 pi/(m hold) above 0. Shape: (k,)."""
    period = levels.size * hold
    k = np.round(omega * period / (2.0 * np.pi)).astype(int)
    return 2.0 * np.fft.fft(levels)[k % levels.size] * -np.expm1(-1j * omega * hold) / (1j * omega * period)


def band(omega: Array, low: float, high: float, order: int) -> Array:
    """Gain of a Butterworth band-pass, `order` an edge, run forwards and backwards (no phase); low 0: low-pass. Shape: (k,)."""
    gain = 1.0 / (1.0 + (omega / high) ** (2 * order))
    if low > 0.0:
        gain /= 1.0 + (low / omega) ** (2 * order)
    return gain
