"""Boundaries of several runs in one picture: dry against fuel, one section against another."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base import files
from . import canvas, look

COLOURS = (look.BLUE, look.ORANGE, look.PURPLE, look.SKY, look.INK, look.GREY)
MARKS = {"onset": "o", "recovery": "D", "divergence": "^"}
LINES = ("-", "--", "-.", ":")


def draw(runs: Mapping[str, Sequence[dict[str, Any]]], path: Path) -> None:
    """Neutral V_f with error bars (± 2 standard deviations) over Mach number, frequency below, into the PNG `path`.

    runs: name → rows of `results.boundary_table.rows`. The lowest onsets of a run are joined by a line; those whose slosh
    model does not hold, are crossed."""
    with canvas.rc_context(look.STYLE):
        figure, (top, low) = canvas.subplots(
            2, 1, figsize=(7.4, 8.0), sharex=True, gridspec_kw={"height_ratios": [2.2, 1.0]}, constrained_layout=True
        )
        for n, (name, rows) in enumerate(runs.items()):
            colour, dash = COLOURS[n % len(COLOURS)], LINES[n % len(LINES)]
            known = [row for row in rows if row["V_f"] is not None]
            first = {row["mach"]: row for row in reversed(known) if kind(row) == "onset"}
            for axis, key in ((top, "V_f"), (low, "frequency")):
                machs = sorted(first)
                axis.plot(machs, [first[m][key] for m in machs], color=colour, ls=dash, lw=1.0)
            for word, mark in MARKS.items():
                mine = [row for row in known if kind(row) == word]
                if not mine:
                    continue
                mach, V_f, frequency = (np.array([row[k] for row in mine], dtype=float) for k in ("mach", "V_f", "frequency"))
                error = 2.0 * np.array([row["V_f_uncertainty"] or 0.0 for row in mine])
                style: dict[str, Any] = {"fmt": mark, "color": colour, "mfc": "white", "mew": 1.3, "ms": 5.5}
                top.errorbar(mach, V_f, yerr=error, capsize=3, label=f"{name}: {word}", **style)
                low.errorbar(mach, frequency, **style)
            doubtful = [(row["mach"], row["V_f"]) for row in known if row["slosh_holds"] is False]
            if doubtful:
                top.plot(
                    *zip(*doubtful, strict=True),
                    "x",
                    color=look.INK,
                    ms=10,
                    mew=1.5,
                    label="slosh model does not hold: no verdict",
                )
        top.set_ylabel(look.SPEED_INDEX)
        low.set_ylabel(look.FREQUENCY)
        low.set_xlabel(look.MACH)
        machs = sorted({row["mach"] for rows in runs.values() for row in rows})
        span = " to ".join(dict.fromkeys(f"{m:g}" for m in (machs[0], machs[-1])))
        figure.suptitle(f"Neutral $V_f$: {' against '.join(runs)}, Mach {span}", fontsize=10.5)
        canvas.legend(figure, top)
        path.parent.mkdir(parents=True, exist_ok=True)
        with files.part(path) as hidden:
            figure.savefig(hidden, format="png")


def kind(row: dict[str, Any]) -> str:
    """Onset, recovery or divergence."""
    return "divergence" if row["kind"] == "divergence" else str(row["direction"] or "onset")
