"""The picture of a flutter boundary: neutral V_f and frequency over Mach, linear and marched, branch by branch."""

from __future__ import annotations

import csv
import math
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from ..boundary.next_march import Crossing
from ..boundary.search import BoundaryPoint, State
from ..case.fuel_tank import LABEL, holds
from ..linear.model import LinearCrossing
from ..results import trust
from . import canvas as plt
from . import look
from .look import BLUE, CROSSING_MARKS, CROSSINGS, GREY, ORANGE, PURPLE, STYLE

NEAR = 0.45  # crossings of neighbouring Mach numbers further apart than this in ln V_f and ln frequency are not joined
Found = Crossing | LinearCrossing


def branches(rows: list[tuple[float, list[Found]]]) -> list[list[tuple[float, Found]]]:
    """Join crossings of neighbouring Mach numbers: same direction, near in V_f and frequency, nearest first.

    `rows`: (mach, crossings), in rising Mach number. Each branch is a list of (mach, crossing)."""
    done: list[list[tuple[float, Found]]] = []
    growing: list[list[tuple[float, Found]]] = []
    for mach, crossings in rows:
        pairs = sorted(
            (_distance(branch[-1][1], c), i, j)
            for i, branch in enumerate(growing)
            for j, c in enumerate(crossings)
            if branch[-1][1].name == c.name
        )
        taken: dict[int, int] = {}
        for distance, i, j in pairs:
            if distance < NEAR and j not in taken and i not in taken.values():
                taken[j] = i
        ended = [b for i, b in enumerate(growing) if i not in taken.values()]
        done += ended
        growing = [[*(growing[taken[j]] if j in taken else []), (mach, c)] for j, c in enumerate(crossings)]
    return done + growing


def _distance(a: Found, b: Found) -> float:
    frequency = math.log(b.frequency / a.frequency) if min(a.frequency, b.frequency) > 0.0 else 0.0
    return math.hypot(math.log(b.V_f / a.V_f), frequency)


def draw(points: list[BoundaryPoint], path: Path, reference: Path | None = None, slosh: str = "none") -> None:
    """Neutral V_f with error bars, the linear model's as thin lines, every march as a dot, published points; frequency below."""
    points = sorted(points, key=lambda p: p.mach)
    with plt.rc_context(STYLE):
        figure, (top, low) = plt.subplots(
            2, 1, figsize=(7.4, 8.0), sharex=True, gridspec_kw={"height_ratios": [2.2, 1.0]}, constrained_layout=True
        )
        liquid = f", {LABEL[slosh]}" if slosh != "none" else ""
        frozen = ", frozen liquid" if slosh != "none" else ""  # what the linear model carries, whatever the slosh model
        for grows, color, label in ((False, BLUE, "march: damped"), (True, ORANGE, "march: growing")):
            dots = [(p.mach, s.V_f) for p in points for s in p.samples if s.known and (s.growth_rate > 0) is grows]
            if dots:
                top.plot(*zip(*dots, strict=True), ".", color=color, ms=4, alpha=0.6, label=label, zorder=2)
        linear = [(p.mach, [q.crossing for q in p.predictions]) for p in points if p.predictions]
        for branch in branches([(m, list(c)) for m, c in linear]):
            machs, values = [m for m, _ in branch], [c.V_f for _, c in branch]
            color = CROSSINGS[branch[0][1].name]
            top.plot(machs, values, "-", marker="." if len(branch) == 1 else "", color=color, lw=0.8, ms=3, zorder=1)
            low.plot(machs, [c.frequency for _, c in branch], "-", color=color, lw=0.8, zorder=1)
        marched = [(p.mach, [c for c in p.crossings if c.source == "march"]) for p in points]
        for branch in branches([(m, list(c)) for m, c in marched]):
            if not linear:
                top.plot([m for m, _ in branch], [c.V_f for _, c in branch], "-", color=GREY, lw=0.8, zorder=1)
                low.plot([m for m, _ in branch], [c.frequency for _, c in branch], "-", color=GREY, lw=0.8, zorder=1)
        for direction, mark in CROSSING_MARKS.items():
            found = [(m, c.V_f, c.uncertainty, c.frequency) for m, cs in marched for c in cs if c.name == direction]
            if not found:
                continue
            mach, value, error, frequency = (np.array(column) for column in zip(*found, strict=True))
            style = {"fmt": mark, "color": CROSSINGS[direction], "mfc": "white", "mew": 1.3, "ms": 5.5, "zorder": 3}
            top.errorbar(mach, value, yerr=2.0 * error, capsize=3, label=f"{direction}{liquid}, marched (± 2 sd)", **style)
            low.errorbar(mach, frequency, **style)
        doubtful = [
            (p.mach, c.V_f) for p in points for c in p.crossings
            if c.source == "march" and not holds(trust.of_crossing(c, p.marches), trust.largest_edge(p.marches))
        ]  # fmt: skip
        if doubtful:
            style = {"color": PURPLE, "ms": 11, "mew": 1.6, "zorder": 5}
            top.plot(*zip(*doubtful, strict=True), "x", label="slosh model does not hold: undetermined", **style)
        missed = [(p.mach, q.crossing.V_f) for p in points for q in p.predictions if q.state is State.CONTRADICTED]
        if missed:
            top.plot(*zip(*missed, strict=True), "x", color=PURPLE, ms=6, label="linear, not confirmed", zorder=3)
        for direction, shade in CROSSINGS.items():
            if any(c.name == direction for _, cs in linear for c in cs):
                top.plot([], [], "-", color=shade, lw=0.8, label=f"{direction}{frozen}, linear model")
        if reference is not None:
            _published(top, reference, points[0].mach - 0.05, points[-1].mach + 0.05)
        top.set_ylabel(look.SPEED_INDEX)
        low.set_ylabel(look.FREQUENCY)
        low.set_xlabel(look.MACH)
        span = " to ".join(dict.fromkeys(f"{p.mach:g}" for p in (points[0], points[-1])))
        text = f"{LABEL[slosh]}, Mach {span}: neutral $V_f$; growing above an onset, damped above a recovery"
        top.set_title(text, fontsize=10)
        top.margins(y=0.08)
        top.set_xlim(points[0].mach - 0.01, points[-1].mach + 0.01)
        plt.legend(figure, top)
        figure.savefig(path)


def _published(axis: Axes, file: Path, low: float, high: float) -> None:
    """Points of a CSV file with low <= mach <= high: mach, V_f, state; '#' lines are comments."""
    marks = {"neutral": "s", "damped": "v", "diverging": "^"}
    with file.open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(line for line in stream if not line.startswith("#")))
    drawn: set[str] = set()
    for row in rows:
        if not low <= float(row["mach"]) <= high:
            continue
        state = row["state"]
        axis.plot(
            float(row["mach"]),
            float(row["V_f"]),
            marks.get(state, "x"),
            color="black",
            mfc="none",
            ms=8,
            label=None if state in drawn else f"Srivastava et al.: {state}",
            zorder=4,
        )
        drawn.add(state)
