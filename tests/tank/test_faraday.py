"""Waves that gravity's changes feed, against Mathieu's equation."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.tank import faraday
from aeroslosh.fmus.tank.liquid import Tank

TANK = Tank(0.5, 0.15)


def test_faraday_waves_grow_as_mathieu_says() -> None:
    """Gravity changed by eps at twice a wave's frequency: the growing one of two solutions, half of the seed, grows by
    eps omega/4 − zeta omega (to first order in eps)."""
    waves = faraday.waves(TANK, 1e-6)
    j, eps, dt = 5, 0.1, 1e-3
    state, largest = faraday.still(), 0.0
    for k in range(8000):
        gammas = [eps * np.cos(2.0 * waves.omega[j] * t) for t in (k * dt, (k + 1) * dt)]
        largest = faraday.grow(state, *gammas, dt, waves)
    expected = 8.0 * waves.omega[j] * (eps / 4.0 - waves.damping[j]) - 0.5 * np.log(2.0)
    assert largest == pytest.approx(expected, rel=0.02)
    quiet = faraday.still()
    for _ in range(1000):
        largest = faraday.grow(quiet, 0.0, 0.0, dt, waves)
    assert largest < 0.5  # a seed is a seed


@pytest.mark.parametrize("over", [0.8, 1.25])
def test_growth_begins_above_four_times_the_damping(over: float) -> None:
    """Exactly at twice a wave's frequency: a change of gravity of 4 zeta is neutral."""
    waves = faraday.waves(TANK, 1e-4)
    j, dt = 3, 2e-3
    state, found = faraday.still(), []
    for k in range(20000):
        gammas = [4.0 * over * waves.damping[j] * np.cos(2.0 * waves.omega[j] * t) for t in (k * dt, (k + 1) * dt)]
        found.append(faraday.grow(state, *gammas, dt, waves))
    assert (found[-1] > found[10000] + 0.1) == (over > 1.0)
