"""The picture of a sweep: growth rate (or neutral V_f) over what was swept, two keys of a grid as a map.

Verdicts have a colour and a shape each; the signs stand below the axes; the title tells what all points have in common."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from ..case.fuel_tank import LABEL
from . import canvas, look

SHOWN = {
    "point": ("growth_rate", "growth_rate_uncertainty", look.GROWTH),
    "boundary": ("V_f", "V_f_uncertainty", "neutral " + look.SPEED_INDEX),
}
LINES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 3)), (0, (8, 3)), (0, (3, 3)))
PANELS = 6
DOUBTFUL = "slosh model does not hold: no verdict"


def draw(table: Sequence[dict[str, Any]], kind: str, names: Sequence[str], grid: bool) -> bytes | None:
    """A PNG of `table` (rows of `sweep_results.flat`); None when there is nothing to draw."""
    value, error, label = SHOWN[kind]
    names = [*names, "mach"] if kind == "boundary" and "flow.mach" not in names else list(names)
    names = [n for n in names if len({str(line[n]) for line in table}) > 1] or names[:1]
    known = [line for line in table if line[value] is not None]
    if not known:
        return None
    numbers = [n for n in names if all(_is_number(line[n]) for line in table)]
    with canvas.rc_context(look.STYLE):
        if grid and len(names) == len(numbers) == 2:
            figure, axis = canvas.subplots(figsize=(6.6, 5.2), constrained_layout=True)
            _map(axis, known, numbers, value, label)
            _static(axis, [(line[numbers[0]], line[numbers[1]]) for line in table if line.get("verdict") == "divergence"])
            drawn = [axis]
        else:
            shown = names[:PANELS]
            rows = -(-len(shown) // 2)
            columns = min(2, len(shown))
            figure, axes = canvas.subplots(
                rows, columns, figsize=(1.0 + 4.4 * columns, 1.3 + 3.4 * rows), squeeze=False, constrained_layout=True
            )
            for axis, name in zip(axes.flat, shown, strict=False):
                _panel(axis, known, name, [n for n in names if n != name] if len(names) == 2 else [], value, error, label)
            for axis in list(axes.flat)[len(shown) :]:
                axis.set_visible(False)
            drawn = list(axes.flat)[: len(shown)]
        canvas.legend(figure, *drawn)
        figure.suptitle(title(known, kind, names), fontsize=10.5)
        picture = io.BytesIO()
        figure.savefig(picture, format="png")
    return picture.getvalue()


def title(known: Sequence[dict[str, Any]], kind: str, names: Sequence[str]) -> str:
    """Model, Mach number and V_f of all points, as far as they have one in common, else their range."""
    models = list(dict.fromkeys(str(line["slosh"]) for line in known if line.get("slosh")))
    parts = [" and ".join(LABEL.get(m, m) for m in models)]
    for name, symbol in (("mach", "Mach"), ("V_f", "$V_f$ =")):
        if name == "V_f" and kind == "boundary":
            continue
        values = [line[name] for line in known if _is_number(line.get(name))]
        if values:
            low, high = min(values), max(values)
            parts.append(f"{symbol} {low:.4g}" + (f" to {high:.4g}" if high > low else ""))
    what = "Neutral $V_f$" if kind == "boundary" else "Growth rate"
    over = " and ".join(look.words(n).split(" [")[0].split(" (")[0].split(" $")[0] for n in names[:2])
    return f"{what} over {over}{' and more' if len(names) > 2 else ''}\n{', '.join(filter(None, parts))}"


def _map(axis: Axes, known: Sequence[dict[str, Any]], names: Sequence[str], value: str, label: str) -> None:
    """Colours over two keys; points without a value stay white, neutral is drawn as a line."""
    x, y = (sorted({line[n] for line in known}) for n in names)
    z = np.full((len(y), len(x)), np.nan)
    for line in known:
        z[y.index(line[names[1]]), x.index(line[names[0]])] = line[value]
    signed = value == "growth_rate"
    most = float(np.nanmax(np.abs(z))) or 1.0
    colors = {"cmap": look.signed_map(), "vmin": -most, "vmax": most} if signed else {"cmap": look.EVEN}
    mesh = axis.pcolormesh(x, y, z, shading="nearest", **colors)
    axis.figure.colorbar(mesh, ax=axis, label=f"{label}, above 0: unstable" if signed else label)
    if signed and min(z.shape) > 1 and np.isfinite(z).all() and z.min() < 0.0 < z.max():
        axis.contour(x, y, z, levels=[0.0], colors=look.INK, linewidths=1.4)
        axis.plot([], [], "-", color=look.INK, lw=1.4, label="neutral")
    axis.plot([line[names[0]] for line in known], [line[names[1]] for line in known], ".", color="black", ms=2, alpha=0.4)
    _cross(axis, [(line[names[0]], line[names[1]]) for line in known if line.get("slosh_holds") is False])
    axis.set_xlabel(look.words(names[0]))
    axis.set_ylabel(look.words(names[1]))
    axis.grid(False)


def _static(axis: Axes, places: Sequence[tuple[Any, Any]]) -> None:
    """Triangles where the section diverges statically, with a growth rate or without."""
    if places:
        axis.plot(*zip(*places, strict=True), "^", color=look.PURPLE, mec="white", ms=6, label="static divergence")


def _panel(
    axis: Axes, known: Sequence[dict[str, Any]], name: str, others: Sequence[str], value: str, error: str, label: str
) -> None:
    """The value over one key; with one other key swept, a line for each of its values."""
    words = not all(_is_number(line[name]) for line in known)
    places = {word: i for i, word in enumerate(dict.fromkeys(str(line[name]) for line in known))}
    groups: dict[str, list[dict[str, Any]]] = {}
    for line in known:
        groups.setdefault(", ".join(f"{look.words(n).split(' [')[0]} {_said(line[n])}" for n in others), []).append(line)
    joined = len(groups) <= len(LINES) and len(known) > len(groups)
    for dash, (text, group) in zip([*LINES, *["-"] * len(groups)], groups.items(), strict=False):
        xs = np.array([places[str(line[name])] if words else float(line[name]) for line in group])
        order = np.argsort(xs)
        ys = np.array([line[value] for line in group])
        bars = np.array([line[error] or 0.0 for line in group])
        if len(set(xs)) == len(xs) and joined and not words:
            style: dict[str, Any] = {"ls": dash, "lw": 1.0, "capsize": 2, "color": look.GREY, "label": text or None}
            axis.errorbar(xs[order], ys[order], yerr=2.0 * bars[order], **style)
        for verdict in dict.fromkeys(str(line["verdict"]) for line in group):
            mine = [i for i, line in enumerate(group) if line["verdict"] == verdict]
            look_of: dict[str, Any] = {"marker": look.MARKS.get(verdict, "v"), "color": look.VERDICTS.get(verdict, look.GREY)}
            axis.plot(xs[mine], ys[mine], ls="", ms=5, label=verdict, **look_of)
    doubtful = [line for line in known if line.get("slosh_holds") is False]
    _cross(axis, [(places[str(line[name])] if words else float(line[name]), line[value]) for line in doubtful])
    if words:
        axis.set_xticks(list(places.values()), list(places))
    if value == "growth_rate":
        axis.axhline(0.0, color=look.GREY, lw=0.8)
    axis.set_xlabel(look.words(name))
    axis.set_ylabel(label)


def _cross(axis: Axes, doubtful: Sequence[tuple[float, float]]) -> None:
    """Mark the points that rest on a slosh model which does not hold: they have no verdict."""
    if doubtful:
        axis.plot(*zip(*doubtful, strict=True), "x", color="black", ms=8, mew=1.5, zorder=4, label=DOUBTFUL)


def _said(value: Any) -> str:
    return f"{value:.6g}" if _is_number(value) else str(value)


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
