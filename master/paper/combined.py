"""Combined pitch and plunge of the tank in phase: what figures 24 and 25 are made of."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

from ..pictures import canvas, look
from .outcome import Table
from .tank import Loads, beyond_first, driven, peaks, spectrum
from .work import Work

HEIGHT = 0.15  # of the tank [m]: plunge is told in parts of it
PERIODS, FEW = 22, 6  # two of them to rise and settle
LOADS = {"vertical": "vertical force", "lateral": "lateral force", "moment": "moment"}


class Motion(NamedTuple):
    """A panel of the paper: pitch [deg], plunge over the tank's height, frequency [rad/s]."""

    panel: str
    degrees: float
    plunge: float
    omega: float


class Answer(NamedTuple):
    """Number of peaks in the spectrum of a load, and the part of it that is not at the forcing frequency."""

    peaks: int
    rest: float


def run(work: Work, motions: Sequence[Motion]) -> dict[str, Loads]:
    """Panel → loads, by the two-phase flow."""
    periods = work.pick(PERIODS, FEW)
    return {
        m.panel: driven(work, "slosh_vof", m.omega, periods, h=m.plunge * HEIGHT, alpha=math.radians(m.degrees)) for m in motions
    }


def answers(motions: Sequence[Motion], found: dict[str, Loads]) -> dict[str, dict[str, Answer]]:
    """Panel → load → what its spectrum has."""
    out: dict[str, dict[str, Answer]] = {}
    for m in motions:
        loads = found[m.panel]
        for name in LOADS:
            at, size = spectrum(loads, getattr(loads, name), m.omega)
            out.setdefault(m.panel, {})[name] = Answer(peaks(size), beyond_first(at, size))
    return out


def said(motions: Sequence[Motion], found: dict[str, dict[str, Answer]]) -> list[str]:
    """A remark a panel."""
    return [
        f"{m.panel} {m.degrees:g}°, {m.plunge:.1%} of the height, {m.omega:g} rad/s: "
        + ", ".join(
            f"{LOADS[name]} {a.peaks} peaks, {a.rest:.0%} not at the forcing frequency" for name, a in found[m.panel].items()
        )
        for m in motions
    ]


def tables(motions: Sequence[Motion], found: dict[str, Loads], counted: dict[str, dict[str, Answer]]) -> dict[str, Table]:
    """Loads over time, spectra, and what was counted."""
    series, spectra = [], []
    for m in motions:
        loads = found[m.panel]
        columns = (loads.time, loads.vertical, loads.lateral, loads.moment)
        series += [(m.panel, *(float(v) for v in row)) for row in zip(*columns, strict=True)]
        for name in LOADS:
            at, size = spectrum(loads, getattr(loads, name), m.omega)
            spectra += [(m.panel, name, float(a), float(s)) for a, s in zip(at, size, strict=True)]
    counts = [(panel, name, a.peaks, a.rest) for panel, by_load in counted.items() for name, a in by_load.items()]
    return {
        "loads": Table(("panel", "time [s]", "vertical [N/m]", "lateral [N/m]", "moment [N]"), series),
        "spectra": Table(("panel", "load", "frequency over forcing", "amplitude [N/m or N]"), spectra),
        "peaks": Table(("panel", "load", "peaks", "part not at the forcing frequency"), counts),
    }


def draw(motions: Sequence[Motion], found: dict[str, Loads], title: str) -> Any:
    """A row a panel: forces, moment, spectra."""
    figure, rows = canvas.subplots(len(motions), 3, figsize=(11.5, 2.5 * len(motions) + 1.2), layout="constrained", squeeze=False)
    colours = {"vertical": look.BLUE, "lateral": look.ORANGE, "moment": look.PURPLE}
    for m, (forces, moment, ffts) in zip(motions, rows, strict=True):
        loads = found[m.panel]
        last = loads.time >= loads.time[-1] - 6 * 2 * math.pi / m.omega
        for name, axis in (("vertical", forces), ("lateral", forces), ("moment", moment)):
            axis.plot(loads.time[last], getattr(loads, name)[last], color=colours[name], lw=1.0, label=LOADS[name])
            at, size = spectrum(loads, getattr(loads, name), m.omega)
            ffts.plot(at, size / size.max(), color=colours[name], lw=1.0, label=LOADS[name])
        forces.set(
            ylabel="force [N/m]", title=f"{m.panel} {m.degrees:g}°, plunge {100 * m.plunge:g} % of the height, {m.omega:g} rad/s"
        )
        forces.title.set_fontsize(9.5)
        moment.set(ylabel="moment, nose-up [N]")
        ffts.set(ylabel="spectrum over its peak [–]")
    rows[-1][0].set_xlabel("time [s]")
    rows[-1][1].set_xlabel("time [s]")
    rows[-1][2].set_xlabel("frequency over forcing [–]")
    figure.suptitle(title, fontsize=11)
    canvas.legend(figure, rows[0][0], rows[0][1])
    return figure
