"""A host's clock: what is the same but for rounding, what is refused."""

from __future__ import annotations

import math

import pytest

from aeroslosh.fmus.kit import clock
from aeroslosh.fmus.kit.failure import StepError


def test_steps_that_differ_by_rounding_are_the_instances_own() -> None:
    """Differences of times, as libcosim takes them, and multiples, as FMPy does: every step has the bits of the first."""
    time, last, step_size = 0.0, 0.0, 1.455168e-3
    for k in range(100_000):
        host = k * step_size
        start, size, time = clock.step(time, last, math.inf, host, (k + 1) * step_size - host)
        assert k == 0 or size == last
        last = size
        assert abs(start - host) < 1e-9 * step_size
    assert last == step_size


def test_a_difference_that_adds_up_is_the_hosts() -> None:
    assert clock.step(1.0, 0.1, math.inf, 1.0 + 2e-10, 0.1) == (1.0 + 2e-10, 0.1, 1.0 + 2e-10 + 0.1)
    assert clock.step(1.0, 0.1, math.inf, 1.0, 0.1 + 2e-10)[1] == 0.1 + 2e-10


@pytest.mark.parametrize("step_size", [0.0, -0.1, math.nan, math.inf, 1e-101])
def test_sizes_that_are_none(step_size: float) -> None:
    with pytest.raises(StepError, match="Remedy"):
        clock.step(0.0, 0.1, math.inf, 0.0, step_size)


@pytest.mark.parametrize(
    ("current_time", "stop_time"), [(math.nan, math.inf), (0.05, math.inf), (math.inf, math.inf), (0.0, 0.09)]
)
def test_times_that_are_none(current_time: float, stop_time: float) -> None:
    with pytest.raises(StepError, match="Remedy"):
        clock.step(0.0, 0.1, stop_time, current_time, 0.1)


def test_a_step_that_the_time_cannot_resolve() -> None:
    with pytest.raises(StepError, match="floating-point"):
        clock.step(1e12, 1e-9, math.inf, 1e12, 1e-9)
