"""Pressure: conjugate gradients in double precision, preconditioned by one single-precision multigrid cycle.

Unknown q = p/ρ_l [m²/s²]; A q = Σ k (q − q_neighbour) with conductances k = (ρ_l/ρ_face)·(width/distance), 0 where nothing
passes; + d q where gas can be compressed (`cushion`).
Arrays are laid out as in `grid`; level arrays as in `multigrid`.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import jit
from .multigrid import set_up, v_cycle

ROUND_OFF = 2e-15
"""Residuals below this share of their terms are noise; conjugate gradients that go on lose the solution."""


@jit
def prepare(levels: Any, kx: Any, ky: Any, ke: Any, kn: Any, d: Any, di: Any, diagonal: Any = None, own: Any = None) -> None:
    """Set up the preconditioner for conductances kx, ky, and the diagonal's own terms (own: their levels), or None."""
    s, n = levels[0, 2], levels[0, 1] * levels[0, 2]
    fine, first = 2 * s, levels[0, 3] + s
    east, north = ke[first : first + n], kn[first : first + n]
    x, y = kx[fine : fine + n], ky[fine : fine + n]
    for k in range(n):
        east[k] = np.float32(x[k])
        north[k] = np.float32(y[k])
    if own is not None:
        here, mine = own[first : first + n], diagonal[fine : fine + n]
        for k in range(n):
            here[k] = np.float32(mine[k])
    set_up(levels, ke, kn, d, di, own)


@jit
def residual(r: Any, rhs: Any, q: Any, kx: Any, ky: Any, first: int, n: int, s: int, diagonal: Any = None) -> tuple[float, float]:
    """r = rhs − A q; returns its largest entry and the largest term it is the difference of."""
    out, b, c = r[first : first + n], rhs[first : first + n], q[first : first + n]
    qe, qw = q[first + 1 : first + 1 + n], q[first - 1 : first - 1 + n]
    qn, qs = q[first + s : first + s + n], q[first - s : first - s + n]
    e, w = kx[first : first + n], kx[first - 1 : first - 1 + n]
    north, south = ky[first : first + n], ky[first - s : first - s + n]
    largest, size = 0.0, 0.0
    for k in range(n):
        flow = e[k] * (qe[k] - c[k]) + w[k] * (qw[k] - c[k]) + north[k] * (qn[k] - c[k]) + south[k] * (qs[k] - c[k])
        out[k] = b[k] + flow
        largest = max(largest, abs(out[k]))
        size = max(size, (e[k] + w[k] + north[k] + south[k]) * abs(c[k]) + abs(b[k]))
    if diagonal is not None:
        own = diagonal[first : first + n]
        largest = 0.0
        for k in range(n):
            out[k] -= own[k] * c[k]
            largest = max(largest, abs(out[k]))
            size = max(size, own[k] * abs(c[k]))
    return largest, size


@jit
def _product(out: Any, x: Any, kx: Any, ky: Any, first: int, n: int, s: int, diagonal: Any = None) -> float:
    """out = A x; returns x · A x."""
    y, c = out[first : first + n], x[first : first + n]
    xe, xw = x[first + 1 : first + 1 + n], x[first - 1 : first - 1 + n]
    xn, xs = x[first + s : first + s + n], x[first - s : first - s + n]
    e, w = kx[first : first + n], kx[first - 1 : first - 1 + n]
    north, south = ky[first : first + n], ky[first - s : first - s + n]
    total = 0.0
    for k in range(n):
        value = e[k] * (c[k] - xe[k]) + w[k] * (c[k] - xw[k]) + north[k] * (c[k] - xn[k]) + south[k] * (c[k] - xs[k])
        y[k] = value
        total += value * c[k]
    if diagonal is not None:
        own = diagonal[first : first + n]
        for k in range(n):
            value = own[k] * c[k]
            y[k] += value
            total += value * c[k]
    return total


@jit
def _scale_down(b: Any, r: Any, factor: float, here: int, there: int, n: int) -> None:
    out, source = b[there : there + n], r[here : here + n]
    for k in range(n):
        out[k] = np.float32(factor * source[k])


@jit
def _inner(r: Any, z: Any, here: int, there: int, n: int) -> float:
    a, b = r[here : here + n], z[there : there + n]
    total = 0.0
    for k in range(n):
        total += a[k] * b[k]
    return total


@jit
def _direction(p: Any, z: Any, beta: float, scale: float, here: int, there: int, n: int) -> None:
    out, source = p[here : here + n], z[there : there + n]
    for k in range(n):
        out[k] = scale * source[k] + beta * out[k]


@jit
def _advance(q: Any, r: Any, p: Any, product: Any, alpha: float, first: int, n: int) -> float:
    x, y, a, b = q[first : first + n], r[first : first + n], p[first : first + n], product[first : first + n]
    largest = 0.0
    for k in range(n):
        x[k] += alpha * a[k]
        y[k] -= alpha * b[k]
        largest = max(largest, abs(y[k]))
    return largest


@jit
def solve(q: Any, rhs: Any, kx: Any, ky: Any, limit: float, most: int, levels: Any, coarse: Any, work: Any,
          diagonal: Any = None) -> tuple[int, float]:  # fmt: skip
    """Solve A q = rhs from the guess in q until the largest residual is below limit; in place.

    coarse (7, n): level arrays ke, kn, d, di, b, x, scratch in single precision, an eighth with a diagonal; work (3, n): flat
    arrays; diagonal: own terms of cells, flat, or None (then a kernel without them). Returns the iterations taken and the
    residual left over the limit, which is not below round-off (NaN where it broke down).
    """
    ny, s = levels[0, 1], levels[0, 2]
    first, there, n = 2 * s, levels[0, 3] + s, ny * s
    r, p, product = work[0], work[1], work[2]
    ke, kn, d, di, b, x, scratch = coarse[0], coarse[1], coarse[2], coarse[3], coarse[4], coarse[5], coarse[6]
    left, size = residual(r, rhs, q, kx, ky, first, n, s, diagonal)
    limit = max(limit, ROUND_OFF * size)
    if left <= limit:
        return 0, left / limit
    if diagonal is not None:
        prepare(levels, kx, ky, ke, kn, d, di, diagonal, coarse[7])
    else:
        prepare(levels, kx, ky, ke, kn, d, di)
    before = 1.0
    for iteration in range(1, most + 1):
        _scale_down(b, r, 1.0 / left, first, there, n)  # the range of single precision is small
        v_cycle(levels, ke, kn, d, di, b, x, scratch)
        now = left * _inner(r, x, first, there, n)
        _direction(p, x, now / before if iteration > 1 else 0.0, left, first, there, n)
        curvature = _product(product, p, kx, ky, first, n, s, diagonal)
        alpha = now / curvature
        if not np.isfinite(alpha):
            return iteration, np.nan
        left = _advance(q, r, p, product, alpha, first, n)
        before = now
        if iteration % 10 == 0:  # what was updated and what is may part
            left, size = residual(r, rhs, q, kx, ky, first, n, s, diagonal)
            limit = max(limit, ROUND_OFF * size)
        if left <= limit:
            return iteration, left / limit
    return most, left / limit
