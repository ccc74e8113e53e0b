"""Motions of a tank for tests: harmonic with a smooth start, and random."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.tank.motion import SectionMotion

Course = Callable[[float], SectionMotion]
REST = SectionMotion()


def harmonic(omega: float, rise: float, *, pitch: float = 0.0, plunge: float = 0.0, surge: float = 0.0) -> Course:
    """amplitude · (10 s³ − 15 s⁴ + 6 s⁵) · sin(ω t), s = t/rise up to 1 [rad, m, s]."""

    def at(t: float) -> SectionMotion:
        s = min(t / rise, 1.0)
        r, r1, r2 = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 * (1 - s) ** 2 / rise, 60 * s * (1 - s) * (1 - 2 * s) / rise**2
        sin, cos = np.sin(omega * t), np.cos(omega * t)
        q = np.array([r * sin, r1 * sin + r * omega * cos, r2 * sin + 2 * r1 * omega * cos - r * omega**2 * sin])
        return SectionMotion(*(plunge * q), *(pitch * q), *(surge * q))

    return at


def random(seed: int, *, plunge: float, pitch: float, surge: float) -> Course:
    """Twelve frequencies from 2 to 60 rad/s; amplitudes of the rates [m/s, rad/s, m/s] each, rising over half a second."""
    rng = np.random.default_rng(seed)
    omega, phase = rng.uniform(2, 60, 12), rng.uniform(0, 2 * np.pi, (3, 12))

    def at(t: float) -> SectionMotion:
        s = min(t / 0.5, 1.0)
        r, r1, r2 = s**3, 3 * s**2 / 0.5 * (s < 1), 6 * s / 0.25 * (s < 1)
        values: list[float] = []
        for rate, p in zip((plunge, pitch, surge), phase, strict=True):
            q = rate * np.array(
                [(np.sin(omega * t + p) / omega).sum(), np.cos(omega * t + p).sum(), -(omega * np.sin(omega * t + p)).sum()]
            )
            values += [r * q[0], r1 * q[0] + r * q[1], r2 * q[0] + 2 * r1 * q[1] + r * q[2]]
        return SectionMotion(*map(float, values))

    return at


def march(flow: Flow, motion: Course, duration: float, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Drive a started flow; returns times (n,) and loads (n, 7) at the end of each communication step."""
    times = step * np.arange(1, round(duration / step) + 1)
    rows = []
    for t in times:
        flow.advance(motion(t - step), motion(t), step)
        rows.append(flow.loads(motion(t)))
    return times, np.array(rows)
