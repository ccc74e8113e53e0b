"""Figure 22: lateral force in fast pitch (1 degree at 100 rad/s), two-phase flow against potential theory."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..pictures import canvas, look
from .claims import Claim, at_least
from .outcome import Outcome, Table
from .tank import ABOUT, Loads, driven
from .work import Work

OMEGA, ALPHA = 100.0, math.radians(1.0)
SECONDS, SHORT, SAMPLE = 4.0, 0.4, 0.02  # the paper's time and sampling [s]
ARM = 1.8  # of the tank behind the elastic axis, as in cases/paper_s.toml [m]
AXES = {"section's axis": ARM, "tank's centre": 0.0}
APART = 0.5
""""Cannot predict": the rms difference is at least half the standard deviation of the flow's force."""


def make(work: Work) -> Outcome:
    """Both models through the same motion, about the section's axis and about the tank's centre."""
    periods = round(work.pick(SECONDS, SHORT) * OMEGA / (2 * math.pi))
    found = {name: pair(work, periods, arm) for name, arm in AXES.items()}
    flow, linear = found["section's axis"]
    late = flow.time >= 0.5 * flow.time[-1]
    apart = {name: difference(*both, late) for name, both in found.items()}
    said = "rms difference over the flow's standard deviation, second half"
    remarks = [f"{said}: about the {name} {value:.2f}" for name, value in apart.items()]
    remarks += [
        f"a degree at 100 rad/s is {ARM * ALPHA * OMEGA**2 / 9.81:.0f} g at the tank of the section, "
        f"{0.25 * ALPHA * OMEGA**2 / 9.81:.1f} g at the ends of a tank that turns about its centre: the fuel is thrown about, "
        "far above the slosh frequencies (5.2 rad/s and up); it is not a resonance",
        "the paper's samples of 0.02 s are 3.14 a period: its curve is aliased, the picture shows both samplings",
    ]
    conditions = [
        f"{ABOUT}; judged: about the section's elastic axis, {ARM:g} m ahead of the tank (\"the tank attached to the wing "
        f'section"; '
        f"chord of 2 m, so that the tank fits), beside it about the tank's centre; {flow.time[-1]:.2f} s, 60 samples a period",
        f"differs: {APART:g} of the standard deviation or more, second half of the motion",
    ]
    rows = [
        (name, *(float(v) for v in r)) for name, (a, b) in found.items() for r in zip(a.time, a.lateral, b.lateral, strict=True)
    ]
    tables = {"force": Table(("axis", "time [s]", "two-phase flow [N/m]", "potential theory [N/m]"), rows)}
    return Outcome([judged(apart["section's axis"])], conditions, tables, lambda: draw(flow, linear), remarks)


def pair(work: Work, periods: int, arm: float) -> tuple[Loads, Loads]:
    """Loads by the two-phase flow and by linear theory."""
    flow, linear = (driven(work, model, OMEGA, periods, alpha=ALPHA, arm=arm) for model in ("slosh_vof", "slosh_ems"))
    return flow, linear


def difference(flow: Loads, linear: Loads, part: Any) -> float:
    """Rms difference of the lateral force over the standard deviation of the flow's, on `part` of the samples."""
    a, b = flow.lateral[part], linear.lateral[part]
    return float(np.sqrt(np.mean((a - b) ** 2)) / a.std())


def judged(found: float) -> Claim:
    """The paper: linear potential theory cannot predict the force."""
    what = "at 100 rad/s linear theory cannot predict the lateral force: rms difference over standard deviation"
    return at_least(what, "section IV E, Fig. 22", APART, found, "linear theory still tells the larger part of the force here")


def draw(flow: Loads, linear: Loads) -> Any:
    """The last periods in full, and all of it as the paper samples it."""
    figure, (top, low) = canvas.subplots(2, 1, figsize=(9.0, 7.4), layout="constrained")
    last = flow.time >= flow.time[-1] - 8 * 2 * math.pi / OMEGA
    every = np.unique(np.searchsorted(flow.time, np.arange(0.0, flow.time[-1], SAMPLE)))
    for axis, part, mark in ((top, np.flatnonzero(last), ""), (low, every, ".")):
        for loads, colour, name in ((flow, look.ORANGE, "two-phase flow"), (linear, look.BLUE, "potential theory (EMS)")):
            axis.plot(loads.time[part], loads.lateral[part], marker=mark, ms=3, lw=1.0, color=colour, label=name)
        axis.set(ylabel="lateral force [N/m]", xlabel="time [s]")
    top.set_title("the last eight periods, 60 samples a period")
    low.set_title(f"all of it every {SAMPLE:g} s, as the paper samples it (3.14 a period: aliased)")
    figure.suptitle("Fig. 22: pitch of 1° at 100 rad/s, half-full tank 1.8 m behind the axis", fontsize=11)
    canvas.legend(figure, top)
    return figure
