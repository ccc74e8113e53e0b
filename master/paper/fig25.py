"""Figure 25: loads of combined pitch and plunge (4 degrees, 5 % of the tank's height) over the frequency."""

from __future__ import annotations

import itertools

from .claims import Claim, at_least
from .combined import PERIODS, Answer, Motion, answers, draw, run, said, tables
from .outcome import Outcome
from .tank import CENTRE, PEAK
from .work import Work

MOTIONS = (
    Motion("(a)", 4.0, 0.05, 3.14), Motion("(b)", 4.0, 0.05, 6.28),
    Motion("(c)", 4.0, 0.05, 12.56), Motion("(d)", 4.0, 0.05, 25.12),
)  # fmt: skip


def make(work: Work) -> Outcome:
    """The four frequencies."""
    motions = work.pick(MOTIONS, MOTIONS[:2])
    found = run(work, motions)
    counted = answers(motions, found)
    conditions = [
        f"{CENTRE}; pitch and plunge in phase, {PERIODS} periods, spectra of the last {PERIODS - 2}; a peak counts from "
        f"{PEAK:.0%} of the highest; frequencies up to eight times the forcing",
        "nonlinear: the part of the lateral force's spectrum that is not at the forcing frequency (rms)",
    ]
    title = "Fig. 25: two-phase slosh, pitch of 4° and plunge of 5 % of the height, half-full tank"
    return Outcome(
        judged(counted), conditions, tables(motions, found, counted), lambda: draw(motions, found, title), said(motions, counted)
    )


def judged(counted: dict[str, dict[str, Answer]]) -> list[Claim]:
    """Each frequency against the one before, and peaks against the lowest frequency's."""
    panels, claims = list(counted), []
    where = "section IV E, Fig. 25"
    for before, now in itertools.pairwise(panels):
        what = (
            f"the answer becomes more nonlinear with the frequency, {before} to {now}: lateral force not at the forcing frequency"
        )
        why = "the first waves (5.2 rad/s) answer most near their own frequency"
        old, new = counted[before]["lateral"].rest, counted[now]["lateral"].rest
        claims.append(at_least(what, where, 100.0 * old, 100.0 * new, why, " %"))
    first, last = (sum(a.peaks for a in counted[panel].values()) for panel in (panels[0], panels[-1]))
    what = f"more peaks in the spectra at the highest frequency {panels[-1]} than at the lowest: all three loads"
    claims.append(at_least(what, where, first + 1, last))
    return claims
