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

CALM = 0.1
"""Second difference of pressure, over the sensor's, below which nothing is limited: 1e-4 of the limiter at most."""

TILE = 56
_W = TILE + 8
# slots of the scratch array, four variables each
_PREV, _CUR, _NEXT = 0 * _W, 4 * _W, 8 * _W
_RIGHT, _LEFT = 12 * _W, 16 * _W
_TOPB, _TOP, _BOTTOM = 20 * _W, 24 * _W, 28 * _W
_FI, _FJ, _ACC = 32 * _W, 36 * _W, 40 * _W
SCRATCH = 44 * _W
"""Numbers of a tile's scratch array, whose type is that of the arithmetic."""


@inline
def shock(below: Any, centre: Any, above: Any) -> tuple[Any, Any]:
    """Share of van Albada's limiter (0 to 1) from three pressures, as numerator and denominator."""
    t = type(centre)
    v = abs(below - t(2.0) * centre + above)
    w = (below + t(2.0) * centre + above) * t(SENSOR)
    v4, w4 = (v * v) * (v * v), (w * w) * (w * w)
    return max(t(0.0), v4 - t(CALM**4) * w4), v4 + w4


@inline
def limited(a: Any, b: Any) -> tuple[Any, Any]:
    """What van Albada's function takes off a slope (0 to 1) between backward (a) and forward (b) differences, as numerator and
    denominator."""
    t = type(a)
    whole = a * a + b * b + t(ALBADA)
    return whole - max(t(0.0), t(2.0) * a * b + t(ALBADA)), whole


@inline
def limits(
    share: Any, whole: Any, a0: Any, b0: Any, a1: Any, b1: Any, a2: Any, b2: Any, a3: Any, b3: Any
) -> tuple[Any, Any, Any, Any]:
    """Limiters (0 to 1) on the slopes of the four variables, by one division in all: it costs as much as ten products."""
    one = type(a0)(1.0)
    t0, w0 = limited(a0, b0)
    t1, w1 = limited(a1, b1)
    t2, w2 = limited(a2, b2)
    t3, w3 = limited(a3, b3)
    first, last = w0 * w1, w2 * w3
    common = share / (whole * first * last)
    first, last = first * common, last * common
    return one - t0 * w1 * last, one - t1 * w0 * last, one - t2 * w3 * first, one - t3 * w2 * first


@inline
def half_slopes(a: Any, b: Any, limit: Any) -> tuple[Any, Any]:
    """Half differences towards the faces behind and ahead, from backward (a) and forward (b) differences and the limiter."""
    t = type(a)
    one, k, quarter = t(1.0), t(KAPPA) * limit, t(0.25) * limit
    return quarter * ((one + k) * a + (one - k) * b), quarter * ((one - k) * a + (one + k) * b)


@inline
def clip(slope: Any, value: Any) -> Any:
    """Half slope of a positive quantity, at most half its value."""
    most = type(value)(0.5) * value
    return min(max(slope, -most), most)


@inline
def roe(
    nx: Any, ny: Any, vn: Any, vx: Any, vy: Any, rl: Any, ul: Any, vl: Any, pl: Any, rr: Any, ur: Any, vr: Any, pr: Any
) -> tuple[Any, Any, Any, Any]:
    """Roe's flux a unit length through a face with unit normal (nx, ny) moving at vn along it; states left and right.

    (vx, vy): velocity of the section, against which the local Mach number counts."""
    t = type(rl)
    one, half, quarter, over_g1 = t(1.0), t(0.5), t(0.25), t(1.0 / (GAMMA - 1.0))
    # averages and jumps: every flux of the two sides is a polynomial in them, with a third of the work
    r, u, v, p = half * (rl + rr), half * (ul + ur), half * (vl + vr), half * (pl + pr)
    dr, du, dv, dp = rr - rl, ur - ul, vr - vl, pr - pl
    un, dw = u * nx + v * ny, du * nx + dv * ny
    w = un - vn
    # one division for all: a/r is the square of the speed of sound, b/a that of the local Mach number
    a = t(GAMMA) * p
    b = ((u - vx) * (u - vx) + (v - vy) * (v - vy)) * r
    ab = a + b
    over = one / (a * r * ab)
    over_ar = over * ab
    c2, over_c2 = a * a * over_ar, r * r * over_ar
    c = np.sqrt(c2)
    over_c = c * over_c2
    # share of the normal velocity's jump that counts: m sqrt(4 + (1 − m2)^2)/(1 + m2), m the Mach number
    share = min(one, np.sqrt(b * r * over_ar * (t(4.0) * a * a + (a - b) * (a - b))) * (over * a * r))
    floor, flatter = t(ENTROPY) * c, t(0.5 / ENTROPY) * over_c
    l0, lp, lm = abs(w), abs(w + c), abs(w - c)
    lp = lp if lp > floor else (lp * lp + floor * floor) * flatter
    lm = lm if lm > floor else (lm * lm + floor * floor) * flatter
    mean, skew = half * (lp + lm) - l0, half * (lp - lm)
    dun = dw * share
    d1 = (mean * dp + skew * r * c * dun) * over_c2
    d2 = mean * r * dun + skew * dp * over_c
    mass = r * w + quarter * dr * dw - half * (l0 * dr + d1)
    along = quarter * (r * dw + w * dr) - half * l0 * r
    push = p - half * d2
    # kinetic energy: twice its average a unit mass, and half its jump
    k = u * u + v * v
    both, jump = k + quarter * (du * du + dv * dv), u * du + v * dv
    e = p * over_g1 + half * (r * both + half * dr * jump)
    de = dp * over_g1 + r * jump + half * both * dr
    h = c2 * over_g1 + half * k
    return (
        mass,
        u * mass + du * along + nx * push,
        v * mass + dv * along + ny * push,
        e * w + de * (quarter * dw - half * l0) + un * p + quarter * dw * dp - half * (d1 * h + d2 * un),
    )


