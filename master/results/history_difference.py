"""Two histories beside each other: the same to the bit, or how far apart and since when."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from .history_file import History

DEPARTURE = 1e-9  # of a channel's range: beyond it two marches have parted
SOLVER = ("residual", "subiterations", "passes")  # channels that tell of the way to the solution, not of the solution
AXES = {"time": "times", "tau": "values of tau"}


@dataclass(frozen=True)
class Channel:
    """A channel's largest difference, `largest` in its unit and `relative` to its range (to its value where it does not vary).

    at, first: where on the axis the largest is and where it first exceeds DEPARTURE (nan where it never does). Not-a-number
    on one side alone is an infinite difference.
    """

    name: str
    unit: str
    largest: float
    relative: float
    at: float
    first: float

    @property
    def physics(self) -> bool:
        """Whether it tells of the solution; in a run of any system channels are named <component>.<output>."""
        return self.name.rpartition(".")[2] not in (*SOLVER, *AXES)


@dataclass(frozen=True)
class HistoryDifference:
    """What `difference` found.

    same      all channels the same to the bit, and no others
    how       how samples were paired, "" when sample by sample on the same times; `axis`: "time" [s] or "tau"
    compared  samples compared; `sizes` of the two
    ends      whether they begin and end at the same places of the axis, within a step
    missing   channels that only one of them has
    """

    name: str
    same: bool
    axis: str
    how: str
    compared: int
    sizes: tuple[int, int]
    ends: bool
    channels: list[Channel]
    missing: list[str]

    @property
    def first(self) -> float:
        """Where on the axis the first channel departs; nan where none does."""
        return min((c.first for c in self.channels if not math.isnan(c.first)), default=math.nan)

    @property
    def worst(self) -> Channel | None:
        """The channel of the physics (any one, where there is no other) with the largest relative difference."""
        physics = [c for c in self.channels if c.physics] or self.channels
        return max(physics, key=lambda c: c.relative, default=None)

    def differs(self, tolerance: float) -> bool:
        """Whether a channel differs by more than `tolerance` of its range; 0: by a bit. Solver channels count for bits alone."""
        if tolerance == 0.0:
            return not self.same
        apart = any(c.relative > tolerance for c in self.channels if c.physics)
        return apart or bool(self.missing) or not self.ends or self.compared == 0


def difference(name: str, a: History, b: History) -> HistoryDifference:
    """Compare two histories channel by channel."""
    common = [channel for channel in a.values if channel in b.values]
    missing = sorted(set(a.values) ^ set(b.values))
    same = not missing and all(a.values[c].tobytes() == b.values[c].tobytes() for c in common)
    axis, how, points, pairs = _paired(a, b, common)
    channels = [_channel(c, a.units[c], points, *pair) for c, pair in pairs.items() if points.size]
    return HistoryDifference(name, same, axis, how, points.size, (a.size, b.size), _ends(a, b, axis), channels, missing)


def _ends(a: History, b: History, axis: str) -> bool:
    if axis not in AXES:
        return a.size == b.size
    x, y = a.values[axis], b.values[axis]
    step = max((v[-1] - v[0]) / max(1, v.size - 1) for v in (x, y))
    return bool(abs(x[0] - y[0]) <= step and abs(x[-1] - y[-1]) <= step)


def _paired(a: History, b: History, common: list[str]) -> tuple[str, str, np.ndarray, dict[str, tuple[np.ndarray, np.ndarray]]]:
    """Axis, words, places on the axis (n,), and each channel's samples of both there, (n,) each."""
    axes = [axis for axis in AXES if axis in common]
    n = min(a.size, b.size)
    for axis in axes:
        x, y = a.values[axis], b.values[axis]
        step = (x[n - 1] - x[0]) / (n - 1) if n > 1 else 0.0
        if np.allclose(x[:n], y[:n], rtol=0.0, atol=1e-9 * abs(step)):
            how = [] if axis == "time" else ["at equal tau: the steps differ in seconds"]
            if a.size != b.size:
                how.append(f"over the first {n} samples: A has {a.size}, B {b.size}")
            channels = common if axis == "time" else [c for c in common if c not in AXES]
            return axis, "; ".join(how), x[:n], {c: (a.values[c][:n], b.values[c][:n]) for c in channels}
    if not axes:
        return (
            "sample",
            "by sample: they have no common time",
            np.arange(n),
            {c: (a.values[c][:n], b.values[c][:n]) for c in common},
        )
    # another omega_alpha: cycles correspond, seconds do not
    axis = "tau" if "tau" in axes and a.attributes.get("omega_alpha") != b.attributes.get("omega_alpha") else axes[0]
    x, y = a.values[axis], b.values[axis]
    low, high = max(x[0], y[0]), min(x[-1], y[-1])
    inside = [grid[(grid >= low) & (grid <= high)] for grid in (x, y)]
    # at the samples of the coarser: the finer one's interpolation errs less
    points = min(inside, key=len)
    unit = " s" if axis == "time" else ""
    how_text = f"interpolated linearly at {points.size} common {AXES[axis]} from {low:.4g} to {high:.4g}{unit}: the grids differ"
    if axis == "tau":
        how_text = f"at equal tau, {how_text}"
    pairs = {c: (np.interp(points, x, a.values[c]), np.interp(points, y, b.values[c])) for c in common if c not in AXES}
    return axis, how_text, points, pairs


def _channel(name: str, unit: str, points: np.ndarray, a: np.ndarray, b: np.ndarray) -> Channel:
    with np.errstate(invalid="ignore", over="ignore"):
        apart = np.abs(b - a)
    equal = (a == b) | (np.isnan(a) & np.isnan(b))
    apart = np.where(equal, 0.0, np.where(np.isfinite(apart), apart, np.inf))
    finite = [v[np.isfinite(v)] for v in (a, b)]
    scale = max((float(np.ptp(v)) for v in finite if v.size), default=0.0)
    if scale == 0.0:
        scale = max((float(np.abs(v).max()) for v in finite if v.size), default=0.0)
    worst = int(np.argmax(apart))
    largest = float(apart[worst])
    relative = 0.0 if largest == 0.0 else largest / scale if scale > 0.0 else math.inf
    departed = np.nonzero(apart > DEPARTURE * scale)[0]
    first = float(points[departed[0]]) if departed.size else math.nan
    return Channel(name, unit, largest, relative, float(points[worst]), first)
