"""The table of a boundary: a row a neutral V_f, and one for each Mach number that has none. `boundary.csv` of a run folder."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

COLUMNS = {  # column → where it is in the data: of the crossing, of the Mach number, or by value of either
    "mach": "point", "V_f": "crossing", "V_f_uncertainty": "crossing", "frequency": "crossing", "kind": "crossing",
    "direction": "crossing", "source": "crossing", "tolerance_met": "crossing", "slope": "crossing", "slosh": "point",
    "slosh_holds": "point", "static_divergence_V_f": "point", "airspeed": "stream", "equivalent_airspeed": "stream",
    "dynamic_pressure": "stream", "pressure_altitude": "stream", "own_V_f": "stream", "margin": "value",
    "neutral_pitch_frequency": "value", "flutter_airspeed": "value", "flutter_equivalent_airspeed": "value",
    "flutter_dynamic_pressure": "value", "outcome": "point",
}  # fmt: skip


def rows(points: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """The rows of `points` (Mach numbers as in result.json), in rising Mach number and V_f; None where there is no value.

    V_f, frequency over omega_alpha; slope d(growth rate)/d(V_f); SI units by value: m/s, Pa, m, Hz."""
    found = []
    for p in sorted(points, key=lambda p: p["mach"]):
        for c in sorted(p["crossings"], key=lambda c: c["V_f"]) or [{}]:
            places = {"point": p, "crossing": c, "stream": p.get("by_value") or {}, "value": c.get("by_value") or {}}
            found.append({name: places[place].get(name) for name, place in COLUMNS.items()})
    return found


def as_csv(points: Sequence[dict[str, Any]]) -> bytes:
    """The same as CSV; numbers in the shortest text that reads back to the same bits."""
    text = io.StringIO()
    writer = csv.DictWriter(text, list(COLUMNS), lineterminator="\n")
    writer.writeheader()
    writer.writerows(rows(points))
    return text.getvalue().encode("utf-8")
