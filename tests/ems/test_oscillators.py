"""Oscillators under polynomial forces: against a Runge-Kutta method, for short and long steps, and over many of them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aeroslosh.fmus.tank.oscillators import LARGEST_DAMPING, Oscillators, phi

FORCE = np.array([1.0, -2.0, 3.0, 0.5, -4.0, 7.0])


@pytest.mark.parametrize("duration", [1e-5, 1e-3, 0.3, 2.0])
@pytest.mark.parametrize(("omega", "damping"), [(5.2, 0.0), (5.2, 0.01), (110.0, 5e-4), (3.0, LARGEST_DAMPING)])
def test_step_is_exact(omega: float, damping: float, duration: float) -> None:
    bank = Oscillators(np.array([omega]), np.array([damping]))
    w = bank.advance(bank.amplitude(np.array([0.3]), np.array([-0.2])), FORCE[:, None], duration)

    def rate(t: float, y: np.ndarray) -> list[float]:
        return [y[1], np.polyval(FORCE[::-1], t / duration) - 2 * damping * omega * y[1] - omega**2 * y[0]]

    s, v = solve_ivp(rate, (0.0, duration), [0.3, -0.2], method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    scale = 0.3 * math.exp(-damping * omega * duration) + 7.0 / omega**2
    assert bank.displacement(w)[0] == pytest.approx(s, abs=2e-12 * scale)
    assert bank.velocity(w)[0] == pytest.approx(v, abs=2e-12 * omega * scale)


def test_phi_joins_where_series_and_recursion_meet_and_holds_far_out() -> None:
    z = np.array([1.9999j, 2.0001j, -1.2 + 1.6j * 1.0001, 1e-9 + 0j, -40.0 + 300.0j])
    nodes, weights = np.polynomial.legendre.leggauss(400)
    t = 0.5 * (nodes + 1.0)
    for k, values in enumerate(phi(z, 6), start=1):
        # phi_k(z) = integral of exp((1 − t) z) t^(k−1) / (k−1)!
        exact = np.exp((1.0 - t) * z[:, None]) @ (0.5 * weights * t ** (k - 1)) / math.factorial(k - 1)
        np.testing.assert_allclose(values, exact, rtol=0.0, atol=5e-14)


def test_energy_stays_over_a_hundred_thousand_steps() -> None:
    omega = np.array([5.2, 12.8, 110.7])
    bank = Oscillators(omega, np.zeros(3))
    w = start = bank.amplitude(np.array([1.0, 0.1, 0.01]), np.array([0.0, 1.0, 2.0]))
    still = np.zeros((6, 1))
    for i in range(100_000):
        w = bank.advance(w, still, 1e-3 * (1 + i % 3))
    energy, first = (0.5 * bank.velocity(x) ** 2 + 0.5 * (omega * bank.displacement(x)) ** 2 for x in (w, start))
    np.testing.assert_allclose(energy, first, rtol=1e-11)


@pytest.mark.parametrize(("omega", "damping"), [(0.0, 0.1), (5.0, -0.1), (5.0, 1.0), (math.nan, 0.1)])
def test_impossible_oscillators_are_refused(omega: float, damping: float) -> None:
    with pytest.raises(ValueError, match="damping ratio"):
        Oscillators(np.array([omega]), np.array([damping]))
