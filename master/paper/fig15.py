"""Figure 15: the flow around the section with fuel at Mach 0.80, V_f 0.70: steady, forced, and in the fifth free cycle."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..base import vtk
from ..pictures import canvas, look, mach_field
from .claims import Claim, word
from .outcome import Outcome, Table
from .replay import MACH, V_F, Instant, Replay, march, replay
from .work import Work


def make(work: Work) -> Outcome:
    """The march with two-phase fuel, and the flow at the paper's four instants."""
    shown = march(work)
    files = replay(work, shown, "aero")
    fields = [vtk.read(path).scaled(shown.chord, shown.elastic_axis) for path in files]
    rows = [
        (i.panel, i.what, i.cycle, np.degrees(i.alpha), i.h_over_b, float(f.cells["mach"].max()))
        for i, f in zip(shown.instants, fields, strict=True)
    ]
    header = ("panel", "instant", "cycle", "pitch [deg]", "h/b [–]", "highest local Mach number")
    remarks = [
        f"{shown.said}; neutral V_f at this Mach number: fig21",
        "the paper contradicts itself: with fuel it flutters at V_f 0.70 here, while its dry section is damped at 0.78 "
        "(section IV B) and its conclusion is a higher V_f with sloshing",
        "highest local Mach number: " + ", ".join(f"{r[0]} {r[-1]:.3f}" for r in rows),
    ]
    conditions = [
        "cases/paper_s.toml (Isogai A ratios) with two-phase fuel, forced pitch of 1°, two forced and five free cycles; "
        "fields from the same motion driven through the aero FMU once more",
    ]
    return Outcome([judged(shown)], conditions, {"instants": Table(header, rows)}, lambda: draw(shown.instants, fields), remarks)


def judged(shown: Replay) -> Claim:
    """The caption's word."""
    why = "with fuel V_f 0.70 lies below every boundary of ours at this Mach number: fig21"
    what = "motion with fuel at Mach 0.80, V_f 0.70, fifth free cycle"
    return word(what, "Fig. 15 (c) and section IV D", "going into flutter", shown.verdict, ("flutter", "limit cycle"), why)


def draw(instants: list[Instant], fields: list[vtk.Field]) -> Any:
    """A panel an instant."""
    low, high = mach_field.limits(fields)
    figure, axes = canvas.subplots(2, 2, figsize=(9.6, 7.6), sharex=True, sharey=True, layout="constrained")
    for axis, instant, field in zip(axes.flat, instants, fields, strict=True):
        axis.grid(False)
        mesh = mach_field.draw(axis, field, low, high)
        axis.set(xlim=mach_field.WINDOW[:2], ylim=mach_field.WINDOW[2:], aspect="equal")
        axis.set_title(f"{instant.panel} {instant.what}: α = {np.degrees(instant.alpha):+.2f}°", fontsize=9.5)
    for axis in axes[-1]:
        axis.set_xlabel("chordwise place $x/c$ [–]")
    for axis in axes[:, 0]:
        axis.set_ylabel("height $y/c$ [–]")
    figure.colorbar(mesh, ax=axes, label="local Mach number [–] (white line: 1)", shrink=0.85, extend="min")
    figure.suptitle(f"Fig. 15: Mach {MACH:g}, $V_f$ = {V_F:g}, two-phase fuel, Euler flow", fontsize=11, color=look.INK)
    return figure
