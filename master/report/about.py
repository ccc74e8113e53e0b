"""What a run rests on besides its result: settings that differ from the defaults, what it took, where it comes from."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable
from typing import Any

from ..base import toml_text
from ..case import case as cases
from ..case.case import TABLES
from ..cosim import system_file
from ..results.past_run import PastRun
from .markup import Markup, facts, join, paragraph, table, tag
from .words import number

COSTS = {
    "wall_seconds": "wall clock [s]",
    "cpu_seconds": "processor [s]",
    "steady_cpu_seconds": "steady start, processor [s]",
    "companion_cpu_seconds": "coarse marches for the error bar, processor [s]",
}


def settings(run: PastRun) -> Markup:
    """Keys of the case, or of the system file, whose values are not the defaults; all of them with their meaning."""
    unread = {
        "point": ("output", "sweep", "boundary"),
        "amplitude": ("output", "sweep", "boundary"),
        "boundary": ("output", "sweep"),
        "sweep": ("output",),
    }
    tables = {n: c for n, c in TABLES.items() if n not in unread.get(run.kind, ())}
    if run.kind == "run":
        tables = {"run": system_file.Run, "system": system_file.Wiring, "coupling": cases.Coupling}
    known = {
        f"{table}.{f.name}": (_default(f), f.metadata.get("doc", ""))
        for table, content in tables.items()
        for f in dataclasses.fields(content)
    }
    rows = []
    for key, value in run.settings.items():
        if key.startswith("components."):
            for name, own in value.get("parameters", {}).items():
                rows.append((f"{key}.{name}", _text(own), "", f"parameter of {value['fmu']}"))
        elif key in known and _text(value) != _text(known[key][0]):
            default, meaning = known[key]
            unit = f" [{run.units[key]}]" if key in run.units else ""
            rows.append((key, _text(value), "none" if default is None else _text(default), tag("span", meaning + unit)))
    if not run.settings:
        return Markup("")
    said = paragraph("All others stand at their default; case.toml of the folder has every key with unit and meaning.")
    return join([table(("key", "value", "default", "meaning"), rows), said])


def health(scheme: dict[str, Any] | None, unconverged: dict[str, int], steps: int) -> Markup:
    """Coupling of one march or run in numbers."""
    if not scheme and not unconverged:
        return Markup("")
    scheme = scheme or {}
    rows: list[tuple[str, Any]] = [
        ("steps", scheme.get("steps")),
        ("passes a step, mean", number(scheme.get("passes_mean"))),
        ("passes a step, most", scheme.get("passes_max")),
        ("steps tried again", scheme.get("retried_steps")),
    ]
    rows += [(f"steps that ended as “{word}”", n) for word, n in (scheme.get("outcomes") or {}).items()]
    rows += [(f"steps in which {name} did not converge", f"{n} of {steps}") for name, n in unconverged.items()]
    return facts(rows)


def cost(data: dict[str, Any], more: Iterable[tuple[str, Any]] = ()) -> Markup:
    """Seconds, and the share of each component."""
    spent = data.get("cpu_seconds_by_component") or {}
    total = sum(spent.values()) or 1.0
    rows: list[tuple[str, Any]] = [(label, number(data.get(key))) for key, label in COSTS.items()]
    rows += [(f"{name} [s]", f"{seconds:.3g} ({100.0 * seconds / total:.0f} %)") for name, seconds in spent.items()]
    if data.get("master_share") is not None:
        rows.append(("the master's own share", f"{100.0 * data['master_share']:.1f} %"))
    return facts([*rows, *more])


def provenance(run: PastRun) -> Markup:
    """Where the numbers come from."""
    rows = [(tag("span", name), value) for name, value in run.provenance.items()]
    return facts(rows)


def warnings(result: dict[str, Any]) -> Markup:
    """What was unusual in the case."""
    return join(paragraph(f"Warning: {text}", class_="note") for text in result.get("warnings") or [])


def _default(field: dataclasses.Field[Any]) -> Any:
    if field.default is not dataclasses.MISSING:
        return field.default
    return field.default_factory() if field.default_factory is not dataclasses.MISSING else None


def _text(value: Any) -> str:
    return "" if value is None else toml_text.literal(value)
