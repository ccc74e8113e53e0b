"""First-order upwind linearisation of the residual: 4 x 4 blocks a face, assembled a cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import jit
from .flux import ENTROPY, GAMMA


@jit
def _jacobian_terms(nx: float, ny: float, r: float, u: float, v: float, p: float, terms: Any) -> None:
    """Rows and columns of which the flux Jacobian and Roe's |A| are made, into terms (16,): dp, rho dun; (1,u,v,H), (0,n,un)."""
    g1 = GAMMA - 1.0
    terms[0], terms[1], terms[2], terms[3] = g1 * 0.5 * (u * u + v * v), -g1 * u, -g1 * v, g1
    terms[4], terms[5], terms[6], terms[7] = -(u * nx + v * ny), nx, ny, 0.0
    terms[8], terms[9], terms[10], terms[11] = 1.0, u, v, GAMMA / g1 * p / r + 0.5 * (u * u + v * v)
    terms[12], terms[13], terms[14], terms[15] = 0.0, nx, ny, u * nx + v * ny


@jit
def face_blocks(nx: float, ny: float, length: float, left: Any, right: Any, plus: Any, minus: Any, work: Any) -> None:
    """d(flux·length)/d(left state) into plus, /d(right state) into minus, (16,) by rows; states are primitive (4,)."""
    for side in range(2):
        state = left if side == 0 else right
        target = plus if side == 0 else minus
        r, u, v, p = state[0], state[1], state[2], state[3]
        _jacobian_terms(nx, ny, r, u, v, p, work)
        un = u * nx + v * ny
        for a in range(4):
            for b in range(4):
                target[4 * a + b] = 0.5 * length * (work[8 + a] * work[4 + b] + work[12 + a] * work[b])
            target[5 * a] += 0.5 * length * un
    r, u = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1])
    v, p = 0.5 * (left[2] + right[2]), 0.5 * (left[3] + right[3])
    _jacobian_terms(nx, ny, r, u, v, p, work)
    c2 = GAMMA * p / r
    c = np.sqrt(c2)
    un = u * nx + v * ny
    floor = ENTROPY * c  # under the shear and entropy waves too, which the flux has without: the blocks are the better to invert
    l0, lp, lm = max(abs(un), floor), max(abs(un + c), floor), max(abs(un - c), floor)
    mean, skew = 0.5 * (lp + lm) - l0, 0.5 * (lp - lm)
    m_c2, s_c = mean / c2, skew / c
    for a in range(4):
        for b in range(4):
            d = work[8 + a] * (m_c2 * work[b] + s_c * work[4 + b]) + work[12 + a] * (mean * work[4 + b] + s_c * work[b])
            if a == b:
                d += l0
            plus[4 * a + b] += 0.5 * length * d
            minus[4 * a + b] -= 0.5 * length * d


@jit
def _add(block: Any, sign: float, target: Any, cell: int) -> None:
    """target's block of `cell` += sign·block."""
    for k in range(16):
        target[16 * cell + k] += sign * block[k]


@jit
def _put(block: Any, sign: float, target: Any, cell: int) -> None:
    """target's block of `cell` = sign·block."""
    for k in range(16):
        target[16 * cell + k] = sign * block[k]


@jit
def _state(w: Any, cell: int, state: Any) -> None:
    """The primitive state (4,) of a cell."""
    for m in range(4):
        state[m] = w[4 * cell + m]


@jit
def assemble(
    q: Any, side: Any, ring: Any, far: Any, diagonal: Any, back: Any, ahead: Any, below: Any, above: Any, radius: Any
) -> None:
    """First-order linearisation of the residual on a mesh at rest.

    q: (nj, 4, ni); side, ring, far as in flux.residual but shaped; diagonal: flat (nj·ni·16,), a cell's block by rows; back,
    ahead, below, above: the same of its neighbours i−1, i+1, j−1, j+1; radius: flat (nj·ni,), sum of spectral radii times face
    lengths.
    """
    nj, ni = q.shape[0], q.shape[2]
    w = np.empty(nj * ni * 4)
    for j in range(nj):
        for i in range(ni):
            r = q[j, 0, i]
            u, v = q[j, 1, i] / r, q[j, 2, i] / r
            cell = 4 * (j * ni + i)
            w[cell], w[cell + 1], w[cell + 2] = r, u, v
            w[cell + 3] = (GAMMA - 1.0) * (q[j, 3, i] - 0.5 * r * (u * u + v * v))
    for k in range(diagonal.size):
        diagonal[k], back[k], ahead[k], below[k], above[k] = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(radius.size):
        radius[k] = 0.0
    plus, minus, work = np.empty(16), np.empty(16), np.empty(16)
    left, right = np.empty(4), np.empty(4)
    for j in range(nj):
        for i in range(ni):
            here, behind = j * ni + i, j * ni + (i - 1 if i > 0 else ni - 1)
            nx, ny, length = side[j, 0, i], side[j, 1, i], side[j, 2, i]
            _state(w, behind, left)
            _state(w, here, right)
            face_blocks(nx, ny, length, left, right, plus, minus, work)
            _add(plus, 1.0, diagonal, behind)
            _add(minus, -1.0, diagonal, here)
            _put(minus, 1.0, ahead, behind)
            _put(plus, -1.0, back, here)
            speed = abs(0.5 * ((left[1] + right[1]) * nx + (left[2] + right[2]) * ny))
            speed = (speed + np.sqrt(GAMMA * right[3] / right[0])) * length
            radius[behind] += 0.5 * speed
            radius[here] += 0.5 * speed
    for j in range(nj + 1):
        for i in range(ni):
            nx, ny, length = ring[j, 0, i], ring[j, 1, i], ring[j, 2, i]
            here, under = min(j, nj - 1) * ni + i, (j - 1) * ni + i
            _state(w, here, right)
            speed = (abs(right[1] * nx + right[2] * ny) + np.sqrt(GAMMA * right[3] / right[0])) * length
            if j == 0:
                # wall: only the pressure acts
                _jacobian_terms(nx, ny, right[0], right[1], right[2], right[3], work)
                for b in range(4):
                    diagonal[16 * here + 4 + b] -= nx * length * work[b]
                    diagonal[16 * here + 8 + b] -= ny * length * work[b]
                continue
            radius[under] += 0.5 * speed
            _state(w, under, left)
            if j == nj:
                for m in range(4):
                    right[m] = far[m, i]
                face_blocks(nx, ny, length, left, right, plus, minus, work)
                _add(plus, 1.0, diagonal, under)
            else:
                face_blocks(nx, ny, length, left, right, plus, minus, work)
                _add(plus, 1.0, diagonal, under)
                _add(minus, -1.0, diagonal, here)
                _put(minus, 1.0, above, under)
                _put(plus, -1.0, below, here)
                radius[here] += 0.5 * speed
