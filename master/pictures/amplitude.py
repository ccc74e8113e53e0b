"""Damping over amplitude at each V_f, and the limit cycles over V_f."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..case.fuel_tank import LABEL
from . import canvas, look


def draw(data: dict[str, Any], path: Path) -> None:
    """A PNG of `api.amplitude`'s data. Raises OSError."""
    speeds = data["speeds"]
    with canvas.rc_context(look.STYLE):
        figure, (left, right) = canvas.subplots(1, 2, figsize=(10.0, 4.6), constrained_layout=True)
        shades = look.even(len(speeds))
        for row, colour in zip(speeds, shades, strict=True):
            points = row["curve"]
            sizes, rates, errors = ([p[k] for p in points] for k in ("amplitude_deg", "growth_rate", "standard_error"))
            left.errorbar(sizes, rates, errors, color=colour, marker=".", capsize=2, label=f"$V_f$ {row['V_f']:g}")
        left.axhline(0.0, color=look.INK, lw=0.8)
        left.set(xscale="log", xlabel="amplitude of the pitch [deg]", ylabel=look.GROWTH)
        for stable, colour, mark, word in (
            (True, look.BLUE, "o", "stable limit cycle"),
            (False, look.ORANGE, "^", "unstable limit cycle"),
        ):
            mine = [(row["V_f"], c) for row in speeds for c in row["cycles"] if c["stable"] is stable]
            if mine:
                sure = [c["confirmed"] != "" for _, c in mine]
                x, y = np.array([v for v, _ in mine]), np.array([c["amplitude_deg"] for _, c in mine])
                e = np.array([c["std_deg"] for _, c in mine])
                right.errorbar(x, y, e, color=colour, ls="", capsize=3)
                for shown, face, extra in ((True, colour, ""), (False, "white", ", not confirmed")):
                    these = np.array(sure) == shown
                    if these.any():
                        right.plot(x[these], y[these], mark, color=colour, mfc=face, ls="", label=word + extra)
        for row in speeds:
            if not row["cycles"] and row["curve"]:
                grows = row["curve"][-1]["growth_rate"] > 0.0
                word = "all grow" if grows else "all decay"
                span = [row["curve"][0]["amplitude_deg"], row["curve"][-1]["amplitude_deg"]]
                right.plot(
                    [row["V_f"]] * 2, span, color=look.ORANGE if grows else look.BLUE, ls="--" if grows else "-", label=word
                )
        right.set(xlabel=look.words("V_f"), ylabel="amplitude of the pitch [deg]", yscale="log")
        for axis in (left.xaxis, right.yaxis):
            look.plain_decades(axis)
        canvas.legend(figure, left, right)
        figure.suptitle(
            f"{LABEL.get(data['slosh'], data['slosh'])}, Mach {data['mach']:g}: {data['free_cycles']:g} free cycles a march",
            fontsize=11,
        )
        figure.savefig(path)
