"""Pressure at points of the tank, its mean over a sensor's face and over a trailing time.

Pressure at a point is interpolated between the cells about it, each continued to the point by its own body force, so that liquid
at rest is exact at any tilt; cells of the other fluid or beyond a baffle do not take part, and a cell that the interface crosses
counts from the interface on, as in `loads`. It is what lies above the mean pressure of the gas (of a tank without gas: above that
in the middle of the roof): what a sensor reads in a vented tank. Sampled after every internal step: the mean over a trailing
window is the difference of a running integral, kept at BINS equal parts of the window.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.cache import argument
from ..kit.compiled import inline, jit
from .grid import Grid

Array = NDArray[np.float64]
BINS = 64
POINT, AREA, INTEGRAL, TIME, KEPT = range(5)
"""Columns of `Watch.rings`: the last point value and area mean [Pa], integral of the area mean [Pa s], its time [s], and from
KEPT on the integral at the last multiples of a bin."""
MOST_POINTS = 256


@dataclass(frozen=True)
class Probe:
    """A sensor at (x, y) [m] from the west wall and the floor; its face is `extent` [m] long, along the nearest wall."""

    x: float
    y: float
    extent: float = 0.0


@argument
class Watch(NamedTuple):
    """What the march looks at: points (n, 4) of probe, places in the cell (0 to 1 each way) and weight in the area mean, their
    cells (n,), rings (probes, KEPT + BINS + 2), the window [s]."""

    points: Any
    cells: Any
    rings: Any
    window: float


def watch(grid: Grid, probes: tuple[Probe, ...] = (), window: float = 0.0) -> Watch:
    """Set up `probes`, the first point of each its middle; no probe costs nothing.

    Raises ValueError for a probe outside the tank, a negative extent or a negative window.
    """
    if window < 0.0:
        raise ValueError(f"a window of {window:g} s. Remedy: 0 or more")
    rows: list[tuple[float, ...]] = []
    cells: list[int] = []
    for number, probe in enumerate(probes):
        length, height = grid.tank.length, grid.tank.height
        if not (0.0 <= probe.x <= length and 0.0 <= probe.y <= height) or probe.extent < 0.0:
            raise ValueError(
                f"a probe at ({probe.x:g}, {probe.y:g}) m of extent {probe.extent:g} m in a tank of {length:g} x {height:g} m. "
                "Remedy: x from the west (fore) wall, y from the floor, both inside the tank; an extent of 0 or more"
            )
        upright = min(probe.x, length - probe.x) <= min(probe.y, height - probe.y)
        along = grid.dy if upright else grid.dx
        count = min(max(int(np.ceil(2.0 * probe.extent / along)), 4), MOST_POINTS) if probe.extent > 0.0 else 0
        shifts = np.concatenate([[0.0], probe.extent * ((np.arange(count) + 0.5) / count - 0.5) if count else np.zeros(0)])
        for m, shift in enumerate(shifts):
            x = min(max(probe.x + (0.0 if upright else shift), 0.0), length) / grid.dx
            y = min(max(probe.y + (shift if upright else 0.0), 0.0), height) / grid.dy
            i, j = min(int(x), grid.nx - 1), min(int(y), grid.ny - 1)
            weight = (0.0 if m == 0 else 1.0 / count) if count else 1.0
            rows.append((number, x - i, y - j, weight))
            cells.append((j + 2) * grid.stride + i + 1)
    return Watch(np.array(rows, dtype=float).reshape(-1, 4), np.array(cells, dtype=np.int64),
                 np.zeros((len(probes), KEPT + BINS + 2)), window)  # fmt: skip


@inline
def _told(
    state: Any, surface: Any, rho: Any, frame: Any, x: Any, y: Any, p: Any, k: int, fx: float, fy: float, wet: bool
) -> float:
    """Pressure [Pa] that cell k tells of the point (fx, fy) in its own units, 0 to 1 inside; wet: whether the point is."""
    ax, ay = (fx - 0.5) * p.dx, (fy - 0.5) * p.dy
    mx, my = x[k] + 0.5 * ax, y[k] + 0.5 * ay
    spin, swirl, rate, s = frame[2], frame[3], frame[4], p.nx + 2
    across = frame[0] - spin * my + swirl * mx - rate * (state[2][k] + state[2][k - s])
    g = -(frame[1] + spin * mx + swirl * my + rate * (state[1][k] + state[1][k - 1]))
    value = p.liquid_density * state[5][k]
    m = surface.at[k] - 1
    if m >= 0:
        n_x, n_y, d = surface.lines[m, 0], surface.lines[m, 1], surface.lines[m, 2]
        if abs(n_y) >= abs(n_x):
            rise, centre = (d - n_x * fx) / n_y, (d - 0.5 * n_x) / n_y
            at_interface = (
                value - rho[k] * g * (centre - 0.5) * p.dy + p.liquid_density * (across * ax + g * (centre - rise) * p.dy)
            )
            return at_interface + (p.liquid_density if wet else p.gas_density) * g * (rise - fy) * p.dy
    return value + rho[k] * (across * ax - g * ay)


@inline
def _point(state: Any, surface: Any, rho: Any, frame: Any, x: Any, y: Any, open_x: Any, open_y: Any, p: Any, k: int, fx: float,
           fy: float) -> float:  # fmt: skip
    """Pressure [Pa] at a point of cell k, before the datum is taken off."""
    s = p.nx + 2
    m = surface.at[k] - 1
    wet = state[0][k] > 0.5
    if m >= 0:
        wet = surface.lines[m, 0] * fx + surface.lines[m, 1] * fy < surface.lines[m, 2]
    side, up = (1 if fx > 0.5 else -1), (1 if fy > 0.5 else -1)
    wx, wy = abs(fx - 0.5), abs(fy - 0.5)
    total, weights = 0.0, 0.0
    for far in range(4):
        i, j = far % 2, far // 2
        weight = (wx if i else 1.0 - wx) * (wy if j else 1.0 - wy)
        other = k
        if j:
            if open_y[k if up > 0 else k - s] == 0.0:
                continue
            other += up * s
        if i:
            if open_x[other if side > 0 else other - 1] == 0.0:
                continue
            other += side
        if far and (surface.at[other] > 0 or (state[0][other] > 0.5) != wet):
            continue
        total += weight * _told(state, surface, rho, frame, x, y, p, other, fx - i * side, fy - j * up, wet)
        weights += weight
    return total / weights


@jit
def _datum(state: Any, p: Any) -> float:
    """Mean pressure [Pa] of the gas; of the cells in the middle of the roof where there is none."""
    c, q, s = state[0], state[5], p.nx + 2
    gas, total = 0.0, 0.0
    for k in range(2 * s, (p.ny + 2) * s):
        i = k % s
        if i == 0 or i > p.nx:
            continue
        share = 1.0 - min(max(c[k], 0.0), 1.0)
        gas += share
        total += share * q[k]
    if gas > 1e-3 * p.nx * p.ny:
        return p.liquid_density * total / gas
    k = (p.ny + 1) * s + (p.nx + 1) // 2
    return p.liquid_density * 0.5 * (q[k] + q[k + 1 - p.nx % 2])


@jit
def sample(watch: Any, state: Any, surface: Any, rho: Any, frame: Any, x: Any, y: Any, open_x: Any, open_y: Any, p: Any,
           dt: float) -> None:  # fmt: skip
    """Take the pressures at the present time, dt [s] after the last time (0: the first), into the rings."""
    rings, last = watch.rings, -1
    datum = _datum(state, p)
    before = np.zeros(rings.shape[0])
    for n in range(watch.points.shape[0]):
        probe = int(watch.points[n, 0])
        pressure = _point(state, surface, rho, frame, x, y, open_x, open_y, p, watch.cells[n], watch.points[n, 1],
                          watch.points[n, 2]) - datum  # fmt: skip
        if probe != last:
            rings[probe, POINT] = pressure
            before[probe] = rings[probe, AREA]
            rings[probe, AREA] = 0.0
            last = probe
        rings[probe, AREA] += watch.points[n, 3] * pressure
    bin_ = watch.window / BINS
    for probe in range(rings.shape[0]):
        start, end = rings[probe, TIME], rings[probe, TIME] + dt
        slope = (rings[probe, AREA] - before[probe]) / dt if dt > 0.0 else 0.0
        if bin_ > 0.0:
            m = max(int(start / bin_), int(end / bin_) - BINS - 1) + 1
            while m * bin_ <= end:
                t = m * bin_ - start
                rings[probe, KEPT + m % (BINS + 2)] = rings[probe, INTEGRAL] + t * (before[probe] + 0.5 * slope * t)
                m += 1
        rings[probe, INTEGRAL] += dt * (before[probe] + 0.5 * slope * dt)
        rings[probe, TIME] = end


def time_mean(watch: Watch, probe: int) -> float:
    """Mean of the area mean [Pa] over the trailing window, or since the start where that is shorter."""
    row = watch.rings[probe]
    now, window = float(row[TIME]), watch.window
    if window <= 0.0 or now <= 0.0:
        return float(row[AREA])
    if now <= window:
        return float(row[INTEGRAL]) / now
    place = (now - window) * BINS / window
    m = int(place)
    old, new = row[KEPT + m % (BINS + 2)], row[KEPT + (m + 1) % (BINS + 2)]
    return float(row[INTEGRAL] - (old + (place - m) * (new - old))) / window