@jit
def _load(q: Any, ni: int, row: int, i0: int, beside: Any, s: Any) -> None:
    """Primitive variables of one mesh row's tile, two neighbours each side, into the NEXT slot; behind them the third neighbours
    after and before, which the cut needs. beside: columns of these six."""
    t = s.dtype.type
    base = row * 4 * ni
    for m in range(4):
        line = q[base + m * ni + i0 : base + m * ni + i0 + TILE]
        for k in range(TILE):
            s[_NEXT + m * _W + 2 + k] = line[k]
    for k in range(_NEXT + 2, _NEXT + 2 + TILE):
        one = t(1.0) / s[k]
        u = s[_W + k] * one
        v = s[2 * _W + k] * one
        s[_W + k] = u
        s[2 * _W + k] = v
        s[3 * _W + k] = t(GAMMA - 1.0) * (s[3 * _W + k] - t(0.5) * s[k] * (u * u + v * v))
    for n in range(6):
        k = _NEXT + (n if n < 2 else TILE + n)
        i = base + beside[n]
        one = t(1.0) / t(q[i])
        u = t(q[i + ni]) * one
        v = t(q[i + 2 * ni]) * one
        s[k] = q[i]
        s[_W + k] = u
        s[2 * _W + k] = v
        s[3 * _W + k] = t(GAMMA - 1.0) * (t(q[i + 3 * ni]) - t(0.5) * s[k] * (u * u + v * v))


@jit
def _reconstruct(before: Any, here: Any, after: Any, back: Any, ahead: Any, many: int) -> None:
    """States of `many` cells, a multiple of 8, at their faces behind and ahead, from those of the cells before, here and after:
    slots of the scratch array, or parts of them."""
    t = here.dtype.type
    rough = t(0.0)
    for k in range(many):
        below, p, above = before[3 * _W + k], here[3 * _W + k], after[3 * _W + k]
        v, w = below - t(2.0) * p + above, (below + t(2.0) * p + above) * t(CALM * SENSOR)
        rough += max(t(0.0), v * v - w * w)  # a sum, not the largest: it is SIMD code
    if rough > t(0.0):
        for k in range(many):
            r, u, v, p = here[k], here[_W + k], here[2 * _W + k], here[3 * _W + k]
            share, whole = shock(before[3 * _W + k], p, after[3 * _W + k])
            a0, b0 = r - before[k], after[k] - r
            a1, b1 = u - before[_W + k], after[_W + k] - u
            a2, b2 = v - before[2 * _W + k], after[2 * _W + k] - v
            a3, b3 = p - before[3 * _W + k], after[3 * _W + k] - p
            l0, l1, l2, l3 = limits(share, whole, a0, b0, a1, b1, a2, b2, a3, b3)
            low, high = half_slopes(a0, b0, l0)
            back[k], ahead[k] = r - clip(low, r), r + clip(high, r)
            low, high = half_slopes(a1, b1, l1)
            back[_W + k], ahead[_W + k] = u - low, u + high
            low, high = half_slopes(a2, b2, l2)
            back[2 * _W + k], ahead[2 * _W + k] = v - low, v + high
            low, high = half_slopes(a3, b3, l3)
            back[3 * _W + k], ahead[3 * _W + k] = p - clip(low, p), p + clip(high, p)
    else:
        for m in range(4):
            for k in range(many):
                value = here[m * _W + k]
                low, high = half_slopes(value - before[m * _W + k], after[m * _W + k] - value, t(1.0))
                if m == 0 or m == 3:
                    low, high = clip(low, value), clip(high, value)
                back[m * _W + k], ahead[m * _W + k] = value - low, value + high


