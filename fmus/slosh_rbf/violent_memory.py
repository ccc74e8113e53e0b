"""What a broken surface remembers of the motion: filters of how the tank moves up and down, nothing fed back from a load.

Times in sqrt(l/g), accelerations in g, lengths in l (the tank's); p = g_n/g − 1 at the liquid's centre, u = 1 + p, gap the room
between surface and roof:

    v' = p − v/HOLD                              velocity of the tank; two stages of SMOOTH on p² and v² are its envelopes
    Q = sqrt(2 <p²>), V = sqrt(2 <v²>)           amplitudes of p and v; A = V²/Q that of the displacement
    c' = sqrt(max(−u, 0)/gap) − FORGET sqrt(max(u, 0)/gap) c            clock: how long the liquid has been thrown
    q'' + (2 ζ ω + STEEP ω a²/gap²) q' + ω² u q = f_x − H alpha''       odd waves from what drives them, crest a cut at the gap
    age' = (grown − age)/SETTLE                  how long waves have filled the gap: a surface just broken takes more work
    y'' = −u/gap − k |y'| y', 0 ≤ y ≤ 1          slugs between floor and roof (y in gaps), five drags k, stopped at both

A steady oscillation without memory would do for its first harmonic; the onset, which decides a flutter march, needs clock and
waves. A surface counts as broken (`share`) where gravity has vanished somewhere, D from 1 to 2 (the largest so far, forgotten
with FADE), and waves have grown, the logarithm of their energy from −6 to −4: before, all records have the loads of a whole
surface. All are bounded for a bounded motion: v leaks, envelopes are means, the clock forgets, waves are cut, slugs are between
walls.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from ..tank.modes import modes
from ..tank.motion import course_into
from .memory import FX, GAMMA, SPIN, Array, Memory, Place, drive

WAVES = 8
DRAGS = np.array([0.3, 1.0, 3.0, 10.0, 30.0])
SLUGS = 5
HARMONICS = 3
HOLD = 1.1
SMOOTH = 0.15
FORGET = 0.05
STEEP = 0.5
FADE = 20.0
SETTLE = 1.1
HIGH = (-1.0, 1.0)
"""ln of the waves' energy between which crests come to fill the gap; `age` follows it within SETTLE."""
SEED = 1e-4
"""Acceleration [g] that drives every wave besides the motion: a pure plunge stirs none of itself, a real surface is never
level."""
PIECE = 5e-3
"""Longest piece of a step [sqrt(l/g)], 1.1 ms for half a metre: slugs meet walls within it."""
FLOOR = 0.02
"""Amplitude [g] below which phase and frequency are not followed."""
SPEED = 9.0
"""Angular frequency [sqrt(g/l)] that goes with the floor: 40 rad/s for half a metre."""

BEGIN, FULL = 1.0, 2.0
"""D where a surface begins to count as broken, and from where it does if waves have grown."""
WHOLE, GROWN = -6.0, -4.0
"""ln of the waves' energy, likewise: crests of a twentieth and of an eighth of the gap."""

V, P1, P2, S1, S2, CLOCK, UNEVEN, AGE = range(8)
Q_AT = 8
W_AT = Q_AT + WAVES
Y_AT = W_AT + WAVES
R_AT = Y_AT + SLUGS
SIZE = R_AT + SLUGS
SPACE = 5
"""Coordinates of the read-out that the motion gives: ln(A/gap), ln Q, clock, ln of the waves' energy, age; the fill is the
sixth."""
ENERGY = 3
BASIS = 1 + 2 * HARMONICS + 3 * SLUGS
"""What is read out: 1, harmonics of the phase, and acceleration, place and velocity of the slugs."""


@argument
class Basin(NamedTuple):
    """A tank for the kernels: unit of time sqrt(l/g) [s]; gap and waves' heights over l, elevation at the wall per q; omega in
    1/unit, damping ratios; shapes (WAVES,)."""

    unit: float
    gap: float
    omega: Array
    damping: Array
    height: Array
    elevation: Array


def basin(memory: Memory) -> Basin:
    """Of a tank with a roof above its liquid."""
    tank = memory.tank
    m, unit = modes(tank, WAVES), math.sqrt(tank.length / tank.gravity)
    gap = max(tank.height - tank.depth, 1e-3 * tank.height) / tank.length
    return Basin(unit, gap, m.omega * unit, memory.damping[:WAVES].copy(), m.height / tank.length, m.elevation.copy())


def still() -> Array:
    """A level surface that has not been thrown. Shape: (SIZE,)."""
    return np.zeros(SIZE)


