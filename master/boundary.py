"""The flutter boundary: the neutral V_f of each Mach number by a few marches, the steady flow computed
once a Mach."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field

from master.errors import AeroSloshError, ComponentError
from master.flutter import March
from master.linear import LinearCrossing, LinearModel
from master.search import FIRST_SLOPE, Crossing, Sample, crossings, propose
from master.wording import plus_minus

Marcher = Callable[[float], March]  # V_f → march
Strategy = Callable[[Marcher, float, float, float], "BoundaryPoint"]  # marcher, Mach, guess of V_f, of dσ/dln V_f


@dataclass(frozen=True)
class Prediction:
    """A crossing of the linear model and what marches said of it.

    state    "confirmed", "contradicted" or "not marched"
    marched  the crossing confirmed; `text` says it in words
    """

    crossing: LinearCrossing
    state: str = "not marched"
    marched: Crossing | None = None
    text: str = ""


@dataclass
class BoundaryPoint:
    """What the search found at one Mach number. `outcome` says in words what it means; `crossings` may be empty."""

    mach: float
    crossings: list[Crossing]
    samples: list[Sample]
    outcome: str
    converged: bool
    marches: list[March] = field(default_factory=list, repr=False)
    wall: float = 0.0
    failure: ComponentError | None = None
    linear: LinearModel | None = None
    predictions: list[Prediction] = field(default_factory=list)


def sample(march: March) -> Sample:
    """What the search sees of a march; a fit spoilt by a failure or by too few cycles counts as none."""
    fit = march.fit
    if fit is None or not math.isfinite(fit.growth_rate) or fit.growth_rate_uncertainty > 0.05:
        return Sample(march.scales.V_f, math.nan, math.nan, math.nan)
    return Sample(march.scales.V_f, fit.growth_rate, fit.growth_rate_uncertainty, fit.frequency)


def search(
    marcher: Marcher,
    mach: float,
    guess: float,
    low: float,
    high: float,
    tolerance: float,
    max_marches: int,
    slope: float = FIRST_SLOPE,
    done: list[March] | None = None,
    take: Callable[[March], Sample] = sample,
) -> BoundaryPoint:
    """Find a neutral V_f at `mach` in [low, high], starting from `guess` with the expected dσ/dln V_f `slope`.

    `done`: marches made before at this Mach number; `take` reads a growth rate out of a march. Every march is kept, and
    every crossing among them reported."""
    begin = clock.perf_counter()
    marches = list(done or [])
    failure: ComponentError | None = None
    guess = min(max(guess, low), high)
    while len(marches) < max_marches:
        target = propose([take(m) for m in marches], guess, low, high, tolerance, slope)
        if target is None:
            break
        marches.append(marcher(target))
        failure = marches[-1].failure or failure
    samples = [take(m) for m in marches]
    found = crossings(samples, tolerance)
    wanted = propose(samples, guess, low, high, tolerance, slope)
    converged = bool(found) and wanted is None
    return BoundaryPoint(
        mach,
        found,
        samples,
        outcome_text(found, samples, converged, low, high, len(marches), failure),
        converged,
        marches,
        clock.perf_counter() - begin,
        failure,
    )


def boundary(
    marcher_at: Callable[[float], tuple[Marcher, Callable[[], None]]],
    machs: list[float],
    guess: float,
    V_f_range: tuple[float, float],
    tolerance: float,
    max_marches: int,
    on_point: Callable[[BoundaryPoint], None] = lambda point: None,
    strategy: Strategy | None = None,
) -> list[BoundaryPoint]:
    """Search every Mach number; each starts from its nearest solved neighbour's result, the first from `guess`.

    `marcher_at(mach)` gives the marcher and a function that closes it; `strategy` is what to do at a Mach number instead of
    `search` (module `confirm` has one with a linear model). A Mach number whose component
    fails before any march is a point with that outcome; the others go on.
    """
    points: list[BoundaryPoint] = []
    for mach in machs:
        start, slope = _prior(points, mach, guess)
        try:
            marcher, close = marcher_at(mach)
        except ComponentError as error:
            points.append(BoundaryPoint(mach, [], [], f"failed: {error.what}", False, failure=error))
            on_point(points[-1])
            continue
        try:
            if strategy is not None:
                point = strategy(marcher, mach, start, slope)
            else:
                point = search(marcher, mach, start, V_f_range[0], V_f_range[1], tolerance, max_marches, slope)
        finally:
            close()
        points.append(point)
        on_point(point)
    if not points:
        raise AeroSloshError("No Mach number given", "boundary.mach", "give at least one")
    return points


def _prior(points: list[BoundaryPoint], mach: float, guess: float) -> tuple[float, float]:
    """Guess of V_f and of dσ/dln V_f from Mach numbers solved: linear in Mach from the two nearest, within 40 %."""
    solved = sorted((p for p in points if p.crossings), key=lambda p: abs(p.mach - mach))
    if not solved:
        return guess, FIRST_SLOPE
    nearest = solved[0].crossings[0]
    value = nearest.V_f
    if len(solved) > 1 and solved[0].mach != solved[1].mach:
        other = solved[1].crossings[0]
        trend = (nearest.V_f - other.V_f) / (solved[0].mach - solved[1].mach)
        value = min(max(value + trend * (mach - solved[0].mach), 0.6 * nearest.V_f), 1.4 * nearest.V_f)
    return value, max(nearest.slope * nearest.V_f, 0.2 * FIRST_SLOPE)


def outcome_text(
    found: list[Crossing],
    samples: list[Sample],
    converged: bool,
    low: float,
    high: float,
    n: int,
    failure: ComponentError | None,
) -> str:
    """One line for people."""
    if found:
        text = ", ".join(f"{c.direction} at V_f = {plus_minus(c.V_f, c.uncertainty, 4)}" for c in found)
        return text if converged else f"{text}; tolerance not met in {n} marches"
    known = [s for s in samples if s.known]
    if not known:
        return f"failed: {failure.what}" if failure else "no march gave a growth rate"
    word = "growing" if known[0].growth_rate > 0 else "damped"
    span = (min(s.V_f for s in known), max(s.V_f for s in known))
    searched = f"V_f {span[0]:.3f} to {span[1]:.3f}"
    if span[0] <= low * 1.01 and span[1] >= high * 0.99:
        return f"no crossing in range: {word} in all {n} marches over {searched}"
    return f"no crossing found: {word} in {searched} ({n} marches)"
