"""The search for neutral V_f on growth-rate curves that are known. Marched curves: test_search_marched.py."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from aeroslosh.master.analysis.crossings import Crossing, Sample
from aeroslosh.master.boundary.next_march import crossings, propose
from aeroslosh.master.boundary.search import outcome_text

Curve = Callable[[float], float]
TOLERANCE = 0.005


def searched(
    curve: Curve,
    guess: float,
    low: float = 0.2,
    high: float = 3.0,
    std: float = 0.0,
    seed: int = 0,
    tolerance: float = TOLERANCE,
) -> tuple[list[Sample], list[Crossing]]:
    """Run the proposals to their end."""
    rng, samples = np.random.default_rng(seed), []
    while len(samples) < 15:
        target = propose(samples, guess, low, high, tolerance)
        if target is None:
            break
        assert low <= target <= high
        samples.append(Sample(target, curve(target) + std * rng.standard_normal(), std, 0.9))
    return samples, crossings(samples, tolerance)


CURVES: list[tuple[str, Curve, float]] = [
    ("like Isogai's", lambda v: 0.075 * (v - 0.595), 0.595),
    ("curved", lambda v: 0.04 * ((v / 0.595) ** 2 - 1.0) - 0.02 * (v - 0.595) ** 3, 0.595),
    ("steep", lambda v: 1.0 * (v - 0.8), 0.8),
    ("logarithmic", lambda v: 0.05 * math.log(v / 1.5), 1.5),
    ("exponential", lambda v: 0.02 * (math.exp(3.0 * (v - 0.6)) - 1.0), 0.6),
]


@pytest.mark.parametrize(("name", "curve", "root"), CURVES, ids=[c[0] for c in CURVES])
def test_few_marches_from_a_near_guess(name: str, curve: Curve, root: float) -> None:
    samples, found = searched(curve, 1.03 * root)
    assert len(found) == 1 and found[0].direction == "onset"
    assert found[0].V_f == pytest.approx(root, rel=TOLERANCE / 5)
    assert len(samples) <= 4


@pytest.mark.parametrize("guess", [0.3, 1.0, 2.5])
@pytest.mark.parametrize(("name", "curve", "root"), CURVES, ids=[c[0] for c in CURVES])
def test_any_guess_ends_at_the_root(name: str, curve: Curve, root: float, guess: float) -> None:
    samples, found = searched(curve, guess)
    assert found[0].V_f == pytest.approx(root, rel=TOLERANCE / 3)
    assert len(samples) <= 12


def test_noise_goes_into_the_uncertainty() -> None:
    ratios = []
    for seed in range(30):
        _, found = searched(CURVES[0][1], 0.612, std=1e-4, seed=seed)
        assert len(found) == 1
        ratios.append((found[0].V_f - 0.595) / found[0].uncertainty)
    assert 0.3 < np.sqrt(np.mean(np.square(ratios))) < 2.0


def test_no_crossing_scans_the_range_and_ends() -> None:
    for rate in (-0.01, 0.01):
        samples, found = searched(lambda v, r=rate: r, 0.6)
        assert not found
        assert min(s.V_f for s in samples) == pytest.approx(0.2) and max(s.V_f for s in samples) == pytest.approx(3.0)


def test_every_crossing_of_the_marches_is_reported_with_its_direction() -> None:
    """An S-shaped boundary: onset, recovery, onset."""
    samples = [Sample(v, 0.05 * (v - 0.55) * (v - 1.3) * (v - 2.2), 1e-5, 0.9) for v in np.arange(0.4, 2.6, 0.1)]
    found = crossings(samples, TOLERANCE)
    assert [c.direction for c in found] == ["onset", "recovery", "onset"]
    assert [c.V_f for c in found] == pytest.approx([0.55, 1.3, 2.2], rel=1e-3)
    assert all(c.bracketed for c in found)


def test_failed_marches_are_stepped_back_from() -> None:
    samples, found = searched(lambda v: math.nan if v > 0.64 else 0.075 * (v - 0.6), 0.7)
    assert found[0].V_f == pytest.approx(0.6, rel=TOLERANCE)
    assert not samples[0].known


def test_all_marches_failing_ends() -> None:
    samples, found = searched(lambda v: math.nan, 0.7)
    assert len(samples) == 3 and not found


def test_a_bracket_in_which_marches_fail_does_not_meet_the_tolerance() -> None:
    """The search ends, as no march can narrow the root down; it must not say that it did."""
    known = [Sample(v, 0.075 * (v - 0.595), 1e-6, 0.9) for v in (0.4, 0.5, 0.7)]
    samples = [*known, Sample(0.6, math.nan, math.nan, math.nan)]
    assert propose(samples, 0.5, 0.2, 3.0, TOLERANCE) is None
    [found] = crossings(samples, TOLERANCE)
    assert found.bracketed and not found.met
    assert "tolerance not met in 4 marches" in outcome_text([found], samples, 0.2, 3.0, len(samples), None)


def test_noise_above_the_tolerance_does_not_meet_it() -> None:
    """A growth rate known to 1e-3 gives V_f to 1e-3 / 0.075 = 2 percent: half a percent would be luck, 10 percent is had."""
    met = [any(c.met for c in searched(CURVES[0][1], 0.7, std=1e-3, seed=seed)[1]) for seed in range(20)]
    assert np.mean(met) < 0.2
    met = [any(c.met for c in searched(CURVES[0][1], 0.7, std=1e-3, seed=seed, tolerance=0.1)[1]) for seed in range(20)]
    assert all(met)


def test_a_trend_that_turns_before_the_axis_is_no_crossing() -> None:
    samples = [Sample(v, -1e-5 - 0.05 * (v - 0.6) ** 2, 1e-7, 0.9) for v in (0.59, 0.6, 0.61)]
    assert not crossings(samples, TOLERANCE)


def test_a_motion_that_grew_out_of_reach_tells_its_sign() -> None:
    """No growth rate above V_f = 1.2: the search goes down from there until marches tell more, and never says "failed"."""

    def marched(V_f: float) -> Sample:
        if V_f > 1.2:
            return Sample(V_f, math.nan, math.nan, math.nan, grows=True)
        return Sample(V_f, 0.075 * (V_f - 0.595), 1e-6, 0.9)

    samples: list[Sample] = []
    while (target := propose(samples, 3.0, 0.2, 3.0, TOLERANCE)) is not None:
        samples.append(marched(target))
    [found] = crossings(samples, TOLERANCE)
    assert found.met and found.V_f == pytest.approx(0.595, rel=TOLERANCE) and len(samples) <= 6
    text = outcome_text([], [Sample(3.0, math.nan, math.nan, math.nan, grows=True)], 0.2, 3.0, 1, None)
    assert text == "no crossing found: growing in V_f 3.000 to 3.000 (1 march)"


@pytest.mark.parametrize("wrong", [0.8, 1.0, 1.25])
@pytest.mark.parametrize(("name", "curve", "root"), CURVES, ids=[c[0] for c in CURVES])
def test_two_or_three_marches_when_place_and_slope_are_known(name: str, curve: Curve, root: float, wrong: float) -> None:
    """As the linear model tells them: V_f within a percent, the slope within a quarter."""
    slope = wrong * (curve(root + 1e-6) - curve(root - 1e-6)) / 2e-6
    samples: list[Sample] = []
    while (target := propose(samples, 1.01 * root, 0.2, 3.0, TOLERANCE, slope)) is not None:
        samples.append(Sample(target, curve(target), 1e-6, 0.9))
    [found] = crossings(samples, TOLERANCE, slope)
    assert 2 <= len(samples) <= 3
    assert found.met and abs(found.V_f - root) < 2.0 * found.uncertainty


@pytest.mark.parametrize("wrong", [0.8, 1.0, 1.25])
@pytest.mark.parametrize("off", [0.98, 0.99, 0.9965, 1.0, 1.0035, 1.01, 1.02])
@pytest.mark.parametrize(("name", "curve", "root"), CURVES, ids=[c[0] for c in CURVES])
def test_one_march_where_the_linear_model_was_right_more_where_not(
    name: str, curve: Curve, root: float, off: float, wrong: float
) -> None:
    """One where the root is a Newton step of 0.4 % away: a quarter of the tolerance by a slope known to 0.3 of itself."""
    slope = wrong * (curve(root + 1e-6) - curve(root - 1e-6)) / 2e-6
    samples: list[Sample] = []
    while (target := propose(samples, off * root, 0.2, 3.0, TOLERANCE, slope, 1)) is not None:
        samples.append(Sample(target, curve(target), 1e-6, 0.9))
    [found] = crossings(samples, TOLERANCE, slope, 1)
    assert found.met and abs(found.V_f - root) < max(2.0 * found.uncertainty, 1e-9)
    if abs(off - 1.0) <= 0.0035 / max(1.0, 1.0 / wrong):
        assert len(samples) == 1 and not found.bracketed and found.direction == "onset"
    elif abs(off - 1.0) >= 0.01:
        assert 2 <= len(samples) <= 4 and abs(found.V_f / root - 1.0) < 0.25 * TOLERANCE


def test_one_march_that_tells_no_growth_rate_is_none() -> None:
    lost = Sample(0.6, math.nan, math.nan, math.nan)
    assert crossings([lost], TOLERANCE, 0.1, 1) == [] and propose([lost], 0.6, 0.2, 3.0, TOLERANCE, 0.1, 1) is not None
    noisy = Sample(0.6, 1e-5, 1e-3, 0.9)
    assert crossings([noisy], TOLERANCE, 0.1, 1) == [] and propose([noisy], 0.6, 0.2, 3.0, TOLERANCE, 0.1, 1) is not None


def test_a_crossing_that_nothing_narrows_down_has_a_finite_error_bar() -> None:
    """JSON has no infinity: three marches whose differences are noise alone."""
    samples = [Sample(v, s, 1e-3, 0.9) for v, s in ((0.5, -1e-5), (0.6, 2e-5), (0.7, 1e-5))]
    [found] = crossings(samples, TOLERANCE)
    assert math.isfinite(found.uncertainty) and found.uncertainty >= found.V_f and not found.met
