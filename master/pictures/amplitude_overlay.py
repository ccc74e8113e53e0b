"""Limit cycles over V_f of several runs in one picture: the bifurcation with each model of the fuel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

from ..base import files
from . import canvas, look
from .overlay import COLOURS

MARKS = ("o", "s", "D", "P", "X", "h")  # triangles tell where all motions go


def draw(runs: Mapping[str, Sequence[dict[str, Any]]], title: str, path: Path) -> None:
    """Amplitudes of limit cycles over V_f with ± 2 standard deviations, into the PNG `path`. Raises OSError.

    runs: name → `speeds` of `api.amplitude`'s data. Filled: stable and marched at from a side, or both; white: not confirmed;
    half: unstable. Where a run has no limit cycle at a V_f, an arrow at an edge of the picture says that all motions marched grow
    (up) or decay (down)."""
    with canvas.rc_context(look.STYLE):
        figure, axes = canvas.subplots(figsize=(7.4, 5.2), constrained_layout=True)
        sizes = [c["amplitude_deg"] for rows in runs.values() for row in rows for c in row["cycles"]]
        sizes += [p["amplitude_deg"] for rows in runs.values() for row in rows for p in row["curve"]]
        low, high = (min(sizes), max(sizes)) if sizes else (0.1, 1.0)
        for n, (name, rows) in enumerate(runs.items()):
            colour, mark = COLOURS[n % len(COLOURS)], MARKS[n % len(MARKS)]
            stable = [(row["V_f"], c) for row in rows for c in row["cycles"] if c["stable"]]
            axes.plot([v for v, _ in stable], [c["amplitude_deg"] for _, c in stable], color=colour, lw=1.0)
            axes.plot([], [], mark, color=colour, label=name)
            for row in rows:
                for c in row["cycles"]:
                    whole = "full" if c["stable"] else "left"
                    face = colour if c["confirmed"] else "white"
                    error = 2.0 * c["std_deg"]
                    size = c["amplitude_deg"]
                    bar = [[min(error, 0.9 * size)], [error]]  # the axis is logarithmic
                    axes.errorbar(row["V_f"], size, bar, color=colour, ls="", capsize=3, lw=1.0)
                    axes.plot(row["V_f"], size, mark, color=colour, fillstyle=whole, mfc=face, markerfacecoloralt="white")
                way = _way(row)
                if way:
                    height = (high * 1.25 if way > 0 else low / 1.25) * (1.0 + 0.16 * way) ** n
                    axes.plot(row["V_f"], height, "^" if way > 0 else "v", color=colour, ms=6)
        for mark, word in (("^", "all motions marched grow"), ("v", "all decay")):
            axes.plot([], [], mark, color=look.GREY, label=word)
        axes.plot([], [], "o", color=look.GREY, mfc="white", label="limit cycle not confirmed")
        axes.plot([], [], "o", color=look.GREY, fillstyle="left", markerfacecoloralt="white", label="unstable")
        axes.set(xlabel=look.words("V_f"), ylabel="amplitude of the pitch [deg]", yscale="log")
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.yaxis.set_minor_formatter(NullFormatter())
        canvas.legend(figure, axes)
        figure.suptitle(title, fontsize=10.5)
        path.parent.mkdir(parents=True, exist_ok=True)
        with files.part(path) as hidden:
            figure.savefig(hidden, format="png")


def _way(row: dict[str, Any]) -> int:
    """Where motions of all amplitudes marched go at a V_f without limit cycle: 1 up, -1 down, 0 otherwise."""
    rates = np.array([p["growth_rate"] for p in row["curve"]])
    if row["cycles"] or not rates.size or (rates.min() < 0.0 < rates.max()):
        return 0
    return 1 if rates.max() > 0.0 else -1
