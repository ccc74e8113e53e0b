"""Factors of block-tridiagonal lines, LANES lines at a time in float32.

Layout of factors: [line group][cell][matrix][entry][LANES]; see implicit.py for what they are used for.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import jit

LANES = 16
MATRIX = 16 * LANES
"""Numbers of LANES 4 x 4 matrices side by side."""
UNFELT = np.float32(1e-6)
"""Entry of a response that makes no difference beside what packing loses of the others, 4e-3 of each."""
PACKED = MATRIX // 2
"""Words of LANES matrices whose entries are packed."""


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


@jit
def _invert(source: Any, target: Any) -> None:
    """target = source^-1 for LANES matrices, Gauss–Jordan; source is destroyed. No pivoting: the blocks are dominant."""
    for k in range(MATRIX):
        target[k] = 0.0
    for m in range(4):
        for l in range(LANES):
            target[5 * m * LANES + l] = 1.0
    for m in range(4):
        for l in range(LANES):
            factor = np.float32(1.0) / source[5 * m * LANES + l]
            for b in range(4):
                source[(4 * m + b) * LANES + l] *= factor
                target[(4 * m + b) * LANES + l] *= factor
        for a in range(4):
            if a != m:
                for l in range(LANES):
                    f = source[(4 * a + m) * LANES + l]
                    for b in range(4):
                        source[(4 * a + b) * LANES + l] -= f * source[(4 * m + b) * LANES + l]
                        target[(4 * a + b) * LANES + l] -= f * target[(4 * m + b) * LANES + l]


@jit
def _multiply(first: Any, second: Any, target: Any) -> None:
    """target = first·second for LANES matrices."""
    for a in range(4):
        for b in range(4):
            for l in range(LANES):
                target[(4 * a + b) * LANES + l] = (
                    first[4 * a * LANES + l] * second[b * LANES + l]
                    + first[(4 * a + 1) * LANES + l] * second[(4 + b) * LANES + l]
                    + first[(4 * a + 2) * LANES + l] * second[(8 + b) * LANES + l]
                    + first[(4 * a + 3) * LANES + l] * second[(12 + b) * LANES + l]
                )


@jit
def _copy(source: Any, at: int, target: Any, to: int) -> None:
    for k in range(MATRIX):
        target[to + k] = source[at + k]


@jit
def _subtract(what: Any, target: Any) -> None:
    for k in range(MATRIX):
        target[k] -= what[k]


@jit
def _gather(blocks: Any, shift: Any, first: int, count: int, stride: int, target: Any, padding: float) -> None:
    """LANES blocks (flat, 16 each) from `first` on, `stride` blocks apart, side by side; shift on their diagonals.

    Lanes beyond count get padding on the diagonal.
    """
    for k in range(MATRIX):
        target[k] = 0.0
    for l in range(LANES):
        if l < count:
            at = 16 * (first + l * stride)
            for k in range(16):
                target[k * LANES + l] = blocks[at + k]
            if padding != 0.0:
                for m in range(4):
                    target[5 * m * LANES + l] += shift[first + l * stride]
        else:
            for m in range(4):
                target[5 * m * LANES + l] = padding


@jit
def factorise_around(
    diagonal: Any, back: Any, ahead: Any, shift: Any, ni: int, nj: int, around: Any, spikes: Any
) -> None:  # fmt: skip
    """Factors of the closed lines along i for the diagonal blocks plus shift·I.

    diagonal, back, ahead: flat (nj·ni·16,) blocks of a cell and of its neighbours i−1, i+1; shift: (nj·ni,);
    around: flat (groups of j · ni · 3 matrices · 16 · LANES,) float32, written: inverse pivot, pivot·lower, pivot·upper; spikes:
    flat (groups of j · ni · 16 · LANES,), written: the response to the last cell.
    """
    middle, lower, upper = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    inverse, product, by_lower = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    by_upper, before, spike = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    last = ni - 1
    for g in range((nj + LANES - 1) // LANES):
        count = min(LANES, nj - g * LANES)
        for i in range(last):
            first = g * LANES * ni + i
            _gather(diagonal, shift, first, count, ni, middle, 1.0)
            _gather(back, shift, first, count, ni, lower, 0.0)
            _gather(ahead, shift, first, count, ni, upper, 0.0)
            f = (g * ni + i) * 3 * MATRIX
            if i > 0:
                _multiply(lower, before, product)
                _subtract(product, middle)
            _invert(middle, inverse)
            _multiply(inverse, lower, by_lower)
            _multiply(inverse, upper, by_upper)
            # the response to the last cell starts from its coupling into cells 0 and last − 1
            if i == 0:
                _copy(by_lower, 0, spike, 0)
            else:
                _multiply(by_lower, spike, product)
                for k in range(MATRIX):
                    spike[k] = -product[k]
            if i == last - 1:
                for k in range(MATRIX):
                    spike[k] += by_upper[k]
                    by_upper[k] = 0.0
            if i == 0:
                for k in range(MATRIX):
                    by_lower[k] = 0.0
            _copy(inverse, 0, around, f)
            _copy(by_lower, 0, around, f + MATRIX)
            _copy(by_upper, 0, around, f + 2 * MATRIX)
            _copy(spike, 0, spikes, (g * ni + i) * MATRIX)
            _copy(by_upper, 0, before, 0)
        for i in range(last - 2, -1, -1):
            f = (g * ni + i) * 3 * MATRIX
            _copy(around, f + 2 * MATRIX, upper, 0)
            _multiply(upper, spike, product)
            _copy(spikes, (g * ni + i) * MATRIX, spike, 0)
            _subtract(product, spike)
            _copy(spike, 0, spikes, (g * ni + i) * MATRIX)
        # the last cell: what remains of its block once the others are eliminated
        first = g * LANES * ni + last
        _gather(diagonal, shift, first, count, ni, middle, 1.0)
        _gather(back, shift, first, count, ni, lower, 0.0)
        _gather(ahead, shift, first, count, ni, upper, 0.0)
        _multiply(upper, spike, product)
        _subtract(product, middle)
        _copy(spikes, (g * ni + last - 1) * MATRIX, spike, 0)
        _multiply(lower, spike, product)
        _subtract(product, middle)
        _invert(middle, inverse)
        _multiply(inverse, lower, by_lower)
        _multiply(inverse, upper, by_upper)
        f = (g * ni + last) * 3 * MATRIX
        _copy(inverse, 0, around, f)
        _copy(by_lower, 0, around, f + MATRIX)
        _copy(by_upper, 0, around, f + 2 * MATRIX)


@jit
def felt(spikes: Any, ni: int, ends: Any) -> None:
    """Where the response to the last cell (`factorise_around`) is felt: ends: (groups of j, 2), written: the cells before the
    first number and from the second on. Elsewhere no entry of it exceeds UNFELT: it falls fast with the distance."""
    for g in range(ends.shape[0]):
        first, second = 0, ni - 1
        for i in range(ni - 1):
            most = np.float32(0.0)
            for k in range((g * ni + i) * MATRIX, (g * ni + i + 1) * MATRIX):
                most = max(most, abs(spikes[k]))
            if most > UNFELT:
                if i < ni // 2:
                    first = i + 1
                elif second == ni - 1:
                    second = i
        ends[g, 0], ends[g, 1] = first, second


@jit
def factorise_across(diagonal: Any, below: Any, above: Any, shift: Any, ni: int, nj: int, across: Any) -> None:
    """Factors of the lines along j of D^-1 [D + Lj], so that the product of both sweeps needs no extra multiplication.

    Arguments as for factorise_around, below and above being the neighbours j−1, j+1; across: flat (groups of i · nj ·
    3 matrices · 16 · LANES,) float32, written: inverse pivot, pivot·lower, pivot·upper.
    """
    middle, lower, upper = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    inverse, product, before = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    by_lower, by_upper = np.zeros(MATRIX, np.float32), np.zeros(MATRIX, np.float32)
    for g in range((ni + LANES - 1) // LANES):
        count = min(LANES, ni - g * LANES)
        for j in range(nj):
            first = j * ni + g * LANES
            _gather(diagonal, shift, first, count, 1, middle, 1.0)
            _gather(below, shift, first, count, 1, lower, 0.0)
            _gather(above, shift, first, count, 1, upper, 0.0)
            _invert(middle, inverse)
            _multiply(inverse, lower, by_lower)
            _multiply(inverse, upper, by_upper)
            # pivot I − lower·(upper of the cell before)
            for k in range(MATRIX):
                middle[k] = 0.0
            if j > 0:
                _multiply(by_lower, before, product)
                _subtract(product, middle)
            for m in range(4):
                for l in range(LANES):
                    middle[5 * m * LANES + l] += 1.0
            _invert(middle, inverse)
            _multiply(inverse, by_lower, product)
            _multiply(inverse, by_upper, before)
            f = (g * nj + j) * 3 * MATRIX
            _copy(inverse, 0, across, f)
            _copy(product, 0, across, f + MATRIX)
            _copy(before, 0, across, f + 2 * MATRIX)