@jit
def follow(state: Array, start: Array, end: Array, duration: float, place: Place, basin: Basin) -> None:
    """Advance `state` (SIZE,) in place over a step of `duration` [s] between two motions (9,)."""
    table, moment, rows = np.empty((9, 6)), np.empty(9), np.empty((3, 5))
    course_into(start, end, duration, table)
    for j in range(9):
        value = 0.0
        for k in range(5, -1, -1):
            value = 0.5 * value + table[j, k]
        moment[j] = value
    drive(start, place, rows[0])
    drive(moment, place, rows[1])
    drive(end, place, rows[2])
    whole = duration / basin.unit
    pieces = max(1, math.ceil(whole / PIECE - 1e-9))
    dt = whole / pieces
    leak, smooth = math.exp(-dt / HOLD), 1.0 - math.exp(-dt / SMOOTH)
    fade = math.exp(-whole / FADE)
    p = rows[0, GAMMA]
    for i in range(pieces):
        s = (i + 1.0) / pieces
        m = (i + 0.5) / pieces
        # parabolas through start, middle and end
        a, b, c = (1.0 - s) * (1.0 - 2.0 * s), 4.0 * s * (1.0 - s), s * (2.0 * s - 1.0)
        d, e, f = (1.0 - m) * (1.0 - 2.0 * m), 4.0 * m * (1.0 - m), m * (2.0 * m - 1.0)
        p_end = a * rows[0, GAMMA] + b * rows[1, GAMMA] + c * rows[2, GAMMA]
        p_mid = d * rows[0, GAMMA] + e * rows[1, GAMMA] + f * rows[2, GAMMA]
        along = d * rows[0, FX] + e * rows[1, FX] + f * rows[2, FX] + SEED
        turn = 2.0 * (d * rows[0, SPIN] + e * rows[1, SPIN] + f * rows[2, SPIN])
        v = state[V]
        state[V] = leak * v + dt / 6.0 * (leak * p + 4.0 * math.sqrt(leak) * p_mid + p_end)
        v = 0.5 * (v + state[V])
        state[P1] += smooth * (p_mid * p_mid - state[P1])
        state[P2] += smooth * (state[P1] - state[P2])
        state[S1] += smooth * (v * v - state[S1])
        state[S2] += smooth * (state[S1] - state[S2])
        p = p_end
        u = 1.0 + p_mid
        thrown, held = math.sqrt(max(-u, 0.0) / basin.gap), math.sqrt(max(u, 0.0) / basin.gap)
        state[CLOCK] = (state[CLOCK] + dt * thrown) / (1.0 + dt * FORGET * held)
        _wave(state, u, along, turn, dt, basin)
        _slugs(state, u, dt, basin)
    grown = min(max((_energy(state, basin) - HIGH[0]) / (HIGH[1] - HIGH[0]), 0.0), 1.0)
    state[AGE] += (1.0 - math.exp(-whole / SETTLE)) * (grown - state[AGE])
    state[UNEVEN] = max(state[UNEVEN] * fade, abs(rows[2, GAMMA]) + abs(rows[2, SPIN]))


@jit
def share(D: float, energy: float) -> float:
    """How far a surface is broken, 0 to 1, at the unevenness D (`state[UNEVEN]`) and the logarithm of the waves' energy."""
    d = min(max((D - BEGIN) / (FULL - BEGIN), 0.0), 1.0)
    e = min(max((energy - WHOLE) / (GROWN - WHOLE), 0.0), 1.0)
    return d * d * (3.0 - 2.0 * d) * e * e * (3.0 - 2.0 * e)


@jit
def _energy(state: Array, basin: Basin) -> float:
    """ln of the waves' energy: squares of their crests over the gap."""
    energy = 1e-10
    for n in range(WAVES):
        q, w = state[Q_AT + n], state[W_AT + n] / basin.omega[n]
        energy += (basin.elevation[n] / basin.gap) ** 2 * (q * q + w * w)
    return math.log(energy)


@jit
def _wave(state: Array, u: float, along: float, turn: float, dt: float, basin: Basin) -> None:
    for n in range(WAVES):
        q, w, omega = state[Q_AT + n], state[W_AT + n], basin.omega[n]
        high = basin.elevation[n] / basin.gap
        q += 0.5 * dt * w
        crest = high * high * (q * q + w * w / (omega * omega))
        rate = 2.0 * basin.damping[n] * omega + STEEP * omega * min(crest, 4.0)
        w += dt * (along - basin.height[n] * turn - omega * omega * u * q)
        w /= 1.0 + dt * rate
        q += 0.5 * dt * w
        crest = high * math.sqrt(q * q + w * w / (omega * omega))
        if crest > 1.0:
            q, w = q / crest, w / crest
        state[Q_AT + n], state[W_AT + n] = q, w


@jit
def _slugs(state: Array, u: float, dt: float, basin: Basin) -> None:
    fall = -u / basin.gap
    for i in range(SLUGS):
        y, r = state[Y_AT + i], state[R_AT + i]
        r = (r + dt * fall) / (1.0 + dt * DRAGS[i] * abs(r))
        y += dt * r
        if y <= 0.0:
            y, r = 0.0, 0.0
        elif y >= 1.0:
            y, r = 1.0, 0.0
        state[Y_AT + i], state[R_AT + i] = y, r


@jit
def tell(state: Array, p: float, basin: Basin, space: Array, basis: Array) -> float:
    """Fill the coordinates (SPACE,) and what is read out (BASIS,) at an instant with g_n/g − 1 = `p`; returns Q [g]."""
    Q = math.sqrt(2.0 * state[P2] + FLOOR * FLOOR)
    swing = math.sqrt(2.0 * state[S2] + (FLOOR / SPEED) ** 2)
    space[0] = math.log(swing * swing / (Q * basin.gap))
    space[1] = math.log(Q)
    space[2] = state[CLOCK] / (4.0 + state[CLOCK])
    space[ENERGY] = _energy(state, basin)
    space[4] = state[AGE]
    x, y = p / Q, state[V] / swing
    size = math.sqrt(x * x + y * y + 0.01)
    x, y = x / size, y / size
    basis[0] = 1.0
    a, b = 1.0, 0.0
    for k in range(HARMONICS):
        a, b = a * x - b * y, a * y + b * x
        basis[1 + 2 * k], basis[2 + 2 * k] = a, b
    u = 1.0 + p
    at = 1 + 2 * HARMONICS
    for i in range(SLUGS):
        place, rate = state[Y_AT + i], state[R_AT + i]
        flying = (place > 0.0 and place < 1.0) or (place <= 0.0 and u < 0.0) or (place >= 1.0 and u > 0.0)
        basis[at] = (-u - basin.gap * DRAGS[i] * abs(rate) * rate) / Q if flying else 0.0
        basis[at + 1] = 2.0 * place - 1.0
        basis[at + 2] = basin.gap * rate / swing
        at += 3
    return Q
