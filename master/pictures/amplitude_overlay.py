"""Limit cycles over V_f of several runs in one picture: the bifurcation with each model of the fuel."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ..base import files
from ..results.amplitude_text import trend
from . import canvas, look
from .overlay import COLOURS

MARKS = ("o", "s", "D", "P", "X", "h")  # triangles tell where all motions go
WAYS = {"grow": ("^", 1.25, 1.16), "decay": ("v", 0.8, 0.84)}  # mark, place beside what is drawn, distance from run to run


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
                if row["curve"] and not row["cycles"] and (way := WAYS.get(trend(row))):
                    mark_of_way, edge, apart = way
                    height = (high * edge if edge > 1.0 else low * edge) * apart**n
                    axes.plot(row["V_f"], height, mark_of_way, color=colour, ms=6)
        for mark, word in (("^", "all motions marched grow"), ("v", "all decay")):
            axes.plot([], [], mark, color=look.GREY, label=word)
        axes.plot([], [], "o", color=look.GREY, mfc="white", label="limit cycle not confirmed")
        axes.plot([], [], "o", color=look.GREY, fillstyle="left", markerfacecoloralt="white", label="unstable")
        axes.set(xlabel=look.words("V_f"), ylabel="amplitude of the pitch [deg]", yscale="log")
        look.plain_decades(axes.yaxis)
        canvas.legend(figure, axes)
        figure.suptitle(title, fontsize=10.5)
        path.parent.mkdir(parents=True, exist_ok=True)
        with files.part(path) as hidden:
            figure.savefig(hidden, format="png")
