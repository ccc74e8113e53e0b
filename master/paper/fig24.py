"""Figure 24: loads of combined pitch and plunge at 3.14 rad/s over the amplitude."""

from __future__ import annotations

from .claims import Claim, at_most
from .combined import PERIODS, Answer, Motion, answers, draw, run, said, tables
from .outcome import Outcome
from .tank import CENTRE, PEAK
from .work import Work

MOTIONS = (
    Motion("(a)", 1.0, 0.025, 3.14), Motion("(b)", 2.0, 0.05, 3.14),
    Motion("(c)", 4.0, 0.10, 3.14), Motion("(d)", 6.0, 0.15, 3.14),
)  # fmt: skip
MOST = 2  # peaks, section IV E


def make(work: Work) -> Outcome:
    """The four amplitudes."""
    motions = work.pick(MOTIONS, MOTIONS[-1:])
    found = run(work, motions)
    counted = answers(motions, found)
    conditions = [
        f"{CENTRE}; pitch and plunge in phase, {PERIODS} periods, spectra of the last {PERIODS - 2}; a peak counts from "
        f"{PEAK:.0%} of the highest; frequencies up to eight times the forcing",
    ]
    title = "Fig. 24: two-phase slosh, pitch and plunge at 3.14 rad/s, half-full tank"
    claims = [judged(counted)]
    return Outcome(
        claims, conditions, tables(motions, found, counted), lambda: draw(motions, found, title), said(motions, counted)
    )


def judged(counted: dict[str, dict[str, Answer]]) -> Claim:
    """The most peaks of any load in panel (d)."""
    most = max(a.peaks for a in counted["(d)"].values())
    what = "few peaks in the spectra of the largest motion: the most of the three loads"
    return at_most(what, "section IV E, Fig. 24 (d)", MOST, most, "harmonics of steep waves, and free waves that last")
