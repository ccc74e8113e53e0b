"""The search for neutral V_f on curves that marches drew (tests/data/growth_rates.csv names the commands): how many marches it
takes from no prior knowledge, that is from any first V_f, and whether its error bar holds. Between the marches of a curve σ/V_f
is interpolated (monotone cubic in ln V_f)."""

from __future__ import annotations

import csv
import math
from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from aeroslosh.master.analysis.crossings import Crossing, Sample
from aeroslosh.master.boundary.next_march import crossings, propose
from support.paths import DATA

TABLE = DATA / "growth_rates.csv"
LOW, HIGH, TOLERANCE = 0.2, 3.0, 0.005
ANYWHERE = np.geomspace(LOW, HIGH, 40)
ONE_CROSSING = ["0.6", "0.65", "0.7", "0.75", "0.775", "0.8", "0.825", "0.85"]  # Mach numbers, isogai_a
NAMED = [0.3, 0.612, 1.0, 1.5]


@dataclass
class Curve:
    """What a march at any V_f in [0.2, 3] would tell."""

    V_f: np.ndarray  # of the marches (n,)
    grew: np.ndarray  # out of reach (n,)
    damping: PchipInterpolator  # ln V_f → σ/V_f
    log_std: PchipInterpolator  # ln V_f → ln of the growth rate's standard deviation
    frequency: PchipInterpolator

    def sample(self, V_f: float, rng: np.random.Generator | None = None) -> Sample:
        """A march at `V_f`; beside one that grew out of reach it does so, too. With `rng` it has its noise."""
        i = int(np.clip(np.searchsorted(self.V_f, V_f), 1, self.V_f.size - 1))
        if self.grew[i - 1] or self.grew[i]:
            return Sample(V_f, math.nan, math.nan, math.nan, grows=True)
        x = math.log(V_f)
        std = math.exp(self.log_std(x))
        noise = 0.0 if rng is None else std * rng.standard_normal()
        return Sample(V_f, V_f * float(self.damping(x)) + noise, std, float(self.frequency(x)))

    def roots(self) -> np.ndarray:
        """True neutral V_f, rising. Shape: (n_roots,)."""
        return np.exp(np.sort(self.damping.roots(extrapolate=False)))


@cache
def curve(name: str, mach: str) -> Curve:
    """A curve of the table."""
    with TABLE.open(encoding="utf-8", newline="") as stream:
        lines = csv.DictReader(line for line in stream if not line.startswith("#"))
        rows = [r for r in lines if (r["case"], r["mach"]) == (name, mach)]
    known = [r for r in rows if r["growth_rate"]]
    V_f, rate, std, frequency = (np.array([float(r[key]) for r in known]) for key in ("V_f", "growth_rate", "std", "frequency"))
    x = np.log(V_f)
    return Curve(
        np.array([float(r["V_f"]) for r in rows]),
        np.array([r["grows"] == "1" for r in rows]),
        PchipInterpolator(x, rate / V_f),
        PchipInterpolator(x, np.log(np.maximum(std, 1e-7))),
        PchipInterpolator(x, frequency),
    )


def searched(
    c: Curve, guess: float, slope: float | None = None, rng: np.random.Generator | None = None
) -> tuple[list[Sample], list[Crossing]]:
    """The marches of a search, and the crossings that met the tolerance."""
    samples: list[Sample] = []
    while len(samples) < 12 and (target := propose(samples, float(guess), LOW, HIGH, TOLERANCE, slope)) is not None:
        samples.append(c.sample(target, rng))
    return samples, [found for found in crossings(samples, TOLERANCE, slope) if found.met]


def miss(c: Curve, found: Crossing) -> float:
    """V_f less the nearest true one."""
    roots = c.roots()
    return found.V_f - float(roots[np.argmin(np.abs(roots - found.V_f))])


