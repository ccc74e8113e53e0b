"""First-order upwind linearisation of the residual: 4 x 4 blocks a face, assembled a cell."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import inline, jit
from .flux import ENTROPY, GAMMA


@inline
def _jacobian_terms(nx: float, ny: float, r: float, u: float, v: float, p: float, ap: Any, au: Any, n1: Any, n2: Any) -> None:
    """Rows and columns of which the flux Jacobian and Roe's |A| are made: dp, rho dun; (1,u,v,H), (0,n,un)."""
    g1 = GAMMA - 1.0
    un = u * nx + v * ny
    ap[0], ap[1], ap[2], ap[3] = g1 * 0.5 * (u * u + v * v), -g1 * u, -g1 * v, g1
    au[0], au[1], au[2], au[3] = -un, nx, ny, 0.0
    n1[0], n1[1], n1[2], n1[3] = 1.0, u, v, GAMMA / g1 * p / r + 0.5 * (u * u + v * v)
    n2[0], n2[1], n2[2], n2[3] = 0.0, nx, ny, un


@jit
def _face_blocks(nx: float, ny: float, length: float, left: Any, right: Any, plus: Any, minus: Any, work: Any) -> None:
    """d(flux·length)/d(left state) into plus, /d(right state) into minus, (4, 4); states are primitive (4,)."""
    ap, au, n1, n2 = work[0], work[1], work[2], work[3]
    for side in range(2):
        state = left if side == 0 else right
        target = plus if side == 0 else minus
        r, u, v, p = state[0], state[1], state[2], state[3]
        _jacobian_terms(nx, ny, r, u, v, p, ap, au, n1, n2)
        un = u * nx + v * ny
        for a in range(4):
            for b in range(4):
                target[a, b] = 0.5 * length * (n1[a] * au[b] + n2[a] * ap[b])
            target[a, a] += 0.5 * length * un
    r, u = 0.5 * (left[0] + right[0]), 0.5 * (left[1] + right[1])
    v, p = 0.5 * (left[2] + right[2]), 0.5 * (left[3] + right[3])
    _jacobian_terms(nx, ny, r, u, v, p, ap, au, n1, n2)
    c = np.sqrt(GAMMA * p / r)
    un = u * nx + v * ny
    floor = ENTROPY * c  # under the shear and entropy waves too, which the flux has without: the blocks are the better to invert
    l0, lp, lm = max(abs(un), floor), max(abs(un + c), floor), max(abs(un - c), floor)
    mean, skew = 0.5 * (lp + lm) - l0, 0.5 * (lp - lm)
    for a in range(4):
        for b in range(4):
            d = n1[a] * (mean * ap[b] / (c * c) + skew * au[b] / c) + n2[a] * (mean * au[b] + skew * ap[b] / c)
            if a == b:
                d += l0
            plus[a, b] += 0.5 * length * d
            minus[a, b] -= 0.5 * length * d


@jit
def assemble(q: Any, side: Any, ring: Any, far: Any, diagonal: Any, near: Any, radius: Any) -> None:
    """First-order linearisation of the residual on a mesh at rest.

    q: (nj, 4, ni); side, ring, far as in flux.residual but shaped; diagonal: (nj, ni, 4, 4); near: (4, nj, ni, 4, 4) blocks
    of the neighbours i−1, i+1, j−1, j+1; radius: (nj, ni) sum of spectral radii times face lengths.
    """
    nj, ni = q.shape[0], q.shape[2]
    w = np.empty((nj, ni, 4))
    for j in range(nj):
        for i in range(ni):
            r = q[j, 0, i]
            u, v = q[j, 1, i] / r, q[j, 2, i] / r
            w[j, i, 0], w[j, i, 1], w[j, i, 2] = r, u, v
            w[j, i, 3] = (GAMMA - 1.0) * (q[j, 3, i] - 0.5 * r * (u * u + v * v))
    diagonal[:] = 0.0
    near[:] = 0.0
    radius[:] = 0.0
    plus, minus, work, ghost = np.empty((4, 4)), np.empty((4, 4)), np.empty((4, 4)), np.empty(4)
    for j in range(nj):
        for i in range(ni):
            back = i - 1 if i > 0 else ni - 1
            nx, ny, length = side[j, 0, i], side[j, 1, i], side[j, 2, i]
            _face_blocks(nx, ny, length, w[j, back], w[j, i], plus, minus, work)
            diagonal[j, back] += plus
            diagonal[j, i] -= minus
            near[1, j, back] = minus
            near[0, j, i] = -plus
            speed = abs(0.5 * ((w[j, back, 1] + w[j, i, 1]) * nx + (w[j, back, 2] + w[j, i, 2]) * ny))
            speed = (speed + np.sqrt(GAMMA * w[j, i, 3] / w[j, i, 0])) * length
            radius[j, back] += 0.5 * speed
            radius[j, i] += 0.5 * speed
    for j in range(nj + 1):
        for i in range(ni):
            nx, ny, length = ring[j, 0, i], ring[j, 1, i], ring[j, 2, i]
            here = w[min(j, nj - 1), i]
            speed = (abs(here[1] * nx + here[2] * ny) + np.sqrt(GAMMA * here[3] / here[0])) * length
            if j == 0:
                # wall: only the pressure acts
                _jacobian_terms(nx, ny, here[0], here[1], here[2], here[3], work[0], work[1], work[2], work[3])
                for b in range(4):
                    diagonal[0, i, 1, b] -= nx * length * work[0, b]
                    diagonal[0, i, 2, b] -= ny * length * work[0, b]
            elif j == nj:
                for m in range(4):
                    ghost[m] = far[m, i]
                _face_blocks(nx, ny, length, here, ghost, plus, minus, work)
                diagonal[j - 1, i] += plus
            else:
                _face_blocks(nx, ny, length, w[j - 1, i], here, plus, minus, work)
                diagonal[j - 1, i] += plus
                diagonal[j, i] -= minus
                near[3, j - 1, i] = minus
                near[2, j, i] = -plus
                radius[j, i] += 0.5 * speed
            if j > 0:
                radius[j - 1, i] += 0.5 * speed
