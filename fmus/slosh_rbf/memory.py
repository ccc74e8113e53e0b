"""The surrogate's memory: the tank's linear waves, and what changing gravity makes of them, driven by the tank's motion alone.

In the tank's own axes the liquid feels a body force f = (f_x, f_y) at its centre of mass, and turns (tank.motion). With
gamma = −f_y/g − 1 the change of the effective gravity, modal masses s_n and their corrections S_n obey

    s_n'' + 2 zeta omega s_n' + omega² s_n = f_x − H_n alpha''
    S_n'' + 2 zeta omega S_n' + omega² S_n = (alpha'² − omega² gamma) (s_n + S_n)

Together they are the equation of Benjamin and Ursell (Proc. R. Soc. A 225 (1954) 505, doi:10.1098/rspa.1954.0218) for a gravity
that changes: s is linear slosh, S may grow of itself (Mathieu). Breaking holds such growth in bounds in a tank; here S_n is cut
where its wave reaches a twentieth of the depth. So bounded motion gives bounded memory, whatever reads it out: s is linear and
damped, S is cut.

Over a step the motion is a polynomial (tank.motion.course), its drive is taken through six points of the step, and the
oscillators answer it exactly (tank.oscillators): one step of 5 ms remembers as ten of 0.5 ms. What S pushes at itself in a step
is found by SWEEPS sweeps over the points (each gains a factor omega² gamma T²/2, below 0.02).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import argument
from ..kit.compiled import jit
from ..tank.liquid import Tank
from ..tank.modes import Modes, modes, stokes_damping
from ..tank.motion import course_into
from ..tank.oscillators import LARGEST_DAMPING, Oscillators

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

MODES = SECOND = 20  # modes remembered, and those of them with a correction for changing gravity
HIGHEST = 0.05
"""Largest wave of S_n over the depth: no record with a whole surface reached it, and after break-up more made loads too large."""
POINTS = 6
SWEEPS = 2
FX, GAMMA, SPIN, RATE, TILT = range(5)
"""Rows of a drive: f_x/g, gamma, (l/2) alpha''/g, (l/2) alpha'²/g, alpha."""

_SHARES = 0.5 * (1.0 - np.cos(np.pi * np.arange(POINTS) / (POINTS - 1)))
_TO_POWERS = np.linalg.inv(np.vander(_SHARES, POINTS, increasing=True))


@argument
class Step(NamedTuple):
    """Propagators of one step size. free (MODES,), weights (POINTS, MODES): tank.oscillators at the step's end; free_at (POINTS,
    SECOND), weights_at and answers_at (POINTS, POINTS, SECOND): at the points in it, per coefficient of a force's polynomial and
    per value at a point."""

    duration: float
    free: Complex
    weights: Complex
    free_at: Complex
    weights_at: Complex
    answers_at: Complex


@argument
class Place(NamedTuple):
    """Where the liquid is and what its waves are: tank length, gravity, its centre (x, y) from the elastic axis; heights H_n,
    omega_n, imaginary parts of the rates and largest |S_n| of the modes, shape (MODES,)."""

    length: float
    gravity: float
    x: float
    y: float
    height: Array
    omega: Array
    imag: Array
    highest: Array


class Memory:
    """The waves of `tank`, damped by its liquid's `viscosity` [m2/s]. Stateless but for its propagators.

    The state is one complex array, shape (MODES + SECOND,)."""

    def __init__(self, tank: Tank, viscosity: float) -> None:
        self.tank, self.modes = tank, modes(tank, MODES)
        self.damping = np.minimum(stokes_damping(tank, self.modes.omega, viscosity), LARGEST_DAMPING)
        self.oscillators = Oscillators(self.modes.omega, self.damping)
        self.second = Oscillators(self.modes.omega[:SECOND], self.damping[:SECOND])
        m: Modes = self.modes
        self.place = Place(
            tank.length, tank.gravity, tank.x, tank.centre_y, m.height, m.omega, self.oscillators.rate.imag.copy(),
            HIGHEST * tank.depth / np.maximum(m.elevation, 1e-12),
        )  # fmt: skip
        self._steps: dict[float, Step] = {}

    def start(self, motion: Array) -> Complex:
        """The level surface in a liquid that moves with the tank. motion: nine values of a SectionMotion."""
        w = np.zeros(MODES + SECOND, dtype=np.complex128)
        level = self.tank.gravity / self.modes.omega**2 * math.sin(motion[3])
        # gravity across the tank is g cos(alpha): the level surface stands at tan(alpha)
        steeper = (1.0 / max(math.cos(motion[3]), 0.1) - 1.0) * level
        w[:MODES] = self.oscillators.amplitude(level, np.zeros(MODES))
        w[MODES:] = self.second.amplitude(steeper, np.zeros(SECOND))
        return w

    def step(self, duration: float) -> Step:
        """Propagators of a step of `duration` [s]."""
        found = self._steps.get(duration)
        if found is None:
            if len(self._steps) >= 64:
                self._steps.clear()
            free_at, weights_at = np.ones((POINTS, SECOND), complex), np.zeros((POINTS, POINTS, SECOND), complex)
            for i in range(1, POINTS):
                free_at[i], weights = self.second.propagator(duration * _SHARES[i])
                weights_at[i] = weights * _SHARES[i] ** np.arange(POINTS)[:, None]
            free, weights = self.oscillators.propagator(duration)
            found = self._steps[duration] = Step(
                duration, free, weights, free_at, weights_at, np.einsum("ikn,kj->ijn", weights_at, _TO_POWERS)
            )
        return found


