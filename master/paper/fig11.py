"""Figure 11: the paper's three free motions of the Isogai A section, neutral, damped and diverging."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..api.case import Case
from ..api.point import Point, point
from ..pictures import canvas, look
from .boundaries import coarse
from .claims import Claim, at_most, word
from .outcome import Outcome, Table
from .work import Work

CYCLES, LONG = 5.0, 14.0  # free cycles: the paper's, and those until a limit cycle is reached
NEUTRAL = 10.0
"""By how much [%] an amplitude may change within the paper's five free cycles and still look neutral in a plot of them."""


class Shown(NamedTuple):
    """A panel of the paper: Mach number, V_f, its word, free cycles marched here."""

    panel: str
    mach: float
    V_f: float
    word: str
    cycles: float


PANELS = (
    Shown("(a)", 0.825, 0.612, "neutral", CYCLES),
    Shown("(b)", 0.850, 0.439, "damped", CYCLES),
    Shown("(c)", 0.875, 1.420, "diverging", LONG),
)


def make(work: Work) -> Outcome:
    """The three marches."""
    points = [march(work, shown) for shown in PANELS]
    claims = [judged(shown, *growth(p)) for shown, p in zip(PANELS, points, strict=True)]
    remarks = [f"{shown.panel} {p}" for shown, p in zip(PANELS, points, strict=True)]
    size = points[2].data["limit_cycle_amplitude_deg"]
    if size is not None:
        remarks.append(f"(c) grows from 1° and saturates in a limit cycle of {size:.2f}° in pitch after the paper's five cycles")
    conditions = [
        f"Isogai A ratios (the figures are of these, not of the parameters that the text lists: see `listed`), {CYCLES:g} free "
        f"cycles, {LONG:g} in (c) to see where the growth ends",
        f"neutral to the eye: the pitch amplitude changes by at most {NEUTRAL:g} % within five free cycles",
    ]
    rows = [
        (shown.panel, float(t), float(h), float(np.degrees(a)))
        for shown, p in zip(PANELS, points, strict=True)
        for t, h, a in zip(p.history["tau"].values, p.history["h_over_b"].values, p.history["alpha"].values, strict=True)
    ]
    tables = {
        "motions": Table(("panel", "omega_alpha t [rad]", "h/b [–]", "pitch [deg]"), rows),
        "verdicts": Table(
            ("panel", "Mach", "V_f", "verdict", "growth rate [omega_alpha]", "uncertainty", "frequency [omega_alpha]"),
            [(s.panel, s.mach, s.V_f, str(p.verdict), p.growth_rate, p.growth_rate_uncertainty, p.frequency)
             for s, p in zip(PANELS, points, strict=True)],
        ),
    }  # fmt: skip
    return Outcome(claims, conditions, tables, lambda: draw(points), remarks)


def march(work: Work, shown: Shown) -> Point:
    """One panel."""
    case = Case.isogai_a().replace(flutter={"free_cycles": work.pick(shown.cycles, 3.0)})
    return point(coarse(work, case), mach=shown.mach, V_f=shown.V_f, fmus=work.fmus)


def growth(p: Point) -> tuple[float, float]:
    """By how much [%] the envelope of the flutter mode changes over five free cycles, and the largest |pitch| of the last free
    cycle over the first one's."""
    free = p.history.isel(time=slice(int(p.history.attrs["release_index"]), None))
    tau, alpha = free["tau"].values - float(free["tau"][0]), np.abs(free["alpha"].values)
    first, last = alpha[tau <= 2 * np.pi].max(), alpha[tau >= tau[-1] - 2 * np.pi].max()
    change = 100.0 * (math.exp(2 * np.pi * CYCLES * p.growth_rate) - 1.0) if math.isfinite(p.growth_rate) else math.nan
    return change, float(last / first)


def judged(shown: Shown, change: float, ratio: float) -> Claim:
    """A panel's word against our motion: `change` [%] of the flutter mode over five cycles, `ratio` of last to first pitch."""
    where, what = f"Fig. 11 {shown.panel}", f"motion at Mach {shown.mach:g}, V_f {shown.V_f:g}"
    if shown.word == "neutral":
        return at_most(f"{what} is neutral: change of amplitude over five cycles", where, NEUTRAL, abs(change), "", " %")
    return word(f"{what}", where, shown.word, "diverging" if ratio > 1.0 else "damped")


def draw(points: list[Point]) -> Any:
    """Plunge and pitch, a row a panel."""
    figure, rows = canvas.subplots(len(PANELS), 2, figsize=(10, 8.5), layout="constrained")
    for shown, p, axes in zip(PANELS, points, rows, strict=True):
        cycles = p.history["tau"].values / (2 * np.pi)
        release = cycles[int(p.history.attrs["release_index"])]
        for axis, name, scale, label in (
            (axes[0], "h_over_b", 1.0, "plunge $h/b$, down [–]"), (axes[1], "alpha", 180.0 / np.pi, "pitch α, nose-up [deg]"),
        ):  # fmt: skip
            axis.axvspan(0.0, release, color=look.GREY, alpha=0.12, lw=0, label="forced")
            axis.plot(cycles, scale * p.history[name].values, color=look.BLUE, label="free motion, Euler flow, no fuel")
            axis.set(ylabel=label)
        said = f"{shown.panel} Mach {shown.mach:.3f}, $V_f$ = {shown.V_f:.3f}"
        axes[0].set_title(f"{said}: {p.verdict}")
        axes[1].set_title(f"paper: {shown.word}")
    for axis in rows[-1]:
        axis.set_xlabel("time, in cycles $\\omega_\\alpha t / 2\\pi$ [–]")
    figure.suptitle(
        "Fig. 11: NACA 64A010, Isogai A, Euler flow, no fuel: ours on the left, the paper's word on the right", fontsize=11
    )
    canvas.legend(figure, rows[0][0])
    return figure
