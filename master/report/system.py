"""The page of a system's run: what each component put out, how the coupling fared."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..results import history_file
from ..results.past_run import PastRun
from . import about, films
from .chart import Chart, Line
from .markup import Markup, facts, paragraph, section, table, tag

MOST = 36  # channels drawn


def build(run: PastRun) -> tuple[str, list[Markup]]:
    """Title and parts of the page of a run folder of `aeroslosh run`."""
    r = run.result
    head = [
        tag("p", r.get("outcome", "finished"), class_="verdict" + ("" if r.get("failure") is None else " v-flutter")),
        facts([("end [s]", r.get("end_time")), ("all steps converged", "yes" if r.get("converged") else "no")]),
    ]
    if r.get("failure"):
        head.append(paragraph(str(r["failure"]), class_="note"))
    for name, value in (r.get("last") or {}).items():
        if name.endswith(".validity") and value is not None and value > 1.0:
            head.append(
                paragraph(
                    f"{name.removesuffix('.validity')} says that it does not hold: validity {value:.3g}, edge 1", class_="note"
                )
            )
    parts = [section("Outcome", *head)]
    histories = [h for path in run.histories.values() for h in history_file.read(path)]
    for h in histories:
        parts.append(section("Outputs over time", *_outputs(h.values, h.units)))
        if "passes" in h.values and np.ptp(h.values["passes"][1:]) > 0.0:
            line = Line(h.values["time"][1:], h.values["passes"][1:], "passes", "purple")
            drawn = Chart("Passes over the components", "time [s]", "passes a step [–]", [line], zero=True, zoom=True).html()
            parts.append(section("Passes", tag("div", drawn, class_="charts")))
    shown = films.of_folder(run.path, 1.0, 0.0, "")
    parts.append(section("Fields", tag("div", shown, class_="charts") if shown else None))
    loops = [paragraph(f"Algebraic loop: {' '.join(loop)}") for loop in r.get("algebraic_loops") or []]
    scheme = r.get("scheme") or {}
    parts.append(section("Coupling health", *loops, about.health(scheme, {}, int(scheme.get("steps") or 0))))
    wires = run.settings.get("system.wires") or []
    parts.append(section("Wires", table(("from", "to"), [[w.strip() for w in str(wire).split("->")] for wire in wires])))
    parts.append(section("Cost", about.cost(r.get("cost") or {})))
    return run.path.name + ": " + str(r.get("outcome", "")), parts


def _outputs(values: dict[str, np.ndarray], units: dict[str, str]) -> list[Any]:
    """A chart a channel; those of each component together, those that never move named."""
    moving = [n for n in values if n not in ("time", "passes", "tau") and np.ptp(values[n]) > 0.0]
    groups: dict[str, list[Markup]] = {}
    for name in moving[:MOST]:
        part, _, channel = name.rpartition(".")
        unit = "–" if units[name] in ("", "1") else units[name]
        line = Line(values["time"], values[name], channel or name, "blue")
        drawn = Chart(name, "time [s]", f"{(channel or name).replace('_', ' ')} [{unit}]", [line], height=150.0, zoom=True).html()
        groups.setdefault(part, []).append(drawn)
    found: list[Any] = [
        x for part, drawn in groups.items() for x in (tag("h3", part or "run"), tag("div", *drawn, class_="charts linked"))
    ]
    still = [n for n in values if n not in moving and n not in ("time", "passes", "tau")]
    if still:
        found.append(paragraph(f"Constant: {', '.join(f'{n} = {values[n][0]:.4g}' for n in still)}", class_="small"))
    if len(moving) > MOST:
        found.append(paragraph(f"Not drawn: {', '.join(moving[MOST:])}", class_="small"))
    return found
