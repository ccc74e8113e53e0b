"""Preconditioner of the pressure equation: one multigrid V-cycle in single precision.

Cells are joined in twos in the directions of strong coupling, any number of cells; transfer is piecewise constant, a coarse face
has the mean conductance of its fine faces across the doubled distance. Smoothing: two Jacobi sweeps with Chebyshev weights, in
opposite order on the way up, so that the cycle stays symmetric for conjugate gradients (Tatebe, NASA CP-3224, 1993).

Level arrays are flat and lie one after the other; a row of `levels` holds nx, ny, stride, offset, joined in x, joined in y. Cell
(i, j) of a level is at offset + (j + 1)·stride + i + 1; conductance east of it in ke, north of it in kn, 0 at walls.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kit.compiled import jit

# zeros of the Chebyshev polynomial over the upper three quarters of the spectrum (0.5, 2) of the scaled matrix
_W1 = np.float32(1.0 / (1.25 + 0.75 * 0.5**0.5))
_W2 = np.float32(1.0 / (1.25 - 0.75 * 0.5**0.5))
_W = np.float32(0.7)
_ONE = np.float32(1.0)
_HALF = np.float32(0.5)
_COARSE_SWEEPS = 8


def plan(nx: int, ny: int, dx: float, dy: float) -> tuple[NDArray[np.int64], int]:
    """Levels of a grid and the total length of a level array."""
    rows, offset = [], 0
    while True:
        smallest = nx * ny <= 6 or (nx <= 2 and ny <= 2)
        # cells much longer one way couple weakly that way: joined there only once they are square
        join_x = 2 if nx > 1 and (dx < 1.7 * dy or ny == 1) and not smallest else 1
        join_y = 2 if ny > 1 and (dy < 1.7 * dx or nx == 1) and not smallest else 1
        rows.append((nx, ny, nx + 2, offset, join_x, join_y))
        offset += (nx + 2) * (ny + 2)
        if smallest:
            return np.array(rows), offset
        nx, ny, dx, dy = -(-nx // join_x), -(-ny // join_y), dx * join_x, dy * join_y


@jit
def set_up(levels: Any, ke: Any, kn: Any, d: Any, di: Any, own: Any = None) -> None:
    """Coarse conductances, diagonals d and their inverses di on all levels from ke and kn of the first.

    own: terms of the diagonal alone, those of the first level given; None for none.
    """
    for level in range(levels.shape[0]):
        nx, ny, s, o = levels[level, 0], levels[level, 1], levels[level, 2], levels[level, 3]
        if level > 0:
            _coarsen(levels, level, ke, kn)
            if own is not None:
                _restrict(own, own, levels, level - 1)
        first, n = o + s, ny * s
        e, w = ke[first : first + n], ke[first - 1 : first - 1 + n]
        north, south = kn[first : first + n], kn[first - s : first - s + n]
        dd, ii = d[first : first + n], di[first : first + n]
        for k in range(n):
            total = e[k] + w[k] + north[k] + south[k]
            dd[k] = total
            ii[k] = _ONE / total if total > 0.0 else np.float32(0.0)
        if own is not None:
            gg = own[first : first + n]
            for k in range(n):
                dd[k] += gg[k]
                ii[k] = _ONE / dd[k] if dd[k] > 0.0 else np.float32(0.0)
        for j in range(ny):  # the ghost between rows sees the walls on both sides, but holds no equation
            dd[j * s], dd[j * s + nx + 1] = np.float32(0.0), np.float32(0.0)
            ii[j * s], ii[j * s + nx + 1] = np.float32(0.0), np.float32(0.0)


@jit
def _coarsen(levels: Any, level: int, ke: Any, kn: Any) -> None:
    nx, ny, s, o = levels[level, 0], levels[level, 1], levels[level, 2], levels[level, 3]
    fx, fy, fs, fo = levels[level - 1, 0], levels[level - 1, 1], levels[level - 1, 2], levels[level - 1, 3]
    join_x, join_y = levels[level - 1, 4], levels[level - 1, 5]
    share_x = _HALF if join_x == 2 else _ONE
    share_y = _HALF if join_y == 2 else _ONE
    for j in range(ny):
        low = fo + (join_y * j + 1) * fs + 1
        for i in range(nx):
            k = o + (j + 1) * s + i + 1
            east = low + join_x * i + join_x - 1
            value = np.float32(0.0)
            if i < nx - 1:
                value = ke[east]
                if join_y == 2 and 2 * j + 1 < fy:
                    value += ke[east + fs]
            ke[k] = value * share_x
            value = np.float32(0.0)
            if j < ny - 1:
                north = low + (join_y - 1) * fs + join_x * i
                value = kn[north]
                if join_x == 2 and 2 * i + 1 < fx:
                    value += kn[north + 1]
            kn[k] = value * share_y


@jit
def _from_zero(x: Any, b: Any, di: Any, weight: Any, first: int, n: int) -> None:
    xx, bb, ii = x[first : first + n], b[first : first + n], di[first : first + n]
    for k in range(n):
        xx[k] = weight * ii[k] * bb[k]


@jit
def _sweep(out: Any, x: Any, b: Any, ke: Any, kn: Any, di: Any, weight: Any, first: int, n: int, s: int) -> None:
    """out = x + weight (b − A x)/d."""
    y, xc, bb, ii = out[first : first + n], x[first : first + n], b[first : first + n], di[first : first + n]
    xe, xw = x[first + 1 : first + 1 + n], x[first - 1 : first - 1 + n]
    xn, xs = x[first + s : first + s + n], x[first - s : first - s + n]
    e, w = ke[first : first + n], ke[first - 1 : first - 1 + n]
    north, south = kn[first : first + n], kn[first - s : first - s + n]
    keep = _ONE - weight
    for k in range(n):
        total = bb[k] + e[k] * xe[k] + w[k] * xw[k] + north[k] * xn[k] + south[k] * xs[k]
        y[k] = keep * xc[k] + weight * ii[k] * total


@jit
def _residual(out: Any, x: Any, b: Any, ke: Any, kn: Any, d: Any, first: int, n: int, s: int) -> None:
    y, xc, bb, dd = out[first : first + n], x[first : first + n], b[first : first + n], d[first : first + n]
    xe, xw = x[first + 1 : first + 1 + n], x[first - 1 : first - 1 + n]
    xn, xs = x[first + s : first + s + n], x[first - s : first - s + n]
    e, w = ke[first : first + n], ke[first - 1 : first - 1 + n]
    north, south = kn[first : first + n], kn[first - s : first - s + n]
    for k in range(n):
        y[k] = bb[k] + e[k] * xe[k] + w[k] * xw[k] + north[k] * xn[k] + south[k] * xs[k] - dd[k] * xc[k]


@jit
def _restrict(b: Any, r: Any, levels: Any, level: int) -> None:
    """b of the level below = sums of r of this one; ghosts of r are 0."""
    fs, fo = levels[level, 2], levels[level, 3]
    join_x, join_y = levels[level, 4], levels[level, 5]
    nx, ny, s, o = levels[level + 1, 0], levels[level + 1, 1], levels[level + 1, 2], levels[level + 1, 3]
    for j in range(ny):
        out = b[o + (j + 1) * s + 1 : o + (j + 1) * s + 1 + nx]
        low = fo + (join_y * j + 1) * fs + 1
        if join_x == 2 and join_y == 2:
            a, c = r[low : low + 2 * nx], r[low + fs : low + fs + 2 * nx]
            for i in range(nx):
                out[i] = (a[2 * i] + a[2 * i + 1]) + (c[2 * i] + c[2 * i + 1])
        elif join_x == 2:
            a = r[low : low + 2 * nx]
            for i in range(nx):
                out[i] = a[2 * i] + a[2 * i + 1]
        else:
            a, c = r[low : low + nx], r[low + fs : low + fs + nx]
            for i in range(nx):
                out[i] = a[i] + c[i]


@jit
def _correct(x: Any, levels: Any, level: int) -> None:
    """x of this level += x of the level below."""
    nx, ny, fs, fo = levels[level, 0], levels[level, 1], levels[level, 2], levels[level, 3]
    join_x, join_y = levels[level, 4], levels[level, 5]
    s, o = levels[level + 1, 2], levels[level + 1, 3]
    for j in range(ny):
        fine = x[fo + (j + 1) * fs + 1 : fo + (j + 1) * fs + 1 + nx]
        low = o + (j // join_y + 1) * s + 1
        if join_x == 2:
            half = nx // 2
            coarse = x[low : low + half]
            for i in range(half):
                fine[2 * i] += coarse[i]
                fine[2 * i + 1] += coarse[i]
            if nx % 2:
                fine[nx - 1] += x[low + half]
        else:
            coarse = x[low : low + nx]
            for i in range(nx):
                fine[i] += coarse[i]


@jit
def v_cycle(levels: Any, ke: Any, kn: Any, d: Any, di: Any, b: Any, x: Any, t: Any) -> None:
    """x ≈ A⁻¹ b on the first level; b is kept there; t: scratch."""
    last = levels.shape[0] - 1
    for level in range(last):
        s, o = levels[level, 2], levels[level, 3]
        first, n = o + s, levels[level, 1] * s
        _from_zero(t, b, di, _W1, first, n)
        _sweep(x, t, b, ke, kn, di, _W2, first, n, s)
        _residual(t, x, b, ke, kn, d, first, n, s)
        _restrict(b, t, levels, level)
    s, o = levels[last, 2], levels[last, 3]
    first, n = o + s, levels[last, 1] * s
    _from_zero(x, b, di, _W, first, n)
    for _ in range(_COARSE_SWEEPS // 2):
        _sweep(t, x, b, ke, kn, di, _W, first, n, s)
        _sweep(x, t, b, ke, kn, di, _W, first, n, s)
    for up in range(last):
        level = last - 1 - up
        s, o = levels[level, 2], levels[level, 3]
        first, n = o + s, levels[level, 1] * s
        _correct(x, levels, level)
        _sweep(t, x, b, ke, kn, di, _W2, first, n, s)
        _sweep(x, t, b, ke, kn, di, _W1, first, n, s)
