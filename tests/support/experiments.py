"""Published tank experiments: their data, a motion from a table, and a march that keeps what a rig would have recorded."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.probes import INTEGRAL
from aeroslosh.fmus.tank.motion import SectionMotion

from .paths import DATA

FOLDER = DATA / "slosh_experiments"
Course = Callable[[float], SectionMotion]


def table(name: str) -> Any:
    """A data file as a structured array; its first line names the source where it starts with #."""
    lines = [line for line in (FOLDER / name).read_text(encoding="utf-8").splitlines() if not line.startswith("#")]
    return np.genfromtxt(lines, delimiter=",", names=True)


class Record(NamedTuple):
    """Times (n,) [s]; of each probe the point pressure and the integral of its face mean [Pa, Pa s] (n, probes); heights of the
    gauges (n, gauges) [m]; forces along and up [N], moment [N m] (n, 3)."""

    t: np.ndarray
    pressure: np.ndarray
    integral: np.ndarray
    height: np.ndarray
    load: np.ndarray

    def mean(self, start: float, duration: float, probe: int = 0) -> float:
        """Mean pressure [Pa] of a probe over [start, start + duration]."""
        ends = np.interp([start, start + duration], self.t, self.integral[:, probe])
        return float(ends[1] - ends[0]) / duration


def record(flow: Flow, motion: Course, duration: float, step: float, gauges: tuple[float, ...] = ()) -> Record:
    """March a started flow and keep what its instruments read after every communication step of `step` [s]."""
    times, place = step * np.arange(1, round(duration / step) + 1), np.array(gauges)
    now, rows = motion(0.0), []
    for t in times:
        end = motion(float(t))
        flow.advance(now, end, step)
        now = end
        readings = flow.pressures()
        rows.append(
            [*(point for point, _, _ in readings), *flow.watch.rings[:, INTEGRAL], *(flow.heights(place) if gauges else ()),
             *flow.loads(now)[:3]]
        )  # fmt: skip
    data, n = np.array(rows), flow.watch.rings.shape[0]
    return Record(times, data[:, :n], data[:, n : 2 * n], data[:, 2 * n : 2 * n + len(gauges)], data[:, -3:])


def roll(stretch: float = 1.0) -> Course:
    """The roll of SPHERIC benchmark 10 (water); stretch: of time, as amplitude and shape are the same for other periods."""
    rows = table("spheric10_water_motion_fmu.csv")
    at = rows["time"] * stretch

    def motion(t: float) -> SectionMotion:
        values = [
            np.interp(t, at, rows[name]) / stretch**power for power, name in enumerate(("alpha", "alpha_dot", "alpha_ddot"))
        ]
        return SectionMotion(alpha=float(values[0]), alpha_dot=float(values[1]), alpha_ddot=float(values[2]))

    return motion


def arrivals(t: np.ndarray, p: np.ndarray, threshold: float, apart: float = 1.0) -> list[float]:
    """Times [s] at which p first rises through the threshold, each at least `apart` [s] after the one before."""
    found: list[float] = []
    for k in np.flatnonzero((p[1:] >= threshold) & (p[:-1] < threshold)):
        if not found or t[k + 1] - found[-1] > apart:
            found.append(float(t[k + 1]))
    return found


def vertical_decay(
    flow: Flow, frequency: float, ratio: float, g_start: float, cycles: float, step: float
) -> tuple[np.ndarray, np.ndarray]:
    """A tank on a vertical spring, let go from where the spring pulls it up with g_start times gravity (beside its weight).

    frequency [Hz] of structure and frozen liquid, ratio of the liquid's mass to the structure's; the structure has no damping.
    Returns times and displacement, positive down [m], shape (n,). The structure carries the frozen liquid and takes the residual
    load, extrapolated linearly (artificial damping ratio of this scheme: below 1e-5 for a liquid that does not move).
    """
    tank = flow.grid.tank
    omega, mass = 2.0 * np.pi * frequency, tank.mass / ratio + tank.mass
    gas = -flow.fluids.gas_density * tank.length * (tank.height - tank.depth) * tank.width * tank.gravity
    h, rate, acceleration = g_start * tank.gravity / omega**2, 0.0, -g_start * tank.gravity
    now = SectionMotion(h=h, h_dot=rate, h_ddot=acceleration)
    flow.start(now)

    def residual(motion: SectionMotion) -> float:
        return float(flow.loads(motion).force_y) - gas + tank.mass * (tank.gravity - motion.h_ddot)

    old = new = residual(now)
    rows = [h]
    count = round(cycles / frequency / step)
    for _ in range(count):
        guess = 2.0 * new - old
        # trapezium rule: h'' = −ω² h − residual/mass at the end of the step
        ahead = h + step * rate + 0.25 * step**2 * acceleration
        end = (-(omega**2) * ahead - guess / mass) / (1.0 + 0.25 * step**2 * omega**2)
        h = ahead + 0.25 * step**2 * end
        rate += 0.5 * step * (acceleration + end)
        acceleration = end
        last, now = now, SectionMotion(h=h, h_dot=rate, h_ddot=acceleration)
        flow.advance(last, now, step)
        old, new = new, residual(now)
        rows.append(h)
    return step * np.arange(count + 1), np.array(rows)
