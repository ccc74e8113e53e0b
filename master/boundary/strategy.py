"""What to do at a Mach number: a linear model predicts every neutral V_f, marches confirm them one by one; or either alone.

Each crossing is searched from its predicted V_f and slope, among the marches' modes by its predicted frequency, no further
than to the next crossing of the same mode. What marches do not confirm is recorded as contradicted: there the response depends
on its amplitude, or the linear model is wrong.
"""

from __future__ import annotations

import dataclasses
import math
import time as clock
from collections.abc import Callable

import numpy as np

from ..analysis.crossings import Crossing, Sample
from ..analysis.damping import Mode
from ..base.errors import AeroSloshError, ComponentError
from ..base.wording import plus_minus
from ..case.case import Case
from ..flutter import coarse_marches
from ..flutter.march import March
from ..flutter.setup import FlutterSetup
from ..linear import model as linear_model
from ..linear.model import LinearCrossing, LinearModel
from . import companion as companions
from . import static_strategy
from .companion import Companion
from .search import VAGUE, BoundaryPoint, Limits, Marcher, Prediction, State, oscillation_std, outcome_text, sample, search
from .static_strategy import growing_sample
from .uncertainty import FLAT, Spread

SAME_MODE = 0.25  # relative difference of frequency within which two crossings, or a fitted mode and a crossing, are one mode
HIDES = 0.1  # growth rate from which another pole hides a crossing: a factor 20 in five periods
REACH = 1.35  # a crossing is looked for within this factor of its predicted V_f
OWN_PERIODS = 8.0  # of a mode that a march shows: more of them grow or decay to another amplitude, and tell of that one
SHARED = 0.05  # marches of other crossings this near (relative) count


