"""What came out of a sweep: one flat row a point (or a Mach number of a boundary), as CSV and for pictures."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from .ledger import Row

POINT = (
    "mach", "V_f", "slosh", "verdict", "growth_rate", "growth_rate_uncertainty", "frequency", "frequency_uncertainty",
    "damping_ratio", "limit_cycle_amplitude_deg", "slosh_validity", "slosh_holds", "motion_verdict", "steps",
    "airspeed", "equivalent_airspeed", "dynamic_pressure", "pitch_frequency", "plunge_frequency", "mass",
)  # fmt: skip
BOUNDARY = (
    "mach", "V_f", "V_f_uncertainty", "frequency", "slosh", "verdict", "outcome", "converged", "slosh_validity", "slosh_holds",
    "airspeed", "equivalent_airspeed", "dynamic_pressure", "own_V_f", "margin",
)  # fmt: skip
RESULTS = {"point": POINT, "boundary": BOUNDARY}
ABOUT = ("cause", "attempts", "cpu_seconds", "wall_seconds", "file")


def flat(rows: Sequence[Row], kind: str, names: Sequence[str]) -> list[dict[str, Any]]:
    """Rows as dictionaries: id, status, the swept keys, then the results (None where there are none)."""
    table = []
    for row in rows:
        found = [row.result] if kind != "boundary" else (row.result or {}).get("points", [])
        for result in found or [None]:
            line: dict[str, Any] = {"id": row.id, "status": row.status}
            line |= {name: row.overrides.get(name) for name in names}
            values = ((result or {}).get("by_value") or {}) | (result or {})
            line |= {name: values.get(name) for name in RESULTS[kind]}
            table.append(line | {name: getattr(row, name) for name in ABOUT})
    return table


def as_csv(table: Sequence[dict[str, Any]], kind: str, names: Sequence[str]) -> bytes:
    """The rows of `flat` as CSV."""
    text = io.StringIO()
    writer = csv.DictWriter(text, ["id", "status", *names, *RESULTS[kind], *ABOUT], lineterminator="\n")
    writer.writeheader()
    writer.writerows(table)
    return text.getvalue().encode("utf-8")
