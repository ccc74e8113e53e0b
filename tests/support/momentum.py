"""The loads of a tank of two fluids against the change of their momentum."""

from __future__ import annotations

import math

import numpy as np

from aeroslosh.fmus.slosh_vof import step
from aeroslosh.fmus.slosh_vof.flow import Flow
from support.motions import Course


def momentum_gap(flow: Flow, motion: Course, duration: float, h: float) -> np.ndarray:
    """Root mean square difference of the walls' force to the fluid's change of momentum, over the force's std; tank axes.

    Momentum at half steps, as the solver conserves it: flow has no internal step above h [s].
    """
    flow.start(motion(0.0))
    grid, inner = flow.grid, flow.grid.inner
    x, y, area = inner(grid.x), inner(grid.y), grid.dx * grid.dy
    momenta, bodies, forces = [], [], []
    for k in range(round(duration / h) + 1):
        m = motion(k * h)
        if k:
            flow.advance(motion((k - 1) * h), m, h)
        rho = inner(flow.work[step.RHO])
        at_u, at_v = 0.5 * area * (rho[:, 1:] + rho[:, :-1]), 0.5 * area * (rho[1:] + rho[:-1])
        u, v, au, av = (inner(flow.state[row]) for row in (step.U, step.V, step.AX, step.AY))
        momenta.append([(at_u * (u + 0.5 * h * au)[:, :-1]).sum(), (at_v * (v + 0.5 * h * av)[:-1]).sum()])
        down, sin, cos = 9.81 - m.h_ddot, math.sin(m.alpha), math.cos(m.alpha)
        body_x = down * sin - m.x_ddot * cos - y * m.alpha_ddot + x * m.alpha_dot**2
        body_y = -down * cos - m.x_ddot * sin + x * m.alpha_ddot + y * m.alpha_dot**2
        turn = 2.0 * m.alpha_dot
        bodies.append(
            [
                (rho * body_x).sum() * area - turn * (at_v * v[:-1]).sum(),
                (rho * body_y).sum() * area + turn * (at_u * u[:, :-1]).sum(),
            ]
        )
        forces.append(flow.loads(m)[3:5])
    wall = np.array(forces)[1:]
    gap = wall - (np.array(bodies)[1:] - np.diff(np.array(momenta), axis=0) / h)
    return np.asarray(np.sqrt(np.mean(gap**2, axis=0)) / np.std(wall, axis=0))
