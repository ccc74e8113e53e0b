"""The page of a flutter boundary: V_f over Mach number, V–g and V–f curves with a slider over V_f, the marches."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..case.fuel_tank import LABEL
from ..results import history_file
from ..results.history_file import History
from ..results.past_run import PastRun
from . import about, marches
from .airfoil import outline
from .chart import Chart, Dots, Line
from .markup import Markup, join, paragraph, section, table, tag
from .words import with_error

KINDS = {  # what a crossing is → colour of what is above it, mark
    "onset": ("red", "circle"), "recovery": ("blue", "diamond"),
    "divergence": ("purple", "triangle"), "end of divergence": ("purple", "square"),
}  # fmt: skip
CURVES = ("blue", "red", "purple", "sky", "ink")
V_F = "flutter speed index V_f [–]"
WORST = 0.35  # growth rates drawn
MOST_MARCHES = 60


def build(run: PastRun) -> tuple[str, list[Markup]]:
    """Title and parts of the page of a boundary's run folder."""
    r = run.result
    points = sorted(r["points"], key=lambda p: p["mach"])
    label = LABEL.get(r.get("slosh", "none"), str(r.get("slosh")))
    title = f"Flutter boundary, {label}, Mach " + (
        f"{points[0]['mach']:g} to {points[-1]['mach']:g}" if len(points) > 1 else ", ".join(f"{p['mach']:g}" for p in points)
    )
    head = [paragraph(lead(points)), about.warnings(r), crossings(points), *matched(r)]
    if r.get("unfinished"):
        head.append(paragraph(f"Not computed: Mach {', '.join(f'{m:g}' for m in r['unfinished'])}", class_="note"))
    parts = [section("Neutral V_f", *head)]
    if points:
        parts.append(section("Boundary", tag("div", *over_mach(points, label), class_="charts")))
    histories = _histories(run)
    choices = [one_mach(p, label, histories) for p in points]
    shown = [tag("div", inner, class_="choice", data_value=f"Mach {p['mach']:g}", data_number=p["mach"])
             for p, inner in zip(points, choices, strict=True) if inner]  # fmt: skip
    lead_in = paragraph(
        "Growth rate and frequency of every mode over V_f; drag the sliders, point at a chart, or use arrow keys."
    )
    picker = tag("div", *shown, class_="picker", data_name="Mach number")
    parts.append(section("V–g and V–f curves, marches", lead_in if shown else None, picker if shown else None))
    summary = run.result.get("airfoil_summary") or ""
    parts.append(section("Section", outline(run.path / "airfoil.csv", summary) if run.path.is_dir() else None))
    parts.append(section("Coupling health", _health(points)))
    spent = [(f"Mach {p['mach']:g}", f"{p['cost']['wall_seconds']:.3g} s, {p['cost']['marches']} marches") for p in points]
    parts.append(section("Cost", about.cost(r.get("cost") or {}, spent)))
    return title, parts


def lead(points: list[dict[str, Any]]) -> str:
    """The lowest neutral V_f in a sentence."""
    found = [(c["V_f"], p["mach"], c) for p in points for c in p["crossings"]]
    if not found:
        return "No neutral V_f was found."
    V_f, mach, c = min(found, key=lambda f: f[0])
    return f"The lowest neutral V_f is {with_error(V_f, c['V_f_uncertainty'], 4)} at Mach {mach:g} ({name_of(c)})."


def name_of(c: dict[str, Any]) -> str:
    """Onset, recovery, divergence."""
    if c.get("kind") == "divergence":
        return "divergence" if c.get("direction") == "onset" else "end of divergence"
    return str(c["direction"])


