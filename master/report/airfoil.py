"""The section as it was meshed."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np

from .chart import Chart, Line
from .markup import Markup, join, paragraph


def outline(table: Path, summary: str) -> Markup:
    """The wall of the mesh, from the table that the aero FMU writes; nothing without it."""
    if not table.is_file():
        return Markup("")
    with table.open(encoding="utf-8", newline="") as file:
        points = np.array([(float(r["x"]), float(r["y"])) for r in csv.DictReader(file) if r["what"] == "mesh"])
    if len(points) < 3:
        return Markup("")
    x, y = np.vstack([points, points[:1]]).T
    line = Line(x, y, "wall of the mesh", "blue", quiet=True)
    drawn = Chart("Section", "x/c [–]", "y/c [–]", [line], x_range=(-0.02, 1.02), y_range=_room(y), equal=True).html()
    return join(
        [drawn if not summary else Markup(drawn.removesuffix("</figure>") + paragraph(summary, class_="small") + "</figure>")]
    )


def _room(y: np.ndarray) -> tuple[float, float]:
    """A window a little higher than the section, and never a slit."""
    middle, half = 0.5 * (y.min() + y.max()), max(0.12, 0.7 * float(np.ptp(y)))
    return float(middle - half), float(middle + half)
