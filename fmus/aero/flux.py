"""Residual of the 2-D Euler equations on a rigidly moving O-mesh: MUSCL reconstruction and Roe's flux.

Everything is in chords, freestream density and freestream sound speed, in body axes; velocities are absolute (inertial frame).
Conserved variables q have shape (nj, 4, ni): rho, rho u, rho v, rho E.

Reconstruction: kappa = 1/3 differences of (rho, u, v, p) in index space (van Leer 1979), limited by van Albada's function only
where a pressure sensor sees a shock. Across the cut behind the trailing edge (face i = 0) each side is reconstructed on its own:
the vortex sheet of an unsteady lift leaves along it, and differences across it would spread the sheet over cells about the edge.
What is shed within that width then acts too weakly on the lift, which leads the exact one by a phase that falls with the first
power of the width (0.4 degrees at k = 0.124 on 168 cells; docs/aero.md).

Flux: Roe (1981, doi:10.1016/0021-9991(81)90128-5) on face averages with Harten's entropy floor under the acoustic waves alone:
shear and entropy waves are linear and need none, and one under them diffuses the vortex sheet through faces that lie along it
(on 168 cells the phase is 0.05 degrees off without it and 0.1 with it; the error falls at an order of 1.8 instead of 1). In
subsonic flow the jump of the normal velocity counts with a function of the local Mach number, else its dissipation grows without
bound at low speed (Rieper 2011, doi:10.1016/j.jcp.2011.03.025; the function, smooth at Mach 1: Li and Gu 2008,
doi:10.1016/j.jcp.2008.01.037). Behind the wall: the mirror state of wall.py, through it only pressure acts. Behind the outer
boundary: a given state.

Rows of the mesh are worked through in tiles of a fixed width copied to one scratch array: with offsets known to the compiler
every loop becomes SIMD code, and the tile stays in the first-level cache.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import inline, jit

GAMMA = 1.4

KAPPA = 1.0 / 3.0
SENSOR = 0.03
"""Relative second difference of pressure at which the limiter takes over."""
ALBADA = 1e-6
ENTROPY = 0.05
"""Smallest speed of the acoustic waves in Roe's dissipation, in sound speeds."""

TILE = 56
_W = TILE + 8
# slots of the scratch array, four variables each
_PREV, _CUR, _NEXT = 0 * _W, 4 * _W, 8 * _W
_RIGHT, _LEFT = 12 * _W, 16 * _W
_TOPB, _TOP, _BOTTOM = 20 * _W, 24 * _W, 28 * _W
_FI, _FJ, _ACC = 32 * _W, 36 * _W, 40 * _W
_SIZE = 44 * _W


@inline
def shock(below: float, centre: float, above: float) -> tuple[float, float]:
    """Share of van Albada's limiter (0 to 1) from three pressures, as numerator and denominator."""
    v = abs(below - 2.0 * centre + above)
    w = (below + 2.0 * centre + above) * SENSOR
    v4, w4 = (v * v) * (v * v), (w * w) * (w * w)
    return v4, v4 + w4


@inline
def limited(a: float, b: float) -> tuple[float, float]:
    """What van Albada's function takes off a slope (0 to 1) between backward (a) and forward (b) differences, as numerator and
    denominator."""
    whole = a * a + b * b + ALBADA
    return whole - max(0.0, 2.0 * a * b + ALBADA), whole


