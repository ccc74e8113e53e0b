"""Forced pitch, release and free motion."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.structure.protocol import ForcedPitch, Run
from aeroslosh.fmus.structure.section import Array, Section, SectionData

FORCED = ForcedPitch(amplitude=0.02, frequency=100.0, cycles=2.0, ramp_cycles=1.0)
PERIOD = 2.0 * math.pi / 100.0
NOTHING = np.zeros(4)


def load(t: float) -> Array:
    """Load linear in time, so that its interpolation makes no error."""
    return np.array([800.0 - 9.0e3 * t, 2.0e3 * t])


def march(step_size: float, end: float, forced: ForcedPitch = FORCED) -> Run:
    """March to `end` in equal steps and one rest."""
    run = Run(Section(SectionData()), forced, NOTHING, load(0.0))
    steps = round(end / step_size - 0.5 + 1e-6)
    for i in range(steps):
        run.advance(step_size, load((i + 1) * step_size))
    if end - steps * step_size > 1e-12:
        run.advance(end - steps * step_size, load(end))
    return run


@pytest.mark.parametrize("cycles", [0.25, 1.0, 2.5])
@pytest.mark.parametrize("ramp", [0.0, 0.5, 1.0, 7.0])
def test_forced_rates_are_derivatives_of_the_angle(cycles: float, ramp: float) -> None:
    forced, d = ForcedPitch(0.02, 100.0, cycles, ramp), 1e-5
    for t in np.linspace(0.02, 0.98, 25) * forced.release_time:
        before, (alpha, rate, acceleration), after = (forced.motion(t + k * d) for k in (-1, 0, 1))
        assert rate == pytest.approx((after[0] - before[0]) / (2 * d), abs=1e-4)
        assert acceleration == pytest.approx((after[0] - 2 * alpha + before[0]) / d**2, abs=2e-2)


def test_the_ramp_starts_and_ends_smoothly() -> None:
    assert FORCED.motion(0.0) == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(FORCED.motion(PERIOD * (1 - 1e-7)), FORCED.motion(PERIOD * (1 + 1e-7)), atol=1e-3)
    alpha, rate, acceleration = FORCED.motion(1.25 * PERIOD)
    np.testing.assert_allclose([alpha, rate, acceleration], [0.02, 0.0, -200.0], atol=1e-12)


def test_plunge_is_held_and_pitch_is_prescribed_until_release() -> None:
    run = march(PERIOD / 72, 1.5 * PERIOD)
    assert not run.released
    np.testing.assert_allclose(run.y, [0.0, 0.0, 0.0, -2.0], atol=1e-12)
    np.testing.assert_allclose(run.acceleration, [0.0, 0.0], atol=1e-9)


@pytest.mark.parametrize("divisions", [72, 71.3, 10, 3.7, 0.4], ids=["on a step", "off", "off", "off", "one step"])
def test_release_is_exact_on_and_off_the_steps(divisions: float) -> None:
    """After release the motion is the exact free motion from the forced end, whatever the steps."""
    end = 2.6 * PERIOD
    run = march(PERIOD / divisions, end)
    start = np.array([0.0, 0.0, 0.0, 2.0])  # alpha' = A w at a whole number of cycles
    exact = Section(SectionData()).propagate(start, load(2.0 * PERIOD), load(end), end - 2.0 * PERIOD)
    assert run.released
    np.testing.assert_allclose(run.y, exact, rtol=0.0, atol=1e-10)


def test_released_is_told_at_the_release_and_the_acceleration_is_free_there() -> None:
    run = march(PERIOD / 72, 2.0 * PERIOD)
    assert run.released
    np.testing.assert_allclose(run.acceleration, run.section.acceleration(run.y, load(2.0 * PERIOD)), rtol=1e-9)
    assert not march(PERIOD / 72, 143 / 72 * PERIOD).released


def test_release_at_the_peak_angle() -> None:
    forced = ForcedPitch(0.02, 100.0, 1.25, 0.0)
    run = march(PERIOD / 72, 1.25 * PERIOD, forced)
    np.testing.assert_allclose(run.y, [0.0, 0.02, 0.0, 0.0], atol=1e-12)


def test_no_cycles_is_a_free_start() -> None:
    start = np.array([0.1, 0.2, 0.3, 0.4])
    run = Run(Section(SectionData()), ForcedPitch(cycles=0.0), start, np.zeros(2))
    assert run.released
    assert run.y is start
