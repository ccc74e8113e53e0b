"""Figure 12: the flutter boundary without fuel, against the motions that the paper tells at four Mach numbers."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..pictures import canvas, look
from .boundaries import crossings
from .claims import Claim, between, within
from .outcome import Outcome, Table
from .work import Work

MACH = (0.80, 0.825, 0.85, 0.875)
SHARE = 0.05
"""A point that the paper calls neutral, found by stepping V_f until motions look neutral, is good to about 5 %."""


class Crossing(NamedTuple):
    """A neutral V_f with its standard deviation."""

    mach: float
    direction: str
    V_f: float
    doubt: float
    frequency: float


def make(work: Work) -> Outcome:
    """The boundary of Isogai's case A."""
    points = crossings(work, "isogai_a", "none", work.pick(MACH, (MACH[1],)))
    found = [
        Crossing(p["mach"], c["direction"], c["V_f"], c["V_f_uncertainty"] or 0.0, c["frequency"])
        for p in points
        for c in p["crossings"]
        if c["kind"] == "flutter"
    ]
    conditions = [
        "Isogai A ratios (the figure's), Euler flow; linear model of the air and two to three marches a crossing, error bars "
        "of fit, mesh, outer boundary and amplitude; the paper does not list its Mach numbers: 0.80 of its text and those of "
        "Fig. 11",
        f"a V_f that the paper calls neutral counts as good to {SHARE:.0%}: it steps V_f until a motion of five cycles looks "
        "neutral",
    ]
    remarks = ["above an onset lie a recovery and a second onset from Mach 0.85 on, which the paper does not look for"]
    header = ("Mach", "direction", "V_f", "V_f standard deviation", "frequency [omega_alpha]")
    tables = {"boundary": Table(header, found)}
    return Outcome(judged(found), conditions, tables, lambda: draw(found), remarks)


def judged(found: list[Crossing]) -> list[Claim]:
    """What the paper tells at each Mach number that was computed."""
    first = {c.mach: c for c in sorted(found, key=lambda c: -c.V_f) if c.direction == "onset"}
    claims = []
    if 0.80 in first:
        what = "onset at Mach 0.80: damped at V_f 0.78, flutter at 0.86"
        claims.append(between(what, "section IV B", 0.78, 0.86, first[0.80].V_f))
    if 0.825 in first:
        what, why = "neutral V_f at Mach 0.825", "the paper's motion at 0.612 may still grow slowly"
        claims.append(within(what, "Fig. 11 (a)", 0.612, first[0.825].V_f, SHARE * 0.612, why))
    if 0.85 in first:
        claims.append(between("onset at Mach 0.85: damped at V_f 0.439", "Fig. 11 (b)", 0.439, math.inf, first[0.85].V_f))
    if 0.875 in first:
        above = [c.V_f for c in found if c.mach == 0.875 and c.direction == "recovery" and c.V_f > first[0.875].V_f]
        what = "at Mach 0.875 V_f 1.420 diverges: it lies above the onset"
        claims.append(between(what, "Fig. 11 (c)", -math.inf, 1.420, first[0.875].V_f))
        if above:
            claims.append(between("and below the recovery", "Fig. 11 (c)", 1.420, math.inf, min(above)))
    return claims


def draw(found: list[Crossing]) -> Any:
    """Crossings over Mach number, with the paper's motions."""
    figure, axis = canvas.subplots(figsize=(7.4, 5.8), layout="constrained")
    for direction, mark in (("onset", "o"), ("recovery", "D")):
        mine = [c for c in found if c.direction == direction]
        if mine:
            x, y, e = [c.mach for c in mine], [c.V_f for c in mine], [2.0 * c.doubt for c in mine]
            colour = look.CROSSINGS[direction]
            axis.errorbar(x, y, e, fmt=mark, color=colour, mfc="none", capsize=3, label=f"{direction}, ours (± 2 s.d.)")
    first = {c.mach: c.V_f for c in sorted(found, key=lambda c: -c.V_f) if c.direction == "onset"}
    axis.plot(sorted(first), [first[m] for m in sorted(first)], color=look.ORANGE, lw=1.0)
    for (mark, label), points in {
        ("v", "damped"): [(0.80, 0.78), (0.85, 0.439)], ("P", "neutral"): [(0.825, 0.612)],
        ("^", "flutter"): [(0.80, 0.86), (0.875, 1.42)],
    }.items():  # fmt: skip
        axis.plot(*zip(*points, strict=True), mark, color=look.INK, ms=7, mfc="none", label=f"paper: {label}")
    axis.set(xlabel=look.MACH, ylabel=look.SPEED_INDEX)
    figure.suptitle("Fig. 12: neutral $V_f$ without fuel, NACA 64A010, Isogai A, Euler flow", fontsize=11)
    canvas.legend(figure, axis, columns=3)
    return figure
