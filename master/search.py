"""Neutral V_f from few marches: the growth rate σ(V_f) as a function known at a handful of points with uncertainty.

`crossings` reads every sign change of σ out of the marches done so far, with direction and error bar;
`propose` says where the next march pays most, or that the search may end. Neither runs anything, so a
scan that wants several crossings (restabilisation) can use both with its own list.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

FIRST_SLOPE = 0.05  # dσ/dln V_f of Isogai's section near its boundary: only sizes the first step
FARTHEST = 1.4  # a march goes at most this factor beyond those done
OVERSHOOT = 1.15  # an extrapolated root is overshot a little, so that it becomes bracketed


@dataclass(frozen=True)
class Sample:
    """One march: growth rate σ/ω_α ± std at V_f, frequency ω/ω_α; `growth_rate` nan when the march gave none."""

    V_f: float
    growth_rate: float
    std: float
    frequency: float

    @property
    def known(self) -> bool:
        """True when it has a growth rate."""
        return math.isfinite(self.growth_rate)


@dataclass(frozen=True)
class Crossing:
    """A neutral V_f. `direction`: "onset" (grows above it) or "recovery" (decays above it)."""

    V_f: float
    uncertainty: float  # one standard deviation: damping fit and interpolation
    frequency: float
    direction: str
    slope: float  # dσ/dV_f
    bracketed: bool  # marches on both sides; otherwise extrapolated from the nearest ones
    interpolation_error: float  # the part of the uncertainty due to curvature
    parts: dict[str, float] = field(default_factory=dict)  # further parts, signed changes of V_f: step, amplitude
    source: str = "march"  # or "linear"


def crossings(samples: Sequence[Sample], tolerance: float) -> list[Crossing]:
    """All neutral V_f that `samples` show, in rising V_f.

    Sign changes between neighbours; and, when there is none, an extrapolated root within `tolerance`
    (relative) of a march, which is all one can ask of marches that come out neutral.
    """
    known = _known(samples)
    grows = [s.growth_rate >= 0.0 for s in known]
    found = [_root(known, i, i + 1, True) for i in range(len(known) - 1) if grows[i] != grows[i + 1]]
    if not found and len(known) >= 2:
        i = int(np.argmin([abs(s.growth_rate) for s in known]))
        j = min((k for k in (i - 1, i + 1) if 0 <= k < len(known)), key=lambda k: abs(known[k].growth_rate))
        if known[i].growth_rate != known[j].growth_rate:
            root = _root(known, min(i, j), max(i, j), False)
            if abs(root.V_f - known[i].V_f) <= tolerance * known[i].V_f:
                found.append(root)
    return found


def good_enough(crossing: Crossing, samples: Sequence[Sample], tolerance: float) -> bool:
    """True when the root's interpolation error is within a third of `tolerance` and it was looked at from near."""
    known = _known(samples)
    near = min(abs(s.V_f - crossing.V_f) for s in known)
    return (
        len(known) >= 3
        and crossing.interpolation_error <= tolerance * crossing.V_f / 3.0
        and (near <= 4.0 * tolerance * crossing.V_f)
    )


def propose(
    samples: Sequence[Sample],
    guess: float,
    low: float,
    high: float,
    tolerance: float,
    slope: float = FIRST_SLOPE,
) -> float | None:
    """The next V_f to march at; None when the nearest crossing is good enough or the range holds none.

    First the guess; then a Newton step with the expected `slope` (dσ/dln V_f); then secant and inverse
    interpolation, inside the bracket once there is one. A failed march (no growth rate) halves the way
    back to a good one.
    """
    known = _known(samples)
    failed = [s.V_f for s in samples if not s.known]
    if not known:
        tries = [guess, 0.85 * guess, 1.15 * guess]
        return float(np.clip(tries[len(failed)], low, high)) if len(failed) < len(tries) else None
    roots = crossings(samples, tolerance)
    bracketed = [r for r in roots if r.bracketed]
    for root in roots:
        if good_enough(root, samples, tolerance):
            return None
    if bracketed:
        target = _inside(min(bracketed, key=lambda r: abs(r.V_f - guess)), known, failed, tolerance)
    else:
        target = _outside(known, failed, low, high, tolerance, slope)
    if target is None or any(abs(target - s.V_f) < 1e-9 * target for s in samples):
        return None  # the same march again would tell nothing new
    return target


def _inside(root: Crossing, known: list[Sample], failed: list[float], tolerance: float) -> float | None:
    """A march in the bracket: at the root, but not on top of a march already done."""
    below = max(s.V_f for s in known if s.V_f <= root.V_f)
    above = min(s.V_f for s in known if s.V_f >= root.V_f)
    width = above - below
    if width <= 2.0 * tolerance * root.V_f and len(known) >= 3:
        return None
    margin = min(0.1 * width, 0.5 * tolerance * root.V_f)
    target = float(np.clip(root.V_f, below + margin, above - margin))
    if any(below < f < above for f in failed):
        return None  # the component fails inside the bracket: the root stays as wide as the bracket
    return target


