"""How well loads are foretold: errors over a record, first harmonics, and the work that decides flutter."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ...tank.liquid import Tank
from ..memory import Array

FLOOR = 0.002
"""A load's std counts as at least this part of the liquid's weight (times half the length for the moment): in pure pitch the
force up hardly moves, and a per cent of nothing says nothing."""


class Harmonic(NamedTuple):
    """First harmonic against the true one: relative difference of amplitude, phase ahead [rad]."""

    amplitude: float
    phase: float


def size(loads: Array, tank: Tank) -> Array:
    """Std of force_x, force_y, moment about the record's mean, not below FLOOR of the weight. loads (n, 3); shape (3,)."""
    weight = tank.mass * tank.gravity
    return np.maximum(loads.std(axis=0), FLOOR * weight * np.array([1.0, 1.0, 0.5 * tank.length]))


def errors(found: Array, true: Array, tank: Tank) -> Array:
    """Rms of the difference over the `size` of the true loads, both (n, 3). Shape: (3,)."""
    return np.sqrt(((found - true) ** 2).mean(axis=0)) / size(true, tank)


def phasors(loads: Array, times: np.ndarray, omega: float) -> Array:
    """Complex amplitudes of loads (n, k) at `omega` [rad/s] over the last whole periods of the later half. Shape: (k,)."""
    period = 2.0 * np.pi / omega
    periods = max(1, int(0.5 * (times[-1] - times[0]) / period))
    late = times > times[-1] - periods * period - 1e-9
    t = times[late]
    basis = np.stack([np.cos(omega * t), np.sin(omega * t), np.ones_like(t), t - t.mean()], axis=1)
    c = np.linalg.lstsq(basis, loads[late], rcond=None)[0]
    return c[0] - 1j * c[1]


def harmonics(found: Array, true: Array, times: np.ndarray, omega: float, tank: Tank) -> list[Harmonic | None]:
    """Of each load of a record at one frequency; None where the true one is below FLOOR of the weight."""
    weight = tank.mass * tank.gravity * np.array([1.0, 1.0, 0.5 * tank.length])
    pairs = zip(phasors(found, times, omega), phasors(true, times, omega), FLOOR * weight, strict=True)
    return [Harmonic(float(abs(a) / abs(b) - 1.0), float(np.angle(a / b))) if abs(b) > least else None for a, b, least in pairs]


def work(loads: Array, motions: Array) -> float:
    """Net work of the liquid on its tank over the work that loads and rates of their sizes could do in phase.

    eta = mean(F_x x' − F_y h' + M alpha') / sum of rms(F) rms(rate), loads about their means. For a steady oscillation that is
    the work of a cycle over the sum of pi F X. loads (n, 3), motions (n, 9)."""
    rates = np.stack([motions[:, 7], -motions[:, 1], motions[:, 4]], axis=1)
    swing = loads - loads.mean(axis=0)
    could = float(np.sum(swing.std(axis=0) * np.sqrt((rates**2).mean(axis=0))))
    return float(np.sum((swing * rates).mean(axis=0))) / could if could > 0.0 else 0.0
