"""Approximate inverse of the linearised residual: diagonally dominant ADI (DDADI) on block-tridiagonal lines.

(V a/dt + V/dtau + dR/dq) x = r is approximated by [D + Li] D^-1 [D + Lj] x = r, where dR/dq is the first-order upwind
(Roe) linearisation: D its block diagonal, Li and Lj its neighbours along i (closed lines around the section) and j.
Source: Bardina and Lombard, AIAA 87-1114; MacCormack and Pulliam, AIAA 98-2821 (DDADI).

Blocks are factorised now and then and applied often, in float32: 16 lines at a time side by side, so that every operation is
one SIMD instruction. Factor layout: [line group][cell][matrix entry][16 lines]. Their entries are kept to 8 bits, two in a word
(`factorise.pack`): the factors of 8,064 cells are 3.6 MB in float32, more than a small or shared cache gives a process. What is
lost, at most 0.4 % of an entry, is small beside what the approximation itself leaves, 0.7 of the error.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..kit.compiled import inline, jit
from .factorise import LANES, PACKED, factorise_across, factorise_around, felt, pack
from .jacobian import assemble
from .mesh import Mesh

_VECTOR = 4 * LANES
Array = NDArray[np.float64]


@inline
def _low(word: Any) -> Any:
    """The number in the low half of a word; see factorise.pack."""
    return np.uint32(word << np.uint32(16)).view(np.float32)


@inline
def _high(word: Any) -> Any:
    """The number in the high half of a word."""
    return np.uint32(word).view(np.float32)


@inline
def _two(f: Any, first: int, second: int, s: Any) -> None:
    """s[1] = first·s[1] − second·s[0], s holding two places of LANES vectors of four; matrices packed in f.

    Both in one array, at a distance that the compiler knows: no look whether they overlap, no copies."""
    for l in range(LANES):
        x, y = _VECTOR + l, l
        x0, x1, x2, x3 = s[x], s[x + LANES], s[x + 2 * LANES], s[x + 3 * LANES]
        y0, y1, y2, y3 = s[y], s[y + LANES], s[y + 2 * LANES], s[y + 3 * LANES]
        for a in range(4):
            m, n = first + 2 * a * LANES + l, second + 2 * a * LANES + l
            left, right = np.uint32(f[m]), np.uint32(f[m + LANES])
            below, above = np.uint32(f[n]), np.uint32(f[n + LANES])
            s[x + a * LANES] = (
                _low(left) * x0 + _high(left) * x1 + _low(right) * x2 + _high(right) * x3
                - _low(below) * y0 - _high(below) * y1 - _low(above) * y2 - _high(above) * y3
            )  # fmt: skip


@inline
def _less(f: Any, matrix: int, s: Any, x: int, e: Any, y: int) -> None:
    """s[x] −= matrix·e[y] for LANES vectors of four."""
    for l in range(LANES):
        y0, y1, y2, y3 = e[y + l], e[y + LANES + l], e[y + 2 * LANES + l], e[y + 3 * LANES + l]
        for a in range(4):
            n = matrix + 2 * a * LANES + l
            left, right = np.uint32(f[n]), np.uint32(f[n + LANES])
            s[x + a * LANES + l] -= _low(left) * y0 + _high(left) * y1 + _low(right) * y2 + _high(right) * y3


@inline
def _place(work: Any, at: int, many: int) -> Any:
    """`many` places of LANES vectors from number `at` on."""
    return work[at * _VECTOR : (at + many) * _VECTOR]


@jit
def solve(
    around: Any, spikes: Any, ends: Any, across: Any, r: Any, x: Any, ni: int, nj: int, work: Any
) -> None:  # fmt: skip
    """x = approximate inverse times −r; r, x: (nj·4·ni,) flat float64; around, spikes, across: flat uint32
    (`factorise.pack`); ends: of `factorise.felt`; work: flat float32 of `work_size`, its first place of LANES vectors zero.
    """
    groups_j, groups_i = (nj + LANES - 1) // LANES, (ni + LANES - 1) // LANES
    last = ni - 1
    end = np.empty(_VECTOR, dtype=np.float32)
    for g in range(groups_j):
        lanes = min(LANES, nj - g * LANES)
        base = 1 + g * ni
        # gather lines side by side; one variable after the other, so that what is written stays in the first-level cache
        for m in range(4):
            for l in range(lanes):
                row = r[((g * LANES + l) * 4 + m) * ni : ((g * LANES + l) * 4 + m) * ni + ni]
                to = work[base * _VECTOR + m * LANES + l :]
                for i in range(ni):
                    to[i * _VECTOR] = -row[i]
        # the lower matrix of the first cell is zero: what lies before it does not count
        for i in range(last):
            f = around[(g * ni + i) * 3 * PACKED : (g * ni + i + 1) * 3 * PACKED]
            _two(f, 0, PACKED, _place(work, base + i - 1, 2))
        for i in range(last - 2, -1, -1):
            f = around[(g * ni + i) * 3 * PACKED : (g * ni + i + 1) * 3 * PACKED]
            b = _place(work, base + i, 2)
            _less(f, 2 * PACKED, b, 0, b, _VECTOR)
        # last cell, then its response in the others
        f = around[(g * ni + last) * 3 * PACKED : (g * ni + last + 1) * 3 * PACKED]
        b = _place(work, base + last - 1, 2)
        _two(f, 0, PACKED, b)
        _less(f, 2 * PACKED, b, _VECTOR, _place(work, base, 1), 0)
        for k in range(_VECTOR):
            end[k] = b[_VECTOR + k]
        for i in range(last):
            if i < ends[g, 0] or i >= ends[g, 1]:
                f = spikes[(g * ni + i) * PACKED : (g * ni + i + 1) * PACKED]
                _less(f, 0, _place(work, base + i, 1), 0, end, 0)
    line = 2 + groups_j * ni
    for g in range(groups_i):
        lanes = min(LANES, ni - g * LANES)
        for j in range(nj):
            part = work[(1 + (j // LANES) * ni + g * LANES) * _VECTOR + j % LANES :]
            b = _place(work, line + j, 1)
            for m in range(4):
                for l in range(lanes):
                    b[m * LANES + l] = part[l * _VECTOR + m * LANES]
        for j in range(nj):
            f = across[(g * nj + j) * 3 * PACKED : (g * nj + j + 1) * 3 * PACKED]
            _two(f, 0, PACKED, _place(work, line + j - 1, 2))
        # the upper matrix of the last cell is that of the boundary's state, which does not change
        for j in range(nj - 2, -1, -1):
            f = across[(g * nj + j) * 3 * PACKED : (g * nj + j + 1) * 3 * PACKED]
            b = _place(work, line + j, 2)
            _less(f, 2 * PACKED, b, 0, b, _VECTOR)
        for j in range(nj):
            b = _place(work, line + j, 1)
            for m in range(4):
                row = x[(j * 4 + m) * ni + g * LANES : (j * 4 + m) * ni + g * LANES + lanes]
                for l in range(lanes):
                    row[l] = b[m * LANES + l]


def work_size(ni: int, nj: int) -> int:
    """Numbers that `solve` works on."""
    return (2 + -(-nj // LANES) * ni + nj) * _VECTOR


@dataclass(frozen=True)
class Recipe:
    """What a linearisation was made from: enough to make it again to the last bit.

    flow: (nj, 4, ni) in body axes; far: (4, ni); weight: of the time derivative [1/time]; cfl: of the pseudo-time step;
    least_cfl: below which `weight` lets no cell fall (infinite: it holds everywhere, as a march needs).
    """

    flow: Array
    far: Array
    weight: float
    cfl: float
    least_cfl: float = np.inf


class Blocks:
    """Room for the blocks of a linearisation, used again each time: fresh memory costs as much as filling it."""

    def __init__(self, mesh: Mesh) -> None:
        nj, ni = mesh.shape
        self.diagonal, self.near, self.radius = np.empty(nj * ni * 16), np.empty((4, nj * ni * 16)), np.empty(nj * ni)


class Factors:
    """Line factors of the linearisation described by a recipe; never changed after."""

    def __init__(self, recipe: Recipe, mesh: Mesh, blocks: Blocks) -> None:
        nj, ni = mesh.shape
        groups_j, groups_i = -(-nj // LANES), -(-ni // LANES)
        diagonal, near, radius = blocks.diagonal, blocks.near, blocks.radius
        assemble(recipe.flow, mesh.side, mesh.ring, recipe.far, diagonal, *near, radius)
        # lanes that pad the last group stay zero
        around = np.zeros((groups_j, ni, 3, 16, LANES), dtype=np.float32)
        spikes = np.zeros((groups_j, ni, 16, LANES), dtype=np.float32)
        self._ends = np.empty((groups_j, 2), dtype=np.int64)
        across = np.zeros((groups_i, nj, 3, 16, LANES), dtype=np.float32)
        time = mesh.volume.ravel() * recipe.weight
        if np.isfinite(recipe.least_cfl):
            time = np.minimum(time, radius / recipe.least_cfl)
        shift = time + radius / recipe.cfl
        factorise_around(diagonal, near[0], near[1], shift, ni, nj, around.ravel(), spikes.ravel())
        felt(spikes.ravel(), ni, self._ends)
        factorise_across(diagonal, near[2], near[3], shift, ni, nj, across.ravel())
        self._around, self._spikes, self._across = (pack(f.view(np.uint32).ravel()) for f in (around, spikes, across))
        self.recipe = recipe
        self._shape = nj, ni
        self._work = np.zeros(work_size(ni, nj), dtype=np.float32)

    def solve(self, r: Array, x: Array) -> None:
        """x ≈ −(linearisation)^-1 r, both (nj, 4, ni) and contiguous."""
        nj, ni = self._shape
        solve(self._around, self._spikes, self._ends, self._across, r.reshape(-1), x.reshape(-1), ni, nj, self._work)
