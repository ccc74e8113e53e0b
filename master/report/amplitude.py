"""The page of a boundary over amplitude: limit cycles over V_f, growth rates over amplitude, the marches they come from."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..case.fuel_tank import LABEL
from ..results.amplitude_text import said, trend
from ..results.past_run import PastRun
from . import about
from .chart import Chart, Dots, Line
from .markup import Markup, join, paragraph, section, table, tag
from .words import with_error

COLOURS = ("blue", "red", "purple", "sky", "ink", "grey")  # of V_f, one after the other
V_F = "flutter speed index V_f [–]"
PITCH = "amplitude of the pitch [deg]"
RATE = "growth rate σ/ω_α [–]"


def build(run: PastRun) -> tuple[str, list[Markup]]:
    """Title and parts of the page of an amplitude's run folder."""
    r = run.result
    speeds = sorted(r["speeds"], key=lambda row: row["V_f"])
    label = LABEL.get(r.get("slosh", "none"), str(r.get("slosh")))
    named = f"{label}, Mach {r['mach']:g}"
    span = f"Claims hold between the smallest and the largest amplitude marched, over {r['free_cycles']:g} free cycles a march."
    head = [*(paragraph(f"{said(row)}.") for row in speeds), paragraph(span, class_="small"), about.warnings(r), cycles(speeds)]
    parts = [section("Limit cycles", *head)]
    drawn = [bifurcation(speeds, named), over_amplitude(speeds, f"Growth rate over amplitude: {named}")]
    parts.append(section("Over V_f and over amplitude", tag("div", *drawn, class_="charts")))
    shown = [tag("div", one_speed(row, named), class_="choice", data_value=f"V_f {row['V_f']:g}", data_number=row["V_f"])
             for row in speeds]  # fmt: skip
    parts.append(section("Amplitudes and growth rates", tag("div", *shown, class_="picker", data_name="V_f") if shown else None))
    spent = sum(m["cpu_seconds"] for row in speeds for m in row["marches"])
    count = sum(len(row["marches"]) for row in speeds)
    parts.append(section("Cost", about.cost({"cpu_seconds": spent}, [("marches", count)])))
    return f"Limit cycles, {named}", parts


def cycles(speeds: Sequence[dict[str, Any]]) -> Markup:
    """Every limit cycle with its error bar and from where it was marched at."""
    return table(
        ("V_f", "amplitude [deg]", "kind", "marched at from", "slope of the rate over ln amplitude"),
        [
            (f"{row['V_f']:g}", with_error(c["amplitude_deg"], c["std_deg"], 3), kind(c), c["confirmed"] or "neither side",
             float(c["slope"]))
            for row in speeds
            for c in row["cycles"]
        ],
    )  # fmt: skip


def kind(c: dict[str, Any]) -> str:
    """Stable or not."""
    return "stable" if c["stable"] else "unstable"


def bifurcation(speeds: Sequence[dict[str, Any]], named: str) -> Markup:
    """Limit cycles over V_f, and between them which amplitudes grow and which decay."""
    parts: list[Line | Dots] = []
    for word, colour, mark, share in (("decays", "blue", "circle", -1.0), ("grows", "red", "triangle", 1.0)):
        spots = [(row["V_f"], p) for row in speeds for p in row["curve"] if p["growth_rate"] * share > 0.0]
        texts = [f"V_f {v:g}, {p['amplitude_deg']:.3g} deg: growth rate {p['growth_rate']:+.4g}" for v, p in spots]
        if spots:
            x, y = np.array([v for v, _ in spots]), np.array([p["amplitude_deg"] for _, p in spots])
            parts.append(Dots(x, y, f"a motion of this size {word}", colour, mark, True, None, texts))
    for stable, mark in ((True, "square"), (False, "diamond")):
        found = [(row["V_f"], c) for row in speeds for c in row["cycles"] if c["stable"] is stable]
        texts = [f"V_f {v:g}: {kind(c)}, {with_error(c['amplitude_deg'], c['std_deg'], 3)} deg" for v, c in found]
        if found:
            x, y, e = np.array([(v, c["amplitude_deg"], c["std_deg"]) for v, c in found]).T
            word = f"{'stable' if stable else 'unstable'} limit cycle"
            parts.append(Dots(x, y, word, "ink", mark, not stable, e, texts))
    if not parts:
        return paragraph("No march was long enough to read an envelope.", class_="note")
    return Chart(f"Limit cycles over V_f: {named}", V_F, PITCH, list(parts), y_log=True, height=260.0).html()


def over_amplitude(speeds: Sequence[dict[str, Any]], title: str) -> Markup | None:
    """Growth rates with their standard errors over amplitude, a line a V_f; limit cycles lie where one passes zero."""
    parts: list[Line | Dots] = []
    for n, row in enumerate(speeds):
        if not row["curve"]:
            continue
        colour = COLOURS[n % len(COLOURS)]
        x, y, e = (np.array([p[k] for p in row["curve"]]) for k in ("amplitude_deg", "growth_rate", "standard_error"))
        parts.append(Line(x, y, f"V_f {row['V_f']:g}", colour, n >= len(COLOURS)))
        parts.append(Dots(x, y, "", colour, "circle", True, e))
    return Chart(title, PITCH, RATE, list(parts), x_log=True, zero=True, height=260.0).html() if parts else None


def one_speed(row: dict[str, Any], named: str) -> Markup:
    """Curve, amplitudes and marches of a V_f."""
    growth = table(
        ("amplitude [deg]", "growth rate σ/ω_α", "standard error"),
        [(f"{p['amplitude_deg']:.3g}", float(p["growth_rate"]), float(p["standard_error"])) for p in row["curve"]],
    )
    marched = table(
        ("forced pitch [deg]", "first [deg]", "last [deg]", "growth rate at the end", "verdict of the whole march"),
        [
            (f"{m['forced_deg']:.3g}", m["first_deg"], m["last_deg"], m["last_rate"], m["verdict"])
            for m in sorted(row["marches"], key=lambda m: m["forced_deg"])
        ],
    )
    chart = over_amplitude([row], f"V_f {row['V_f']:g}: {named}")
    told = paragraph(f"No limit cycle: motions {trend(row)}.") if row["curve"] and not row["cycles"] else None
    return join([tag("div", chart, class_="charts") if chart else None, told, growth, tag("h3", "Marches"), marched])
