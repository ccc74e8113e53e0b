"""Figures of results, for notebooks: matplotlib figures that are returned, not shown."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure


def motion(history: xr.Dataset, title: str) -> Figure:
    """Plunge over half chord, and pitch in degrees, over omega_alpha t."""
    from ..pictures import canvas, look

    figure, (upper, lower) = canvas.subplots(2, 1, sharex=True, figsize=(8, 5), layout="constrained")
    upper.plot(history["tau"], history["h_over_b"], lw=1, color=look.BLUE)
    upper.set_ylabel("plunge / half chord, down [–]")
    lower.plot(history["tau"], np.degrees(history["alpha"]), lw=1, color=look.ORANGE)
    lower.set_ylabel("pitch about the mean, nose-up [deg]")
    lower.set_xlabel("time ω_α t [–]")
    upper.set_title(title)
    release = float(history["tau"][int(history.attrs["release_index"])])
    for axis in (upper, lower):
        axis.axvline(release, color="0.6", lw=0.8, ls="--")
        axis.grid(alpha=0.3)
    return figure


def crossings(table: pd.DataFrame, title: str) -> Figure:
    """Neutral V_f over Mach number, one mark a kind of crossing, with error bars."""
    from ..pictures import canvas, look

    figure, axis = canvas.subplots(figsize=(7, 4.5), layout="constrained")
    for name, group in table.groupby("name"):
        style = {"fmt": look.CROSSING_MARKS.get(name, "v"), "color": look.CROSSINGS.get(name, look.GREY)}
        axis.errorbar(group["mach"], group["V_f"], yerr=group["V_f_uncertainty"].fillna(0.0), capsize=3, label=name, **style)
    axis.set_xlabel(look.MACH)
    axis.set_ylabel(look.SPEED_INDEX)
    axis.set_title(title)
    axis.grid(alpha=0.3)
    if len(table):
        canvas.legend(figure, axis)
    return figure
