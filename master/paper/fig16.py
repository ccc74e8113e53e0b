"""Figure 16: the fuel in the tank at the instants of figure 15."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..base import vtk
from ..pictures import canvas, tank_film
from .claims import Claim, at_least, within
from .outcome import Outcome, Table
from .replay import MACH, V_F, Instant, march, replay
from .work import Work

PERTURBED = 0.05
"""A surface that a picture shows as perturbed: rms rise over the depth."""


def make(work: Work) -> Outcome:
    """The fuel in the motion of fig15."""
    shown = march(work)
    files = replay(work, shown, "slosh_vof")
    fields = [vtk.read(path) for path in files]
    rows = [(i.panel, i.what, i.cycle, *measured(f)) for i, f in zip(shown.instants, fields, strict=True)]
    header = (
        "panel",
        "instant",
        "cycle",
        "share of the tank that is fuel",
        "rms rise of the surface over the depth",
        "fuel at the roof",
    )
    remarks = [
        f"fuel lies on {r[5]:.0%} of the roof at {r[0]}, and its surface stands {r[4]:.2f} depths (rms) off its level"
        for r in rows[1:]
    ] + ["at the tank, 1.8 m behind the axis, a degree of pitch is some 7 g: the fuel is thrown from floor to roof"]
    conditions = [
        "cases/paper_s.toml with two-phase fuel on 100 x 30 cells, the march of fig15; the same motion driven through the "
        "slosh FMU once more: the broken surface is one draw of a chaotic flow",
    ]
    return Outcome(judged(rows), conditions, {"surface": Table(header, rows)}, lambda: draw(shown.instants, fields), remarks)


def measured(field: vtk.Field) -> tuple[float, float, float]:
    """Share of the tank that is fuel, rms rise of the columns over the mean depth, share of the roof's cells that hold fuel."""
    share = np.clip(field.cells["volume_fraction"], 0.0, 1.0)
    columns = share.mean(axis=0)
    return float(share.mean()), float(columns.std() / columns.mean()), float(np.mean(share[-1] > 0.5))


def judged(rows: list[Any]) -> list[Claim]:
    """What the captions say: half full, and perturbed after the forced cycles."""
    worst = max((r[3] for r in rows), key=lambda v: abs(v - 0.5), default=math.nan)
    return [
        within("the tank is half full, at all four instants", "Fig. 16 (a)", 0.5, worst, 1e-3),
        at_least(
            "the surface is perturbed after two forced cycles: rms rise over the depth", "Fig. 16 (b)", PERTURBED, rows[1][4]
        ),
    ]


def draw(instants: list[Instant], fields: list[vtk.Field]) -> Any:
    """A tank an instant, in inertial axes."""
    figure, axes = canvas.subplots(2, 2, figsize=(10, 5.4), layout="constrained")
    for axis, instant, field, window in zip(
        axes.flat, instants, fields, tank_film.windows(np.array([tank_film.box(f) for f in fields])), strict=True
    ):
        axis.grid(False)
        tank_film.draw(axis, field, window, "")
        axis.set_title(f"{instant.panel} {instant.what}: α = {np.degrees(instant.alpha):+.2f}°", fontsize=9.5)
    figure.suptitle(f"Fig. 16: two-phase fuel, Mach {MACH:g}, $V_f$ = {V_F:g}, tank 1.8 m behind the axis", fontsize=11)
    return figure
