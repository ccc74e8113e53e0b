"""The flutter boundary: the neutral V_f of each Mach number by a few marches, the steady flow computed
once a Mach."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from enum import StrEnum

from ..analysis.crossings import Crossing, Sample
from ..analysis.damping import Fit, Mode
from ..analysis.verdict import Verdict
from ..base.errors import AeroSloshError, ComponentError, InternalError
from ..base.wording import counted, plus_minus
from ..case.case import Case
from ..flutter.march import March
from ..linear.model import LinearCrossing, LinearModel
from .next_march import SLOPE, crossings, propose

VAGUE = 0.05  # a growth rate (over omega_alpha) less certain than this is none
OTHERS = 2.0  # the residual's noise of a mode that the fit's error bar is not of, times this
GROSS = 0.005  # one less certain than this tells, where the motion outgrew linear motion, its sign alone

Marcher = Callable[[float], March]  # V_f → march
Strategy = Callable[[Marcher, float, float, float | None], "BoundaryPoint"]  # marcher, Mach, guess of V_f, of dσ/dV_f


class State(StrEnum):
    """What marches made of a crossing of the linear model; the words of the JSON result."""

    CONFIRMED = "confirmed"
    CONTRADICTED = "contradicted"
    NOT_MARCHED = "not marched"


@dataclass(frozen=True)
class Limits:
    """Where a search looks: V_f from `low` to `high`, to the relative `tolerance`, with `max_marches` at most.

    fewest  marches that make a crossing whose slope is known: one where a linear model of the same flow predicts both"""

    low: float
    high: float
    tolerance: float
    max_marches: int
    fewest: int = 2


@dataclass(frozen=True)
class Prediction:
    """A crossing of the linear model and what marches said of it.

    state    what became of it
    marched  the crossing confirmed; `text` says it in words
    """

    crossing: LinearCrossing
    state: State = State.NOT_MARCHED
    marched: Crossing | None = None
    text: str = ""


@dataclass
class BoundaryPoint:
    """What the search found at one Mach number. `outcome` says in words what it means; `crossings` may be empty.

    `marches` are the search's, `checks` those for the error bars' parts step, amplitude and mesh. `divergence`: the V_f of static
    divergence by two steady solutions alone, inf where there is none, nan where it is not known. `case` is whose it is."""

    mach: float
    crossings: list[Crossing]
    samples: list[Sample]
    outcome: str
    converged: bool
    marches: list[March] = field(default_factory=list, repr=False)
    wall: float = 0.0
    failure: AeroSloshError | None = None
    linear: LinearModel | None = None
    predictions: list[Prediction] = field(default_factory=list)
    checks: list[March] = field(default_factory=list, repr=False)
    divergence: float = math.nan
    interrupted: bool = False
    case: Case | None = field(default=None, repr=False)


def sample(march: March) -> Sample:
    """What the search sees of a march's oscillations; a fit spoilt by a failure or by too few cycles counts as none.

    A motion that grew beyond reach within a cycle or two, or one in a limit cycle that no exponential describes, tells that
    small motions grow there, and no more: a limit cycle is kept up by what grows below it."""
    fit, V_f = march.fit, march.scales.V_f
    mode = fit.oscillation if fit is not None else None
    std = oscillation_std(fit, mode) if fit is not None and mode is not None else math.inf
    grew = march.verdict is Verdict.FLUTTER and (mode is None or std > VAGUE or std > max(GROSS, mode.growth_rate / 3.0))
    cycles = march.verdict is Verdict.LIMIT_CYCLE and std > GROSS
    if march.failure is None and (grew or cycles):
        return Sample(V_f, math.nan, math.nan, math.nan, grows=True)
    if mode is None or not std <= VAGUE:
        return Sample(V_f, math.nan, math.nan, math.nan)
    return Sample(V_f, mode.growth_rate, std, mode.frequency)


def oscillation_std(fit: Fit, mode: Mode) -> float:
    """Standard deviation of the growth rate of `mode`; inf when it is no number."""
    std = fit.growth_rate_uncertainty if mode is fit.flutter else OTHERS * mode.growth_rate_std
    return std if math.isfinite(mode.growth_rate + std) else math.inf


def search(
    marcher: Marcher,
    mach: float,
    guess: float,
    limits: Limits,
    slope: float | None = None,
    done: list[March] | None = None,
    take: Callable[[March], Sample] = sample,
) -> BoundaryPoint:
    """Find a neutral V_f at `mach` within `limits`, starting from `guess`, with the dσ/dV_f `slope` if it is known.

    `done`: marches made before at this Mach number; `take` reads a growth rate out of a march. Every march is kept, and
    every crossing among them reported."""
    begin = clock.perf_counter()
    marches = list(done or [])
    failure: ComponentError | None = None
    low, high, tolerance = limits.low, limits.high, limits.tolerance
    guess = min(max(guess, low), high)
    while len(marches) < limits.max_marches:
        target = propose([take(m) for m in marches], guess, low, high, tolerance, slope, limits.fewest)
        if target is None:
            break
        marches.append(marcher(target))
        failure = marches[-1].failure or failure
    samples = [take(m) for m in marches]
    found = crossings(samples, tolerance, slope, limits.fewest)
    return BoundaryPoint(
        mach,
        found,
        samples,
        outcome_text(found, samples, low, high, len(marches), failure),
        any(c.met for c in found),
        marches,
        clock.perf_counter() - begin,
        failure,
    )


def boundary(
    marcher_at: Callable[[float], tuple[Marcher, Callable[[], None]]],
    machs: list[float],
    guess: float,
    limits: Limits,
    on_point: Callable[[BoundaryPoint], None] = lambda point: None,
    strategy: Strategy | None = None,
    slope: float | None = None,
) -> list[BoundaryPoint]:
    """Search every Mach number; each starts from its nearest solved neighbour's result, the first from `guess` and `slope`.

    `marcher_at(mach)` gives the marcher and a function that closes it; `strategy` is what to do at a Mach number instead of
    `search` (module `boundary/strategy` has one with a linear model). A Mach number at which something fails, an FMU or this
    program, is a point with that outcome and the marches made; the others go on. So is, before an interrupt goes on, one that has
    marches.
    """
    points: list[BoundaryPoint] = []
    for mach in machs:
        start, steepness = prior(points, mach, guess, slope)
        made: list[March] = []
        begin = clock.perf_counter()
        try:
            marcher, close = marcher_at(mach)

            def noted(V_f: float, marcher: Marcher = marcher, made: list[March] = made) -> March:
                made.append(marcher(V_f))
                return made[-1]

            try:
                if strategy is not None:
                    point = strategy(noted, mach, start, steepness)
                else:
                    point = search(noted, mach, start, limits, steepness)
            finally:
                close()
        except Exception as error:
            failure = error if isinstance(error, AeroSloshError) else InternalError(error, f"Mach {mach:g}")
            point = failed(mach, failure, made, begin)
        except BaseException:
            if made:
                on_point(interrupted(mach, made, begin))
            raise
        points.append(point)
        on_point(point)
    if not points:
        raise AeroSloshError("No Mach number given", "boundary.mach", "give at least one")
    return points


def failed(mach: float, failure: AeroSloshError, made: list[March], begin: float) -> BoundaryPoint:
    """A Mach number at which something failed; `made`: its marches, `begin`: when it began (`perf_counter`)."""
    more = f" ({counted(len(made), 'march')} made)" if made else ""
    return replace(_unfinished(mach, f"failed: {failure.what}{more}", made, begin), failure=failure)


def interrupted(mach: float, made: list[March], begin: float) -> BoundaryPoint:
    """A Mach number whose search was ended; arguments as for `failed`."""
    return replace(_unfinished(mach, f"interrupted after {counted(len(made), 'march')}", made, begin), interrupted=True)


def _unfinished(mach: float, outcome: str, made: list[March], begin: float) -> BoundaryPoint:
    return BoundaryPoint(mach, [], [sample(m) for m in made], outcome, False, made, clock.perf_counter() - begin)


def prior(points: list[BoundaryPoint], mach: float, guess: float, slope: float | None = None) -> tuple[float, float | None]:
    """Guess of V_f from Mach numbers solved, linear in Mach from the two nearest, within 40 %; and of dσ/dV_f, the nearest's.

    Where none is solved: `guess` and `slope`."""
    solved = sorted((p for p in points if p.crossings), key=lambda p: abs(p.mach - mach))
    if not solved:
        return guess, slope
    nearest = solved[0].crossings[0]
    value = nearest.V_f
    if len(solved) > 1 and solved[0].mach != solved[1].mach:
        other = solved[1].crossings[0]
        trend = (nearest.V_f - other.V_f) / (solved[0].mach - solved[1].mach)
        value = min(max(value + trend * (mach - solved[0].mach), 0.6 * nearest.V_f), 1.4 * nearest.V_f)
    return value, max(nearest.slope, 0.2 * SLOPE)


def outcome_text(
    found: list[Crossing], samples: list[Sample], low: float, high: float, n: int, failure: AeroSloshError | None
) -> str:
    """One line for people: the crossings, whether each meets the tolerance, and the number of marches `n`."""
    if found:
        texts = [f"{c.name} at V_f = {plus_minus(c.V_f, c.uncertainty, 4)}" for c in found]
        if not any(c.met for c in found):
            return f"{', '.join(texts)}; tolerance not met in {counted(n, 'march')}"
        marked = [text if c.met else f"{text} (tolerance not met)" for text, c in zip(texts, found, strict=True)]
        return ", ".join(marked) + (f" ({counted(n, 'march')})" if n else "")
    signs = {s.growth_rate >= 0.0 if s.known else True for s in samples if s.known or s.grows}
    if not signs:
        return f"failed: {failure.what}" if failure else "no march gave a growth rate"
    if len(signs) > 1:
        return f"growing at some V_f and damped at others, no crossing narrowed down in {counted(n, 'march')}"
    word = "growing" if signs == {True} else "damped"
    told = [s.V_f for s in samples if s.known or s.grows]
    searched = f"V_f {min(told):.3f} to {max(told):.3f}"
    if min(told) <= low * 1.01 and max(told) >= high * 0.99:
        return f"no crossing in range: {word} in all {n} marches over {searched}"
    return f"no crossing found: {word} in {searched} ({counted(n, 'march')})"