def crossings(points: list[dict[str, Any]]) -> Markup:
    """Every neutral V_f with what its error bar is made of, and the outcome of every Mach number."""
    rows: list[tuple[Any, ...]] = []
    for p in points:
        for c in p["crossings"]:
            error = ", ".join(f"{name} {value:.2g}" for name, value in (c.get("uncertainty_parts") or {}).items())
            missing = f"; not known: {', '.join(c['uncertainty_missing'])}" if c.get("uncertainty_missing") else ""
            value = with_error(c["V_f"], c["V_f_uncertainty"], 4)
            doubt = "" if p.get("slosh_holds") is not False else " (undetermined: slosh model does not hold)"
            said = f"{c.get('source', 'march')}{'' if c.get('tolerance_met', True) else ', tolerance not met'}{doubt}"
            rows.append((f"{p['mach']:g}", value, name_of(c), float(c["frequency"]), said, error + missing))
        if not p["crossings"]:
            rows.append((f"{p['mach']:g}", "none", "", "", p.get("outcome", ""), ""))
    return table(("Mach", "neutral V_f", "kind", "frequency ω/ω_α", "rests on", "error bar"), rows)


def matched(r: dict[str, Any]) -> list[Markup]:
    """Where the wing of the case flutters in its air."""
    said = []
    for m in r.get("matched") or []:
        way = "flutters from" if m["onset"] else "is free of flutter again from"
        text = f"This wing in this air {way} about Mach {m['mach']:.4f}: {m['airspeed']:.4g} m/s true, "
        said.append(paragraph(text + f"{m['equivalent_airspeed']:.4g} m/s EAS, q {m['dynamic_pressure'] / 1e3:.4g} kPa."))
    return said


def over_mach(points: list[dict[str, Any]], label: str) -> list[Markup]:
    """V_f with error bars and frequency over Mach number."""
    V_f, frequency = [], []
    for word, colour, mark in (("damped", "blue", "circle"), ("growing", "red", "cross")):
        dots = [(m["mach"], m["V_f"]) for p in points for m in p["marches"] if m.get("growth_rate") is not None
                and (m["growth_rate"] > 0.0) is (word == "growing")]  # fmt: skip
        if dots:
            x, y = np.array(dots).T
            V_f.append(Dots(x, y, f"march: {word}", colour, mark, True))
    for kind, (colour, mark) in KINDS.items():
        rows = [(p["mach"], c) for p in points for c in p["crossings"] if name_of(c) == kind]
        if not rows:
            continue
        mach = np.array([m for m, _ in rows])
        values = {
            k: np.array([np.nan if c[k] is None else c[k] for _, c in rows]) for k in ("V_f", "V_f_uncertainty", "frequency")
        }
        texts = [f"Mach {m:g}, {kind}: V_f {with_error(c['V_f'], c['V_f_uncertainty'], 4)}" for m, c in rows]
        V_f.append(Dots(mach, values["V_f"], kind, colour, mark, False, 2.0 * values["V_f_uncertainty"], texts))
        frequency.append(Dots(mach, values["frequency"], kind, colour, mark, False, None, texts))
    charts = [Chart(f"Neutral V_f, {label} (bars: ± 2 standard deviations)", "Mach number [–]", V_F, list(V_f), height=240.0)]
    charts.append(Chart(f"Frequency at it, {label}", "Mach number [–]", "frequency ω/ω_α [–]", list(frequency), height=240.0))
    return [c.html() for c in charts if c.parts]


