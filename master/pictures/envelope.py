"""Altitude over the speed at which a wing flutters: true and equivalent airspeed, and Mach number."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

from matplotlib.ticker import MaxNLocator

from ..case.fuel_tank import LABEL
from . import canvas, look

ACROSS = (("airspeed", "true airspeed [m/s]"), ("equivalent_airspeed", "equivalent airspeed [m/s]"), ("mach", look.MACH))


def draw(found: Sequence[dict[str, Any]], others: Sequence[str], slosh: str, low: float, high: float) -> bytes:
    """A PNG of the matched points `found` (`sweeps.envelope.points`), a curve for each value of the keys `others`.

    low, high: altitudes searched [m]."""
    groups: dict[str, list[dict[str, Any]]] = {}
    for p in found:
        name = ", ".join(f"{look.words(n).split(' [')[0]} {p[n]}" for n in others)
        groups.setdefault(name, []).append(p)
    with canvas.rc_context(look.STYLE):
        figure, axes = canvas.subplots(1, len(ACROSS), figsize=(10.0, 4.6), sharey=True, constrained_layout=True)
        for axis, (key, label) in zip(axes, ACROSS, strict=True):
            for colour, (name, points) in zip(
                (look.ORANGE, look.BLUE, look.PURPLE, look.SKY, look.GREY) * 9, groups.items(), strict=False
            ):
                for onset, mark, word in ((True, "o", "flutters from here on"), (False, "D", "free of flutter again")):
                    mine = sorted((p["altitude"], p[key]) for p in points if p["onset"] is onset)
                    if not mine:
                        continue
                    altitudes, values = zip(*mine, strict=True)
                    single = len(set(altitudes)) == len(altitudes)
                    style = {"color": colour, "mfc": "white", "ls": "-" if single else "", "marker": mark}
                    axis.plot(values, altitudes, label=f"{name}: {word}" if name else word, **style)
            axis.set_xlabel(label)
            axis.xaxis.set_major_locator(MaxNLocator(4))
        axes[0].set_ylabel("pressure altitude [m]")
        axes[0].set_ylim(low - 0.05 * (high - low or 1.0), high + 0.05 * (high - low or 1.0))
        canvas.legend(figure, axes[0], columns=2)
        figure.suptitle(
            f"{LABEL.get(slosh, slosh)}: where this wing flutters with its own frequencies, matched points", fontsize=10.5
        )
        picture = io.BytesIO()
        figure.savefig(picture, format="png")
    return picture.getvalue()