@dataclasses.dataclass(frozen=True)
class Confirm:
    """What to do at one Mach number (a `boundary.Strategy`): `setup_at(mach)` is the open one, `open_setup` opens one of another
    case there, `say` tells the user.

    Without `marching` the linear model's crossings are the result; with the case's method "march" no model is made."""

    case: Case
    setup_at: Callable[[float], FlutterSetup]
    open_setup: Callable[[Case, float], FlutterSetup]
    say: Callable[[str], None]
    marching: bool

    def __call__(self, marcher: Marcher, mach: float, guess: float, slope: float | None) -> BoundaryPoint:
        """The point at `mach`. A linear model that cannot be had is said; then marches search from `guess` alone."""
        b, begin = self.case.boundary, clock.perf_counter()
        low, high = b.V_f_range
        if b.method == "march":
            return self._searched(marcher, mach, guess, slope)
        setup = self.setup_at(mach)
        amplitude = b.linear_amplitude_deg
        if not isinstance(amplitude, float):
            amplitude = self.case.flutter.forced_amplitude_deg or 1.0
        try:
            model = linear_model.identify(setup, amplitude, self.say)
            setup.needed_cycles = model.cycles
        except AeroSloshError as error:
            if not self.marching:
                failure = error if isinstance(error, ComponentError) else None
                return BoundaryPoint(mach, [], [], f"no linear model: {error.what}", False, failure=failure)
            self.say(f"  no linear model at Mach {mach:g}: {error.what}; marches alone")
            return self._searched(marcher, mach, guess, slope)
        if self.case.slosh.model not in ("none", "frozen"):
            self.say("  the linear model carries the liquid frozen; marches let it slosh")
        expected = model.crossings(low, high)
        for c in expected:
            self.say(f"  linear: {c.name} at V_f = {plus_minus(c.V_f, c.uncertainty, 4)}, frequency {c.frequency:.4f}")
        asked = b.companion and bool(expected) and not (self.marching and (b.uncertainty or b.richardson))
        beside = companions.identify(self.open_setup, model, self.say) if asked else None
        if not self.marching:
            point = _unmarched(mach, model, expected, low, high, beside)
        elif expected:
            point = self._confirmed(marcher, mach, model, expected, beside)
        else:
            point = self._none_expected(marcher, mach, model)
        if asked and beside is None:
            point.crossings[:] = [dataclasses.replace(c, missing=c.missing + coarse_marches.PARTS) for c in point.crossings]
        point.divergence = self._divergence(mach)
        point.wall = clock.perf_counter() - begin
        return point

    def _searched(
        self, marcher: Marcher, mach: float, guess: float, slope: float | None, done: list[March] | None = None
    ) -> BoundaryPoint:
        """Marches alone, from `guess`; `done` are marches made before."""
        b, begin = self.case.boundary, clock.perf_counter()
        low, high = b.V_f_range
        point = search(marcher, mach, guess, Limits(low, high, b.tolerance, b.max_marches), slope, done)
        point.divergence = self._divergence(mach)
        if low <= point.divergence <= high:
            self._add_divergence(point, marcher)
        for i, c in enumerate(point.crossings):
            if c.met:
                take = sample if c.frequency else growing_sample
                c = self._widened(c, point.marches, take, point.checks, mach)
                point.crossings[i] = self._beside_marches(c, point.marches, take, point.checks)
        if point.checks:
            point.outcome = outcome_text(point.crossings, point.samples, low, high, len(point.marches), point.failure)
        point.wall = clock.perf_counter() - begin
        return point

    def _divergence(self, mach: float) -> float:
        """The V_f of static divergence by two steady solutions; nan where they could not be had."""
        try:
            return self.setup_at(mach).divergence()
        except AeroSloshError:
            return math.nan

    def _add_divergence(self, point: BoundaryPoint, marcher: Marcher) -> None:
        """March about the divergence that the steady flow promises, and add what is found to `point`."""
        found, static, why = static_strategy.confirm(marcher, point.divergence, self.case.boundary.tolerance)
        point.marches += static
        point.samples += [sample(m) for m in static]
        point.crossings = sorted([*point.crossings, *([] if found is None else [found])], key=lambda c: c.V_f)
        point.converged = any(c.met for c in point.crossings)
        low, high = self.case.boundary.V_f_range
        point.outcome = outcome_text(point.crossings, point.samples, low, high, len(point.marches), point.failure)
        if why:
            point.outcome += f"; divergence at V_f = {point.divergence:.4f} by two steady solutions not confirmed: {why}"

    def _widened(
        self, crossing: Crossing, searched: list[March], take: Callable[[March], Sample], checks: list[March], mach: float
    ) -> Crossing:
        """`crossing` with the parts of its error bar that were asked for; their marches go to `checks`."""
        if not (self.case.boundary.uncertainty or self.case.boundary.richardson):
            return crossing
        spread = self._spread(mach, take)
        wider = spread.widened(crossing, searched)
        checks += spread.marches
        return wider

    def _beside_marches(
        self, crossing: Crossing, searched: list[March], take: Callable[[March], Sample], checks: list[March]
    ) -> Crossing:
        """`crossing`, found without a linear model, with what coarse marches tell of its error bar; they go to `checks`."""
        b = self.case.boundary
        near = [m for m in searched if take(m).known]
        if not b.companion or b.uncertainty or b.richardson or not near:
            return crossing
        if abs(crossing.slope) * crossing.V_f <= FLAT:
            return dataclasses.replace(crossing, missing=crossing.missing + coarse_marches.PARTS)
        nearest = min(near, key=lambda m: abs(m.scales.V_f - crossing.V_f))
        pole = complex(take(nearest).growth_rate, take(nearest).frequency)
        told = coarse_marches.change(self.open_setup, self.case, nearest, pole, lambda text: self.say(f"  {text}"))
        checks += told.marches
        parts = {name: -rate / crossing.slope for name, rate in told.growth_rate.items()}
        return dataclasses.replace(crossing, parts=crossing.parts | parts, missing=crossing.missing + told.missing)

    def _spread(self, mach: float, take: Callable[[March], Sample]) -> Spread:
        return Spread(self.case, mach, self.setup_at(mach), self.open_setup, take, self.say)

    def _confirmed(
        self, marcher: Marcher, mach: float, model: LinearModel, expected: list[LinearCrossing], beside: Companion | None
    ) -> BoundaryPoint:
        """March at every predicted crossing; `beside` tells of their error bars what marches do not."""
        b, setup = self.case.boundary, self.setup_at(mach)
        as_modelled = self.case.slosh.model in ("none", "frozen")  # liquid that moves changes the slope, and gathers way
        short = as_modelled and not (b.uncertainty or b.richardson)  # these repeat marches on setups of their own
        marches: list[March] = []
        checks: list[March] = []
        samples: list[Sample] = []
        found: list[Crossing] = []
        predictions: list[Prediction] = []
        failure: AeroSloshError | None = None
        for c in expected:
            setup.enough_cycles = math.inf
            hidden = _hidden(c, model)
            if hidden:
                predictions.append(Prediction(c, State.NOT_MARCHED, None, hidden))
                found.append(_as_crossing(c, beside))
                continue
            if c.kind == "divergence":
                marched, static, why = static_strategy.confirm(marcher, c.V_f, b.tolerance, model.real)
                marches += static
                samples += [sample(m) for m in static]
                if marched is not None:
                    marched = _beside(self._widened(marched, static, growing_sample, checks, mach), c, beside)
                    found.append(marched)
                predictions.append(_static_prediction(c, marched, why))
                continue
            low, high = _window(c, expected, b.V_f_range[0], b.V_f_range[1])

            def take(march: March, c: LinearCrossing = c) -> Sample:
                return mode_sample(march, c, model)

            near = [m for m in marches if abs(m.scales.V_f / c.V_f - 1.0) < SHARED and take(m).known]
            most = len(near) + max(3, b.max_marches // 2)
            setup.enough_cycles = OWN_PERIODS / c.frequency if short else math.inf
            limits = Limits(low, high, b.tolerance, most, 1 if as_modelled else 2)
            part = search(marcher, mach, c.V_f, limits, c.slope, near, take)
            marches += part.marches[len(near) :]
            samples += part.samples[len(near) :]
            failure = part.failure or failure
            # a crossing is confirmed by one of the same direction
            same = [x for x in part.crossings if x.direction == c.direction]
            marched = min(same, key=lambda x: abs(x.V_f - c.V_f), default=None)
            if marched is not None:
                marched = _beside(self._widened(marched, part.marches, take, checks, mach), c, beside)
            predictions.append(_prediction(c, marched, part, model))
            found += [] if marched is None else [marched]
        found.sort(key=lambda x: x.V_f)
        text = outcome_text(found, samples, b.V_f_range[0], b.V_f_range[1], len(marches), failure)
        text = "; ".join([text, *[p.text for p in predictions if p.text and p.state is not State.CONFIRMED]])
        sure = any(x.source == "march" for x in found) and all(x.met for x in _bounding(found))
        return BoundaryPoint(mach, found, samples, text, sure, marches, 0.0, failure, model, predictions, checks)

    def _none_expected(self, marcher: Marcher, mach: float, model: LinearModel) -> BoundaryPoint:
        """No crossing predicted: a few marches, the least damped V_f among them, see whether that is so.

        When one of them grows the marches look for the crossing on their own."""
        b = self.case.boundary
        low, high = b.V_f_range
        places = _to_probe(model, low, high)
        self.say(f"  linear: no crossing in range; marches at V_f {', '.join(f'{v:.3g}' for v in places)}")
        marches = [marcher(V_f) for V_f in places[: b.max_marches]]
        known = [s for s in map(sample, marches) if s.known]
        if any(s.growth_rate > 0.0 for s in known):
            first = max(known, key=lambda s: s.growth_rate)
            point = self._searched(marcher, mach, first.V_f, None, marches)
            point.linear = model
            return point
        failure = next((m.failure for m in marches if m.failure is not None), None)
        agreed = len(known) == len(marches)
        word = "growing" if model.eigenvalues(low)[0].real > 0.0 else "damped"
        text = f"no crossing: {word} in V_f {low:g} to {high:g} (linear model), damped in {len(known)} of {len(marches)} marches"
        agreed = agreed and word == "damped"
        return BoundaryPoint(mach, [], [sample(m) for m in marches], text, agreed, marches, 0.0, failure, model)


def _bounding(found: list[Crossing]) -> list[Crossing]:
    """Those of all crossings, in rising V_f, between stable and unstable V_f: not those of a pole beside an unstable one."""
    unstable, bounding = 0, []
    for c in found:
        onset = c.direction == "onset"
        if unstable == (0 if onset else 1):
            bounding.append(c)
        unstable = unstable + 1 if onset else max(0, unstable - 1)
    return bounding


def _hidden(c: LinearCrossing, model: LinearModel) -> str:
    """Why no march can show `c`: another pole grows so much there that the motion is soon beyond reach; else nothing."""
    values = model.spectrum(c.V_f)
    others = values[(values.imag >= 0.0) & (np.abs(values - 1j * c.frequency) > 0.02)]
    worst = others[np.argmax(others.real)]
    if worst.real < HIDES:
        return ""
    what = "flutter" if worst.imag else "divergence"
    return f"linear {c.name} at V_f = {c.V_f:.4f} not marched: {what} that grows at {worst.real:+.2f} omega_alpha hides it there"


def _as_crossing(c: LinearCrossing, beside: Companion | None) -> Crossing:
    """A crossing of the linear model as a result."""
    known = math.isfinite(c.uncertainty)
    parts, missing = ({"model": c.uncertainty}, ()) if known else ({}, ("model",))
    found = Crossing(c.V_f, c.frequency, c.direction, c.slope, True, parts, met=True, source="linear", missing=missing)
    return _beside(found, c, beside)


def _beside(crossing: Crossing, c: LinearCrossing, beside: Companion | None) -> Crossing:
    """`crossing`, which is `c`, with what the coarse models tell of its error bar."""
    return crossing if beside is None else beside.widened(crossing, c)


def mode_sample(march: March, c: LinearCrossing, model: LinearModel) -> Sample:
    """The growth rate of the fitted mode that the linear model's crossing `c` is of; none when no visible mode is near.

    At the march's V_f the model says where that mode's eigenvalue is, and where the others are: of two close modes each is
    taken for the one whose eigenvalue is nearer."""
    V_f, whole, fit = march.scales.V_f, sample(march), march.fit
    if fit is None:
        return dataclasses.replace(whole, grows=False)  # what grew may be another mode
    expected = model.eigenvalues(V_f)
    own = expected[np.argmin(np.abs(expected - complex(c.slope * (V_f - c.V_f), c.frequency)))]
    near = [m for m in fit.modes if abs(m.frequency - own.imag) <= SAME_MODE * own.imag and m.share >= 0.005]
    if len(near) > 1:
        others = [e for e in expected if e is not own and abs(e.imag - own.imag) <= 2.0 * SAME_MODE * own.imag]
        mine = [m for m in near if all(abs(_pole(m) - own) <= abs(_pole(m) - e) for e in others)]
        near = mine or near
    mode = min(near, key=lambda m: abs(_pole(m) - own), default=None)
    std = oscillation_std(fit, mode) if mode is not None else math.inf
    if mode is None or std > VAGUE:
        return Sample(V_f, math.nan, math.nan, math.nan)
    return Sample(V_f, mode.growth_rate, std, mode.frequency)


def _pole(mode: Mode) -> complex:
    return complex(mode.growth_rate, mode.frequency)


def _to_probe(model: LinearModel, low: float, high: float) -> list[float]:
    """V_f worth a march when the model is damped everywhere: three spread evenly, and where its damping has a minimum."""
    grid = np.geomspace(low, high, 60)
    rates = np.array([model.eigenvalues(float(v))[0].real for v in grid])
    peaks = [int(i) + 1 for i in np.flatnonzero((rates[1:-1] > rates[:-2]) & (rates[1:-1] > rates[2:]))]
    peaks = sorted(peaks, key=lambda i: -rates[i])[:2]
    spread = [float(grid[i]) for i in (10, 30, 50)]
    return sorted(spread + [v for v in (float(grid[i]) for i in peaks) if all(abs(v / s - 1.0) > 0.05 for s in spread)])


def _window(c: LinearCrossing, expected: list[LinearCrossing], low: float, high: float) -> tuple[float, float]:
    """Where to look for `c`: within REACH, and half the way to the next crossing of the same mode."""
    low, high = max(low, c.V_f / REACH), min(high, c.V_f * REACH)
    for other in expected:
        if other is c or abs(other.frequency - c.frequency) > SAME_MODE * c.frequency:
            continue
        middle = math.sqrt(other.V_f * c.V_f)
        low, high = (max(low, middle), high) if other.V_f < c.V_f else (low, min(high, middle))
    return low, high


def _prediction(c: LinearCrossing, marched: Crossing | None, part: BoundaryPoint, model: LinearModel) -> Prediction:
    """What marches said of `c`, in words."""
    said = f"linear {c.name} at V_f = {c.V_f:.4f} (sweeps of {model.amplitude_deg:g}°)"
    if marched is not None:
        return Prediction(c, State.CONFIRMED, marched, f"{said}: marched {marched.V_f:.4f}, {marched.V_f / c.V_f - 1.0:+.2%}")
    known = [s for s in part.samples if s.known]
    if not known:
        return Prediction(c, State.CONTRADICTED, None, f"{said} not confirmed: no march there gave this mode's growth rate")
    span = f"V_f {min(s.V_f for s in known):.4f} to {max(s.V_f for s in known):.4f}"
    rates = f"{min(s.growth_rate for s in known):+.4f} to {max(s.growth_rate for s in known):+.4f}"
    return Prediction(c, State.CONTRADICTED, None, f"{said} not confirmed by marches: growth rate {rates} over {span}")


def _static_prediction(c: LinearCrossing, marched: Crossing | None, why: str) -> Prediction:
    """What marches said of the divergence `c`, in words."""
    said = f"divergence at V_f = {c.V_f:.4f} (steady slopes)"
    if marched is None:
        return Prediction(c, State.CONTRADICTED, None, f"{said} not confirmed: {why}")
    return Prediction(c, State.CONFIRMED, marched, f"{said}: marched {marched.V_f:.4f}, {marched.V_f / c.V_f - 1.0:+.2%}")


def _unmarched(
    mach: float, model: LinearModel, expected: list[LinearCrossing], low: float, high: float, beside: Companion | None
) -> BoundaryPoint:
    """The linear model's crossings as the result."""
    found = [_as_crossing(c, beside) for c in expected]
    text = outcome_text(found, [], low, high, 0, None)
    if not found:
        rate = max(float(model.eigenvalues(v)[0].real) for v in (low, high))
        text = f"no crossing in V_f {low:g} to {high:g}: {'growing' if rate > 0 else 'damped'} (linear model)"
    if model.liquid is not None and model.case.slosh.model != "frozen":
        text += " (liquid carried frozen)"
    predictions = [Prediction(c) for c in expected]
    return BoundaryPoint(mach, found, [], text, not model.note, linear=model, predictions=predictions)
