"""Waves that nobody drives: gravity that changes at twice a wave's frequency makes it grow of itself (Faraday).

Each of the first WAVES waves is followed by Mathieu's equation A'' + 2 zeta omega A' + omega² (1 + gamma) A = 0 (Benjamin and
Ursell 1954, doi:10.1098/rspa.1954.0218), of either symmetry, from two starts a quarter of a period apart; `grow` gives the
logarithm of the largest amplitude over its seed. It begins above 4 zeta g. Two solvers that round differently then disagree by
as much: no model can predict such waves one by one.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import argument
from ..kit.compiled import jit
from .liquid import Tank
from .modes import stokes_damping, wave_frequencies
from .motion import SectionMotion, body_force
from .oscillators import LARGEST_DAMPING

Array = NDArray[np.float64]

WAVES = 40
"""Waves to 50 rad/s in half a metre: gravity that changes at up to 100 rad/s."""


@argument
class Waves(NamedTuple):
    """omega [rad/s] and damping ratios of the waves, shape (WAVES,)."""

    omega: Array
    damping: Array


def waves(tank: Tank, viscosity: float) -> Waves:
    """Waves of both symmetries in `tank`, damped by the liquid's `viscosity` [m2/s]."""
    halves = np.arange(1.0, WAVES + 1.0)
    omega = wave_frequencies(tank, halves)
    return Waves(omega, np.minimum(stokes_damping(tank, omega, viscosity, halves), LARGEST_DAMPING))


def still() -> Array:
    """No wave has grown: two solutions of unit size together. Shape: (WAVES, 5): two solutions and the logarithm taken out."""
    state = np.zeros((WAVES, 5))
    state[:, 0] = state[:, 3] = math.sqrt(0.5)
    return state


def gravity_change(tank: Tank, motion: SectionMotion) -> float:
    """gamma: the change of the gravity that the liquid's centre feels, over gravity."""
    return -body_force(motion, tank.x, tank.centre_y, tank.gravity)[1] / tank.gravity - 1.0


@jit
def grow(state: Array, before: float, after: float, duration: float, waves: Waves) -> float:
    """Advance the waves in place over a step at whose ends gravity is 1 + `before` and 1 + `after` of its usual size; returns
    the largest logarithm of growth.

    A step is cut so that no wave turns by more than half a radian; in a piece gravity stands at its middle."""
    largest = 0.0
    for j in range(WAVES):
        omega, zeta = waves.omega[j], waves.damping[j]
        pieces = int(omega * duration / 0.5) + 1
        dt = duration / pieces
        fade = math.exp(-zeta * omega * dt)
        a, b, c, d = state[j, 0], state[j, 1], state[j, 2], state[j, 3]  # A1, A1'/omega, A2, A2'/omega
        for i in range(pieces):
            share = (i + 0.5) / pieces
            stiff = 1.0 + before + share * (after - before)
            root = math.sqrt(abs(stiff))
            turn = omega * root * dt
            if stiff > 0.0:
                cos, sin_over, sin_times = math.cos(turn), math.sin(turn) / root, -math.sin(turn) * root
            else:
                cos = math.cosh(turn)
                sin_over = math.sinh(turn) / root if root > 1e-9 else omega * dt
                sin_times = math.sinh(turn) * root
            a, b = fade * (cos * a + sin_over * b), fade * (sin_times * a + cos * b)
            c, d = fade * (cos * c + sin_over * d), fade * (sin_times * c + cos * d)
        size = math.sqrt(a * a + b * b + c * c + d * d)
        if not size < 1e300:  # gravity beyond all bounds: the wave is beyond telling
            state[j, 4] += 700.0
            a, b, c, d, size = 0.5, 0.5, 0.5, 0.5, 1.0
        if size > 1e6 or size < 1e-6:  # what is beyond goes into the logarithm
            state[j, 4] += math.log(size)
            a, b, c, d = a / size, b / size, c / size, d / size
            size = 1.0
        if state[j, 4] + math.log(size) < 0.0:  # a seed is always there
            scale = 1.0 / size
            a, b, c, d, size = a * scale, b * scale, c * scale, d * scale, 1.0
            state[j, 4] = 0.0
        state[j, 0], state[j, 1], state[j, 2], state[j, 3] = a, b, c, d
        largest = max(largest, state[j, 4] + math.log(size))
    return largest
