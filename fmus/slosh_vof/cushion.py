"""Gas that can be compressed: its mass, its pressure, and the term it adds to the pressure equation.

Each cell keeps the mass of its gas, carried by the gas that the volume-of-fluid step moves: the gas of a bubble or of a
compartment keeps its mass to round-off. In cells with at most half liquid it follows p = p₀ (ρ/ρ₀)^γ; in the others the flow
stays free of divergence, so the liquid's volume is kept as before (Weymouth and Yue's indicator is 0 wherever gas is compressed),
and what gas they have is given the pressure of its place by exchange with the gas beside it, which is compressed in its stead.

In time: the acceleration belongs to the pressure p + φ₁ (pₙ₊₁ − p) − φ₂ (p − pₙ₋₁), its changes being −γ p Δt ∇·w/(1 − c) of the
half-step velocities w after and before. φ₁ = φ₂ would be Newmark's scheme (β = φ; J. Eng. Mech. Div. ASCE 85 (1959) 67): second
order, no damping, stable for any speed of sound from 1/4 on where steps are equal. They are not: in violent flow 1/4 was seen to
fail and 1/2 to take twice the steps, 1 leaves room for steps that grow. A swing of frequency ω is slowed by 0.46 (ωΔt)². φ₁ is
larger by Δt/DAMPING, so that sound that steps do not resolve dies out; what they do resolve is damped by ωΔt²/(2 DAMPING) of
critical, second order too. Stiff gas gives the equation of gas that cannot be compressed.

The inertia of gas stays that of its density at the start.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import argument
from ..kit.compiled import jit
from .grid import Grid

Array = NDArray[np.float64]
PHI = 1.0
DAMPING, MOST_DAMPING = 5e-3, 1.0
"""[s]; largest φ₁ − φ₂."""
SOONEST = 32.0
"""A cell that fills with liquid loses the divergence of its gas within a step, or this share of the time `step` takes for it."""
FULL = 0.5
"""Cells with more liquid are not compressed: the indicator of `advection`."""
THINNEST, DENSEST = 0.02, 50.0
"""Density of gas over that at the start: bounds of the pressure's formula, far beyond any cushion."""
TRACE, QUICKEST = 1e-3, 0.1
"""Less gas than TRACE of a cell has no density of its own; largest change of density by an exchange in one step."""
_SOME = 1e-3  # of a compartment's cells: less gas than that tells no pressure


@argument
class Cushion(NamedTuple):
    """pressure [Pa]: absolute, of the gas at the start; gamma; shortest [s]: a step in which sound passes half a cell; rooms
    (m, 2): first column and column after the last of compartments; diagonal (size,): term of the pressure equation; middle
    (size,): scratch."""

    pressure: float
    gamma: float
    shortest: float
    rooms: Any
    diagonal: Any
    middle: Any


def cushion(grid: Grid, pressure: float, gamma: float, gas_density: float) -> Cushion | None:
    """Return that of a tank; None where the gas's pressure is 0: it cannot be compressed."""
    if pressure <= 0.0:
        return None
    shortest = 0.5 * min(grid.dx, grid.dy) * (gas_density / (gamma * pressure)) ** 0.5
    rooms = np.array(grid.rooms, dtype=np.int64)
    return Cushion(pressure, gamma, shortest, rooms, np.zeros(grid.size), np.zeros(grid.size))


def charge(mass: Array, q: Array, c: Array, grid: Grid, gas: Cushion, density: float) -> None:
    """Set the mass of gas [ρ₀ times the cell's volume] that belongs to the pressure ρ_l q, whose mean over the gas of each
    compartment becomes 0, that is the pressure at the start; density [kg/m3]: ρ_l."""
    inner, pressure, shares = grid.inner(mass), grid.inner(q), 1.0 - np.clip(grid.inner(c), 0.0, 1.0)
    for first, last in grid.rooms:
        share, room = shares[:, first:last], pressure[:, first:last]
        if share.sum() > _SOME * share.size:
            room -= (share * room).sum() / share.sum()
    inner[:] = shares * np.maximum(1.0 + density * pressure / gas.pressure, 0.0) ** (1.0 / gas.gamma)


@jit
def _carry(mass: Any, out: Any, share: Any, nu: Any, flux: Any, q: Any, gas: Any, factor: float, nx: int, ny: int,
           step: int) -> None:  # fmt: skip
    """out = mass after a sweep along `step`; share: volume of gas in cells. Upwind; gas goes where the liquid does not."""
    s = nx + 2
    for j in range(2, ny + 2):
        for k in range(j * s + 1, j * s + nx + 1):
            out[k] = mass[k]
    for j in range(2, ny + 2):
        for k in range(j * s + 1, j * s + nx + 1):
            if nu[k] == 0.0:
                continue
            donor = k if nu[k] > 0.0 else k + step
            if share[donor] > TRACE:
                density = min(max(mass[donor] / share[donor], THINNEST), DENSEST)
            else:  # a trace of gas has the pressure of its place
                density = max(1.0 + factor * q[donor], 0.0) ** (1.0 / gas.gamma)
            amount = (nu[k] - flux[k]) * density
            out[k] -= amount
            out[k + step] += amount