@inline
def limits(
    share: float, whole: float,
    a0: float, b0: float, a1: float, b1: float, a2: float, b2: float, a3: float, b3: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Limiters (0 to 1) on the slopes of the four variables, by one division in all: it costs as much as ten products."""
    t0, w0 = limited(a0, b0)
    t1, w1 = limited(a1, b1)
    t2, w2 = limited(a2, b2)
    t3, w3 = limited(a3, b3)
    first, last = w0 * w1, w2 * w3
    common = share / (whole * first * last)
    first, last = first * common, last * common
    return 1.0 - t0 * w1 * last, 1.0 - t1 * w0 * last, 1.0 - t2 * w3 * first, 1.0 - t3 * w2 * first


@inline
def half_slopes(a: float, b: float, limit: float) -> tuple[float, float]:
    """Half differences towards the faces behind and ahead, from backward (a) and forward (b) differences and the limiter."""
    k = KAPPA * limit
    quarter = 0.25 * limit
    return quarter * ((1.0 + k) * a + (1.0 - k) * b), quarter * ((1.0 - k) * a + (1.0 + k) * b)


@inline
def clip(slope: float, value: float) -> float:
    """Half slope of a positive quantity, at most half its value."""
    return min(max(slope, -0.5 * value), 0.5 * value)


@inline
def roe(
    nx: float, ny: float, vn: float, vx: float, vy: float,
    rl: float, ul: float, vl: float, pl: float,
    rr: float, ur: float, vr: float, pr: float,
) -> tuple[float, float, float, float]:  # fmt: skip
    """Roe's flux a unit length through a face with unit normal (nx, ny) moving at vn along it; states left and right.

    (vx, vy): velocity of the section, against which the local Mach number counts."""
    g1 = GAMMA - 1.0
    el = pl / g1 + 0.5 * rl * (ul * ul + vl * vl)
    er = pr / g1 + 0.5 * rr * (ur * ur + vr * vr)
    unl = ul * nx + vl * ny
    unr = ur * nx + vr * ny
    # face averages
    r = 0.5 * (rl + rr)
    u = 0.5 * (ul + ur)
    v = 0.5 * (vl + vr)
    p = 0.5 * (pl + pr)
    un = 0.5 * (unl + unr)
    # one division for all: a/r is the square of the speed of sound, b/a that of the local Mach number
    a = GAMMA * p
    b = ((u - vx) ** 2 + (v - vy) ** 2) * r
    ab = a + b
    one = 1.0 / (a * r * ab)
    c2, over_c2 = a * (one * a * ab), r * (one * r * ab)
    c = np.sqrt(c2)
    over_c = c * over_c2
    # share of the normal velocity's jump that counts: m sqrt(4 + (1 − m2)^2)/(1 + m2), m the Mach number
    share = min(1.0, np.sqrt(b * (one * r * ab) * (4.0 * a * a + (a - b) * (a - b))) * (one * a * r))
    h = c2 * (1.0 / g1) + 0.5 * (u * u + v * v)
    w = un - vn
    floor = ENTROPY * c
    l0, lp, lm = abs(w), abs(w + c), abs(w - c)
    half = (0.5 / ENTROPY) * over_c
    lp = lp if lp > floor else (lp * lp + floor * floor) * half
    lm = lm if lm > floor else (lm * lm + floor * floor) * half
    dp = pr - pl
    dun = (unr - unl) * share
    mean = 0.5 * (lp + lm) - l0
    skew = 0.5 * (lp - lm)
    d1 = (mean * dp + skew * r * c * dun) * over_c2
    d2 = mean * r * dun + skew * dp * over_c
    wl = unl - vn
    wr = unr - vn
    ml = rl * wl
    mr = rr * wr
    return (
        0.5 * (ml + mr - l0 * (rr - rl) - d1),
        0.5 * (ml * ul + mr * ur - l0 * (rr * ur - rl * ul) - d1 * u - d2 * nx) + p * nx,
        0.5 * (ml * vl + mr * vr - l0 * (rr * vr - rl * vl) - d1 * v - d2 * ny) + p * ny,
        0.5 * (wl * el + wr * er + unl * pl + unr * pr - l0 * (er - el) - d1 * h - d2 * un),
    )


@inline
def _load(q: Any, ni: int, row: int, i0: int, s: Any) -> None:
    """Primitive variables of one mesh row's tile, two neighbours each side, into the NEXT slot; behind them the third neighbours
    after and before, which the cut needs."""
    base = row * 4 * ni
    q0 = q[base + i0 : base + i0 + TILE]
    q1 = q[base + ni + i0 : base + ni + i0 + TILE]
    q2 = q[base + 2 * ni + i0 : base + 2 * ni + i0 + TILE]
    q3 = q[base + 3 * ni + i0 : base + 3 * ni + i0 + TILE]
    for k in range(TILE):
        r = q0[k]
        u = q1[k] / r
        v = q2[k] / r
        s[_NEXT + 2 + k] = r
        s[_NEXT + _W + 2 + k] = u
        s[_NEXT + 2 * _W + 2 + k] = v
        s[_NEXT + 3 * _W + 2 + k] = (GAMMA - 1.0) * (q3[k] - 0.5 * r * (u * u + v * v))
    for n in range(6):
        k = n if n < 2 else TILE + n
        i = (i0 + (k if n < 5 else -1) - 2 + ni) % ni
        r = q[base + i]
        u = q[base + ni + i] / r
        v = q[base + 2 * ni + i] / r
        s[_NEXT + k] = r
        s[_NEXT + _W + k] = u
        s[_NEXT + 2 * _W + k] = v
        s[_NEXT + 3 * _W + k] = (GAMMA - 1.0) * (q[base + 3 * ni + i] - 0.5 * r * (u * u + v * v))


@inline
def _reconstruct_i(s: Any) -> None:
    """States of cells −1 … TILE at their faces behind (LEFT) and ahead (RIGHT) along i."""
    for k in range(TILE + 2):
        share, whole = shock(s[_CUR + 3 * _W + k], s[_CUR + 3 * _W + k + 1], s[_CUR + 3 * _W + k + 2])
        r, u, v, p = s[_CUR + k + 1], s[_CUR + _W + k + 1], s[_CUR + 2 * _W + k + 1], s[_CUR + 3 * _W + k + 1]
        a0, b0 = r - s[_CUR + k], s[_CUR + k + 2] - r
        a1, b1 = u - s[_CUR + _W + k], s[_CUR + _W + k + 2] - u
        a2, b2 = v - s[_CUR + 2 * _W + k], s[_CUR + 2 * _W + k + 2] - v
        a3, b3 = p - s[_CUR + 3 * _W + k], s[_CUR + 3 * _W + k + 2] - p
        l0, l1, l2, l3 = limits(share, whole, a0, b0, a1, b1, a2, b2, a3, b3)
        behind, ahead = half_slopes(a0, b0, l0)
        s[_LEFT + k + 1], s[_RIGHT + k + 1] = r - clip(behind, r), r + clip(ahead, r)
        behind, ahead = half_slopes(a1, b1, l1)
        s[_LEFT + _W + k + 1], s[_RIGHT + _W + k + 1] = u - behind, u + ahead
        behind, ahead = half_slopes(a2, b2, l2)
        s[_LEFT + 2 * _W + k + 1], s[_RIGHT + 2 * _W + k + 1] = v - behind, v + ahead
        behind, ahead = half_slopes(a3, b3, l3)
        s[_LEFT + 3 * _W + k + 1], s[_RIGHT + 3 * _W + k + 1] = p - clip(behind, p), p + clip(ahead, p)


@inline
def _keep_jump(s: Any, cell: int, second: int, third: int, share: float, ahead: bool) -> None:
    """Reconstruct a cell along i by the parabola through it and the two behind it, seen from the cut.

    cell, second, third: their places in the tile's rows; share: the limiter's; ahead: whether the cut is at the cell's face
    behind, or at that ahead."""
    for m in range(4):
        value, near, far = s[_CUR + m * _W + cell], s[_CUR + m * _W + second], s[_CUR + m * _W + third]
        to_cut = 0.125 * (1.0 - share) * (7.0 * value - 10.0 * near + 3.0 * far)
        away = 0.125 * (1.0 - share) * (6.0 * near - 5.0 * value - far)
        if m == 0 or m == 3:
            to_cut, away = clip(to_cut, value), clip(away, value)
        if ahead:
            s[_LEFT + m * _W + cell] = value + to_cut
            s[_RIGHT + m * _W + cell] = value + away
        else:
            s[_RIGHT + m * _W + cell] = value + to_cut
            s[_LEFT + m * _W + cell] = value + away


@inline
def _keep_jumps(s: Any, first: int, third_last: int, third: int) -> None:
    """The cells on both sides of the cut, which lies before the place `first` of the tile's rows; third_last, third: places of
    the third cell before the cut and of the third behind it."""
    p = _CUR + 3 * _W + first
    share, whole = shock(s[p - 2], s[p - 1], s[p])
    _keep_jump(s, first - 1, first - 2, third_last, share / whole, False)
    share, whole = shock(s[p - 1], s[p], s[p + 1])
    _keep_jump(s, first, first + 1, third, share / whole, True)


@inline
def _reconstruct_j(s: Any) -> None:
    """States of cells 0 … TILE−1 at their faces below (BOTTOM) and above (TOP) along j."""
    for k in range(2, TILE + 2):
        share, whole = shock(s[_PREV + 3 * _W + k], s[_CUR + 3 * _W + k], s[_NEXT + 3 * _W + k])
        r, u, v, p = s[_CUR + k], s[_CUR + _W + k], s[_CUR + 2 * _W + k], s[_CUR + 3 * _W + k]
        a0, b0 = r - s[_PREV + k], s[_NEXT + k] - r
        a1, b1 = u - s[_PREV + _W + k], s[_NEXT + _W + k] - u
        a2, b2 = v - s[_PREV + 2 * _W + k], s[_NEXT + 2 * _W + k] - v
        a3, b3 = p - s[_PREV + 3 * _W + k], s[_NEXT + 3 * _W + k] - p
        l0, l1, l2, l3 = limits(share, whole, a0, b0, a1, b1, a2, b2, a3, b3)
        behind, ahead = half_slopes(a0, b0, l0)
        s[_BOTTOM + k], s[_TOP + k] = r - clip(behind, r), r + clip(ahead, r)
        behind, ahead = half_slopes(a1, b1, l1)
        s[_BOTTOM + _W + k], s[_TOP + _W + k] = u - behind, u + ahead
        behind, ahead = half_slopes(a2, b2, l2)
        s[_BOTTOM + 2 * _W + k], s[_TOP + 2 * _W + k] = v - behind, v + ahead
        behind, ahead = half_slopes(a3, b3, l3)
        s[_BOTTOM + 3 * _W + k], s[_TOP + 3 * _W + k] = p - clip(behind, p), p + clip(ahead, p)


@inline
def _flux(faces: Any, ni: int, row: int, i0: int, motion: Any, s: Any, left: int, right: int, out: int) -> None:
    """Roe flux times length through TILE faces of a row, from the states at slots left and right, into slot out."""
    base = row * 4 * ni + i0
    nx = faces[base : base + TILE]
    ny = faces[base + ni : base + ni + TILE]
    length = faces[base + 2 * ni : base + 2 * ni + TILE]
    arm = faces[base + 3 * ni : base + 3 * ni + TILE]
    vx, vy, rate = motion[0], motion[1], motion[2]
    for k in range(TILE):
        a, b, c, d = roe(
            nx[k], ny[k], vx * nx[k] + vy * ny[k] - rate * arm[k], vx, vy,
            s[left + k], s[left + _W + k], s[left + 2 * _W + k], s[left + 3 * _W + k],
            s[right + k], s[right + _W + k], s[right + 2 * _W + k], s[right + 3 * _W + k],
        )  # fmt: skip
        s[out + k] = a * length[k]
        s[out + _W + k] = b * length[k]
        s[out + 2 * _W + k] = c * length[k]
        s[out + 3 * _W + k] = d * length[k]


@inline
def _last_flux_i(side: Any, ni: int, row: int, i0: int, motion: Any, s: Any) -> None:
    """The flux behind the tile's last cell, through the first face of the next tile, into FI."""
    i = row * 4 * ni + (i0 + TILE) % ni
    k = TILE
    x, y, size = side[i], side[i + ni], side[i + 2 * ni]
    a, b, c, d = roe(
        x, y, motion[0] * x + motion[1] * y - motion[2] * side[i + 3 * ni], motion[0], motion[1],
        s[_RIGHT + 1 + k], s[_RIGHT + _W + 1 + k], s[_RIGHT + 2 * _W + 1 + k], s[_RIGHT + 3 * _W + 1 + k],
        s[_LEFT + 2 + k], s[_LEFT + _W + 2 + k], s[_LEFT + 2 * _W + 2 + k], s[_LEFT + 3 * _W + 2 + k],
    )  # fmt: skip
    s[_FI + k] = a * size
    s[_FI + _W + k] = b * size
    s[_FI + 2 * _W + k] = c * size
    s[_FI + 3 * _W + k] = d * size


@jit
def residual(
    q: Any, out: Any, side: Any, ring: Any, ghost: Any, pressure: Any, far: Any, motion: Any, ni: int, nj: int
) -> None:  # fmt: skip
    """Net outward flux of every cell.

    q, out: (nj·4·ni,) flat; side: (nj·4·ni,), ring: ((nj+1)·4·ni,) flat metrics of the mesh; ghost: (4·ni,) primitive state
    behind the wall; pressure: (ni,) at the wall; far: (4·ni,) primitive state behind the outer faces; motion: (3,) mesh
    velocity x, y at the origin of the moment arms and angular rate, nose-up.
    """
    s = np.empty(_SIZE)
    vx, vy, rate = motion[0], motion[1], motion[2]
    tiles = (ni + TILE - 1) // TILE
    for tile in range(tiles):
        i0 = min(tile * TILE, ni - TILE)
        # wall: mirror row into PREV, pressure flux into FJ
        _load(q, ni, 0, i0, s)
        for m in range(4):
            for k in range(TILE):
                s[_PREV + m * _W + 2 + k] = ghost[m * ni + i0 + k]
        for k in range(TILE):
            i = i0 + k
            nx, ny, length, arm = ring[i], ring[ni + i], ring[2 * ni + i], ring[3 * ni + i]
            push = pressure[i] * length
            s[_FJ + k] = 0.0
            s[_FJ + _W + k] = push * nx
            s[_FJ + 2 * _W + k] = push * ny
            s[_FJ + 3 * _W + k] = push * (vx * nx + vy * ny - rate * arm)
        for k in range(4 * _W):
            s[_CUR + k] = s[_NEXT + k]
        for j in range(nj):
            if j + 1 < nj:
                _load(q, ni, j + 1, i0, s)
            else:
                for m in range(4):
                    for k in range(TILE):
                        s[_NEXT + m * _W + 2 + k] = far[m * ni + i0 + k]
            _reconstruct_i(s)
            if i0 == 0:
                _keep_jumps(s, 2, TILE + 5, 4)
            if i0 + TILE == ni:
                _keep_jumps(s, TILE + 2, TILE - 1, TILE + 4)
            _reconstruct_j(s)
            _flux(side, ni, j, i0, motion, s, _RIGHT + 1, _LEFT + 2, _FI)
            _last_flux_i(side, ni, j, i0, motion, s)
            if j > 0:
                _flux(ring, ni, j, i0, motion, s, _TOPB + 2, _BOTTOM + 2, _FJ)
                for m in range(4):
                    row = out[((j - 1) * 4 + m) * ni + i0 : ((j - 1) * 4 + m) * ni + i0 + TILE]
                    for k in range(TILE):
                        row[k] = s[_ACC + m * _W + k] + s[_FJ + m * _W + k]
            for m in range(4):
                for k in range(TILE):
                    s[_ACC + m * _W + k] = s[_FI + m * _W + k + 1] - s[_FI + m * _W + k] - s[_FJ + m * _W + k]
            for k in range(4 * _W):
                s[_TOPB + k] = s[_TOP + k]
            for k in range(4 * _W):
                s[_PREV + k] = s[_CUR + k]
            for k in range(4 * _W):
                s[_CUR + k] = s[_NEXT + k]
        _flux(ring, ni, nj, i0, motion, s, _TOPB + 2, _CUR + 2, _FJ)
        for m in range(4):
            row = out[((nj - 1) * 4 + m) * ni + i0 : ((nj - 1) * 4 + m) * ni + i0 + TILE]
            for k in range(TILE):
                row[k] = s[_ACC + m * _W + k] + s[_FJ + m * _W + k]
