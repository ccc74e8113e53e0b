"""Flow around the section and liquid in a tank as small pictures of the recorded fields, to be shown one after the other."""

from __future__ import annotations

import base64
import io
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base import pvd, vtk
from ..base.errors import AeroSloshError
from ..results import export
from .chart import Chart, Frames
from .markup import Markup, join, tag

MOST = 24  # instants shown
WIDE = 560  # pixels
NAMES = "fields_*.vts"


def of_folder(folder: Path, chord: float, elastic_axis: float, about: str) -> Markup:
    """Every film that the fields in `folder` and its folders give: the Mach number around a section, the liquid in a tank.

    chord [m], elastic_axis [x/c]: of the section; about: model, Mach number and V_f for the title. Nothing without fields."""
    if not any(folder.rglob(NAMES)):
        return Markup("")
    groups: dict[Path, list[pvd.Frame]] = {}
    try:
        for time, path in export.fields(folder):
            if path.match(NAMES):
                groups.setdefault(path.parent, []).append((time, path))
    except AeroSloshError as error:
        return tag("p", f"The fields cannot be shown: {error}", class_="note")
    found = []
    for frames in groups.values():
        shown = sorted(frames)[:: -(-len(frames) // MOST)]
        times = [time for time, _ in shown]
        try:
            fields = [vtk.read(path) for _, path in shown]
        except AeroSloshError as error:
            found.append(tag("p", f"The fields in {shown[0][1].parent.name} cannot be shown: {error}", class_="note"))
            continue
        if all("mach" in f.cells for f in fields):
            found.append(_flow([f.scaled(chord, elastic_axis) for f in fields], times, about))
        elif all(f.cells.get("volume_fraction", np.empty(0)).ndim == 2 for f in fields):
            found.append(_tank(fields, times, about))
    return join(found)


def _flow(fields: Sequence[vtk.Field], times: Sequence[float], about: str) -> Markup:
    from ..pictures import look, mach_field

    window = mach_field.WINDOW
    low, high = mach_field.limits(fields)

    def draw(axis: Any, field: vtk.Field) -> None:
        mach_field.draw(axis, field, low, high)

    frames = Frames([_picture(f, window, draw) for f in fields], window, [f"t = {t:.4f} s" for t in times])
    chart = Chart(
        f"Local Mach number, {about}", "x/c [–]", "y/c [–]", [frames], x_range=window[:2], y_range=window[2:], equal=True
    )
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    ramp = ", ".join(to_hex(colormaps[look.EVEN](s)) for s in np.linspace(0.0, 1.0, 9))
    line = "; white line: Mach 1" if low < 1.0 < high else ""
    scale = tag(
        "div", f"Mach {low:.2f}", tag("span", "", class_="ramp", style=f"background: linear-gradient(90deg, {ramp})"),
        f"{high:.2f}{line}", class_="scale",
    )  # fmt: skip
    return tag("div", chart.html(), scale, class_="film")


def _tank(fields: Sequence[vtk.Field], times: Sequence[float], about: str) -> Markup:
    from ..pictures import tank_film

    windows = tank_film.windows(np.array([tank_film.box(f) for f in fields]))
    left, right, bottom, top = (float(v) for v in windows[0])
    whole = (left, right, bottom, top)

    def draw(axis: Any, field: vtk.Field) -> None:
        tank_film.draw(axis, field, windows[0], "")

    frames = Frames([_picture(f, whole, draw) for f in fields], whole, [f"t = {t:.4f} s" for t in times])
    title = f"Liquid in the tank, {about}" if about else "Liquid in the tank"
    return Chart(title, "X [m]", "Y [m]", [frames], x_range=(left, right), y_range=(bottom, top), equal=True).html()


def _picture(field: vtk.Field, window: Sequence[float], draw: Callable[[Any, vtk.Field], None]) -> str:
    """What `draw` draws in the window (left, right, bottom, top), without axes, as a data URI (WebP)."""
    from matplotlib.figure import Figure
    from PIL import Image

    a, b, c, d = window
    figure = Figure(figsize=(WIDE / 100.0, WIDE / 100.0 * (d - c) / (b - a)), dpi=100)
    axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    draw(axis, field)
    axis.set(xlim=(a, b), ylim=(c, d), title="", aspect="auto")
    axis.set_axis_off()
    raw, small = io.BytesIO(), io.BytesIO()
    figure.savefig(raw, format="png", dpi=100)
    Image.open(raw).convert("RGB").save(small, "WEBP", quality=82, method=4)
    return "data:image/webp;base64," + base64.b64encode(small.getvalue()).decode("ascii")
