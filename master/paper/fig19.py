"""Figure 19: what each further mode adds to the force."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...fmus.tank.modes import modes
from ..pictures import canvas, look
from .claims import Claim, within
from .outcome import Outcome, Table
from .tank import Array, tank
from .work import Work

COUNT, FOURTH = 8, 1.14  # modes; what the fourth adds by the paper [%], section IV E
TOLERANCE = 0.1  # [%]
LABELS = {
    "slow sway": "slow sway (sum of the masses)", "sway at 3.14 rad/s": "sway at 3.14 rad/s", "sway at 6.28 rad/s": "sway "
    "at 6.28 rad/s",
    "pitch at 100 rad/s": "pitch at 100 rad/s",
}  # fmt: skip


def make(work: Work) -> Outcome:
    """Sums over the modes under four motions."""
    box = tank(work)
    m = modes(box, COUNT)
    lever = m.height + box.gravity / m.omega**2
    terms = {
        "slow sway": m.mass,
        "sway at 3.14 rad/s": m.mass * m.omega**2 / (m.omega**2 - 3.14**2),
        "sway at 6.28 rad/s": m.mass * m.omega**2 / (m.omega**2 - 6.28**2),
        "pitch at 100 rad/s": m.mass * lever * m.omega**2 / (m.omega**2 - 100.0**2),
    }
    sums = {name: np.cumsum(term) for name, term in terms.items()}
    added = {name: 100.0 * float(s[3] / s[2] - 1.0) for name, s in sums.items()}
    claims = judged(added, {name: float(abs(s[2] / s[-1])) for name, s in sums.items()})
    remarks = ["the fourth mode adds " + ", ".join(f"{value:+.2f} % ({name})" for name, value in added.items())]
    conditions = [
        "the paper does not say which motion its force is of: slow sway, where the force is the sum of the masses, is judged; "
        "equations as corrected (docs/ems.md)"
    ]
    rows = [(k + 1, *(float(s[k]) for s in sums.values())) for k in range(COUNT)]
    header = ("modes", *(f"{name} [kg]" if "pitch" not in name else f"{name} [kg m]" for name in sums))
    return Outcome(claims, conditions, {"sums": Table(header, rows)}, lambda: draw(sums), remarks)


def judged(added: dict[str, float], three: dict[str, float]) -> list[Claim]:
    """The fourth mode's part [%] and the first three modes' share of eight, by motion."""
    why = "the paper does not name its motion; none of those tried gives 1.14 %: see remarks"
    return [
        within("the first three modes hold nearly all of the modal force: share", "section IV E", 1.0, three["slow sway"], 0.02),
        within("the fourth mode adds", "section IV E, Fig. 19", FOURTH, added["slow sway"], TOLERANCE, why, " %"),
    ]


def draw(sums: dict[str, Array]) -> Any:
    """Sums over their last value."""
    figure, axis = canvas.subplots(figsize=(7.0, 5.2), layout="constrained")
    for (name, s), colour, mark in zip(sums.items(), (look.BLUE, look.SKY, look.PURPLE, look.ORANGE), "os^x", strict=True):
        axis.plot(range(1, COUNT + 1), s / s[-1], marker=mark, color=colour, mfc="none", label=LABELS[name])
    axis.set(xlabel="number of modes [–]", ylabel="modal force over that of eight modes [–]")
    figure.suptitle("Fig. 19: cumulative modal force, linear slosh, half-full tank", fontsize=11)
    canvas.legend(figure, axis, columns=2)
    return figure
