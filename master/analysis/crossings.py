"""A neutral V_f between marches: lines, parabolas, hyperbolas through g = σ/V_f over x = ln V_f, and what they may be wrong by.

σ, the growth rate over omega_alpha, goes to zero with the stream at low V_f: a root that is none. g has a limit there, the
aerodynamic damping of one unit of stream, and is nearly straight over x from there to the boundary and beyond. Its roots are
those of σ, and there dg/dx = dσ/dV_f.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from .richardson import GridStudy

SURE = 3.0  # a difference of this many of its standard deviations is no noise
SINGULAR = 1e-10  # of three growth rates less unlike than this share of their size no hyperbola is made
UNKNOWN = 1.0  # in ln V_f: an error that nothing tells, finite for those who read it
UNSEEN = 0.05  # of the distance to the nearest march: the least interpolation error, whatever the curves agree on
OTHER_MODE = 1.5  # marches whose frequencies have a ratio above this tell of two modes, between which g has a kink
KINK = 0.5  # as UNSEEN, where g may have one
WIDE = 0.3  # in ln V_f: marches further apart are not asked about curvature unless g goes on as between them
ALONE = 0.1  # as UNSEEN, for a line through two marches, whose curvature nothing tells
TOLD = 0.3  # as UNSEEN, for Newton's step from one march with a slope that was known beforehand: what that is taken to be off by


@dataclass(frozen=True)
class Sample:
    """One march: growth rate σ/ω_α ± std at V_f, frequency ω/ω_α; `growth_rate` nan when the march gave none.

    grows  without a growth rate: the motion grew out of what a fit can read, so that its sign alone is known"""

    V_f: float
    growth_rate: float
    std: float
    frequency: float
    grows: bool = False

    @property
    def known(self) -> bool:
        """True when it has a growth rate."""
        return math.isfinite(self.growth_rate)

    @property
    def x(self) -> float:
        """ln V_f."""
        return math.log(self.V_f)

    @property
    def g(self) -> float:
        """Growth rate over V_f."""
        return self.growth_rate / self.V_f

    @property
    def g_std(self) -> float:
        """Standard deviation of `g`; never 0, it is divided by."""
        return max(self.std, 1e-12) / self.V_f


@dataclass(frozen=True)
class Crossing:
    """A neutral V_f.

    direction  "onset" (grows above it) or "recovery" (decays above it)
    slope      dσ/dV_f
    bracketed  marches on both sides; otherwise extrapolated from the nearest ones
    parts      of the error bar, changes of V_f (those of step, amplitude and mesh signed): their squares add up
    met        the search's tolerance is met
    source     "march" or "linear"
    missing    parts that were asked for and could not be had
    grids      V_f on three meshes, if it was asked for
    """

    V_f: float
    frequency: float
    direction: str
    slope: float
    bracketed: bool
    parts: dict[str, float] = field(default_factory=dict)
    met: bool = False
    source: str = "march"
    missing: tuple[str, ...] = ()
    grids: GridStudy | None = None

    @property
    def kind(self) -> str:
        """ "divergence" (static: frequency 0) or "flutter"."""
        return "flutter" if self.frequency else "divergence"

    @property
    def name(self) -> str:
        """What to call it: onset or recovery of flutter, or (end of) divergence."""
        return name(self.kind, self.direction)

    @property
    def uncertainty(self) -> float:
        """Of V_f, one standard deviation."""
        return math.hypot(*self.parts.values())


def name(kind: str, direction: str) -> str:
    """The word for a crossing."""
    if kind == "flutter":
        return direction
    return "divergence" if direction == "onset" else "end of divergence"


class Root(NamedTuple):
    """Where a curve through samples is zero: x, the samples' noise in it (one standard deviation), dg/dx there."""

    x: float
    noise: float
    slope: float


