"""A communication step in one compiled call: as many internal time steps as the flow asks for.

Velocity Verlet: half-step velocity → volume fractions → acceleration at the new time with the new surface → velocity. Gravity
waves and the tank's acceleration are second order in time for any sequence of steps; advection and viscosity are taken at the
half step.

Rows of `state`: C volume fraction, U, V velocities, AX, AY accelerations (all at the same time, both free of divergence), Q
pressure over liquid density, Q_BEFORE that of the step before; GAS its mass, where it can be compressed. Rows of `work`: scratch.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from .advection import advect
from .curvature import curvature
from .cushion import carry, keep_velocity, soften
from .forces import interface_forces
from .momentum import LIQUID as FULL
from .momentum import component, mirror, shear, wall_ghosts
from .partition import settle, slip
from .pressure import solve
from .probes import sample
from .side_walls import hold_back
from .wall_layer import wall_shear

C, U, V, AX, AY, Q, Q_BEFORE, GAS = range(8)
STATE_ROWS = 7  # and GAS with a cushion
NU_X, NU_Y, FLUX_X, FLUX_Y, MIDDLE, NEW, OLD_RHO, RHO, LIQUID, MU, TAU, MASS_X, MASS_Y, ALONG, ACROSS, KX, KY, RHS = range(18)
U_HALF, V_HALF = 18, 19
WORK_ROWS = 20
TIME_STEP, STEPS, ITERATIONS, UNCONVERGED, RESIDUAL, Y_FIRST, RATE = range(7)
NOTES = 7

OK, NOT_FINITE, TOO_SMALL, TOO_MANY = range(4)
SMALLEST_STEP = 1e-9
MOST_STEPS = 2_000_000
FARTHEST = 4.0
"""Pressure is not extrapolated over more than this many of the last steps: a tiny step's change is noise."""


@argument
class Numbers(NamedTuple):
    """Constants of a run: cell counts and sizes, fluids, gravity, numerics."""

    nx: int
    ny: int
    dx: float
    dy: float
    liquid_density: float
    gas_density: float
    liquid_viscosity: float
    gas_viscosity: float
    surface_tension: float
    gravity: float
    cfl: float
    tolerance: float
    max_step: float
    most_iterations: int
    slip: bool
    layer: bool


@argument
class Places(NamedTuple):
    """Arrays that never change: coordinates of cells, open faces, multigrid levels."""

    x: Any
    y: Any
    open_x: Any
    open_y: Any
    levels: Any


@jit
def frame_force(course: Any, share: float, gravity: float, frame: Any) -> None:
    """Body force of the moving frame at a share of the communication step: `tank.motion.body_force`, compiled and by its parts.

    course (9, 6) as from `tank.motion.course`; frame (5,) receives the force at the elastic axis along x and y, the angular
    acceleration, the squared rate and the rate (nose-up).
    """
    h_ddot, alpha, rate, spin, x_ddot = 0.0, 0.0, 0.0, 0.0, 0.0
    for m in range(5, -1, -1):
        h_ddot = h_ddot * share + course[2, m]
        alpha = alpha * share + course[3, m]
        rate = rate * share + course[4, m]
        spin = spin * share + course[5, m]
        x_ddot = x_ddot * share + course[8, m]
    down = gravity - h_ddot
    sin, cos = math.sin(alpha), math.cos(alpha)
    frame[0] = down * sin - x_ddot * cos
    frame[1] = -down * cos - x_ddot * sin
    frame[2] = spin
    frame[3] = rate * rate
    frame[4] = rate


@jit
def _courant(nu: Any, half: Any, w: Any, a: Any, dt: float, h: float, first: int, n: int) -> float:
    """Half-step velocities and Courant numbers of the faces; returns the largest, NaN where one is not finite."""
    out, hw, ww, aa = nu[first : first + n], half[first : first + n], w[first : first + n], a[first : first + n]
    per_h, largest, total = dt / h, 0.0, 0.0
    for k in range(n):
        hw[k] = ww[k] + 0.5 * dt * aa[k]
        out[k] = hw[k] * per_h
        largest = max(largest, abs(out[k]))
        total += out[k]
    return largest + 0.0 * total  # max lets NaN pass, a sum does not


