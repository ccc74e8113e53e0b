"""Charts of a march: motion with its envelope, phase, loads, and how the coupling and the components fared."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..results.history_file import History
from .chart import Chart, Line
from .markup import Markup, join, paragraph, tag
from .signals import envelope
from .words import sentence

DEGREES = 180.0 / np.pi
LOADS = (
    ("C_L", "lift coefficient [–]", 1.0), ("C_M", "moment coefficient about the elastic axis [–]", 1.0),
    ("slosh_force_y", "force of the liquid, up [kN/m]", 1e-3), ("slosh_moment", "moment of the liquid, nose-up [kN]", 1e-3),
    ("wave_height_west", "surface at the fore wall [mm]", 1e3), ("wave_height_east", "surface at the aft wall [mm]", 1e3),
    ("slosh_validity", "validity of the slosh model (edge 1) [–]", 1.0),
)  # fmt: skip


def title(result: dict[str, Any], label: str) -> str:
    """Model, Mach number and V_f."""
    return f"{label}, Mach {result['mach']:g}, V_f {result['V_f']:.4g}"


def motion(history: History, result: dict[str, Any], about: str) -> Markup:
    """Plunge and pitch over cycles with the critical mode's envelope, and both against each other."""
    values, cycles = history.values, _cycles(history)
    release = _release(history)
    forced = [(0.0, float(cycles[release]), "forced")] if release else []
    charts = []
    named = (("h_over_b", "plunge h/b, down [–]", 1.0), ("alpha", "pitch, nose-up [deg]", DEGREES))
    for name, label, scale in named:
        if name not in values:
            continue
        parts = [Line(cycles, scale * values[name], "computed", "blue")]
        found = envelope(values["tau"][release:], values[name][release:], result)
        if found is not None:
            for n, side in enumerate(found):
                parts.append(
                    Line(cycles[release:], scale * side, "" if n else "envelope of the flutter mode", "red", True, bool(n))
                )
        word = label.split(",")[0].split(" h/b")[0]
        charts.append(Chart(f"{sentence(word)}: {about}", CYCLES, label, list(parts), forced, zoom=True).html())
    grey = paragraph("Grey: forced motion, before the release.", class_="small") if release else None
    return join([tag("div", *charts, class_="charts linked"), grey])


def phase(history: History, about: str) -> Markup:
    """Pitch rate over pitch, plunge over pitch; the forced part grey."""
    v, release = history.values, _release(history)
    omega = float(history.attributes.get("omega_alpha", 1.0))
    pairs = []
    if "alpha_dot" in v:
        pairs.append(("Pitch and its rate", v["alpha_dot"] * DEGREES / omega, "pitch rate over ω_α [deg]"))
    if "h_over_b" in v:
        pairs.append(("Pitch and plunge", v["h_over_b"], "plunge h/b, down [–]"))
    charts = []
    for name, y, label in pairs:
        x = v["alpha"] * DEGREES
        parts = [Line(x[: release + 1], y[: release + 1], "forced", "grey", True, True)] if release else []
        parts.append(Line(x[release:], y[release:], "free", "blue", quiet=True))
        charts.append(Chart(f"{name}: {about}", "pitch, nose-up [deg]", label, list(parts)).html())
    return tag("div", *charts, class_="charts") if charts else Markup("")


def loads(history: History, about: str) -> Markup:
    """Loads of the air and of the liquid over cycles; what the march does not have, or what never moves, is left out."""
    cycles, charts = _cycles(history), []
    for name, label, scale in LOADS:
        if name in history.values and np.ptp(history.values[name]) > 0.0:
            line = Line(cycles, scale * history.values[name], label.split(" [")[0], "blue")
            charts.append(Chart(f"{sentence(line.label)}: {about}", CYCLES, label, [line], zoom=True).html())
    return tag("div", *charts, class_="charts linked") if charts else Markup("")


def health(history: History, about: str) -> Markup:
    """What steps took: residual, subiterations and passes over cycles."""
    cycles, charts = _cycles(history), []
    v = history.values
    if "residual" in v and (v["residual"] > 0.0).any():
        line = Line(cycles, v["residual"], "residual", "blue")
        label = "residual of the last subiteration [–]"
        charts.append(Chart(f"Flow's residual: {about}", CYCLES, label, [line], y_log=True, zoom=True).html())
    for name, label, word in (
        ("subiterations", "subiterations of the flow a step [–]", "Subiterations"),
        ("passes", "passes over the components a step [–]", "Passes"),
    ):
        if name in v and np.ptp(v[name][1:]) > 0.0:
            line = Line(cycles[1:], v[name][1:], name, "purple")
            charts.append(Chart(f"{sentence(word)}: {about}", CYCLES, label, [line], zero=True, zoom=True).html())
    return tag("div", *charts, class_="charts linked") if charts else Markup("")


CYCLES = "cycles ω_α t / 2π [–]"


def _cycles(history: History) -> np.ndarray:
    return history.values["tau"] / (2.0 * np.pi)


def _release(history: History) -> int:
    return min(int(history.attributes.get("release_index", 0)), history.size - 1)
