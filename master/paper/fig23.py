"""Figure 23: lateral force over the amplitude of a slow forced pitch, 1 to 8 degrees."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..pictures import canvas, look
from .claims import Claim, at_most
from .outcome import Outcome, Table
from .tank import CENTRE, amplitude, driven
from .work import Work

OMEGA, PERIODS = 3.14, 10
DEGREES = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0)
LINEAR = 10.0
"""Linear to the eye: no force is off the line through the origin by more than 10 %."""


def make(work: Work) -> Outcome:
    """Largest force of the settled motion at each amplitude, by the flow and by linear theory."""
    periods = work.pick(PERIODS, 3)
    rows = []
    for degrees in work.pick(DEGREES, DEGREES[:2]):
        sizes = []
        for model in ("slosh_vof", "slosh_ems"):
            loads = driven(work, model, OMEGA, periods, alpha=math.radians(degrees))
            sizes.append(amplitude(loads.lateral[loads.settled]))
        rows.append((degrees, *sizes))
    found = departure([r[0] for r in rows], [r[1] for r in rows])
    conditions = [
        f"{CENTRE}; the paper does not tell its frequency: {OMEGA:g} rad/s, that of its Fig. 24 (0.60 of the first natural "
        f"frequency); half the range of the force from the third to period {periods}",
        f"linear: no amplitude off the best line through the origin by more than {LINEAR:g} %",
    ]
    first = rows[0][1] / rows[0][0]
    remarks = [
        f"force a degree, over that at {rows[0][0]:g}°: " + ", ".join(f"{d:g}° {f / d / first:.3f}" for d, f, _ in rows),
        f"linear theory has {rows[0][2] / rows[0][0]:.2f} N/m a degree, the flow {first:.2f} at {rows[0][0]:g}°",
    ]
    tables = {"force": Table(("pitch [deg]", "two-phase flow [N/m]", "potential theory [N/m]"), rows)}
    return Outcome([judged(found)], conditions, tables, lambda: draw(rows), remarks)


def departure(x: list[float], y: list[float]) -> float:
    """The largest distance of a point from the best line through the origin, over the line [%]."""
    a, b = np.array(x), np.array(y)
    slope = float(a @ b / (a @ a))
    return 100.0 * float(np.max(np.abs(b / (slope * a) - 1.0)))


def judged(found: float) -> Claim:
    """The paper: linear with the amplitude."""
    what = "the lateral force is linear in the amplitude, 1° to 8°: largest departure from a line"
    return at_most(what, "section IV E, Fig. 23", LINEAR, found, "waves become steep at the larger angles", " %")


def draw(rows: list[Any]) -> Any:
    """Force over amplitude."""
    figure, axis = canvas.subplots(figsize=(7.0, 5.2), layout="constrained")
    x = [r[0] for r in rows]
    axis.plot(x, [r[1] for r in rows], "D", color=look.ORANGE, mfc="none", label="two-phase flow")
    axis.plot(x, [r[2] for r in rows], "-", color=look.BLUE, label="potential theory (EMS)")
    axis.set(xlabel="amplitude of the pitch [deg]", ylabel="amplitude of the lateral force [N/m]", xlim=(0, None), ylim=(0, None))
    figure.suptitle(f"Fig. 23: forced pitch at {OMEGA:g} rad/s, half-full tank", fontsize=11)
    canvas.legend(figure, axis)
    return figure
