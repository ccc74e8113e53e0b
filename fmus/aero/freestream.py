"""The stream in SI units and the scales of the solver: chord, freestream density, freestream sound speed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from .field import Motion
from .flux import GAMMA

GAS_CONSTANT = 287.05  # [J/(kg K)], dry air


@dataclass(frozen=True)
class Freestream:
    """Uniform stream of air past a section of the given chord."""

    mach: float
    pressure: float  # [Pa], static
    temperature: float  # [K], static
    chord: float  # [m]

    @property
    def sound_speed(self) -> float:
        """[m/s]"""
        return math.sqrt(GAMMA * GAS_CONSTANT * self.temperature)

    @property
    def speed(self) -> float:
        """[m/s]"""
        return self.mach * self.sound_speed

    @property
    def density(self) -> float:
        """[kg/m3]"""
        return self.pressure / (GAS_CONSTANT * self.temperature)

    @property
    def dynamic_pressure(self) -> float:
        """[Pa]"""
        return 0.5 * self.density * self.speed**2

    def scaled_time(self, seconds: float) -> float:
        """Time in chords over sound speed."""
        return seconds * self.sound_speed / self.chord

    def scaled_motion(self, motion: Motion) -> Motion:
        """Motion from SI units [m, rad, s] to chords and sound speed."""
        a, c = self.sound_speed, self.chord
        return Motion(
            h=motion.h / c,
            h_dot=motion.h_dot / a,
            h_ddot=motion.h_ddot * c / a**2,
            alpha=motion.alpha,
            alpha_dot=motion.alpha_dot * c / a,
            alpha_ddot=motion.alpha_ddot * (c / a) ** 2,
        )


def between(start: Motion, end: Motion, duration: float, share: float) -> Motion:
    """Motion at start + share·duration: the cubics through positions and rates at both ends, accelerations linear."""
    s = share

    def cubic(p0: float, v0: float, p1: float, v1: float) -> tuple[float, float]:
        d = duration
        value = (1 + 2 * s) * (1 - s) ** 2 * p0 + s * s * (3 - 2 * s) * p1 + d * s * (1 - s) * ((1 - s) * v0 - s * v1)
        rate = 6 * s * (1 - s) * (p1 - p0) / d + (1 - s) * (1 - 3 * s) * v0 + s * (3 * s - 2) * v1
        return value, rate

    h, h_dot = cubic(start.h, start.h_dot, end.h, end.h_dot)
    alpha, alpha_dot = cubic(start.alpha, start.alpha_dot, end.alpha, end.alpha_dot)
    return Motion(
        h,
        h_dot,
        (1 - s) * start.h_ddot + s * end.h_ddot,
        alpha,
        alpha_dot,
        (1 - s) * start.alpha_ddot + s * end.alpha_ddot,
    )