@jit
def _fluids(c: Any, rho: Any, mu: Any, liquid: Any, p: Any, n: int, start: int) -> None:
    """Density, dynamic viscosity and liquid flag of cells (ghosts follow by mirror)."""
    cc, r, m, f = c[start : start + n], rho[start : start + n], mu[start : start + n], liquid[start : start + n]
    gas, jump = p.gas_density, p.liquid_density - p.gas_density
    thin = p.gas_density * p.gas_viscosity
    thick = p.liquid_density * p.liquid_viscosity - thin
    for k in range(n):
        share = min(max(cc[k], 0.0), 1.0)
        r[k] = gas + jump * cc[k]
        m[k] = thin + thick * share
        f[k] = 1.0 if cc[k] > FULL else 0.0


@jit
def _mass(mass: Any, nu: Any, flux: Any, p: Any, start: int, n: int) -> None:
    m, v, f = mass[start : start + n], nu[start : start + n], flux[start : start + n]
    gas, jump = p.gas_density, p.liquid_density - p.gas_density
    for k in range(n):
        m[k] = gas * v[k] + jump * f[k]


@jit
def _conductance(k_out: Any, rho: Any, gate: Any, ratio: float, density: float, start: int, n: int, step: int) -> None:
    out, g = k_out[start : start + n], gate[start : start + n]
    r0, r1 = rho[start : start + n], rho[start + step : start + step + n]
    factor = 2.0 * density * ratio
    for k in range(n):
        out[k] = g[k] * factor / (r0[k] + r1[k])


@jit
def _divergence(
    rhs: Any, ax: Any, ay: Any, u: Any, v: Any, per_dt: float, dx: float, dy: float, first: int, n: int, s: int
) -> None:
    """rhs = −(divergence of the acceleration + that left in the velocity, to be undone within a step) times cell area."""
    out = rhs[first : first + n]
    a0, a1 = ax[first - 1 : first - 1 + n], ax[first : first + n]
    b0, b1 = ay[first - s : first - s + n], ay[first : first + n]
    u0, u1 = u[first - 1 : first - 1 + n], u[first : first + n]
    v0, v1 = v[first - s : first - s + n], v[first : first + n]
    for k in range(n):
        out[k] = -dy * ((a1[k] - a0[k]) + per_dt * (u1[k] - u0[k])) - dx * ((b1[k] - b0[k]) + per_dt * (v1[k] - v0[k]))
    for k in range(0, n, s):  # velocities beyond walls are mirrored ones
        out[k] = 0.0
        out[k + s - 1] = 0.0


@jit
def _project(a: Any, w: Any, half: Any, q: Any, k_face: Any, width: float, dt: float, first: int, n: int, step: int) -> float:
    """Subtract the pressure gradient, advance the velocity by half a step; returns the largest velocity."""
    acc, ww, hw = a[first : first + n], w[first : first + n], half[first : first + n]
    q0, q1, kk = q[first : first + n], q[first + step : first + step + n], k_face[first : first + n]
    per_width, largest = 1.0 / width, 0.0
    for k in range(n):
        acc[k] -= kk[k] * (q1[k] - q0[k]) * per_width
        ww[k] = hw[k] + 0.5 * dt * acc[k]
        largest = max(largest, abs(ww[k]))
    return largest


@jit
def _extrapolate(q: Any, before: Any, ratio: float, n: int) -> None:
    for k in range(n):
        last = q[k]
        q[k] = last + ratio * (last - before[k])
        before[k] = last


