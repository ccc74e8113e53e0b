"""The page of one march."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

from ..case.fuel_tank import LABEL
from ..results import history_file
from ..results.history_file import History
from ..results.past_run import PastRun
from . import about, films, marches
from .airfoil import outline
from .markup import Markup, facts, paragraph, section, table, tag
from .words import number, percent, sentence, with_error


def build(run: PastRun) -> tuple[str, list[Markup]]:
    """Title and parts of the page of a point's run folder."""
    r, history = run.result, _history(run)
    label = LABEL.get(r["slosh"], r["slosh"])
    named = marches.title(r, label)
    head = [tag("p", r["verdict"], class_=f"verdict v-{str(r['verdict']).replace(' ', '-')}"), paragraph(r["reason"])]
    if r.get("remedy"):
        head.append(paragraph(f"Remedy: {r['remedy']}", class_="note"))
    for key in ("note", "stopped", "failure"):
        if r.get(key):
            head.append(paragraph(f"{'Ended early: ' if key != 'note' else 'Note: '}{r[key]}", class_="note"))
    parts = [section("Verdict", *head, about.warnings(r), rests_on(r), flight(r.get("by_value")))]
    if history is not None and history.size > 1:
        parts.append(section("Motion", marches.motion(history, r, named)))
        parts.append(section("Phase", marches.phase(history, named)))
        parts.append(section("Loads", marches.loads(history, named)))
    s = run.settings
    chord, axis = float(s.get("section.chord", 1.0)), float(s.get("section.elastic_axis", 0.0))
    shown = films.of_folder(run.path, chord, axis, named) if run.path.is_dir() else Markup("")
    section_drawn = outline(run.path / "airfoil.csv", r.get("airfoil_summary") or "")
    flow = section("Flow and section", tag("div", shown, section_drawn, class_="charts") if shown or section_drawn else None)
    parts += [flow, section("Modes of the motion", modes(r), about_curves())]
    health = [about.health(r.get("scheme"), r.get("unconverged_steps") or {}, int(r.get("steps") or 0))]
    if history is not None and history.size > 1:
        health.append(marches.health(history, named))
    parts += [section("Coupling health", *health), section("Cost", about.cost(r.get("cost") or {}))]
    return f"{sentence(named)}: {r['verdict']}", parts


def rests_on(r: dict[str, Any]) -> Markup:
    """The numbers behind the verdict."""
    hertz = f" ({r['frequency'] * r['omega_alpha'] / (2.0 * math.pi):.4g} Hz)" if r.get("frequency") else ""
    rows: list[tuple[str, Any]] = [
        ("growth rate σ/ω_α", with_error(r.get("growth_rate"), r.get("growth_rate_uncertainty"))),
        (
            "frequency ω/ω_α",
            with_error(r.get("frequency"), r.get("frequency_uncertainty")) + hertz if r.get("frequency") else None,
        ),
        ("damping ratio", None if r.get("damping_ratio") is None else f"{r['damping_ratio']:+.5f}"),
        ("free cycles", number(r.get("free_cycles"))),
        ("poles found", f"{len(r.get('modes') or [])} oscillations, {len(r.get('real_poles') or [])} real"),
        ("missed by the fit", percent(r.get("fit_residual"))),
        ("forecast of the last part off by", percent(r.get("fit_forecast"))),
        (
            "settled: more cycles change nothing",
            r.get("settled") if r.get("settled") is None else "yes" if r["settled"] else "no",
        ),
        ("pitch stiffness that the steady flow leaves", percent(r.get("static_stiffness"))),
        ("limit cycle, pitch amplitude [deg]", number(r.get("limit_cycle_amplitude_deg"))),
        ("validity of the slosh model (edge 1)", number(r.get("slosh_validity"))),
        ("motion as computed", r.get("motion_verdict") if r.get("slosh_holds") is False else None),
    ]
    parts = [
        (f"  uncertainty: {name.replace('_', ' ')}", f"{value:.2g}") for name, value in (r.get("uncertainty_parts") or {}).items()
    ]
    missing = ", ".join(r.get("uncertainty_missing") or [])
    return facts([*rows, *parts, ("not in the error bar", missing)])


def modes(r: dict[str, Any]) -> Markup:
    """Every pole of the free motion."""
    found = [*(r.get("modes") or []), *(r.get("real_poles") or [])]
    rows = [
        (
            n + 1,
            float(m["growth_rate"]),
            float(m["frequency"]),
            f"{100.0 * m['share']:.2f} %" if m.get("share") is not None else "",
        )
        for n, m in enumerate(found)
    ]
    return table(("pole", "growth rate σ/ω_α", "frequency ω/ω_α", "share of the motion"), rows)


def about_curves() -> Markup:
    """Where the V–g curves are."""
    return paragraph("One march is one point of the V–g and V–f curves; `aeroslosh boundary` of the same case has the curves.")


def flight(d: dict[str, Any] | None) -> Markup:
    """Speeds, air and section by value."""
    if not d:
        return Markup("")
    names = {
        "airspeed": ("true airspeed", 1.0, "m/s"), "equivalent_airspeed": ("equivalent airspeed", 1.0, "m/s"),
        "dynamic_pressure": ("dynamic pressure", 1e-3, "kPa"), "pressure_altitude": ("pressure altitude", 1.0, "m"),
        "density": ("air density", 1.0, "kg/m³"), "mass": ("mass of the section", 1.0, "kg/m"),
        "plunge_frequency": ("plunge frequency alone", 1.0, "Hz"), "pitch_frequency": ("pitch frequency alone", 1.0, "Hz"),
    }  # fmt: skip
    return facts(
        (f"{name} [{unit}]", f"{d[key] * scale:.4g}") for key, (name, scale, unit) in names.items() if d.get(key) is not None
    )


def _history(run: PastRun) -> History | None:
    path: Path | None = run.histories.get("history")
    if path is None:
        return None
    found = history_file.read(path)
    return found[0] if found else None