@jit
def _even_out(mass: Any, c: Any, q: Any, open_x: Any, open_y: Any, gas: Any, factor: float, nx: int, ny: int) -> None:
    """Give the little gas of cells that are mostly liquid the pressure of their place, with gas of cells beside them.

    Those cells are not compressed: their gas would keep the pressure of an earlier time, and set it free at another.
    """
    s = nx + 2
    for j in range(2, ny + 2):
        for k in range(j * s + 1, j * s + nx + 1):
            share = 1.0 - c[k]
            if not TRACE < share < 1.0 - FULL:
                continue
            west = open_x[k - 1] * (1.0 - c[k - 1]) if c[k - 1] <= FULL else 0.0
            east = open_x[k] * (1.0 - c[k + 1]) if c[k + 1] <= FULL else 0.0
            south = open_y[k - s] * (1.0 - c[k - s]) if c[k - s] <= FULL else 0.0
            north = open_y[k] * (1.0 - c[k + s]) if c[k + s] <= FULL else 0.0
            total = west + east + south + north
            if total == 0.0:
                continue
            wanted = share * max(1.0 + factor * q[k], THINNEST) ** (1.0 / gas.gamma)
            each = (mass[k] - wanted) / total
            if abs(each) > QUICKEST:
                each = math.copysign(QUICKEST, each)
            mass[k] -= each * total
            mass[k - 1] += each * west
            mass[k + 1] += each * east
            mass[k - s] += each * south
            mass[k + s] += each * north


@jit
def carry(mass: Any, c: Any, middle: Any, nu_x: Any, nu_y: Any, flux_x: Any, flux_y: Any, q: Any, gas: Any, factor: float,
          share: Any, open_x: Any, open_y: Any, nx: int, ny: int, y_first: bool) -> None:  # fmt: skip
    """Carry the mass of gas with what `advection.advect` moved.

    c, middle: volume fractions before and after the first sweep; nu_x, nu_y, flux_x, flux_y: Courant numbers and liquid's fluxes;
    factor: ρ_l/p₀; share: scratch.
    """
    s = nx + 2
    step, other = (s, 1) if y_first else (1, s)
    nu_1, nu_2 = (nu_y, nu_x) if y_first else (nu_x, nu_y)
    flux_1, flux_2 = (flux_y, flux_x) if y_first else (flux_x, flux_y)
    _even_out(mass, c, q, open_x, open_y, gas, factor, nx, ny)
    for k in range(2 * s, (ny + 2) * s):
        share[k] = 1.0 - c[k]
    _carry(mass, gas.middle, share, nu_1, flux_1, q, gas, factor, nx, ny, step)
    for k in range(2 * s, (ny + 2) * s):
        share[k] = 1.0 - middle[k] - (nu_1[k] - nu_1[k - step] if c[k] <= FULL else 0.0)
    _carry(gas.middle, mass, share, nu_2, flux_2, q, gas, factor, nx, ny, other)


@jit
def keep_velocity(acc: Any, w: Any, nu_x: Any, nu_y: Any, open_face: Any, rho: Any, gas_density: float, per_dt: float, first: int,
                  n: int, step: int, s: int) -> None:  # fmt: skip
    """Add to accelerations what `momentum` misses where gas is compressed: its velocity stays, its density grows."""
    for k in range(first, first + n):
        if open_face[k] == 0.0:
            continue
        near = nu_x[k] - nu_x[k - 1] + nu_y[k] - nu_y[k - s]
        m = k + step
        far = nu_x[m] - nu_x[m - 1] + nu_y[m] - nu_y[m - s]
        acc[k] += gas_density * (near + far) * w[k] * per_dt / (rho[k] + rho[m])


@jit
def soften(rhs: Any, mass: Any, c: Any, u: Any, v: Any, gas: Any, density: float, per_time: float, dt: float, before: float,
           dx: float, dy: float, nx: int, ny: int) -> None:  # fmt: skip
    """Set the diagonal term and change the right-hand side in cells whose gas can be compressed.

    u, v: half-step velocities; per_time: share of their divergence that rhs undoes; density [kg/m3]: ρ_l; before [s]: the step
    before dt, which a tiny one between long ones must not part from: what it does is repeated by the long one after it.
    """
    s, area = nx + 2, dx * dy
    span = max(dt, gas.shortest, 0.5 * before)
    damping = min(span / DAMPING, MOST_DAMPING)
    ahead = PHI + damping
    undone = damping / (ahead * span)
    per_undo = max(per_time, min(1.0 / span, SOONEST * per_time))
    for j in range(2, ny + 2):
        for k in range(j * s + 1, j * s + nx + 1):
            spread = dy * (u[k] - u[k - 1]) + dx * (v[k] - v[k - s])
            if c[k] > FULL:
                gas.diagonal[k] = 0.0
                rhs[k] += (per_time - per_undo) * spread
                continue
            share = 1.0 - max(c[k], 0.0)
            pressure = gas.pressure * min(max(mass[k] / share, THINNEST), DENSEST) ** gas.gamma
            gas.diagonal[k] = area * share * density / (gas.gamma * pressure * ahead * span * span)
            rhs[k] += (per_time - undone) * spread + gas.diagonal[k] * (pressure - gas.pressure) / density
    for m in range(gas.rooms.shape[0]):
        low, high = gas.rooms[m, 0] + 1, gas.rooms[m, 1] + 1
        soft = 0.0
        for j in range(2, ny + 2):
            for k in range(j * s + low, j * s + high):
                soft += gas.diagonal[k]
        if soft == 0.0:  # liquid alone has nowhere to go
            continue
        for j in range(2, ny + 2):
            for k in range(j * s + low, j * s + high):
                if c[k] > 1.0:  # what came in before a cell was full
                    rhs[k] += area * (c[k] - 1.0) * per_time * per_undo