def one_mach(p: dict[str, Any], label: str, histories: dict[tuple[float, float], History]) -> Markup:
    """V–g and V–f of a Mach number under one slider, and its marches."""
    named = f"{label}, Mach {p['mach']:g}"
    curves = [_arrays(m) for m in (p.get("linear") or {}).get("modes", [])]
    marched = [m for m in p["marches"] if m.get("growth_rate") is not None and m.get("frequency") is not None]
    growth: list[Any] = []
    frequency: list[Any] = []
    for n, m in enumerate(curves):
        static = not (np.nan_to_num(m["frequency"], nan=-1.0) > 0.0).any()
        word, colour = ("real pole (static)", "grey") if static else (f"mode {n + 1}", CURVES[n % len(CURVES)])
        growth.append(Line(m["V_f"], m["growth_rate"], word, colour, static))
        if not static:
            frequency.append(Line(m["V_f"], m["frequency"], word, colour))
    if marched:
        x = np.array([m["V_f"] for m in marched])
        texts = [f"march at V_f {m['V_f']:.4f}: growth rate {m['growth_rate']:+.5f}, {m['verdict']}" for m in marched]
        growth.append(Dots(x, np.array([m["growth_rate"] for m in marched]), "march", "ink", "circle", True, None, texts))
        frequency.append(Dots(x, np.array([m["frequency"] for m in marched]), "march", "ink", "circle", True, None, texts))
    inner: list[Markup | None] = []
    low, high = (float(curves[0]["V_f"][0]), float(curves[0]["V_f"][-1])) if curves else _around([m["V_f"] for m in marched])
    if growth:
        seen = np.concatenate([v[np.isfinite(v) & (np.abs(v) < WORST)] for part in growth for v in [np.asarray(part.y)]])
        size = max(0.02, float(np.abs(seen).max(initial=0.0)))
        room = (max(-WORST, 1.1 * min(float(seen.min(initial=0.0)), -0.2 * size)), min(WORST, 1.15 * size))
        marks = [(c["V_f"], f"{name_of(c)} {c['V_f']:.4f}") for c in p["crossings"]]
        shared: dict[str, Any] = {"x_log": True, "x_range": (low, high), "lines_x": marks}
        g = Chart(
            f"V–g: {named}", V_F, "growth rate σ/ω_α (above 0: unstable) [–]", list(growth), y_range=room, zero=True, **shared
        )
        f = Chart(f"V–f: {named}", V_F, "frequency ω/ω_α [–]", list(frequency), **shared)
        inner.append(tag("div", class_="along-here"))
        inner.append(tag("div", g.html(), f.html(), class_="charts linked"))
        note = (p.get("linear") or {}).get("note")
        inner.append(paragraph(f"Note: {note}", class_="note") if note else None)
        predicted = [c["text"] for c in (p.get("linear") or {}).get("crossings", []) if c.get("text")]
        inner += [paragraph(text, class_="small") for text in predicted]
    inner.append(_marches(p, label, histories))
    start = p.get("V_f") or float(np.sqrt(low * high))
    slider: dict[str, Any] = {"data_along": V_F, "data_low": low, "data_high": high, "data_start": min(max(start, low), high)}
    return tag("div", *inner, **(slider if growth else {}))


def _marches(p: dict[str, Any], label: str, histories: dict[tuple[float, float], History]) -> Markup | None:
    """Motion and phase of each march, one at a time."""
    shown = []
    for m in sorted(p["marches"], key=lambda m: m["V_f"])[:MOST_MARCHES]:
        history = histories.get(_place(m["mach"], m["V_f"]))
        if history is None or history.size < 2:
            continue
        named = marches.title(m, label)
        said = paragraph(f"{m['verdict']}: {m['reason']}")
        inner = join([said, marches.motion(history, m, named), marches.phase(history, named)])
        shown.append(tag("div", inner, class_="choice", data_value=f"{m['V_f']:.4f}, {m['verdict']}", data_number=m["V_f"]))
    return join([tag("h3", "Marches"), tag("div", *shown, class_="picker", data_name="March at V_f")]) if shown else None


def _health(points: list[dict[str, Any]]) -> Markup:
    rows = []
    for p in points:
        for m in p["marches"]:
            scheme = m.get("scheme") or {}
            bad = ", ".join(f"{name} {n}" for name, n in (m.get("unconverged_steps") or {}).items() if n) or "none"
            rows.append(
                (f"{m['mach']:g}", f"{m['V_f']:.4f}", m.get("steps"), scheme.get("passes_mean"), bad, m.get("note") or "")
            )
    return table(("Mach", "V_f", "steps", "passes a step", "steps not converged", "note"), rows)


def _histories(run: PastRun) -> dict[tuple[float, float], History]:
    """By Mach number and V_f, as the files tell them."""
    found = {}
    for path in run.histories.values():
        for history in history_file.read(Path(path)):
            if "V_f" in history.attributes:
                found[_place(history.attributes.get("mach", 0.0), history.attributes["V_f"])] = history
    return found


def _place(mach: float, V_f: float) -> tuple[float, float]:
    return round(float(mach), 6), round(float(V_f), 9)


def _arrays(mode: dict[str, list[float | None]]) -> dict[str, np.ndarray]:
    return {k: np.array([np.nan if x is None else x for x in v], dtype=float) for k, v in mode.items()}


def _around(values: list[float]) -> tuple[float, float]:
    return (0.9 * min(values), 1.1 * max(values)) if values else (0.1, 1.0)
