"""Figures that are written to files, whatever backend the program around us draws with; none is shown, none is remembered."""

from __future__ import annotations

from typing import Any

from matplotlib import rc_context
from matplotlib.figure import Figure

__all__ = ["rc_context", "subplots"]
ARRANGED = ("sharex", "sharey", "squeeze", "width_ratios", "height_ratios", "subplot_kw", "gridspec_kw")


def subplots(rows: int = 1, columns: int = 1, **options: Any) -> tuple[Figure, Any]:
    """As pyplot's: a figure and its axes."""
    arranged = {name: options.pop(name) for name in ARRANGED if name in options}
    figure = Figure(**options)
    return figure, figure.subplots(rows, columns, **arranged)