@jit
def drive(motion: Array, place: Place, out: Array) -> None:
    """The drive (5,) at one instant of the motion (9,)."""
    sin, cos = math.sin(motion[3]), math.cos(motion[3])
    down, turn, square = place.gravity - motion[2], motion[5], motion[4] ** 2
    along = down * sin - motion[8] * cos - place.y * turn + place.x * square
    up = -down * cos - motion[8] * sin + place.x * turn + place.y * square
    out[FX] = along / place.gravity
    out[GAMMA] = -up / place.gravity - 1.0
    out[SPIN] = 0.5 * place.length * turn / place.gravity
    out[RATE] = 0.5 * place.length * square / place.gravity
    out[TILT] = motion[3]


@jit
def remember(w: Complex, start: Array, end: Array, step: Step, place: Place) -> Complex:
    """The state after a step between two motions (9,)."""
    table, moment, rows = np.empty((9, 6)), np.empty(9), np.empty((POINTS, 5))
    course_into(start, end, step.duration, table)
    for i in range(POINTS):
        for j in range(9):
            value = 0.0
            for k in range(5, -1, -1):
                value = value * _SHARES[i] + table[j, k]
            moment[j] = value
        drive(moment, place, rows[i])
    along, turn = np.empty(POINTS), np.empty(POINTS)
    for k in range(POINTS):
        a, b = 0.0, 0.0
        for i in range(POINTS):
            a += _TO_POWERS[k, i] * rows[i, FX]
            b += _TO_POWERS[k, i] * rows[i, SPIN]
        along[k], turn[k] = a * place.gravity, b * place.gravity / (0.5 * place.length)
    new = np.empty(MODES + SECOND, dtype=np.complex128)
    for n in range(MODES):
        value = step.free[n] * w[n]
        for k in range(POINTS):
            value += step.weights[k, n] * (along[k] - place.height[n] * turn[k])
        new[n] = value
    first, answer, pushed = np.empty(POINTS), np.empty(POINTS), np.empty(POINTS)
    for n in range(SECOND):
        for i in range(POINTS):
            value = step.free_at[i, n] * w[n]
            for k in range(POINTS):
                value += step.weights_at[i, k, n] * (along[k] - place.height[n] * turn[k])
            first[i] = value.imag / place.imag[n]
            answer[i] = (step.free_at[i, n] * w[MODES + n]).imag / place.imag[n]
        for _ in range(SWEEPS):
            for i in range(POINTS):
                square = rows[i, RATE] * place.gravity / (0.5 * place.length)
                pushed[i] = (square - place.omega[n] ** 2 * rows[i, GAMMA]) * (first[i] + answer[i])
            for i in range(POINTS):
                value = step.free_at[i, n] * w[MODES + n]
                for k in range(POINTS):
                    value += step.answers_at[i, k, n] * pushed[k]
                answer[i] = value.imag / place.imag[n]
        value = step.free[n] * w[MODES + n]
        for k in range(POINTS):
            push = 0.0
            for i in range(POINTS):
                push += _TO_POWERS[k, i] * pushed[i]
            value += step.weights[k, n] * push
        most = place.highest[n]
        size = abs(value) / place.imag[n]
        if size > most:
            value *= most / size
        new[MODES + n] = value
    return new
