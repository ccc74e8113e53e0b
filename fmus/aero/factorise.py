"""Factors of block-tridiagonal lines, LANES lines at a time in float32.

Layout of factors: [line group][cell][matrix][entry][LANES]; see implicit.py for what they are used for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import inline, jit

LANES = 16
MATRIX = 16 * LANES
"""Numbers of LANES 4 x 4 matrices side by side."""
PACKED = MATRIX // 2
"""Words of LANES matrices whose entries are packed."""

# matrices of the lines in hand, in one work array at compile-time offsets
_DIAGONAL, _LOWER, _UPPER = 0 * MATRIX, 1 * MATRIX, 2 * MATRIX
_INVERSE, _PRODUCT, _SPARE = 3 * MATRIX, 4 * MATRIX, 5 * MATRIX
_BEFORE, _SPIKE, _RESULT = 6 * MATRIX, 7 * MATRIX, 8 * MATRIX
_WORK = 9 * MATRIX


@jit
def pack(bits: Any) -> Any:
    """Factors with two entries a word, rounded to 8 bits each (bfloat16: by 0.4 % at most).

    bits: the float32 entries read as uint32, flat; entry 2 n is in the low half of what is returned, 2 n + 1 in the high half.
    The high one is read with the low one's bits behind it, and is rounded so that this comes nearest."""
    out = np.empty(bits.size // 2, dtype=np.uint32)
    for pair in range(bits.size // (2 * LANES)):
        for l in range(LANES):
            low = np.uint32((bits[2 * pair * LANES + l] + np.uint32(0x8000)) >> np.uint32(16))
            high = bits[(2 * pair + 1) * LANES + l]
            # sign and magnitude: adding to the bits moves away from zero; a zero stays one
            top = np.uint32(0) if high < low else np.uint32((high - low + np.uint32(0x8000)) & np.uint32(0xFFFF0000))
            out[pair * LANES + l] = top | low
    return out


@inline
def _invert(w: Any, source: int, target: int) -> None:
    """target = source^-1 for LANES matrices, Gauss–Jordan; source is destroyed. No pivoting: the blocks are dominant."""
    for k in range(MATRIX):
        w[target + k] = 0.0
    for m in range(4):
        for l in range(LANES):
            w[target + 5 * m * LANES + l] = 1.0
    for m in range(4):
        for l in range(LANES):
            factor = np.float32(1.0) / w[source + 5 * m * LANES + l]
            for b in range(4):
                w[source + (4 * m + b) * LANES + l] *= factor
                w[target + (4 * m + b) * LANES + l] *= factor
        for a in range(4):
            if a != m:
                for l in range(LANES):
                    f = w[source + (4 * a + m) * LANES + l]
                    for b in range(4):
                        w[source + (4 * a + b) * LANES + l] -= f * w[source + (4 * m + b) * LANES + l]
                        w[target + (4 * a + b) * LANES + l] -= f * w[target + (4 * m + b) * LANES + l]


@inline
def _multiply(w: Any, first: int, second: int, target: int) -> None:
    """target = first·second for LANES matrices."""
    for a in range(4):
        for b in range(4):
            for l in range(LANES):
                w[target + (4 * a + b) * LANES + l] = (
                    w[first + 4 * a * LANES + l] * w[second + b * LANES + l]
                    + w[first + (4 * a + 1) * LANES + l] * w[second + (4 + b) * LANES + l]
                    + w[first + (4 * a + 2) * LANES + l] * w[second + (8 + b) * LANES + l]
                    + w[first + (4 * a + 3) * LANES + l] * w[second + (12 + b) * LANES + l]
                )


@inline
def _copy(source: Any, at: int, target: Any, to: int) -> None:
    for k in range(MATRIX):
        target[to + k] = source[at + k]


@inline
def _subtract(w: Any, what: int, target: int) -> None:
    for k in range(MATRIX):
        w[target + k] -= w[what + k]


@inline
def _gather(blocks: Any, shift: Any, first: int, count: int, stride: int, w: Any, to: int, padding: float) -> None:
    """LANES blocks (flat, 16 each) from `first` on, `stride` blocks apart, side by side; shift on their diagonals.

    Lanes beyond count get padding on the diagonal.
    """
    for k in range(MATRIX):
        w[to + k] = 0.0
    for l in range(LANES):
        if l < count:
            block = blocks[16 * (first + l * stride) : 16 * (first + l * stride) + 16]
            for k in range(16):
                w[to + k * LANES + l] = block[k]
            if padding != 0.0:
                for m in range(4):
                    w[to + 5 * m * LANES + l] += shift[first + l * stride]
        else:
            for m in range(4):
                w[to + 5 * m * LANES + l] = padding


@jit
def factorise_around(diagonal: Any, back: Any, ahead: Any, shift: Any, ni: int, nj: int, around: Any) -> None:
    """Factors of the closed lines along i for the diagonal blocks plus shift·I.

    diagonal, back, ahead: flat (nj·ni·16,) blocks of a cell and of its neighbours i−1, i+1; shift: (nj·ni,);
    around: flat (groups of j · ni · 4 matrices · 16 · LANES,) float32, written: inverse pivot, pivot·lower, pivot·upper and
    the response to the last cell.
    """
    w = np.zeros(_WORK, dtype=np.float32)
    last = ni - 1
    for g in range((nj + LANES - 1) // LANES):
        count = min(LANES, nj - g * LANES)
        for i in range(last):
            first = g * LANES * ni + i
            _gather(diagonal, shift, first, count, ni, w, _DIAGONAL, 1.0)
            _gather(back, shift, first, count, ni, w, _LOWER, 0.0)
            _gather(ahead, shift, first, count, ni, w, _UPPER, 0.0)
            f = around[(g * ni + i) * 4 * MATRIX : (g * ni + i + 1) * 4 * MATRIX]
            if i > 0:
                _multiply(w, _LOWER, _BEFORE, _PRODUCT)
                _subtract(w, _PRODUCT, _DIAGONAL)
            _invert(w, _DIAGONAL, _INVERSE)
            _multiply(w, _INVERSE, _LOWER, _SPARE)
            _multiply(w, _INVERSE, _UPPER, _RESULT)
            # the response to the last cell starts from its coupling into cells 0 and last − 1
            if i == 0:
                _copy(w, _SPARE, w, _SPIKE)
            else:
                _multiply(w, _SPARE, _SPIKE, _PRODUCT)
                for k in range(MATRIX):
                    w[_SPIKE + k] = -w[_PRODUCT + k]
            if i == last - 1:
                for k in range(MATRIX):
                    w[_SPIKE + k] += w[_RESULT + k]
                    w[_RESULT + k] = 0.0
            if i == 0:
                for k in range(MATRIX):
                    w[_SPARE + k] = 0.0
            _copy(w, _INVERSE, f, 0)
            _copy(w, _SPARE, f, MATRIX)
            _copy(w, _RESULT, f, 2 * MATRIX)
            _copy(w, _SPIKE, f, 3 * MATRIX)
            _copy(w, _RESULT, w, _BEFORE)
        for i in range(last - 2, -1, -1):
            f = around[(g * ni + i) * 4 * MATRIX : (g * ni + i + 1) * 4 * MATRIX]
            _copy(f, 2 * MATRIX, w, _UPPER)
            _multiply(w, _UPPER, _SPIKE, _PRODUCT)
            _copy(f, 3 * MATRIX, w, _SPIKE)
            _subtract(w, _PRODUCT, _SPIKE)
            _copy(w, _SPIKE, f, 3 * MATRIX)
        # the last cell: what remains of its block once the others are eliminated
        first = g * LANES * ni + last
        _gather(diagonal, shift, first, count, ni, w, _DIAGONAL, 1.0)
        _gather(back, shift, first, count, ni, w, _LOWER, 0.0)
        _gather(ahead, shift, first, count, ni, w, _UPPER, 0.0)
        _multiply(w, _UPPER, _SPIKE, _PRODUCT)
        _subtract(w, _PRODUCT, _DIAGONAL)
        before = around[(g * ni + last - 1) * 4 * MATRIX : (g * ni + last) * 4 * MATRIX]
        _copy(before, 3 * MATRIX, w, _SPIKE)
        _multiply(w, _LOWER, _SPIKE, _PRODUCT)
        _subtract(w, _PRODUCT, _DIAGONAL)
        _invert(w, _DIAGONAL, _INVERSE)
        _multiply(w, _INVERSE, _LOWER, _SPARE)
        _multiply(w, _INVERSE, _UPPER, _RESULT)
        f = around[(g * ni + last) * 4 * MATRIX : (g * ni + last + 1) * 4 * MATRIX]
        _copy(w, _INVERSE, f, 0)
        _copy(w, _SPARE, f, MATRIX)
        _copy(w, _RESULT, f, 2 * MATRIX)


@jit
def factorise_across(diagonal: Any, below: Any, above: Any, shift: Any, ni: int, nj: int, across: Any) -> None:
    """Factors of the lines along j of D^-1 [D + Lj], so that the product of both sweeps needs no extra multiplication.

    Arguments as for factorise_around, below and above being the neighbours j−1, j+1; across: flat (groups of i · nj ·
    3 matrices · 16 · LANES,) float32, written: inverse pivot, pivot·lower, pivot·upper.
    """
    w = np.zeros(_WORK, dtype=np.float32)
    for g in range((ni + LANES - 1) // LANES):
        count = min(LANES, ni - g * LANES)
        for j in range(nj):
            first = j * ni + g * LANES
            _gather(diagonal, shift, first, count, 1, w, _DIAGONAL, 1.0)
            _gather(below, shift, first, count, 1, w, _LOWER, 0.0)
            _gather(above, shift, first, count, 1, w, _UPPER, 0.0)
            _invert(w, _DIAGONAL, _INVERSE)
            _multiply(w, _INVERSE, _LOWER, _SPARE)
            _multiply(w, _INVERSE, _UPPER, _RESULT)
            # pivot I − lower·(upper of the cell before)
            for k in range(MATRIX):
                w[_DIAGONAL + k] = 0.0
            if j > 0:
                _multiply(w, _SPARE, _BEFORE, _PRODUCT)
                _subtract(w, _PRODUCT, _DIAGONAL)
            for m in range(4):
                for l in range(LANES):
                    w[_DIAGONAL + 5 * m * LANES + l] += 1.0
            _invert(w, _DIAGONAL, _INVERSE)
            _multiply(w, _INVERSE, _SPARE, _PRODUCT)
            _multiply(w, _INVERSE, _RESULT, _BEFORE)
            f = across[(g * nj + j) * 3 * MATRIX : (g * nj + j + 1) * 3 * MATRIX]
            _copy(w, _INVERSE, f, 0)
            _copy(w, _PRODUCT, f, MATRIX)
            _copy(w, _BEFORE, f, 2 * MATRIX)
