"""Picture of an FMU driven by a table, or of a system's run: inputs and outputs over time."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np

from ..base import files
from ..fmi.table_drive import Table
from . import canvas, look


def draw(path: Path, table: Table, columns: dict[str, np.ndarray], units: dict[str, str]) -> None:
    """Inputs and outputs over time, one small panel each; what never changes is left out."""
    series = [(n, table.times, v, look.GREY) for n, v in zip(table.names, table.values.T, strict=True)]
    series += [(n, columns["time"], v, look.BLUE) for n, v in columns.items() if n != "time"]
    series = [entry for entry in series if np.ptp(entry[2]) > 0.0] or series[:1]
    across = 2 if len(series) > 1 else 1
    down = math.ceil(len(series) / across)
    with canvas.rc_context(look.STYLE):
        figure, axes = canvas.subplots(
            down, across, figsize=(5 * across, 1.8 * down), sharex=True, layout="constrained", squeeze=False
        )
        for axis, (name, times, values, colour) in zip(axes.flat, series, strict=False):
            axis.plot(times, values, colour, lw=1)
            axis.set_title(f"{name.replace('_', ' ')} [{_unit(units.get(name))}]", fontsize=9, loc="left")
        for axis in axes.flat[len(series) :]:
            axis.set_visible(False)
        for axis in axes[-1]:
            axis.set_xlabel("time [s]")
        path.parent.mkdir(parents=True, exist_ok=True)
        with files.part(path) as hidden:
            figure.savefig(hidden, dpi=110, format="png")


def _unit(unit: str | None) -> str:
    return unit if unit and unit != "1" else "–"
