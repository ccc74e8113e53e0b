"""Slip wall of a moving section: the state behind it and the pressure on it.

The mirror state keeps entropy and relative total enthalpy, the pressure follows from the normal momentum equation along the
curved wall (Dadone and Grossman, AIAA J. 32(2), 1994, doi:10.2514/3.11983). Here the wall accelerates and rotates: in its frame
dp/dn = rho (curvature u_t^2 + 2 rate u_t − a_n), and the relative total enthalpy changes by −a_n along the normal.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from ..kit.compiled import inline, jit
from .flux import GAMMA


@inline
def mirror(
    nx: float, ny: float, vx: float, vy: float, curvature: float, acceleration: float, rate: float, gap: float,
    r: float, u: float, v: float, p: float,
) -> tuple[float, float, float, float, float]:  # fmt: skip
    """State behind a wall that moves at (vx, vy), and the normal pressure gradient at it.

    acceleration: normal component of the wall's; rate: angular rate of the section, nose-up. Returns rho, u, v, p, dp/dn.
    """
    un = (u - vx) * nx + (v - vy) * ny
    ut = (u - vx) * ny - (v - vy) * nx
    gradient = r * (curvature * ut * ut + 2.0 * rate * ut - acceleration)
    pg = max(p - gradient * gap, 0.2 * p)
    rg = r * (pg / p) ** (1.0 / GAMMA)
    # relative total enthalpy grows along the normal by minus the wall's acceleration
    heat = GAMMA / (GAMMA - 1.0)
    ut2 = ut * ut + 2.0 * (heat * (p / r - pg / rg) + gap * acceleration)
    utg = np.sqrt(max(ut2, 0.0))
    utg = utg if ut >= 0.0 else -utg
    return rg, vx + utg * ny - un * nx, vy - utg * nx - un * ny, pg, gradient


@jit
def wall_state(q: Any, ring: Any, wall: Any, motion: Any, ghost: Any, pressure: Any) -> None:
    """Fill ghost (4, ni), primitive, and pressure (ni,) from the two rows of cells at the wall.

    q: (nj, 4, ni); ring: (nj+1, 4, ni); wall: (5, ni) curvature, mirror distance, normal acceleration, x and y of the face
    middles; motion: (3,) mesh velocity at the origin and angular rate.
    """
    ni = q.shape[2]
    vx, vy, rate = motion[0], motion[1], motion[2]
    for i in range(ni):
        r = q[0, 0, i]
        u, v = q[0, 1, i] / r, q[0, 2, i] / r
        p = (GAMMA - 1.0) * (q[0, 3, i] - 0.5 * r * (u * u + v * v))
        r2 = q[1, 0, i]
        p2 = (GAMMA - 1.0) * (q[1, 3, i] - 0.5 * (q[1, 1, i] ** 2 + q[1, 2, i] ** 2) / r2)
        rg, ug, vg, pg, gradient = mirror(
            ring[0, 0, i], ring[0, 1, i], vx + rate * wall[4, i], vy - rate * wall[3, i],
            wall[0, i], wall[2, i], rate, wall[1, i], r, u, v, p,
        )  # fmt: skip
        ghost[0, i], ghost[1, i], ghost[2, i], ghost[3, i] = rg, ug, vg, pg
        # parabola through both cells with the exact slope at the wall
        pressure[i] = max((9.0 * p - p2) * 0.125 - 0.375 * wall[1, i] * gradient, 0.1 * p)
