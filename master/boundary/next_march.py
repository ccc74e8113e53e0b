"""Neutral V_f from few marches: the growth rate σ(V_f) as a function known at a handful of points with uncertainty.

`crossings` reads every sign change of σ out of the marches done so far, with direction and error bar;
`propose` says where the next march pays most, or that the search may end. Neither runs anything, so a
scan that wants several crossings (restabilisation) can use both with its own list. Module `roots` interpolates.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..analysis.crossings import SURE, Crossing, Sample, hyperbola, newton, root

SLOPE = 0.07  # dσ/dV_f at a boundary, and dg/dx on the way: 0.04 to 0.1 for Isogai's section. Sizes steps without a prior
WIDE = 0.06  # ln V_f: marches apart by less may differ by noise alone
FARTHEST = 2.5  # a march goes at most this factor beyond those done
OVERSHOOT = 1.1  # an extrapolated root is overshot a little, so that it becomes bracketed
NEAR = 4.0  # a root is looked at from no further than this many tolerances
INTERPOLATION = 0.25  # of the tolerance may be interpolation error
BEYOND = 0.5  # of its interpolation error a march in a bracket goes beyond the root, towards the bracket's farther end


def crossings(samples: Sequence[Sample], tolerance: float, slope: float | None = None, fewest: int = 2) -> list[Crossing]:
    """All neutral V_f that `samples` show, in rising V_f. `slope`: dσ/dV_f there, when it is known beforehand.

    Sign changes between neighbours; and, when there is none, an extrapolated root within `tolerance`
    (relative) of a march, which is all one can ask of marches that come out neutral. `fewest` marches are needed where the slope
    is known; of a single one the root is a Newton step away.
    """
    known = _known(samples)
    if fewest == 1 and len(known) == 1 and slope is not None:
        near = newton(known[0], slope)
        return [replace(near, met=True)] if near is not None and _met(near, known, tolerance, fewest) else []
    grows = [s.growth_rate >= 0.0 for s in known]
    pairs = [(i, i + 1) for i in range(len(known) - 1) if grows[i] != grows[i + 1]]
    found = [c for i, j in pairs if (c := root(known, i, j, True, slope)) is not None]
    if not pairs and len(known) >= 2:
        i = int(np.argmin([abs(s.g) for s in known]))
        j = min((k for k in (i - 1, i + 1) if 0 <= k < len(known)), key=lambda k: abs(known[k].g))
        outside = root(known, min(i, j), max(i, j), False, slope)
        if outside is not None and abs(outside.V_f - known[i].V_f) <= tolerance * known[i].V_f:
            found.append(outside)
    return [replace(c, met=_met(c, known, tolerance, 3 if slope is None else fewest)) for c in found]


def _met(crossing: Crossing, known: list[Sample], tolerance: float, fewest: int) -> bool:
    """True when there are `fewest` marches, the error bar is within `tolerance`, the interpolation's part well within, and the
    root was looked at from near."""
    allowed = tolerance * crossing.V_f
    return bool(
        len(known) >= fewest
        and crossing.parts["interpolation"] <= INTERPOLATION * allowed
        and crossing.uncertainty <= allowed
        and min(abs(s.V_f - crossing.V_f) for s in known) <= NEAR * allowed
    )


def propose(
    samples: Sequence[Sample],
    guess: float,
    low: float,
    high: float,
    tolerance: float,
    slope: float | None = None,
    fewest: int = 2,
) -> float | None:
    """The next V_f to march at; None when the tolerance is met at a crossing, or when no march would tell more.

    First the guess; then a Newton step with the expected `slope` (dσ/dV_f); then the root of line or hyperbola, inside the
    bracket once there is one. A failed march (no growth rate) halves the way back to a good one.
    """
    known = _known(samples)
    failed = [s.V_f for s in samples if not s.known]
    if not known:
        target = _first(samples, failed, guess, low, high)
        return None if target is None or any(abs(target - s.V_f) < 1e-9 * target for s in samples) else target
    found = crossings(samples, tolerance, slope, fewest)
    if any(c.met for c in found):
        return None
    bracketed = [c for c in found if c.bracketed]
    if bracketed:
        target = _inside(min(bracketed, key=lambda c: abs(math.log(c.V_f / guess))), known, failed, tolerance)
        if target is None and not failed:
            target = _wider(known, low, high)
    else:
        target = _outside(known, failed, low, high, tolerance, SLOPE if slope is None else slope)
    if target is None or any(abs(target - s.V_f) < 1e-9 * target for s in samples):
        return None  # the same march again would tell nothing new
    return target


def _first(samples: Sequence[Sample], failed: list[float], guess: float, low: float, high: float) -> float | None:
    """A march when none has given a growth rate: far below those that grew out of reach, near one that failed."""
    grown = min((s.V_f for s in samples if s.grows), default=None)
    if grown is not None:
        return max(low, grown / FARTHEST) if grown > low else None
    tries = [guess, 0.85 * guess, 1.15 * guess]
    return float(np.clip(tries[len(failed)], low, high)) if len(failed) < len(tries) else None


def _inside(crossing: Crossing, known: list[Sample], failed: list[float], tolerance: float) -> float | None:
    """A march in the bracket: at the root, but not on top of a march already done."""
    below = max(s.V_f for s in known if s.V_f <= crossing.V_f)
    above = min(s.V_f for s in known if s.V_f >= crossing.V_f)
    width = math.log(above / below) if above > below else 0.0
    if any(below < f < above for f in failed):
        return None  # the component fails inside the bracket: the root stays as wide as the bracket
    ends = [s for s in known if s.V_f in (below, above)]
    noisy = abs(ends[-1].g - ends[0].g) < math.hypot(ends[0].g_std, ends[-1].g_std)
    if width <= (NEAR if noisy else 0.1) * tolerance:
        return None  # noise decides the sign of neighbours so near
    margin = min(0.1 * width, 0.5 * tolerance)
    from_below = math.log(crossing.V_f / below)
    # else one end would stay while marches creep up from the other
    from_below += math.copysign(BEYOND * crossing.parts["interpolation"] / crossing.V_f, 0.5 * width - from_below)
    return below * math.exp(float(np.clip(from_below, margin, width - margin)))


def _wider(known: list[Sample], low: float, high: float) -> float | None:
    """A march further off, when noise decides the signs of those near the root: from there the slope shows above the noise."""
    for upward in (True, False):
        end = known[-1] if upward else known[0]
        if math.log(known[-1].V_f / known[0].V_f) < WIDE:
            target = end.V_f * math.exp(WIDE if upward else -WIDE)
            if low <= target <= high:
                return target
    return None


def _outside(known: list[Sample], failed: list[float], low: float, high: float, tolerance: float, slope: float) -> float | None:
    """A march beyond those done, all of one sign.

    A section that grows is damped further down (or, below a recovery that a negative `slope` tells of, further up), whatever
    the trend: large motions bend it. One that is damped grows where the trend points to; without a trend further up."""
    grows, rising = known[0].growth_rate >= 0.0, slope > 0.0
    if not grows and len(known) > 1:
        i = max(1, int(np.argmax([s.g for s in known])))
        a, b = known[i - 1], known[i]
        if abs(b.g - a.g) > SURE * math.hypot(a.g_std, b.g_std):
            rising = b.g > a.g
    promised = rising is not grows
    for upward in (promised, not promised):
        end = known[-1] if upward else known[0]
        fails = [f for f in failed if (f > end.V_f if upward else f < end.V_f)]
        limit = min([high, *fails]) if upward else max([low, *fails])
        if abs(limit / end.V_f - 1.0) <= (NEAR if fails else 0.5) * tolerance:
            continue  # nothing between the last march and the limit worth a march
        step = math.log(FARTHEST)  # against the trend: explore
        if upward is promised:
            step = float(np.clip(OVERSHOOT * _to_root(known, upward, slope), 2.0 * tolerance, step))
        target = end.V_f * math.exp(step if upward else -step)
        if fails or (len(known) == 1 and not low <= target <= high):
            limit = math.sqrt(end.V_f * limit)  # a first march at the very end of the range seldom tells
        return min(target, limit) if upward else max(target, limit)
    return None


def _to_root(known: list[Sample], upward: bool, slope: float) -> float:
    """How far in x the root is beyond the last (or first) march: where hyperbola or line through the nearest ones point, if they
    are sure and of the expected sign, else where the expected slope does."""
    near = known[::-1] if upward else known
    end = near[0]
    if len(near) > 2 and (bent := hyperbola(near[:3])) is not None and (bent.x > end.x) is upward and bent.slope * slope > 0.0:
        return abs(bent.x - end.x)
    if len(near) > 1:
        apart = near[1].x - end.x
        secant, doubt = (near[1].g - end.g) / apart, math.hypot(near[1].g_std, end.g_std) / abs(apart)
        if secant * slope > 0.0 and abs(secant) > SURE * doubt:
            slope = secant
    return abs(end.g / slope)


def _known(samples: Sequence[Sample]) -> list[Sample]:
    """Samples with a growth rate in rising V_f; of several at one V_f the last."""
    return sorted({s.V_f: s for s in samples if s.known}.values(), key=lambda s: s.V_f)