@inline
def _keep_jump(s: Any, cell: int, second: int, third: int, share: Any, ahead: bool) -> None:
    """Reconstruct a cell along i by the parabola through it and the two behind it, seen from the cut.

    cell, second, third: their places in the tile's rows; share: the limiter's; ahead: whether the cut is at the cell's face
    behind, or at that ahead."""
    t = s.dtype.type
    for m in range(4):
        value, near, far = s[_CUR + m * _W + cell], s[_CUR + m * _W + second], s[_CUR + m * _W + third]
        eighth = t(0.125) * (t(1.0) - share)
        to_cut = eighth * (t(7.0) * value - t(10.0) * near + t(3.0) * far)
        away = eighth * (t(6.0) * near - t(5.0) * value - far)
        if m == 0 or m == 3:
            to_cut, away = clip(to_cut, value), clip(away, value)
        if ahead:
            s[_LEFT + m * _W + cell] = value + to_cut
            s[_RIGHT + m * _W + cell] = value + away
        else:
            s[_RIGHT + m * _W + cell] = value + to_cut
            s[_LEFT + m * _W + cell] = value + away


@jit
def _keep_jumps(s: Any, first: int, third_last: int, third: int) -> None:
    """The cells on both sides of the cut, which lies before the place `first` of the tile's rows; third_last, third: places of
    the third cell before the cut and of the third behind it."""
    p = _CUR + 3 * _W + first
    share, whole = shock(s[p - 2], s[p - 1], s[p])
    _keep_jump(s, first - 1, first - 2, third_last, share / whole, False)
    share, whole = shock(s[p - 1], s[p], s[p + 1])
    _keep_jump(s, first, first + 1, third, share / whole, True)