@jit
def accelerate(state: Any, work: Any, coarse: Any, surface: Any, layers: Any, frame: Any, places: Any, p: Any,
               dt: float, tolerance: float, sides: Any, ribs: Any = None, gas: Any = None,
               before: float = 0.0) -> tuple[int, float]:  # fmt: skip
    """Acceleration and pressure at the time of the volume fractions in `state`.

    Needs half-step velocities and their mass fluxes over dt in `work`. sides: friction of the side walls (`side_walls.Sides`), or
    None: numba then compiles a kernel without it, whose results are to the bit those it had before; ribs (`partition.Partition`)
    and gas (`cushion.Cushion`) likewise; before [s]: the step before dt. Returns iterations and the residual over its limit.
    """
    nx, ny, dx, dy = p.nx, p.ny, p.dx, p.dy
    s = nx + 2
    first, n = 2 * s, ny * s
    ax, ay, q = state[AX], state[AY], state[Q]
    u, v = work[U_HALF], work[V_HALF]
    rho, old, mu, tau, liquid = work[RHO], work[OLD_RHO], work[MU], work[TAU], work[LIQUID]
    _fluids(state[C], rho, mu, liquid, p, n, first)
    mirror(rho, nx, ny)
    mirror(mu, nx, ny)
    mirror(liquid, nx, ny)
    wall_ghosts(u, v, nx, ny, p.slip)
    shear(tau, u, v, mu, dx, dy, nx, ny, p.slip)
    if ribs is not None:
        slip(tau, places.open_x, ribs, nx, ny)
    if p.layer:
        wall_shear(tau, u, v, state[C], layers, p.liquid_density, p.liquid_viscosity, dx, dy, nx, ny, dt)
    force = (frame[0] + 0.5 * dx * frame[3], frame[3], -frame[2], -2.0 * frame[4])
    component(ax, u, v, places.open_x, old, rho, work[MASS_X], work[MASS_Y], liquid, mu, tau, places.x, places.y, force, dt, dx,
              dy, 1.0 / p.liquid_density, work[ALONG], work[ACROSS], first, n, 1, s, ribs)  # fmt: skip
    force = (frame[1] + 0.5 * dy * frame[3], frame[2], frame[3], 2.0 * frame[4])
    component(ay, v, u, places.open_y, old, rho, work[MASS_Y], work[MASS_X], liquid, mu, tau, places.x, places.y, force, dt, dy,
              dx, 1.0 / p.liquid_density, work[ALONG], work[ACROSS], first, n, s, 1, ribs)  # fmt: skip
    if gas is not None:
        keep_velocity(ax, u, work[NU_X], work[NU_Y], places.open_x, rho, p.gas_density, 1.0 / dt, first, n, 1, s)
        keep_velocity(ay, v, work[NU_X], work[NU_Y], places.open_y, rho, p.gas_density, 1.0 / dt, first, n, s, s)
    if sides is not None:
        hold_back(ax, u, places.open_x, state[C], rho, p, sides, first, n, 1)
        hold_back(ay, v, places.open_y, state[C], rho, p, sides, first, n, s)
    if p.surface_tension > 0.0:
        curvature(state[C], surface, dx, dy, nx, ny, ribs)
    interface_forces(ax, ay, state[C], rho, places.open_x, places.open_y, surface, places.x, places.y, frame,
                     p.liquid_density - p.gas_density, p.surface_tension, dx, dy, s)  # fmt: skip
    _conductance(work[KX], rho, places.open_x, dy / dx, p.liquid_density, first, n, 1)
    _conductance(work[KY], rho, places.open_y, dx / dy, p.liquid_density, first, n, s)
    # a tiny step must neither undo all divergence at once, which a long step after it would repeat, nor ask for more than a
    # small error of pressure
    time = max(dt, math.sqrt(min(dx, dy) / (100.0 * p.gravity)))
    _divergence(work[RHS], ax, ay, u, v, 1.0 / time, dx, dy, first, n, s)
    limit = tolerance / time**2 * dx * dy
    if gas is not None:
        soften(work[RHS], state[GAS], state[C], u, v, gas, p.liquid_density, 1.0 / time, dt, before, dx, dy, nx, ny)
        iterations, left = solve(q, work[RHS], work[KX], work[KY], limit, p.most_iterations, places.levels, coarse, work[:3],
                                 gas.diagonal)  # fmt: skip
        if ribs is not None:
            settle(q, state[C], ribs, nx, ny, gas.diagonal)
        return iterations, left
    iterations, left = solve(q, work[RHS], work[KX], work[KY], limit, p.most_iterations, places.levels, coarse, work[:3])
    if ribs is not None:
        settle(q, state[C], ribs, nx, ny)
    return iterations, left


