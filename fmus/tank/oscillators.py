"""A bank of damped oscillators under forces that are polynomials in time: exact propagation over any step.

    s'' + 2 zeta omega s' + omega² s = f(t)

With lambda = −zeta omega + i omega sqrt(1 − zeta²) the complex amplitude w = s' − conj(lambda) s obeys w' = lambda w + f, so that

    w(T) = exp(lambda T) w(0) + T sum_k f_k k! phi_{k+1}(lambda T),   f(t) = sum_k f_k (t/T)^k

with phi_0(z) = exp(z), phi_{k+1}(z) = (phi_k(z) − 1/k!)/z (Hochbruck and Ostermann, Acta Numerica 19 (2010) 209,
doi:10.1017/S0962492910000048). The step size makes no error, and without damping none of the energy is lost.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

LARGEST_DAMPING = 0.9
"""Damping ratios are held below this: w loses its digits as a mode becomes critically damped, and hardly moves then."""

_SERIES_BELOW = 2.0  # |z| below which phi comes from its series: the recursion divides by z
_SERIES_TERMS = 28
_CACHED_STEPS = 256


class Oscillators:
    """Frequencies omega [rad/s] and damping ratios, shape (n,). Stateless but for a cache of propagators.

    Raises ValueError for a frequency that is not positive or a damping ratio outside 0 to LARGEST_DAMPING.
    """

    def __init__(self, omega: Array, damping: Array) -> None:
        if not (np.all(omega > 0.0) and np.all(damping >= 0.0) and np.all(damping <= LARGEST_DAMPING)):
            raise ValueError(f"oscillators need omega > 0 and a damping ratio of 0 to {LARGEST_DAMPING}")
        self.omega, self.damping = omega, damping
        self.rate: Complex = omega * (-damping + 1j * np.sqrt(1.0 - damping**2))
        self._place: Array = 1.0 / self.rate.imag
        self._decay: Array = self.rate.real / self.rate.imag
        self._propagators: dict[float, tuple[Complex, Complex]] = {}

    def amplitude(self, displacement: Array, velocity: Array) -> Complex:
        """Complex amplitude w [m/s] of displacement [m] and velocity [m/s]."""
        return np.asarray(velocity - np.conj(self.rate) * displacement, dtype=complex)

    def displacement(self, w: Complex) -> Array:
        """Displacement s [m]."""
        return w.imag * self._place

    def velocity(self, w: Complex) -> Array:
        """Velocity s' [m/s]."""
        return w.real + self._decay * w.imag

    def advance(self, w: Complex, force: Array, duration: float) -> Complex:
        """Amplitudes after `duration` [s]. force [m/s2]: coefficients of (t/duration)^k, shape (6, n) or (6, 1)."""
        free, weights = self.propagator(duration)
        return free * w + (weights * force).sum(axis=0)

    def propagator(self, duration: float) -> tuple[Complex, Complex]:
        """exp(lambda T), shape (n,), and T k! phi_{k+1}(lambda T), shape (6, n)."""
        if duration not in self._propagators:
            if len(self._propagators) >= _CACHED_STEPS:
                self._propagators.clear()
            z = self.rate * duration
            weights = np.stack([math.factorial(k) * values for k, values in enumerate(phi(z, 6))])
            self._propagators[duration] = np.exp(z), duration * weights
        return self._propagators[duration]


def phi(z: Complex, count: int) -> list[Complex]:
    """phi_1(z) … phi_count(z), each of the shape of z; real parts of z at most 0."""
    small = np.abs(z) < _SERIES_BELOW
    inside = np.where(small, z, 0.0)
    # small z: the series for the last one, then downwards, which multiplies by z
    last = np.zeros_like(z)
    for j in reversed(range(_SERIES_TERMS)):
        last = last * inside + 1.0 / math.factorial(j + count)
    down = [last]
    for k in reversed(range(1, count)):
        down.insert(0, down[0] * inside + 1.0 / math.factorial(k))
    # the rest: upwards
    outside = np.where(small, 1.0, z)
    up, found = np.exp(outside), []
    for k in range(count):
        up = (up - 1.0 / math.factorial(k)) / outside
        found.append(np.where(small, down[k], up))
    return found