@pytest.mark.parametrize("mach", ONE_CROSSING)
def test_six_marches_from_anywhere(mach: str) -> None:
    """Half a percent in at most six marches from every first V_f between 0.2 and 3, and the error bar holds the rest."""
    c = curve("isogai_a_none", mach)
    for guess in ANYWHERE:
        samples, [found] = searched(c, guess)
        assert len(samples) <= 6, (guess, [s.V_f for s in samples])
        assert abs(miss(c, found)) <= TOLERANCE * found.V_f
        assert abs(miss(c, found)) <= 2.0 * found.uncertainty


@pytest.mark.parametrize("mach", [*ONE_CROSSING, "0.86", "0.875"])
def test_fewer_from_the_usual_guesses(mach: str) -> None:
    marches = [len(searched(curve("isogai_a_none", mach), guess)[0]) for guess in NAMED]
    assert max(marches) <= 6 and np.mean(marches) <= 5


def test_frozen_fuel() -> None:
    c = curve("paper_s_frozen", "0.8")
    for guess in ANYWHERE:
        samples, [found] = searched(c, guess)
        assert len(samples) <= 6 and abs(miss(c, found)) <= TOLERANCE * found.V_f


@pytest.mark.parametrize("mach", ["0.86", "0.875"])
def test_several_crossings(mach: str) -> None:
    """Onset, recovery, second onset: whichever is found is one. Up to 3/4 of the recovery it is the first onset, in six marches;
    beyond, in the damped gap too, where marches see neither recovery nor second onset, it may take two more."""
    c = curve("isogai_a_none", mach)
    first, recovery, _ = c.roots()
    for guess in ANYWHERE:
        samples, [found] = searched(c, guess)
        assert abs(miss(c, found)) <= TOLERANCE * found.V_f
        assert len(samples) <= (6 if guess < 0.75 * recovery else 8), (guess, [s.V_f for s in samples])
        if guess < 0.75 * recovery:
            assert found.V_f == pytest.approx(first, rel=TOLERANCE)


@pytest.mark.parametrize("mach", ["0.89", "0.9"])
def test_a_flat_hill_takes_more_marches_but_is_not_misread(mach: str) -> None:
    """σ/V_f hardly changes between onset and recovery: 0.506 to 1.62 at Mach 0.89, 0.72 to 1.27 at 0.90. Not every search there
    meets the tolerance; those that say so are right within their error bar (three of it)."""
    c = curve("isogai_a_none", mach)
    marches = []
    for guess in ANYWHERE:
        samples, found = searched(c, guess)
        marches.append(len(samples))
        assert all(abs(miss(c, f)) <= max(TOLERANCE * f.V_f, 3.0 * f.uncertainty) for f in found)
    assert np.median(marches) <= 6


@pytest.mark.parametrize("mach", [*ONE_CROSSING, "0.86", "0.875", "0.89", "0.9"])
def test_three_marches_when_a_linear_model_predicted_the_crossing(mach: str) -> None:
    """First onset predicted to within a percent (it is to within 0.9, docs/boundary.md), its slope to within a quarter."""
    c = curve("isogai_a_none", mach)
    first = float(c.roots()[0])
    slope = float(c.damping.derivative()(math.log(first)))
    for off in (0.99, 0.995, 1.0, 1.005, 1.01):
        for wrong in (0.8, 1.0, 1.25):
            samples, [found] = searched(c, off * first, wrong * slope)
            assert len(samples) <= 3
            assert abs(miss(c, found)) <= min(TOLERANCE * first, 2.0 * found.uncertainty)


def test_the_error_bar_covers_noise_and_interpolation() -> None:
    """Errors over error bars of searches with the fits' noise: rms near 1, two in a hundred beyond 3."""
    ratios = []
    for mach in ONE_CROSSING:
        c, rng = curve("isogai_a_none", mach), np.random.default_rng(1)
        ratios += [miss(c, f) / f.uncertainty for guess in ANYWHERE for f in searched(c, guess, rng=rng)[1]]
    assert len(ratios) >= 0.98 * len(ONE_CROSSING) * ANYWHERE.size
    assert 0.5 < float(np.sqrt(np.mean(np.square(ratios)))) < 1.2
    assert float(np.mean(np.abs(ratios) > 3.0)) < 0.02