@jit
def advance(state: Any, work: Any, coarse: Any, surface: Any, layers: Any, notes: Any, course: Any, duration: float,
            places: Any, p: Any, sides: Any, watch: Any, ribs: Any = None, gas: Any = None) -> int:  # fmt: skip
    """Advance the flow by `duration` [s] in a frame that follows `course`; in place. Returns OK or what went wrong.

    notes (7,): last time step, steps, iterations, steps whose pressure did not converge, worst residual over its limit, which
    sweep comes first, and the largest Courant number per second: read and kept. Probes
    of `watch` are read after every internal step; None for none, as of `sides`, `ribs` and `gas`.
    """
    nx, ny, dx, dy = p.nx, p.ny, p.dx, p.dy
    s = nx + 2
    first, n = 2 * s, ny * s
    frame = np.zeros(5)
    done = 0.0
    notes[STEPS], notes[ITERATIONS], notes[UNCONVERGED], notes[RESIDUAL] = 0.0, 0.0, 0.0, 0.0
    while True:
        remaining = duration - done
        dt = min(p.max_step, p.cfl / max(notes[RATE], 1e-9))
        if notes[STEPS] >= MOST_STEPS:
            return TOO_MANY
        while True:
            parts = math.ceil(remaining / dt - 1e-9)
            dt = remaining / parts
            largest = _courant(work[NU_X], work[U_HALF], state[U], state[AX], dt, dx, first, n)
            largest = max(largest, _courant(work[NU_Y], work[V_HALF], state[V], state[AY], dt, dy, first, n))
            if not math.isfinite(largest):
                return NOT_FINITE
            if largest <= p.cfl * 1.05:
                break
            dt *= 0.95 * p.cfl / largest
            if dt < SMALLEST_STEP:
                return TOO_SMALL
        advect(state[C], work[NEW], work[MIDDLE], work[NU_X], work[NU_Y], work[FLUX_X], work[FLUX_Y], surface, nx, ny,
               notes[Y_FIRST] > 0.0, ribs)  # fmt: skip
        if gas is not None:
            carry(state[GAS], state[C], work[MIDDLE], work[NU_X], work[NU_Y], work[FLUX_X], work[FLUX_Y], state[Q], gas,
                  p.liquid_density / gas.pressure, work[ALONG], places.open_x, places.open_y, nx, ny,
                  notes[Y_FIRST] > 0.0)  # fmt: skip
        notes[Y_FIRST] = 1.0 - notes[Y_FIRST]
        _mass(work[MASS_X], work[NU_X], work[FLUX_X], p, first, n)
        _mass(work[MASS_Y], work[NU_Y], work[FLUX_Y], p, first, n)
        state[C, :] = work[NEW]
        work[OLD_RHO, :] = work[RHO]
        done = duration if parts == 1 else done + dt
        frame_force(course, done / duration, p.gravity, frame)
        ratio = dt / notes[TIME_STEP] if notes[TIME_STEP] > 0.0 else 0.0
        _extrapolate(state[Q], state[Q_BEFORE], ratio if ratio < FARTHEST else 0.0, state.shape[1])
        iterations, residual = accelerate(state, work, coarse, surface, layers, frame, places, p, dt, p.tolerance, sides,
                                          ribs, gas, notes[TIME_STEP])  # fmt: skip
        if not math.isfinite(residual):
            return NOT_FINITE
        fastest = _project(state[AX], state[U], work[U_HALF], state[Q], work[KX], dy, dt, first, n, 1) / dx
        fastest = max(fastest, _project(state[AY], state[V], work[V_HALF], state[Q], work[KY], dx, dt, first, n, s) / dy)
        notes[RATE] = fastest
        notes[TIME_STEP] = dt
        notes[STEPS] += 1.0
        notes[ITERATIONS] += iterations
        notes[UNCONVERGED] += 1.0 if residual > 1.0 else 0.0
        notes[RESIDUAL] = max(notes[RESIDUAL], residual)
        if watch is not None:
            sample(watch, state, surface, work[RHO], frame, places.x, places.y, places.open_x, places.open_y, p, dt)
        if parts == 1:
            return OK
