"""Static divergence confirmed by marches: growth just above the V_f that the steady flow promises, none just below it.

A real pole near zero is one of many: those of the wake decay as slowly. One that grows stands out and is read above V_f; two
marches there, carried back to zero along the linear model's curve (or their own line), give the marched V_f; a third one below
must come to rest."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from ..analysis.crossings import Crossing, Sample
from ..analysis.verdict import Verdict, describes
from ..flutter.march import March

ABOVE, BELOW = (1.02, 1.05, 1.09, 1.13), 0.96  # of the promised V_f; the later ones where a nearer one cannot be read
SHARE = 0.05  # of a channel, from which a growing real pole is read
Marcher = Callable[[float], March]


def growing_sample(march: March) -> Sample:
    """The growth rate of the real pole that most of the motion is of (frequency 0); none where it does not grow clearly."""
    fit, V_f = march.fit, march.scales.V_f
    mode = max(fit.reals, key=lambda m: m.share, default=None) if fit is not None else None
    if fit is None or mode is None or march.failure is not None or not describes(fit):
        return Sample(V_f, math.nan, math.nan, math.nan)
    if mode.share < SHARE or mode.growth_rate < 3.0 * mode.growth_rate_std:
        return Sample(V_f, math.nan, math.nan, math.nan)
    std = fit.growth_rate_uncertainty if mode is fit.flutter else 2.0 * mode.growth_rate_std
    return Sample(V_f, mode.growth_rate, std, 0.0)


def comes_to_rest(march: March) -> bool:
    """Whether what does not oscillate is smaller at the end of the free response than in its middle."""
    fit = march.fit
    if fit is None or march.stopped or march.failure is not None:
        return False
    t = np.array([0.5, 1.0]) * (fit.end - fit.start)
    drift = np.array([sum((m.amplitudes[-1].real * np.exp(m.growth_rate * x) for m in fit.reals), fit.constants[-1]) for x in t])
    return bool(abs(drift[1]) <= abs(drift[0]))


def confirm(
    marcher: Marcher, V_f: float, tolerance: float, rate: Callable[[float], float] | None = None
) -> tuple[Crossing | None, list[March], str]:
    """The marched V_f of the divergence promised at `V_f`, the marches, and what they say when they do not confirm it.

    `rate`: the real eigenvalue over omega_alpha that a model has at a V_f; without it the line through both marches serves."""
    marches = [marcher(BELOW * V_f)]
    # below it an oscillation may grow (flutter comes first): then what does not oscillate must not
    flutters = marches[0].verdict is Verdict.FLUTTER and not growing_sample(marches[0]).known
    rest, seen = comes_to_rest(marches[0]) or flutters, list[Sample]()
    for factor in ABOVE:
        if len(seen) == 2 or (factor > ABOVE[2] and not seen):
            break
        marches.append(marcher(factor * V_f))
        seen += [s for s in [growing_sample(marches[-1])] if s.known]
    if not seen or not rest:
        grown = f"{len(seen)} of {len(marches) - 1} marches above it grow without oscillating"
        return None, marches, f"{grown}; the one below it {'comes to rest' if rest else 'does not come to rest'}"
    if rate is not None:
        step = 1e-3 * V_f
        slope = (rate(V_f + step) - rate(V_f - step)) / (2.0 * step)
        roots = [_carried_back(s, V_f, rate) for s in seen]
    elif len(seen) == 2:
        slope = (seen[1].growth_rate - seen[0].growth_rate) / (seen[1].V_f - seen[0].V_f)
        roots = [seen[0].V_f - seen[0].growth_rate / slope] if slope > 0.0 else []
    else:
        roots = []
    if not roots or not all(map(math.isfinite, roots)) or slope <= 0.0:
        return None, marches, "the growth above it does not fall towards it"
    found = roots[0]
    apart = abs(roots[1] - roots[0]) if len(roots) == 2 else 0.25 * abs(seen[0].V_f - found)
    parts = {"fit": seen[0].std / slope, "interpolation": apart}
    crossing = Crossing(found, 0.0, "onset", slope, True, parts)
    met = crossing.uncertainty <= tolerance * found and BELOW * V_f < found < ABOVE[0] * V_f
    if not met and abs(found - V_f) < crossing.uncertainty:
        # marches that agree with the steady flow and know less: theirs is the confirmation, its the V_f
        found, parts = V_f, {"interpolation": abs(found - V_f)}
    return Crossing(found, 0.0, "onset", slope, True, parts, met=bool(met)), marches, ""


def _carried_back(sample: Sample, V_f: float, rate: Callable[[float], float]) -> float:
    """Where the model's curve, moved along V_f so that it goes through `sample`, is zero."""
    grid = np.linspace(0.9 * V_f, 1.2 * V_f, 61)
    rates = np.array([rate(float(v)) for v in grid])
    good = np.isfinite(rates) & (grid >= V_f)
    if good.sum() < 2:
        return math.nan
    return sample.V_f - (float(np.interp(sample.growth_rate, rates[good], grid[good])) - V_f)
