"""Damping over amplitude from envelopes, on motions whose amplitude obeys a known law."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aeroslosh.master.analysis.envelopes import Envelope, curve, cycles, envelope

TAU = np.arange(0.0, 200.0, 0.05)


def motion(start: float, law: object, omega: float = 0.9) -> np.ndarray:
    """An oscillation whose amplitude obeys dA/dtau = A law(A)."""
    size = solve_ivp(lambda t, a: a * law(a), (0.0, TAU[-1]), [start], t_eval=TAU, rtol=1e-9).y[0]  # type: ignore[operator]
    return np.asarray(size * np.cos(omega * TAU + 0.3) + 0.01)


def supercritical(a: float) -> float:
    return 0.02 * (1.0 - (a / 5.0) ** 2)


def subcritical(a: float) -> float:
    """Small motions decay, those above 1 run to a stable cycle at 4."""
    return -0.02 * (1.0 - a**2) * (1.0 - (a / 4.0) ** 2)


def test_rate_is_that_of_the_amplitude() -> None:
    found = envelope(TAU, motion(1.0, lambda a: 0.01), 0.9)
    assert found.rate == pytest.approx(np.full(found.rate.size, 0.01), rel=5e-3)
    assert found.amplitude[0] > 1.0


def test_a_stable_cycle_is_found_from_both_sides() -> None:
    sides = [envelope(TAU, motion(a, supercritical), 0.9) for a in (0.5, 2.0, 12.0)]
    [found] = cycles(sides)
    assert found.stable and found.amplitude == pytest.approx(5.0, abs=2.0 * found.std) and found.std < 0.5


def test_an_unstable_cycle_parts_what_decays_from_what_grows() -> None:
    below, above = (envelope(TAU, motion(a, subcritical), 0.9) for a in (0.9, 1.1))
    found = cycles([below, above, envelope(TAU, motion(4.4, subcritical), 0.9)])
    assert [c.stable for c in found] == [False, True]
    assert found[0].amplitude == pytest.approx(1.0, rel=0.1) and found[1].amplitude == pytest.approx(4.0, rel=0.1)


def test_a_linear_motion_has_none() -> None:
    grown = [envelope(TAU, motion(a, lambda a: -0.004), 0.9) for a in (0.1, 1.0)]
    assert cycles(grown) == []
    amplitude, rate, _ = curve(grown)
    assert np.all(np.diff(amplitude) > 0.0) and np.all(rate < 0.0)


def test_too_short_a_motion_tells_nothing() -> None:
    assert envelope(TAU[:200], motion(1.0, supercritical)[:200], 0.9).amplitude.size == 0
    assert envelope(TAU, motion(1.0, supercritical), 0.0).amplitude.size == 0


def test_one_window_is_as_unsure_as_the_others_of_its_kind() -> None:
    """Rates that scatter by 0.004 do not make a sign sure where a bin happens to hold one of them."""
    scatter = 0.004 * np.random.default_rng(0).standard_normal(60)
    many = Envelope(np.geomspace(1.8, 1.0, 60), scatter - 0.01)
    alone = Envelope(np.array([2.4]), np.array([0.001]))
    _, _, error = curve([many, alone])
    assert error[-1] > 0.002 and cycles([many, alone]) == []