def tiled_faces(side: np.ndarray, ring: np.ndarray, kind: Any) -> tuple[np.ndarray, np.ndarray]:
    """Metrics of a mesh's faces in the order in which `residual` reads them, and its scratch; flat, of the number type `kind`.

    side: (nj, 4, ni); ring: (nj+1, 4, ni). For each row and tile those of the faces below its cells and those between them, the
    face behind the last cell with them."""
    nj, _, ni = side.shape
    tiles = -(-ni // TILE)
    faces = np.ones((nj + 1, tiles, 2, 4, _W), dtype=kind)
    for tile in range(tiles):
        columns = (min(tile * TILE, ni - TILE) + np.arange(TILE + 1)) % ni
        faces[:, tile, 0, :, : TILE + 1] = ring[:, :, columns]
        faces[:nj, tile, 1, :, : TILE + 1] = side[:, :, columns]
    return faces.reshape(-1), np.ones(tiles * SCRATCH, dtype=kind)


@jit
def _flux(vx: Any, vy: Any, rate: Any, face: Any, left: Any, right: Any, out: Any, many: int) -> None:
    """Roe flux times length through `many` faces, from the states left and right of them: slots of the scratch array, or parts
    of them."""
    for k in range(many):
        nx, ny, length, arm = face[k], face[_W + k], face[2 * _W + k], face[3 * _W + k]
        a, b, c, d = roe(
            nx, ny, vx * nx + vy * ny - rate * arm, vx, vy,
            left[k], left[_W + k], left[2 * _W + k], left[3 * _W + k],
            right[k], right[_W + k], right[2 * _W + k], right[3 * _W + k],
        )  # fmt: skip
        out[k] = a * length
        out[_W + k] = b * length
        out[2 * _W + k] = c * length
        out[3 * _W + k] = d * length


@jit
def _put_out(out: Any, ni: int, row: int, i0: int, s: Any) -> None:
    """What leaves the cells of a row: ACC and, through the faces above, FJ."""
    for m in range(4):
        line = out[(row * 4 + m) * ni + i0 : (row * 4 + m) * ni + i0 + TILE]
        for k in range(TILE):
            line[k] = s[_ACC + m * _W + k] + s[_FJ + m * _W + k]


@jit
def residual(
    q: Any, out: Any, faces: Any, scratch: Any, ghost: Any, pressure: Any, far: Any, motion: Any, ni: int, nj: int
) -> None:  # fmt: skip
    """Net outward flux of every cell.

    q, out: (nj·4·ni,) flat; faces, scratch: of `tiled_faces`; the number type of these two, float64 or float32, is
    that of the arithmetic; ghost: (4·ni,) primitive state behind the wall; pressure: (ni,) at the wall; far: (4·ni,) primitive
    state behind the outer faces; motion: (3,) mesh velocity x, y at the origin of the moment arms and angular rate, nose-up.
    """
    t = scratch.dtype.type
    vx, vy, rate = t(motion[0]), t(motion[1]), t(motion[2])
    tiles = (ni + TILE - 1) // TILE
    beside = np.empty((tiles, 6), dtype=np.int64)
    for tile in range(tiles):
        i0, s = min(tile * TILE, ni - TILE), scratch[tile * SCRATCH : (tile + 1) * SCRATCH]
        for n in range(6):
            beside[tile, n] = (i0 + (-2 + n if n < 2 else TILE - 2 + n if n < 5 else -3) + ni) % ni
        # wall: mirror row into PREV, pressure flux into FJ
        _load(q, ni, 0, i0, beside[tile], s)
        for m in range(4):
            for k in range(TILE):
                s[_PREV + m * _W + 2 + k] = ghost[m * ni + i0 + k]
        face = faces[tile * 8 * _W : (tile + 1) * 8 * _W]
        for k in range(TILE):
            nx, ny, length, arm = face[k], face[_W + k], face[2 * _W + k], face[3 * _W + k]
            push = length * t(pressure[i0 + k])
            s[_FJ + k] = 0.0
            s[_FJ + _W + k] = push * nx
            s[_FJ + 2 * _W + k] = push * ny
            s[_FJ + 3 * _W + k] = push * (vx * nx + vy * ny - rate * arm)
        for k in range(4 * _W):
            s[_CUR + k] = s[_NEXT + k]
    # row by row, all its tiles: memory is read and written from one end to the other
    for j in range(nj):
        for tile in range(tiles):
            i0, s = min(tile * TILE, ni - TILE), scratch[tile * SCRATCH : (tile + 1) * SCRATCH]
            face = faces[(j * tiles + tile) * 8 * _W : (j * tiles + tile + 1) * 8 * _W]
            if j + 1 < nj:
                _load(q, ni, j + 1, i0, beside[tile], s)
            else:
                for m in range(4):
                    for k in range(TILE):
                        s[_NEXT + m * _W + 2 + k] = far[m * ni + i0 + k]
            # cells −1 … TILE, and places behind them that fill up a vector
            _reconstruct(s[_CUR:], s[_CUR + 1 :], s[_CUR + 2 :], s[_LEFT + 1 :], s[_RIGHT + 1 :], _W)
            if i0 == 0:
                _keep_jumps(s, 2, TILE + 5, 4)
            if i0 + TILE == ni:
                _keep_jumps(s, TILE + 2, TILE - 1, TILE + 4)
            _reconstruct(s[_PREV + 2 :], s[_CUR + 2 :], s[_NEXT + 2 :], s[_BOTTOM + 2 :], s[_TOP + 2 :], TILE)
            if j > 0:
                _flux(vx, vy, rate, face, s[_TOPB + 2 :], s[_BOTTOM + 2 :], s[_FJ:], TILE)
                _put_out(out, ni, j - 1, i0, s)
            _flux(vx, vy, rate, face[4 * _W :], s[_RIGHT + 1 :], s[_LEFT + 2 :], s[_FI:], _W)
            for m in range(4):
                for k in range(TILE):
                    s[_ACC + m * _W + k] = s[_FI + m * _W + k + 1] - s[_FI + m * _W + k] - s[_FJ + m * _W + k]
            for k in range(4 * _W):
                s[_TOPB + k] = s[_TOP + k]
            for k in range(4 * _W):
                s[_PREV + k] = s[_CUR + k]
            for k in range(4 * _W):
                s[_CUR + k] = s[_NEXT + k]
    for tile in range(tiles):
        i0, s = min(tile * TILE, ni - TILE), scratch[tile * SCRATCH : (tile + 1) * SCRATCH]
        face = faces[(nj * tiles + tile) * 8 * _W : (nj * tiles + tile + 1) * 8 * _W]
        _flux(vx, vy, rate, face, s[_TOPB + 2 :], s[_CUR + 2 :], s[_FJ:], TILE)
        _put_out(out, ni, nj - 1, i0, s)
