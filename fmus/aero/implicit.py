"""Approximate inverse of the linearised residual: diagonally dominant ADI (DDADI) on block-tridiagonal lines.

(V a/dt + V/dtau + dR/dq) x = r is approximated by [D + Li] D^-1 [D + Lj] x = r, where dR/dq is the first-order upwind
(Roe) linearisation: D its block diagonal, Li and Lj its neighbours along i (closed lines around the section) and j.
Source: Bardina and Lombard, AIAA 87-1114; MacCormack and Pulliam, AIAA 98-2821 (DDADI).

Blocks are factorised now and then and applied often, in float32: 16 lines at a time side by side, so that every operation is
one SIMD instruction. Factor layout: [line group][cell][matrix entry][16 lines].
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiled import inline, jit
from .jacobian import assemble
from .mesh import Mesh

LANES = 16
_VECTOR = 4 * LANES
_MATRIX = 16 * LANES

Float32 = NDArray[np.float32]
Array = NDArray[np.float64]


# matrices of the lines in hand, in one work array at compile-time offsets
_DIAGONAL, _LOWER, _UPPER = 0 * _MATRIX, 1 * _MATRIX, 2 * _MATRIX
_INVERSE, _PRODUCT, _SPARE = 3 * _MATRIX, 4 * _MATRIX, 5 * _MATRIX
_BEFORE, _SPIKE, _RESULT = 6 * _MATRIX, 7 * _MATRIX, 8 * _MATRIX
_WORK = 9 * _MATRIX


@inline
def _invert(w: Any, source: int, target: int) -> None:
    """target = source^-1 for LANES matrices, Gauss–Jordan; source is destroyed. No pivoting: the blocks are dominant."""
    for k in range(_MATRIX):
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
    for k in range(_MATRIX):
        target[to + k] = source[at + k]


@inline
def _subtract(w: Any, what: int, target: int) -> None:
    for k in range(_MATRIX):
        w[target + k] -= w[what + k]


@inline
def _gather(blocks: Any, shift: Any, first: int, count: int, stride: int, w: Any, to: int, padding: float) -> None:
    """LANES blocks (flat, 16 each) from `first` on, `stride` blocks apart, side by side; shift on their diagonals.

    Lanes beyond count get padding on the diagonal.
    """
    for k in range(_MATRIX):
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
            f = around[(g * ni + i) * 4 * _MATRIX : (g * ni + i + 1) * 4 * _MATRIX]
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
                for k in range(_MATRIX):
                    w[_SPIKE + k] = -w[_PRODUCT + k]
            if i == last - 1:
                for k in range(_MATRIX):
                    w[_SPIKE + k] += w[_RESULT + k]
                    w[_RESULT + k] = 0.0
            if i == 0:
                for k in range(_MATRIX):
                    w[_SPARE + k] = 0.0
            _copy(w, _INVERSE, f, 0)
            _copy(w, _SPARE, f, _MATRIX)
            _copy(w, _RESULT, f, 2 * _MATRIX)
            _copy(w, _SPIKE, f, 3 * _MATRIX)
            _copy(w, _RESULT, w, _BEFORE)
        for i in range(last - 2, -1, -1):
            f = around[(g * ni + i) * 4 * _MATRIX : (g * ni + i + 1) * 4 * _MATRIX]
            _copy(f, 2 * _MATRIX, w, _UPPER)
            _multiply(w, _UPPER, _SPIKE, _PRODUCT)
            _copy(f, 3 * _MATRIX, w, _SPIKE)
            _subtract(w, _PRODUCT, _SPIKE)
            _copy(w, _SPIKE, f, 3 * _MATRIX)
        # the last cell: what remains of its block once the others are eliminated
        first = g * LANES * ni + last
        _gather(diagonal, shift, first, count, ni, w, _DIAGONAL, 1.0)
        _gather(back, shift, first, count, ni, w, _LOWER, 0.0)
        _gather(ahead, shift, first, count, ni, w, _UPPER, 0.0)
        _multiply(w, _UPPER, _SPIKE, _PRODUCT)
        _subtract(w, _PRODUCT, _DIAGONAL)
        before = around[(g * ni + last - 1) * 4 * _MATRIX : (g * ni + last) * 4 * _MATRIX]
        _copy(before, 3 * _MATRIX, w, _SPIKE)
        _multiply(w, _LOWER, _SPIKE, _PRODUCT)
        _subtract(w, _PRODUCT, _DIAGONAL)
        _invert(w, _DIAGONAL, _INVERSE)
        _multiply(w, _INVERSE, _LOWER, _SPARE)
        _multiply(w, _INVERSE, _UPPER, _RESULT)
        f = around[(g * ni + last) * 4 * _MATRIX : (g * ni + last + 1) * 4 * _MATRIX]
        _copy(w, _INVERSE, f, 0)
        _copy(w, _SPARE, f, _MATRIX)
        _copy(w, _RESULT, f, 2 * _MATRIX)


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
            for k in range(_MATRIX):
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
            f = across[(g * nj + j) * 3 * _MATRIX : (g * nj + j + 1) * 3 * _MATRIX]
            _copy(w, _INVERSE, f, 0)
            _copy(w, _PRODUCT, f, _MATRIX)
            _copy(w, _BEFORE, f, 2 * _MATRIX)


@inline
def _accumulate(matrix: Any, offset: int, x: Any, at: int, y: Any, to: int, sign: Any) -> None:
    """y += sign·matrix·x for LANES vectors of four, entries at compile-time offsets."""
    for l in range(LANES):
        x0, x1, x2, x3 = x[at + l], x[at + LANES + l], x[at + 2 * LANES + l], x[at + 3 * LANES + l]
        for a in range(4):
            f = offset + a * 4 * LANES + l
            y[to + a * LANES + l] += sign * (
                matrix[f] * x0 + matrix[f + LANES] * x1 + matrix[f + 2 * LANES] * x2 + matrix[f + 3 * LANES] * x3
            )


@jit
def solve(around: Any, across: Any, r: Any, x: Any, ni: int, nj: int, buffer: Any) -> None:
    """x = approximate inverse times −r; r, x: (nj·4·ni,) flat float64; around, across flat float32; buffer flat float32
    of shape (groups of j · ni · 4 · LANES,).
    """
    one = np.float32(1.0)
    s = np.zeros(4 * _VECTOR, dtype=np.float32)
    rhs, prev, new, end = 0, _VECTOR, 2 * _VECTOR, 3 * _VECTOR
    groups_j, groups_i = (nj + LANES - 1) // LANES, (ni + LANES - 1) // LANES
    last = ni - 1
    for g in range(groups_j):
        lanes = min(LANES, nj - g * LANES)
        base = g * ni * _VECTOR
        # gather: lines side by side
        for l in range(lanes):
            for m in range(4):
                row = r[((g * LANES + l) * 4 + m) * ni : ((g * LANES + l) * 4 + m) * ni + ni]
                to = base + m * LANES + l
                for i in range(ni):
                    buffer[to + i * _VECTOR] = -row[i]
        for k in range(_VECTOR):
            s[prev + k] = 0.0
        for i in range(last):
            b = buffer[base + i * _VECTOR : base + (i + 1) * _VECTOR]
            f = around[(g * ni + i) * 4 * _MATRIX : (g * ni + i + 1) * 4 * _MATRIX]
            for k in range(_VECTOR):
                s[new + k] = 0.0
                s[rhs + k] = b[k]
            _accumulate(f, 0, s, rhs, s, new, one)
            _accumulate(f, _MATRIX, s, prev, s, new, -one)
            for k in range(_VECTOR):
                s[prev + k] = s[new + k]
                b[k] = s[new + k]
        # prev holds the last forward value; back substitution
        for i in range(last - 2, -1, -1):
            b = buffer[base + i * _VECTOR : base + (i + 1) * _VECTOR]
            f = around[(g * ni + i) * 4 * _MATRIX : (g * ni + i + 1) * 4 * _MATRIX]
            for k in range(_VECTOR):
                s[new + k] = b[k]
            _accumulate(f, 2 * _MATRIX, s, prev, s, new, -one)
            for k in range(_VECTOR):
                s[prev + k] = s[new + k]
                b[k] = s[new + k]
        # last cell, then its response in the others
        f = around[(g * ni + last) * 4 * _MATRIX : (g * ni + last + 1) * 4 * _MATRIX]
        b = buffer[base + last * _VECTOR : base + (last + 1) * _VECTOR]
        before = buffer[base + (last - 1) * _VECTOR : base + last * _VECTOR]
        for k in range(_VECTOR):
            s[end + k] = 0.0
            s[rhs + k] = b[k]
            s[new + k] = before[k]
        _accumulate(f, 0, s, rhs, s, end, one)
        _accumulate(f, _MATRIX, s, new, s, end, -one)
        _accumulate(f, 2 * _MATRIX, s, prev, s, end, -one)
        for k in range(_VECTOR):
            b[k] = s[end + k]
        for i in range(last):
            b = buffer[base + i * _VECTOR : base + (i + 1) * _VECTOR]
            f = around[(g * ni + i) * 4 * _MATRIX : (g * ni + i + 1) * 4 * _MATRIX]
            for k in range(_VECTOR):
                s[new + k] = b[k]
            _accumulate(f, 3 * _MATRIX, s, end, s, new, -one)
            for k in range(_VECTOR):
                b[k] = s[new + k]
    line = np.zeros(nj * _VECTOR, dtype=np.float32)
    for g in range(groups_i):
        lanes = min(LANES, ni - g * LANES)
        for j in range(nj):
            part = buffer[((j // LANES) * ni + g * LANES) * _VECTOR + j % LANES :]
            b = line[j * _VECTOR : (j + 1) * _VECTOR]
            for m in range(4):
                for l in range(lanes):
                    b[m * LANES + l] = part[l * _VECTOR + m * LANES]
        for k in range(_VECTOR):
            s[prev + k] = 0.0
        for j in range(nj):
            b = line[j * _VECTOR : (j + 1) * _VECTOR]
            f = across[(g * nj + j) * 3 * _MATRIX : (g * nj + j + 1) * 3 * _MATRIX]
            for k in range(_VECTOR):
                s[new + k] = 0.0
                s[rhs + k] = b[k]
            _accumulate(f, 0, s, rhs, s, new, one)
            _accumulate(f, _MATRIX, s, prev, s, new, -one)
            for k in range(_VECTOR):
                s[prev + k] = s[new + k]
                b[k] = s[new + k]
        for j in range(nj - 1, -1, -1):
            b = line[j * _VECTOR : (j + 1) * _VECTOR]
            f = across[(g * nj + j) * 3 * _MATRIX : (g * nj + j + 1) * 3 * _MATRIX]
            for k in range(_VECTOR):
                s[new + k] = b[k]
            if j < nj - 1:
                _accumulate(f, 2 * _MATRIX, s, prev, s, new, -one)
            for k in range(_VECTOR):
                s[prev + k] = s[new + k]
            for m in range(4):
                row = x[(j * 4 + m) * ni + g * LANES : (j * 4 + m) * ni + g * LANES + lanes]
                for l in range(lanes):
                    row[l] = s[new + m * LANES + l]


@dataclass(frozen=True)
class Recipe:
    """What a linearisation was made from: enough to make it again to the last bit.

    flow: (nj, 4, ni) in body axes; far: (4, ni); weight: of the time derivative [1/time]; cfl: of the pseudo-time step.
    """

    flow: Array
    far: Array
    weight: float
    cfl: float


class Blocks:
    """Room for the blocks of a linearisation, used again each time: fresh memory costs as much as filling it."""

    def __init__(self, mesh: Mesh) -> None:
        nj, ni = mesh.shape
        self.diagonal, self.near, self.radius = np.empty((nj, ni, 4, 4)), np.empty((4, nj, ni, 4, 4)), np.empty((nj, ni))


class Factors:
    """Line factors of the linearisation described by a recipe; never changed after."""

    def __init__(self, recipe: Recipe, mesh: Mesh, blocks: Blocks) -> None:
        nj, ni = mesh.shape
        groups_j, groups_i = -(-nj // LANES), -(-ni // LANES)
        diagonal, near, radius = blocks.diagonal, blocks.near, blocks.radius
        assemble(recipe.flow, mesh.side, mesh.ring, recipe.far, diagonal, near, radius)
        # lanes that pad the last group stay zero
        around = np.zeros((groups_j, ni, 4, 16, LANES), dtype=np.float32)
        across = np.zeros((groups_i, nj, 3, 16, LANES), dtype=np.float32)
        shift = (mesh.volume * recipe.weight + radius / recipe.cfl).ravel()
        self._around, self._across = around.ravel(), across.ravel()
        factorise_around(diagonal.ravel(), near[0].ravel(), near[1].ravel(), shift, ni, nj, self._around)
        factorise_across(diagonal.ravel(), near[2].ravel(), near[3].ravel(), shift, ni, nj, self._across)
        self.recipe = recipe
        self._shape = nj, ni
        self._buffer = np.zeros(groups_j * ni * _VECTOR, dtype=np.float32)

    def solve(self, r: Array, x: Array) -> None:
        """x ≈ −(linearisation)^-1 r, both (nj, 4, ni) and contiguous."""
        nj, ni = self._shape
        solve(self._around, self._across, r.reshape(-1), x.reshape(-1), ni, nj, self._buffer)
