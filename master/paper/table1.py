"""Table 1: what flow, training and surrogate cost, and when training has paid."""

from __future__ import annotations

from typing import Any

from ..pictures import canvas, look
from .claims import Claim, at_least
from .outcome import Outcome, Table
from .work import Work

PAPER = {"CFD, 100 steps": 289.56, "training data, 900 steps": 2382.48, "training": 160.20, "surrogate, 100 steps": 14.51}
SAVINGS = 94.98  # [%]


def make(work: Work) -> Outcome:
    """CPU seconds as fig14 measured them."""
    costs = work.shared("surrogate_costs", lambda: measured(work))
    ours = {
        "CFD, 100 steps": 100 * costs["flow"], "training data, 900 steps": 900 * costs["flow"], "training": costs["training"],
        "surrogate, 100 steps": 100 * costs["surrogate"],
    }  # fmt: skip
    rows = [(name, PAPER[name], seconds) for name, seconds in ours.items()]
    rows += [("savings [%]", saved(PAPER), saved(ours)), ("steps after which training has paid", pays(PAPER), pays(ours))]
    conditions = [
        "CPU seconds of this machine, one core; our two-phase solver on 100 x 30 cells, steps of 0.02 s; training with the "
        "search of 18 candidates; the paper's machine and mesh are not ours, so only the savings are compared",
    ]
    remarks = [
        f"the paper leaves training out of its savings; with it, its surrogate pays after {pays(PAPER):.0f} steps, ours after "
        f"{pays(ours):.0f}: our solver is {PAPER['CFD, 100 steps'] / ours['CFD, 100 steps']:.0f} times cheaper",
    ]
    tables = {"costs": Table(("what", "paper [s]", "ours [s]"), rows)}
    return Outcome([judged(saved(ours))], conditions, tables, lambda: draw(ours), remarks)


def measured(work: Work) -> dict[str, float]:
    """The seconds, where fig14 was not computed here before."""
    from . import fig14

    fig14.make(work)
    return dict(work.shared("surrogate_costs", dict))


def saved(seconds: dict[str, float]) -> float:
    """The paper's savings [%]: surrogate against CFD, training not counted."""
    return 100.0 * (1.0 - seconds["surrogate, 100 steps"] / seconds["CFD, 100 steps"])


def pays(seconds: dict[str, float]) -> float:
    """Steps after which data and training are paid for."""
    gain = 0.01 * (seconds["CFD, 100 steps"] - seconds["surrogate, 100 steps"])
    return (seconds["training data, 900 steps"] + seconds["training"]) / gain


def judged(savings: float) -> Claim:
    """At least the paper's."""
    return at_least("computational savings of the surrogate, training left out", "Table 1", SAVINGS, savings, "", " %")


def draw(ours: dict[str, float]) -> Any:
    """Both columns, in logarithms."""
    figure, axis = canvas.subplots(figsize=(8.0, 4.6), layout="constrained")
    for shift, label, seconds, colour in ((0.2, "paper", PAPER, look.GREY), (-0.2, "here", ours, look.BLUE)):
        places = [-k + shift for k in range(len(PAPER))]
        axis.barh(places, list(seconds.values()), 0.36, color=colour, label=label)
        for place, value in zip(places, seconds.values(), strict=True):
            axis.text(value * 1.3, place, f"{value:,.0f} s" if value >= 100 else f"{value:.3g} s", va="center", fontsize=9)
    axis.set_yticks([-k for k in range(len(PAPER))], list(PAPER))
    axis.set(xscale="log", xlabel="CPU time [s]", xlim=(min(ours.values()) / 3, 3e4))
    figure.suptitle("Table 1: cost of two-phase slosh and of the paper's surrogate", fontsize=11)
    canvas.legend(figure, axis)
    return figure
