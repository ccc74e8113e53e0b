"""Mean, scatter and verdict of an ensemble, on growth rates drawn from a known distribution."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.master.analysis.members import Ensemble, Member
from aeroslosh.master.analysis.verdict import Verdict

BAND = 5e-4


def drawn(mean: float, sd: float, n: int, seed: int = 0, verdict: Verdict | None = None) -> Ensemble:
    rates = mean + sd * np.random.default_rng(seed).standard_normal(n)
    verdicts = [verdict or (Verdict.FLUTTER if r > 0.0 else Verdict.DAMPED) for r in rates]
    return Ensemble(tuple(Member(k, float(r), 1e-5, 0.97, v) for k, (r, v) in enumerate(zip(rates, verdicts, strict=True))))


def test_the_mean_is_within_two_standard_errors_as_often_as_it_should_be() -> None:
    """Eight members: Student's 2 of 7 degrees of freedom holds 91 % of the means."""
    off = [abs(e.mean - 0.01) / e.error for e in (drawn(0.01, 0.001, 8, seed) for seed in range(400))]
    assert 0.86 < np.mean(np.array(off) < 2.0) < 0.96


@pytest.mark.parametrize(
    ("mean", "sd", "verdict"),
    [
        (0.004, 0.005, Verdict.FLUTTER),
        (-0.004, 0.005, Verdict.DAMPED),
        (1e-5, 1e-4, Verdict.NEUTRAL),
        (0.0, 0.01, Verdict.UNDETERMINED),
    ],
)
def test_verdict_is_that_of_the_mean(mean: float, sd: float, verdict: Verdict) -> None:
    said = drawn(mean, sd, 100).judged(BAND)
    assert said.verdict is verdict
    assert (said.remedy != "") == (verdict is Verdict.UNDETERMINED)


def test_members_that_agree_need_no_mean() -> None:
    said = drawn(0.0, 0.01, 4, verdict=Verdict.LIMIT_CYCLE).judged(BAND)
    assert said.verdict is Verdict.LIMIT_CYCLE and said.reason.startswith("all of 4 members")


def test_a_member_without_growth_rate_is_counted_but_not_averaged() -> None:
    lost = Member(9, math.nan, math.nan, math.nan, Verdict.UNDETERMINED)
    whole = drawn(0.01, 0.001, 4)
    some = Ensemble((*whole.members, lost))
    assert some.mean == whole.mean and len(some.members) == 5
    assert some.as_data()["growth_rates"][-1] is None
    other = Ensemble((*whole.members, Member(9, 0.3, 1e-5, 2.5, Verdict.FLUTTER)))  # an impact's pole
    assert other.mean == whole.mean and other.as_data()["seeds"][-1] == 9
    alone = Ensemble((whole.members[0], lost))
    assert alone.judged(BAND).verdict is Verdict.UNDETERMINED


def test_divergence_in_some_members_is_no_verdict_of_the_others() -> None:
    grown = Member(9, 0.2, 1e-3, 0.0, Verdict.DIVERGENCE)
    said = Ensemble((*drawn(-0.01, 0.001, 6).members, grown)).judged(BAND)
    assert said.verdict is Verdict.UNDETERMINED and "divergence" in said.reason


def test_a_member_without_a_growth_rate_leaves_no_mean() -> None:
    one = Ensemble((Member(0, -0.02, 1e-3, 0.97, Verdict.DAMPED), Member(1, math.nan, math.nan, math.nan, Verdict.UNDETERMINED)))
    said = one.judged(BAND)
    assert said.verdict is Verdict.UNDETERMINED and "1 of them with a growth rate" in said.reason and "nan" not in said.reason
    all_alike = Ensemble(tuple(Member(k, math.nan, math.nan, math.nan, Verdict.FLUTTER) for k in range(2)))
    assert all_alike.judged(BAND).verdict is Verdict.FLUTTER and "nan" not in all_alike.judged(BAND).reason
