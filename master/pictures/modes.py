"""The picture of V–g and V–f curves at one Mach number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.ticker import FormatStrFormatter, NullFormatter

from ..boundary import modes
from ..boundary.search import BoundaryPoint
from ..case.fuel_tank import LABEL
from . import canvas, look
from .look import BLUE, GREY, ORANGE, PURPLE, SKY, STYLE

COLORS = (BLUE, ORANGE, PURPLE, SKY, "#8A6D00")
WORST = 0.35  # growth rates drawn


def draw(point: BoundaryPoint, low: float, high: float, path: Path) -> None:
    """Growth rate and frequency of every mode over V_f, the marches as dots, neutral V_f as vertical lines."""
    curves = modes.modes(point.linear, low, high) if point.linear is not None else []
    with canvas.rc_context(STYLE):
        figure, (top, bottom) = canvas.subplots(
            2, 1, figsize=(7.4, 7.0), sharex=True, gridspec_kw={"height_ratios": [1.6, 1.0]}, constrained_layout=True
        )
        for i, mode in enumerate(curves):
            static = not np.nanmax(np.nan_to_num(mode["frequency"], nan=-1.0)) > 0.0
            style = {"color": GREY if static else COLORS[i % len(COLORS)], "ls": "--" if static else "-", "lw": 1.2}
            top.plot(mode["V_f"], mode["growth_rate"], label="real pole (static)" if static else f"mode {i + 1}", **style)
            if not static:
                bottom.plot(mode["V_f"], mode["frequency"], **style)
        dots = modes.marched(point)
        if dots:
            V_f, growth, frequency = (np.array(column) for column in zip(*dots, strict=True))
            top.plot(V_f, growth, "o", color="black", mfc="white", ms=4.5, label="march", zorder=4)
            bottom.plot(V_f, frequency, "o", color="black", mfc="white", ms=4.5, zorder=4)
        top.axhline(0.0, color="black", lw=0.8)
        names = [f"{c.name} {c.V_f:.3f}" for c in point.crossings]
        for c in point.crossings:
            for axis in (top, bottom):
                axis.axvline(c.V_f, color=GREY, lw=0.8, ls=":")
        values = [m["growth_rate"] for m in curves] + [np.array([d[1] for d in dots])]
        seen = np.concatenate([v[np.isfinite(v) & (np.abs(v) < WORST)] for v in values] or [np.zeros(1)])
        size = max(0.02, float(np.max(np.abs(seen), initial=0.0)))
        top.set_ylim(max(-WORST, 1.1 * min(float(np.min(seen, initial=0.0)), -0.2 * size)), min(WORST, 1.1 * size))
        top.set_xscale("log")
        bottom.set_xscale("log")
        bottom.set_xlim(low, high)
        bottom.xaxis.set_major_formatter(FormatStrFormatter("%g"))
        bottom.xaxis.set_minor_formatter(FormatStrFormatter("%g") if high < 20.0 * low else NullFormatter())
        top.set_ylabel(look.GROWTH + ", above 0: unstable")
        bottom.set_ylabel(look.FREQUENCY)
        bottom.set_xlabel(look.SPEED_INDEX)
        top.set_title(f"{_model(point)}Mach {point.mach:g}: " + (", ".join(names) if names else "no neutral $V_f$"))
        if curves or dots:
            canvas.legend(figure, top, columns=4)
        figure.savefig(path)


def _model(point: BoundaryPoint) -> str:
    """What the marches were made with, and what the linear model carries, where that is another."""
    model = point.marches[0].slosh if point.marches else point.case.slosh.model if point.case is not None else "none"
    carried = "; curves: frozen liquid" if point.linear is not None and model not in ("none", "frozen") else ""
    return f"{LABEL[model]}{carried}, "
