"""Figures that are written to files, whatever backend the program around us draws with; none is shown, none is remembered."""

from __future__ import annotations

from typing import Any

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

__all__ = ["legend", "rc_context", "subplots"]
ARRANGED = ("sharex", "sharey", "squeeze", "width_ratios", "height_ratios", "subplot_kw", "gridspec_kw")


def subplots(rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """As pyplot's: a figure and its axes."""
    arranged = {name: options.pop(name) for name in ARRANGED if name in options}
    figure = Figure(**options)
    return figure, figure.subplots(rows, columns, **arranged)


def legend(figure: Figure, *axes: Axes, columns: int = 3) -> None:
    """The signs of `axes` below the axes of a figure with constrained layout, each name once: never on the data."""
    found = {label: sign for axis in axes for sign, label in zip(*axis.get_legend_handles_labels(), strict=True)}
    if found:
        figure.legend(found.values(), found.keys(), loc="outside lower center", ncols=min(columns, len(found)))
