"""Time differences of flows kept in inertial axes: BDF2opt for any step lengths, quadratic prediction, turning of axes.

BDF2opt: 0.48 BDF3 + 0.52 BDF2 (Vatsa, Carpenter and Lockard, AIAA 2010-0122).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kit.compiled import jit

Array = NDArray[np.float64]

BDF3_SHARE = 0.48


def bdf_weights(times: Sequence[float]) -> Array:
    """Weights of BDF2opt for the derivative at times[0] from values at the four descending times, shape (4,).

    Any step lengths: derivative of the interpolating polynomials through four and three points.
    """
    third, second = _derivative(times), _derivative(times[:3])
    return np.array([BDF3_SHARE * a + (1 - BDF3_SHARE) * b for a, b in zip(third, [*second, 0.0], strict=True)])


def _derivative(times: Sequence[float]) -> list[float]:
    """Weights of the derivative at times[0] of the polynomial through values at all times. Plain numbers: a step takes them
    anew, and arrays of four cost ten times as much."""
    now, past = times[0], times[1:]
    weights = []
    for t in past:
        weight = 1.0 / (t - now)
        for other in past:
            if other != t:
                weight *= (now - other) / (t - other)
        weights.append(weight)
    return [-math.fsum(weights), *weights]


def extrapolation_weights(times: Sequence[float]) -> tuple[Array, Array]:
    """Weights (3,) of the linear prediction at times[0] from the three earlier values, and those that make it quadratic."""
    t, first, second, third = times
    slope = (t - first) / (first - second)
    quadratic = (
        (t - second) * (t - third) / ((first - second) * (first - third)),
        (t - first) * (t - third) / ((second - first) * (second - third)),
        (t - first) * (t - second) / ((third - first) * (third - second)),
    )
    return np.array([1 + slope, -slope, 0.0]), np.array([quadratic[0] - 1 - slope, quadratic[1] + slope, quadratic[2]])


@jit
def turn(flow: Any, out: Any, c: float, s: float) -> None:
    """out = flow with momentum turned by the angle of cosine c and sine s; both (nj, 4, ni).

    From inertial axes to those of a section at incidence a: cos a, sin a; back: cos a, −sin a.
    """
    nj, _, ni = flow.shape
    for j in range(nj):
        r, u, v, e = flow[j, 0], flow[j, 1], flow[j, 2], flow[j, 3]
        a, b, d, f = out[j, 0], out[j, 1], out[j, 2], out[j, 3]
        for i in range(ni):
            x, y = u[i], v[i]
            a[i], f[i] = r[i], e[i]
            b[i] = c * x - s * y
            d[i] = s * x + c * y


@jit
def combine(first: Any, second: Any, third: Any, weights: Any, c: float, s: float, out: Any) -> None:
    """out = weighted sum of three flows, turned as by `turn`; weights (3,)."""
    nj, _, ni = first.shape
    w0, w1, w2 = weights[0], weights[1], weights[2]
    for j in range(nj):
        for m in range(0, 4, 3):
            p0, p1, p2, p = first[j, m], second[j, m], third[j, m], out[j, m]
            for i in range(ni):
                p[i] = w0 * p0[i] + w1 * p1[i] + w2 * p2[i]
        u0, u1, u2, u = first[j, 1], second[j, 1], third[j, 1], out[j, 1]
        v0, v1, v2, v = first[j, 2], second[j, 2], third[j, 2], out[j, 2]
        for i in range(ni):
            x = w0 * u0[i] + w1 * u1[i] + w2 * u2[i]
            y = w0 * v0[i] + w1 * v1[i] + w2 * v2[i]
            u[i] = c * x - s * y
            v[i] = s * x + c * y


@jit
def predict(
    first: Any, second: Any, third: Any, line: Any, bend: Any, share: Any, limit: float, c: float, s: float, out: Any
) -> None:
    """out = extrapolation of three flows, newest first, turned as by `turn`.

    line, bend: (3,) weights of the linear extrapolation and of what makes it quadratic; share: (ni,) how much of the bend a
    column takes; limit: no cell may differ from the newest flow by more than this in density or energy, relative. Where a shock
    passes, extrapolation overshoots to states that the subiterations do not survive.
    """
    nj, _, ni = first.shape
    for j in range(nj):
        for i in range(ni):
            w0, w1, w2 = line[0] + share[i] * bend[0], line[1] + share[i] * bend[1], line[2] + share[i] * bend[2]
            r, x, y, e = first[j, 0, i], first[j, 1, i], first[j, 2, i], first[j, 3, i]
            dr = w0 * r + w1 * second[j, 0, i] + w2 * third[j, 0, i] - r
            dx = w0 * x + w1 * second[j, 1, i] + w2 * third[j, 1, i] - x
            dy = w0 * y + w1 * second[j, 2, i] + w2 * third[j, 2, i] - y
            de = w0 * e + w1 * second[j, 3, i] + w2 * third[j, 3, i] - e
            f = limit / max(limit, max(abs(dr) / r, abs(de) / e))
            x += f * dx
            y += f * dy
            out[j, 0, i] = r + f * dr
            out[j, 1, i] = c * x - s * y
            out[j, 2, i] = s * x + c * y
            out[j, 3, i] = e + f * de


@jit
def add_time_derivative(out: Any, q: Any, past: Any, volume: Any, weight: float) -> None:
    """out += volume · (weight q + past), the time derivative of the conserved variables."""
    nj, _, ni = q.shape
    for j in range(nj):
        for m in range(4):
            o, new, old, v = out[j, m], q[j, m], past[j, m], volume[j]
            for i in range(ni):
                o[i] += v[i] * (weight * new[i] + old[i])