def _outside(known: list[Sample], failed: list[float], low: float, high: float, tolerance: float, slope: float) -> float | None:
    """A march beyond those done: towards the sign change that the trend promises."""
    first, last = known[0], known[-1]
    ceiling = min([high] + [f for f in failed if f > last.V_f])
    floor = max([low] + [f for f in failed if f < first.V_f])
    trend = (last.growth_rate - first.growth_rate) / math.log(last.V_f / first.V_f) if len(known) > 1 else slope
    if len(known) > 1:  # the trend near the smallest |σ| counts
        i = int(np.argmin([abs(s.growth_rate) for s in known]))
        j = i - 1 if i > 0 and (i + 1 == len(known)) else i + 1
        j = j if i not in (0, len(known) - 1) else (1 if i == 0 else i - 1)
        trend = (known[i].growth_rate - known[j].growth_rate) / math.log(known[i].V_f / known[j].V_f)
    sign = math.copysign(1.0, last.growth_rate)
    upward = sign * trend < 0.0
    end, limit = (last, ceiling) if upward else (first, floor)
    if _used_up(end.V_f, limit, limit in failed, tolerance):
        upward = not upward
        end, limit = (last, ceiling) if upward else (first, floor)
        if _used_up(end.V_f, limit, limit in failed, tolerance):
            return None
    step = abs(end.growth_rate / trend) * OVERSHOOT if trend else math.log(FARTHEST)
    if (sign * trend < 0.0) != upward:
        step = math.log(FARTHEST)  # against the trend: explore
    step = float(np.clip(step, 2.0 * tolerance, math.log(FARTHEST)))
    target = end.V_f * math.exp(step if upward else -step)
    if limit in failed:
        middle = 0.5 * (end.V_f + limit)
        return min(target, middle) if upward else max(target, middle)
    return min(target, limit) if upward else max(target, limit)


def _used_up(end: float, limit: float, failing: bool, tolerance: float) -> bool:
    """True when there is nothing between the last march and the limit worth a march."""
    return abs(limit - end) <= (4.0 if failing else 0.5) * tolerance * end


def _known(samples: Sequence[Sample]) -> list[Sample]:
    """Samples with a growth rate in rising V_f; of several at one V_f the last."""
    return sorted({s.V_f: s for s in samples if s.known}.values(), key=lambda s: s.V_f)


def _root(known: list[Sample], i: int, j: int, bracketed: bool) -> Crossing:
    """Root of σ near samples i, j: by the parabola, or by the weighted line, through them and a third neighbour.

    Each has its curvature error and its noise; the one with the least of both together is taken: the parabola for
    clean marches, the line for noisy ones. Two samples alone give a line of unknown curvature error."""
    a, b = known[i], known[j]
    chord = a.V_f - a.growth_rate * (b.V_f - a.V_f) / (b.growth_rate - a.growth_rate)
    third = [known[k] for k in (i - 1, j + 1) if 0 <= k < len(known)]
    if not third:
        # a tenth of the way from the nearest march
        curvature = 0.1 * min(abs(chord - a.V_f), abs(chord - b.V_f))
        root, noise, slope = _estimate([a, b], chord, 1)
    else:
        three = [a, b, min(third, key=lambda s: abs(s.V_f - chord))]
        line = _estimate(three, chord, 1)
        # two near marches may fake a steep slope by their noise: the line's counts when it is the smaller
        curve = _estimate(three, chord, 2, abs(line[2]))
        # what a cubic term could do is guessed from the distance to the nearest march
        near = min(abs(curve[0] - s.V_f) for s in three)
        errors = max(0.05 * near, 0.5 * abs(chord - curve[0])), max(0.05 * near, abs(line[0] - curve[0]))
        take_curve = math.hypot(curve[1], errors[0]) <= math.hypot(line[1], errors[1])
        (root, noise, slope), curvature = (curve, errors[0]) if take_curve else (line, errors[1])
        if bracketed:  # beyond the neighbouring march neither is better than the march's sign
            root = float(np.clip(root, a.V_f, b.V_f))
    weight = (root - a.V_f) / (b.V_f - a.V_f)
    return Crossing(
        root,
        math.hypot(noise, curvature),
        a.frequency + weight * (b.frequency - a.frequency),
        "onset" if b.growth_rate > a.growth_rate else "recovery",
        slope,
        bracketed,
        curvature,
    )


def _estimate(samples: list[Sample], near: float, degree: int, steepest: float = math.inf) -> tuple[float, float, float]:
    """Root nearest to `near` of the weighted polynomial σ(V_f), its noise (one std) and the slope there.

    To first order the root moves by δσ/slope, δσ being the polynomial's value there with the samples' noise;
    for the noise |slope| is taken as `steepest` at most.
    """
    x = np.array([s.V_f for s in samples]) - near
    size = float(np.max(np.abs(x)))
    powers = np.vander(x / size, degree + 1)
    std = np.array([max(s.std, 1e-12) for s in samples])
    inverse = np.linalg.pinv(powers / std[:, None]) / std  # from growth rates to coefficients
    c = inverse @ np.array([s.growth_rate for s in samples])
    roots = np.roots(c)
    real = roots[np.abs(roots.imag) < 1e-12].real
    root = float(real[np.argmin(np.abs(real))]) if real.size else 0.0
    slope = float(np.polyval(np.polyder(c), root)) / size
    value_noise = float(np.linalg.norm(np.vander([root], degree + 1) @ inverse * std))
    noise = value_noise / min(abs(slope), steepest) if slope else math.inf
    return near + size * root, noise, slope
