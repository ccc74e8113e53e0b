"""Approximate inverse of the linearised residual: diagonally dominant ADI (DDADI) on block-tridiagonal lines.

(V a/dt + V/dtau + dR/dq) x = r is approximated by [D + Li] D^-1 [D + Lj] x = r, where dR/dq is the first-order upwind
(Roe) linearisation: D its block diagonal, Li and Lj its neighbours along i (closed lines around the section) and j.
Source: Bardina and Lombard, AIAA 87-1114; MacCormack and Pulliam, AIAA 98-2821 (DDADI).

Blocks are factorised once (float64) and applied often (float32): 16 lines at a time side by side, so that every operation is
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


@jit
def _invert(a: Any, b: Any) -> None:
    """b = a^-1 for a (4, 4), Gauss–Jordan with partial pivoting; a is destroyed."""
    for i in range(4):
        for j in range(4):
            b[i, j] = 1.0 if i == j else 0.0
    for i in range(4):
        pivot = i
        for k in range(i + 1, 4):
            if abs(a[k, i]) > abs(a[pivot, i]):
                pivot = k
        if pivot != i:
            for j in range(4):
                a[i, j], a[pivot, j] = a[pivot, j], a[i, j]
                b[i, j], b[pivot, j] = b[pivot, j], b[i, j]
        factor = 1.0 / a[i, i]
        for j in range(4):
            a[i, j] *= factor
            b[i, j] *= factor
        for k in range(4):
            if k != i:
                f = a[k, i]
                for j in range(4):
                    a[k, j] -= f * a[i, j]
                    b[k, j] -= f * b[i, j]


@jit
def _multiply(a: Any, b: Any, c: Any) -> None:
    for i in range(4):
        for j in range(4):
            c[i, j] = a[i, 0] * b[0, j] + a[i, 1] * b[1, j] + a[i, 2] * b[2, j] + a[i, 3] * b[3, j]


@jit
def factorise(diagonal: Any, near: Any, shift: Any, around: Any, across: Any) -> None:
    """Factors of both line sweeps for the diagonal blocks plus shift·I.

    diagonal, near as from assemble; shift: (nj, ni). around: (groups of j, ni, 4 matrices, 16, LANES) float32 and
    across: (groups of i, nj, 3 matrices, 16, LANES) float32, written. Matrices: inverse pivot, pivot·lower, pivot·upper
    and, on closed lines, the response to the last cell.
    """
    nj, ni = diagonal.shape[0], diagonal.shape[1]
    pivot, inverse, lower, upper = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4))
    product, schur = np.empty((4, 4)), np.empty((4, 4))
    uppers, spikes = np.empty((ni, 4, 4)), np.empty((ni, 4, 4))
    lowers = np.empty((ni, 4, 4))
    last = ni - 1
    for j in range(nj):
        group, lane = j // LANES, j % LANES
        for i in range(last):
            pivot[:] = diagonal[j, i]
            for m in range(4):
                pivot[m, m] += shift[j, i]
            if i > 0:
                _multiply(near[0, j, i], uppers[i - 1], product)
                pivot[:] -= product
            _invert(pivot, inverse)
            _multiply(inverse, near[0, j, i], lower)
            _multiply(inverse, near[1, j, i], upper)
            lowers[i] = lower
            uppers[i] = upper
            # right side of the response to the last cell: its coupling into cells 0 and last−1
            if i == 0:
                spikes[0] = lower
            else:
                _multiply(lower, spikes[i - 1], product)
                spikes[i] = -product
            if i == last - 1:
                spikes[i] += upper
                uppers[i] = 0.0
            for a in range(4):
                for b in range(4):
                    around[group, i, 0, 4 * a + b, lane] = inverse[a, b]
                    around[group, i, 1, 4 * a + b, lane] = 0.0 if i == 0 else lower[a, b]
                    around[group, i, 2, 4 * a + b, lane] = uppers[i, a, b]
        for i in range(last - 2, -1, -1):
            _multiply(uppers[i], spikes[i + 1], product)
            spikes[i] -= product
        schur[:] = diagonal[j, last]
        for m in range(4):
            schur[m, m] += shift[j, last]
        _multiply(near[1, j, last], spikes[0], product)
        schur[:] -= product
        _multiply(near[0, j, last], spikes[last - 1], product)
        schur[:] -= product
        _invert(schur, inverse)
        _multiply(inverse, near[0, j, last], lower)
        _multiply(inverse, near[1, j, last], upper)
        for a in range(4):
            for b in range(4):
                around[group, last, 0, 4 * a + b, lane] = inverse[a, b]
                around[group, last, 1, 4 * a + b, lane] = lower[a, b]
                around[group, last, 2, 4 * a + b, lane] = upper[a, b]
                for i in range(last):
                    around[group, i, 3, 4 * a + b, lane] = spikes[i, a, b]
    # across: lines of D^-1 [D + Lj], so that the product of both factors needs no extra multiplication
    scale = np.empty((4, 4))
    for i in range(ni):
        group, lane = i // LANES, i % LANES
        for j in range(nj):
            pivot[:] = diagonal[j, i]
            for m in range(4):
                pivot[m, m] += shift[j, i]
            _invert(pivot, scale)
            pivot[:] = 0.0
            for m in range(4):
                pivot[m, m] = 1.0
            _multiply(scale, near[2, j, i], lower)
            if j > 0:
                _multiply(lower, uppers[j - 1], product)
                pivot[:] -= product
            _invert(pivot, inverse)
            _multiply(inverse, lower, product)
            for a in range(4):
                for b in range(4):
                    across[group, j, 0, 4 * a + b, lane] = inverse[a, b]
                    across[group, j, 1, 4 * a + b, lane] = product[a, b]
            _multiply(scale, near[3, j, i], product)
            _multiply(inverse, product, upper)
            uppers[j] = upper
            for a in range(4):
                for b in range(4):
                    across[group, j, 2, 4 * a + b, lane] = upper[a, b]


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


class Factors:
    """Line factors of the linearisation described by a recipe; never changed after."""

    def __init__(self, recipe: Recipe, mesh: Mesh) -> None:
        nj, ni = mesh.shape
        groups_j, groups_i = -(-nj // LANES), -(-ni // LANES)
        diagonal, near, radius = np.empty((nj, ni, 4, 4)), np.empty((4, nj, ni, 4, 4)), np.empty((nj, ni))
        assemble(recipe.flow, mesh.side, mesh.ring, recipe.far, diagonal, near, radius)
        # lanes that pad the last group stay zero
        around = np.zeros((groups_j, ni, 4, 16, LANES), dtype=np.float32)
        across = np.zeros((groups_i, nj, 3, 16, LANES), dtype=np.float32)
        factorise(diagonal, near, mesh.volume * recipe.weight + radius / recipe.cfl, around, across)
        self.recipe = recipe
        self._shape = nj, ni
        self._around, self._across = around.ravel(), across.ravel()
        self._buffer = np.zeros(groups_j * ni * _VECTOR, dtype=np.float32)

    def solve(self, r: Array, x: Array) -> None:
        """x ≈ −(linearisation)^-1 r, both (nj, 4, ni) and contiguous."""
        nj, ni = self._shape
        solve(self._around, self._across, r.reshape(-1), x.reshape(-1), ni, nj, self._buffer)
