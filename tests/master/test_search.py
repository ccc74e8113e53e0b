"""The search for neutral V_f on growth-rate curves that are known."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from master.search import Crossing, Sample, crossings, propose

Curve = Callable[[float], float]
TOLERANCE = 0.005


def searched(
    curve: Curve, guess: float, low: float = 0.2, high: float = 3.0, std: float = 0.0, seed: int = 0
) -> tuple[list[Sample], list[Crossing]]:
    """Run the proposals to their end."""
    rng, samples = np.random.default_rng(seed), []
    while len(samples) < 15:
        target = propose(samples, guess, low, high, TOLERANCE)
        if target is None:
            break
        assert low <= target <= high
        samples.append(Sample(target, curve(target) + std * rng.standard_normal(), std, 0.9))
    return samples, crossings(samples, TOLERANCE)


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
