"""Picture of a section: the points of its file and the wall of the mesh, with leading and trailing edge enlarged."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
from matplotlib import rc_context
from matplotlib.figure import Figure

from .look import BLUE, GREY, STYLE
from .look import ORANGE as RED


def read(table: Path) -> dict[str, np.ndarray]:
    """The table that the aero FMU writes as `section_file`: "file", "contour" and "mesh" → points, shape (n, 2), chords."""
    parts: dict[str, list[tuple[float, float]]] = {}
    with table.open(encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            parts.setdefault(row["what"], []).append((float(row["x"]), float(row["y"])))
    return {name: np.array(points) for name, points in parts.items()}


def draw(table: Path, path: Path, summary: str) -> None:
    """Draw the `table` of a section into the PNG `path`, with its `summary` above."""
    parts = read(table)
    mesh, points = parts["mesh"], parts.get("file", parts["contour"])
    label = "file" if "file" in parts else "contour"
    nose, tail = mesh[np.argmin(mesh[:, 0])], mesh[np.argmax(mesh[:, 0])]
    with rc_context(STYLE):
        figure = Figure(figsize=(9.0, 6.4), constrained_layout=True)
        grid = figure.add_gridspec(2, 2, height_ratios=(1.0, 1.25))
        windows = (
            (grid[0, :], "", (0.5, 0.5 * (mesh[:, 1].min() + mesh[:, 1].max())), 0.54),
            (grid[1, 0], "leading edge", (nose[0] + 0.022, nose[1]), 0.03),
            (grid[1, 1], "trailing edge", (tail[0] - 0.022, tail[1]), 0.03),
        )
        for place, title, (x, y), half in windows:
            axis = figure.add_subplot(place)
            axis.plot(*np.vstack([mesh, mesh[:1]]).T, color=BLUE, lw=1.0, marker=".", ms=4 if title else 2, label="mesh wall")
            marks = {"ls": "", "marker": "x"} if label == "file" else {"ls": (0, (3, 4)), "lw": 1.4}
            axis.plot(*points.T, color=RED, ms=5 if title else 2.5, mew=0.8, label=label, **marks)
            axis.axhline(0.0, color=GREY, lw=0.5)
            axis.set_aspect("equal", adjustable="box")
            axis.set_xlim(x - half, x + half)
            if title:
                axis.set_ylim(y - half, y + half)
                axis.set_title(title, fontsize=10)
            else:
                axis.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=2)
            axis.set_xlabel("chordwise place $x/c$ [–]")
            axis.set_ylabel("height $y/c$ [–]")
        figure.suptitle(summary.replace("$", r"\$"), fontsize=8.5, wrap=True)
        figure.savefig(path)
