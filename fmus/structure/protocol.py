"""The flutter protocol of a section: forced pitch cycles, release, free motion under the loads.

    alpha(t) = r(t) A sin(w t),  h = 0          for 0 <= t < cycles 2 pi / w
    r = x^3 (10 - 15 x + 6 x^2), x = t / T_r    quintic start ramp over T_r = min(ramp_cycles, cycles) 2 pi /
    w

The ramp starts with no jump of angle, rate or acceleration, so a flow solver starts smoothly. A release
inside a step splits the step there; the load stays linear over the whole step.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .section import Array, Section

# a release nearer to a communication point than this part of the step falls on it: times are sums of steps
SNAP = 1e-9


@dataclass(frozen=True)
class ForcedPitch:
    """Forced pitch motion; `cycles` = 0 for none."""

    amplitude: float = 0.0  # [rad]
    frequency: float = 100.0  # [rad/s]
    cycles: float = 0.0
    ramp_cycles: float = 1.0

    @property
    def release_time(self) -> float:
        """Time of release after the start [s]."""
        return self.cycles * 2.0 * math.pi / self.frequency if self.cycles > 0.0 else 0.0

    def motion(self, t: float) -> tuple[float, float, float]:
        """Return (alpha [rad], alpha' [rad/s], alpha'' [rad/s2]) at `t` [s] after the start."""
        r, r_dot, r_ddot = self._ramp(t)
        w = self.frequency
        s, c = math.sin(w * t), w * math.cos(w * t)
        return (
            self.amplitude * r * s,
            self.amplitude * (r_dot * s + r * c),
            self.amplitude * (r_ddot * s + 2.0 * r_dot * c - r * w * w * s),
        )

    def _ramp(self, t: float) -> tuple[float, float, float]:
        duration = min(self.ramp_cycles, self.cycles) * 2.0 * math.pi / self.frequency
        if t >= duration:
            return 1.0, 0.0, 0.0
        x = max(t, 0.0) / duration
        return (
            x**3 * (10.0 - 15.0 * x + 6.0 * x * x),
            30.0 * x * x * (1.0 - x) ** 2 / duration,
            60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / duration**2,
        )


class Run:
    """One run of a section. Arrays are replaced, never modified: a state may be kept by reference.

    Attributes:
        t: time since the start [s].
        y: state (h, alpha, h', alpha'). Shape: (4,).
        load: load at `t`, (force down [N/m], moment nose-up [N]). Shape: (2,).
        released: whether the section moves freely from `t` on.
    """

    def __init__(self, section: Section, forced: ForcedPitch, initial: Array, load: Array) -> None:
        self.section = section
        self.forced = forced
        self.t = 0.0
        self.load = load
        self.released = forced.release_time <= 0.0
        self.y = initial if self.released else self._forced_state(0.0)

    @property
    def acceleration(self) -> Array:
        """(h'' [m/s2], alpha'' [rad/s2]) at `t`, consistent with the load there. Shape: (2,)."""
        if self.released:
            return self.section.acceleration(self.y, self.load)
        return np.array([0.0, self.forced.motion(self.t)[2]])

    def advance(self, step_size: float, load_end: Array) -> None:
        """Advance by `step_size` [s] under a load linear from the present one to `load_end`. Shape: (2,)."""
        end = self.t + step_size
        release = self.forced.release_time
        if self.released:
            y = self.section.propagate(self.y, self.load, load_end, step_size)
        elif end < release - SNAP * step_size:
            y = self._forced_state(end)
        else:
            self.released = True
            rest = end - release
            if rest <= SNAP * step_size:
                y = self._forced_state(release)
            else:
                load = self.load + (load_end - self.load) * ((release - self.t) / step_size)
                y = self.section.propagate(self._forced_state(release), load, load_end, rest)
        self.t, self.y, self.load = end, y, load_end

    def _forced_state(self, t: float) -> Array:
        alpha, alpha_dot, _ = self.forced.motion(t)
        return np.array([0.0, alpha, 0.0, alpha_dot])