def root(known: list[Sample], i: int, j: int, bracketed: bool, slope: float | None) -> Crossing | None:
    """The crossing near samples i < j of `known` (in rising V_f); None when no curve through them has one.

    With a third neighbour hyperbola or weighted line, see `_of_three`; with neighbours on both sides both hyperbolas, see
    `_of_four`. Two marches alone give a line, which a `slope` (dσ/dV_f) known beforehand may confirm."""
    a, b = known[i], known[j]
    if a.g == b.g:
        return None
    chord = a.x - a.g * (b.x - a.x) / (b.g - a.g)
    steepest, sure = _steepest(known, i, j)
    thirds = [known[k] for k in (i - 1, j + 1) if 0 <= k < len(known)]
    alone = KINK if thirds else ALONE
    if b.x - a.x > WIDE:  # beyond a hill or a valley so far away a march misleads
        rising = b.g > a.g
        thirds = [t for t in thirds if (t.g < a.g if t.x < a.x else t.g > b.g) is rising]
    if thirds:
        best, error = _of_three(a, b, min(thirds, key=lambda s: abs(s.x - chord)), chord, steepest)
        if best is not None and len(thirds) == 2:
            best, error = _of_four(a, b, thirds, best, error, steepest)
    else:
        best, nearest = polynomial([a, b], chord, 1, steepest), min((a, b), key=lambda s: abs(s.x - chord))
        error = alone * abs(nearest.x - chord)
        if slope is not None and best is not None and slope * best.slope > 0.0:  # Newton's step with it goes elsewhere by so much
            error = max(0.5 * error, 0.5 * abs(nearest.x - nearest.g / slope - chord))
    if best is None:
        return None
    if not bracketed and min(abs(best.x - a.x), abs(best.x - b.x)) > b.x - a.x:
        return None  # an extrapolation further than the marches are apart tells nothing
    x = float(np.clip(best.x, a.x, b.x)) if bracketed else best.x  # neither curve is better than a march's sign
    if max(a.frequency, b.frequency) > OTHER_MODE * min(a.frequency, b.frequency):
        error = max(error, KINK * min(abs(x - a.x), abs(b.x - x)))
    V_f, weight = math.exp(x), (x - a.x) / (b.x - a.x)
    frequency = a.frequency + weight * (b.frequency - a.frequency)
    direction = "onset" if b.g > a.g else "recovery"
    slope_there = best.slope if sure else math.copysign(steepest, b.g - a.g)
    return Crossing(
        V_f,
        frequency,
        direction,
        slope_there,
        bracketed,
        {"fit": V_f * min(best.noise, UNKNOWN), "interpolation": V_f * min(error, UNKNOWN)},
    )


def newton(sample: Sample, slope: float) -> Crossing | None:
    """The crossing near one march by the slope dσ/dV_f that was known beforehand; None without one."""
    if not slope:
        return None
    step, noise = -sample.g / slope, sample.g_std / abs(slope)
    V_f = sample.V_f * math.exp(max(-UNKNOWN, min(UNKNOWN, step)))
    parts = {"fit": V_f * min(noise, UNKNOWN), "interpolation": V_f * min(TOLD * abs(step), UNKNOWN)}
    return Crossing(V_f, sample.frequency, "onset" if slope > 0.0 else "recovery", slope, False, parts)


def _steepest(known: list[Sample], i: int, j: int) -> tuple[float, bool]:
    """|dg/dx| between the nearest marches around samples i < j whose difference is no noise, and whether those are i and j.

    Marches near each other fake steep slopes by their noise, and steep slopes small error bars. 0 where all is noise."""
    sign = 1.0 if known[j].g > known[i].g else -1.0
    pairs = [(a, b) for a in known[: i + 1] for b in known[j:]]
    pairs = [(a, b) for a, b in pairs if sign * (b.g - a.g) > SURE * math.hypot(a.g_std, b.g_std)]
    if not pairs:
        return 0.0, False
    a, b = min(pairs, key=lambda pair: pair[1].x - pair[0].x)
    return abs(b.g - a.g) / (b.x - a.x), a is known[i] and b is known[j]


def _of_three(a: Sample, b: Sample, third: Sample, chord: float, steepest: float) -> tuple[Root | None, float]:
    """The root of the curve through a, b and `third`, or of their weighted line, and its interpolation error in x.

    The curve is a hyperbola, or a parabola where that has a pole between; the two differ by about what a cubic would change.
    Each of curve and line has its error and its noise, and the one with the least of both together is taken: the curve for
    clean marches, the line for noisy ones."""
    three = [a, b, third]
    line = polynomial(three, chord, 1, steepest)
    parabola, bent = polynomial(three, chord, 2, steepest), hyperbola(three, steepest)
    curve = bent or parabola
    if curve is None or line is None:
        return curve or line, math.inf  # a trend that turns before it gets to zero: no telling
    error = 0.5 * abs(chord - curve.x)
    if parabola is not None and bent is not None:
        error = min(error, abs(parabola.x - bent.x))
    error = max(error, UNSEEN * min(abs(curve.x - s.x) for s in three))
    line_error = max(abs(line.x - curve.x), UNSEEN * min(abs(line.x - s.x) for s in three))
    take_curve = math.hypot(curve.noise, error) <= math.hypot(line.noise, line_error)
    return (curve, error) if take_curve else (line, line_error)


