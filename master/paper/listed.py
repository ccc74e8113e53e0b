"""The section that the paper's text lists (x_alpha 0.25, r_alpha² 0.75, mu 75), which its figures are not of."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..api.case import Case
from ..api.point import Point, point
from ..pictures import canvas, look
from .boundaries import coarse, crossings
from .claims import Claim, between, word
from .outcome import Outcome, Table
from .work import Work

LISTED = {
    "section.x_alpha": 0.25, "section.r2_alpha": 0.75, "section.frequency_ratio": 1.0, "section.mass_ratio": 75.0,
    "section.elastic_axis": 0.2,
}  # fmt: skip
"""Section II. The elastic axis is not told: a = -0.6, that of Thomas, Dowell and Hall's section with these ratios."""
THIN = 0.4045  # neutral V_f at Mach 0.80 by Possio's equation (tests/support/possio.py)
MACH, DAMPED, FLUTTER = 0.80, 0.78, 0.86


def make(work: Work) -> Outcome:
    """Its boundary at Mach 0.80, and the paper's two motions there."""
    found = crossings(work, "isogai_a", "none", (MACH,), LISTED)
    onset = [c for p in found for c in p["crossings"] if c["direction"] == "onset"]
    points = {V_f: march(work, LISTED, V_f) for V_f in (DAMPED, FLUTTER)}
    isogai = march(work, {}, DAMPED)
    first = min(onset, key=lambda c: float(c["V_f"])) if onset else None
    V_f = float(first["V_f"]) if first else math.nan
    doubt = float(first["V_f_uncertainty"] or 0.0) if first else math.nan
    remarks = [
        f"listed parameters: onset at V_f {V_f:.4f} ± {doubt:.4f} (thin airfoil in linear flow: {THIN:.4f}); the motions at "
        f"{DAMPED:g} and {FLUTTER:g} are at {DAMPED / V_f:.2f} and {FLUTTER / V_f:.2f} times that",
        f"Isogai A at V_f {DAMPED:g}: {isogai}",
        "so the figures are of Isogai's case A: x_alpha 1.8, r² 3.48, mu 60, 100 rad/s, the elastic axis half a chord ahead "
        "of the section",
    ]
    conditions = [
        "x_alpha 0.25, r² 0.75, omega_h = omega_alpha, mu 75 (section II); the axis is not told, a = -0.6 is taken (x/c = "
        "0.2); 6.2831 rad/s is a scale only in a dry section; dry, forced pitch of 1°",
    ]
    rows = [("listed", p.V_f, str(p.verdict), p.growth_rate, p.frequency) for p in points.values()]
    rows += [("Isogai A", isogai.V_f, str(isogai.verdict), isogai.growth_rate, isogai.frequency)]
    tables = {
        "motions": Table(("parameters", "V_f", "verdict", "growth rate [omega_alpha]", "frequency [omega_alpha]"), rows),
        "onset": Table(("Mach", "V_f", "standard deviation"), [(MACH, V_f, doubt)]),
    }  # fmt: skip
    claims = judged(V_f, str(points[DAMPED].verdict))
    return Outcome(claims, conditions, tables, lambda: draw({"listed parameters": points[DAMPED], "Isogai A": isogai}), remarks)


def march(work: Work, changes: dict[str, Any], V_f: float) -> Point:
    """One motion."""
    return point(coarse(work, Case.isogai_a().changed(changes)), mach=MACH, V_f=V_f, fmus=work.fmus)


def judged(onset: float, at_damped: str) -> list[Claim]:
    """The paper's motions at Mach 0.80 against the section that its text lists."""
    why = "the listed parameters are not those of the figures, which are Isogai's case A"
    return [
        between("onset at Mach 0.80 with the listed parameters: damped at V_f 0.78, flutter at 0.86", "sections II and IV B",
                DAMPED, FLUTTER, onset, why),
        word(f"motion at Mach 0.80, V_f {DAMPED:g} with the listed parameters", "section IV B", "damped", at_damped, (), why),
    ]  # fmt: skip


def draw(points: dict[str, Point]) -> Any:
    """Pitch of both sections at V_f 0.78."""
    figure, axes = canvas.subplots(len(points), 1, figsize=(8.4, 6.4), layout="constrained")
    for axis, (name, p) in zip(axes, points.items(), strict=True):
        cycles = p.history["tau"].values / (2 * np.pi)
        release = cycles[int(p.history.attrs["release_index"])]
        axis.axvspan(0.0, release, color=look.GREY, alpha=0.12, lw=0, label="forced")
        axis.plot(cycles, np.degrees(p.history["alpha"].values), color=look.BLUE, label="pitch, Euler flow, no fuel")
        axis.set(ylabel="pitch α, nose-up [deg]", title=f"{name}: {p.verdict}")
    axes[-1].set_xlabel("time, in cycles $\\omega_\\alpha t / 2\\pi$ [–]")
    figure.suptitle(f"Mach {MACH:.2f}, $V_f$ = {DAMPED:.2f}, where the paper's section is damped", fontsize=11)
    canvas.legend(figure, axes[0])
    return figure
