"""Time differences of flows kept in inertial axes: BDF2opt for any step lengths, quadratic prediction, turning of axes.

BDF2opt: 0.48 BDF3 + 0.52 BDF2 (Vatsa, Carpenter and Lockard, AIAA 2010-0122).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiled import jit

Array = NDArray[np.float64]

BDF3_SHARE = 0.48


def bdf_weights(times: Array) -> Array:
    """Weights of BDF2opt for the derivative at times[0] from values at the four descending times, shape (4,).

    Any step lengths: derivative of the interpolating polynomials through four and three points.
    """

    def derivative(t: Array) -> Array:
        n = len(t)
        result = np.zeros(n)
        for k in range(1, n):
            others = [m for m in range(n) if m not in (0, k)]
            result[k] = np.prod([(t[0] - t[m]) / (t[k] - t[m]) for m in others]) / (t[k] - t[0])
        result[0] = -np.sum(result[1:])
        return result

    return BDF3_SHARE * derivative(times) + (1 - BDF3_SHARE) * np.append(derivative(times[:3]), 0.0)


def extrapolation_weights(times: Array) -> Array:
    """Weights that predict the value at times[0] from the three earlier ones (quadratic), shape (3,)."""
    old = times[1:]
    return np.array([np.prod([(times[0] - old[m]) / (old[k] - old[m]) for m in range(3) if m != k]) for k in range(3)])


@jit
def turn(source: Any, target: Any, c: float, s: float, weight: float, add: bool) -> None:
    """target (+)= weight · source with momentum turned from inertial to body axes; shapes (nj, 4, ni)."""
    nj, _, ni = source.shape
    for j in range(nj):
        r, u, v, e = source[j, 0], source[j, 1], source[j, 2], source[j, 3]
        a, b, d, f = target[j, 0], target[j, 1], target[j, 2], target[j, 3]
        if not add:
            target[j] = 0.0
        for i in range(ni):
            x, y = u[i], v[i]
            a[i] += weight * r[i]
            b[i] += weight * (c * x - s * y)
            d[i] += weight * (s * x + c * y)
            f[i] += weight * e[i]


@jit
def add_time_derivative(out: Any, q: Any, past: Any, volume: Any, weight: float) -> None:
    """out += volume · (weight q + past), the time derivative of the conserved variables."""
    nj, _, ni = q.shape
    for j in range(nj):
        for m in range(4):
            o, new, old, v = out[j, m], q[j, m], past[j, m], volume[j]
            for i in range(ni):
                o[i] += v[i] * (weight * new[i] + old[i])