def _of_four(a: Sample, b: Sample, thirds: list[Sample], three: Root, error: float, steepest: float) -> tuple[Root, float]:
    """`three` and its `error`, or what the two hyperbolas (or the two parabolas, if they agree better) through a, b and the
    neighbour on either side say together if they say it better: weighted as in Neville's scheme, by the distance of the other
    neighbour, which takes the cubic error away. The error is half of what the two differ by, or what hyperbolas and parabolas
    do."""
    near, triples = three.x, [[thirds[0], a, b], [a, b, thirds[1]]]
    share = (thirds[1].x - near) / (thirds[1].x - thirds[0].x)
    said = []
    for curves in ([hyperbola(t, steepest) for t in triples], [polynomial(t, near, 2, steepest) for t in triples]):
        left, right = curves
        if left is not None and right is not None:
            both = Root(*(share * of_left + (1.0 - share) * of_right for of_left, of_right in zip(left, right, strict=True)))
            said.append((abs(left.x - right.x), both))
    if not said:
        return three, error
    differ, best = min(said)
    best_error = max(0.5 * differ, abs(said[0][1].x - said[-1][1].x), UNSEEN * min(abs(best.x - s.x) for s in (a, b)))
    error = max(error, abs(three.x - best.x))
    return (best, best_error) if math.hypot(best.noise, best_error) < math.hypot(three.noise, error) else (three, error)


def hyperbola(three: list[Sample], steepest: float = math.inf) -> Root | None:
    """The root of g = (x − r) / (p + q x) through three samples; None when its pole lies between them or before the root.

    It does not turn as a parabola does, and bends as growth rates beyond a boundary do (Jarratt and Nudds, The Computer
    Journal 8(1), 1965, doi 10.1093/comjnl/8.1.62). For the noise |slope| is taken as `steepest` at most."""
    x, g = np.array([s.x for s in three]), np.array([s.g for s in three])
    scale = float(np.ptp(x))
    u = (x - x[0]) / scale
    matrix = np.column_stack([np.ones(3), g, u * g])  # r + p g + q u g = u
    spread = np.linalg.svd(matrix / (np.linalg.norm(matrix, axis=0) + 1e-300), compute_uv=False)
    if not spread[-1] > SINGULAR * spread[0]:  # growth rates all alike: no hyperbola; whether a solver says so is its rounding
        return None
    r, p, q = np.linalg.solve(matrix, u)
    shifts = np.linalg.solve(matrix, -np.diag(p + q * u))[0]  # dr/dg of each sample
    below = p + q * np.append(u, r)
    if not (np.all(below > 0.0) or np.all(below < 0.0)):
        return None
    slope = 1.0 / (scale * float(p + q * r))
    noise = scale * float(np.linalg.norm(shifts * np.array([s.g_std for s in three])))
    return Root(float(x[0] + scale * r), noise * max(1.0, abs(slope) / steepest) if steepest else math.inf, slope)


def polynomial(samples: list[Sample], near: float, degree: int, steepest: float = math.inf) -> Root | None:
    """The root nearest to x = `near` of the weighted polynomial g(x); None when it has none.

    To first order the root moves by δg/slope, δg being the polynomial's value there with the samples' noise;
    for the noise |slope| is taken as `steepest` at most."""
    x = np.array([s.x for s in samples]) - near
    size = float(np.max(np.abs(x)))
    std = np.array([s.g_std for s in samples])
    inverse = np.linalg.pinv(np.vander(x / size, degree + 1) / std[:, None]) / std  # from g to coefficients
    c = inverse @ np.array([s.g for s in samples])
    roots = np.roots(c)
    real = roots[np.abs(roots.imag) < 1e-12].real
    if not real.size:
        return None
    nearest = float(real[np.argmin(np.abs(real))])
    slope = float(np.polyval(np.polyder(c), nearest)) / size
    if not slope:
        return None
    noise = float(np.linalg.norm(np.vander([nearest], degree + 1) @ inverse * std))
    return Root(near + size * nearest, noise / min(abs(slope), steepest) if steepest else math.inf, slope)
