"""Friction of the front and the back wall of a narrow tank, which a two-dimensional flow does not see.

Flow between two plates at distance w that oscillates with angular frequency ω as a whole: with k = (w/2) sqrt(iω/ν) the walls
hold a mean velocity U back by F U per mass, F = iω f/(1 − f), f = tanh(k)/k (exact for laminar flow: Landau and Lifshitz, Fluid
Mechanics, 2nd ed. 1987, section 24, problem 5). Thin layers: F = 2 sqrt(νω/2)/w (1 + i), Stokes; thick ones: 12 ν/w²,
Poiseuille. The real part, friction in phase with the flow, is applied to both fluids, each by its own viscosity; the imaginary
part, the inertia of the layers, is left out: a wave's frequency comes out too high by half of F_real/ω.

Laminar, one frequency: an impact, shorter than 1/ω, is held back too little by the square root of its share; above a Reynolds
number of the layer U sqrt(2/(ων)) of about 550 the layer is turbulent and holds back more.
"""

from __future__ import annotations

import cmath
from typing import Any, NamedTuple

from ..kit.cache import argument
from ..kit.compiled import jit

FORCE_X, FORCE_Y, MOMENT = range(3)


@argument
class Sides(NamedTuple):
    """Friction per volume and velocity [kg/(m3 s)] of liquid and gas."""

    liquid: float
    gas: float


_THIN = 1e-3  # of |k|: below it 1 - f is round-off


def rate(viscosity: float, omega: float, width: float) -> float:
    """Friction per mass and velocity [1/s] of both walls at distance `width` [m]; 0 without viscosity [m2/s] or omega [rad/s]."""
    if viscosity <= 0.0 or omega <= 0.0:
        return 0.0
    k = 0.5 * width * cmath.sqrt(1j * omega / viscosity)
    if abs(k) < _THIN:
        return 12.0 * viscosity / width**2
    f = (1.0 if k.real > 300.0 else cmath.tanh(k)) / k
    return float((1j * omega * f / (1.0 - f)).real)


@jit
def hold_back(acc: Any, velocity: Any, gate: Any, c: Any, rho: Any, p: Any, sides: Any, first: int, n: int, step: int) -> None:
    """Take the friction's deceleration from the accelerations of open faces; step: 1 for u, the stride for v."""
    for k in range(first, first + n):
        share = min(max(0.5 * (c[k] + c[k + step]), 0.0), 1.0)
        drag = sides.gas + (sides.liquid - sides.gas) * share
        acc[k] -= gate[k] * drag * velocity[k] / (0.5 * (rho[k] + rho[k + step]))


@jit
def side_loads(state: Any, places: Any, p: Any, sides: Any, out: Any) -> None:
    """Forces along x and y and moment about the elastic axis of both fluids on the side walls, per metre of width; out (3,)."""
    s, c = p.nx + 2, state[0]
    out[FORCE_X], out[FORCE_Y], out[MOMENT] = 0.0, 0.0, 0.0
    area = p.dx * p.dy
    for k in range(2 * s, (p.ny + 2) * s):
        if not 0 < k % s <= p.nx:
            continue
        for way in range(2):
            step = s if way else 1
            gate = places.open_y[k] if way else places.open_x[k]
            share = min(max(0.5 * (c[k] + c[k + step]), 0.0), 1.0)
            drag = sides.gas + (sides.liquid - sides.gas) * share
            force = gate * drag * state[2 if way else 1][k] * area
            if way:
                out[FORCE_Y] += force
                out[MOMENT] -= places.x[k] * force
            else:
                out[FORCE_X] += force
                out[MOMENT] += places.y[k] * force
