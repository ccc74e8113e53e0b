"""Times that a host gives: what an experiment and a step may be."""

from __future__ import annotations

import math

from .failure import StepError

ROUNDING = 1e-9
"""Difference over the step size up to which two times or step sizes are the same but for rounding."""
SHORTEST = 1e-100
"""Shortest step [s]: its square and cube still have all their digits."""


def check_experiment(start_time: float, stop_time: float | None) -> None:
    """Raise StepError for times [s] of fmi2SetupExperiment that are none; no stop time is None."""
    if not math.isfinite(start_time):
        raise StepError(f"start time {start_time} is not finite. Remedy: give a finite start time")
    if stop_time is not None and not stop_time >= start_time:
        raise StepError(
            f"stop time {stop_time} s is not after the start time {start_time} s. Remedy: give a later one, or none at all"
        )


def step(time: float, last: float, stop_time: float, current_time: float, step_size: float) -> tuple[float, float, float]:
    """Return start, size and end [s] of a step of `step_size` [s] that a host asks for from `current_time`.

    Hosts take steps as differences of times, whose last bits vary, and a breaking wave is another one after a change of the last
    bit. So where they differ by rounding alone from what the instance counts itself, its own time and last step hold. A
    difference that adds up is no longer rounding: then the host's hold.

    Args:
        time: where the instance stands [s].
        last: its step before [s], 0 if there was none.
        stop_time: of its experiment [s], infinite if none was set up.
        current_time: where the host says that it stands [s].
        step_size: what the host asks for [s].

    Raises:
        StepError: the step starts elsewhere, is too short or not finite, cannot be resolved, or goes past the stop time.
    """
    if abs(step_size - last) <= ROUNDING * last and abs(current_time - time) <= ROUNDING * last:
        end = time + last
        if time < end <= stop_time and end < math.inf:
            return time, last, end  # one more step like the last
    if not SHORTEST <= step_size < math.inf:
        raise StepError(f"step size {step_size} s. Remedy: give a finite step size of at least {SHORTEST} s")
    # the clock of a host may differ by rounding; written so that NaN does not pass
    rounding = 1e-6 * step_size + 1e-15 * abs(time)
    if not abs(current_time - time) <= rounding:
        raise StepError(
            f"step asked from t = {current_time!r} s but this instance stands at {time!r} s. "
            "Remedy: restore the state of that time first"
        )
    limit = ROUNDING * step_size
    start = time if abs(current_time - time) <= limit else current_time
    step_size = last if abs(step_size - last) <= limit else step_size
    end = start + step_size
    if not start < end < math.inf:
        raise StepError(
            f"a step of {step_size!r} s from t = {start!r} s ends at {end!r} s in floating-point numbers. "
            "Remedy: give a step size that the time can resolve, or start at time 0"
        )
    if end > stop_time + rounding:
        raise StepError(
            f"a step from t = {start!r} s to {end!r} s goes past the stop time {stop_time!r} s that was "
            "set up. Remedy: end the last step there, or set up a later stop time or none"
        )
    return start, step_size, end
