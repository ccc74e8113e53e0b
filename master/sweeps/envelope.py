"""Where a given wing flutters at each altitude: matched points, of a boundary sweep over flow.altitude and flow.mach.

At an altitude the air is fixed, and a wing by value has a neutral V_f and a V_f of its own at every Mach number; where their
ratio, the margin, passes 1 between two Mach numbers, speed, Mach number and air belong together (docs/cases.md)."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from typing import Any

from ..results import by_value
from .ledger import Row

ALTITUDE, MACH = "flow.altitude", "flow.mach"
COLUMNS = ("altitude", "mach", "airspeed", "equivalent_airspeed", "dynamic_pressure", "onset", "mach_below", "mach_above")


def wanted(kind: str, names: Sequence[str]) -> bool:
    """Whether a sweep is of boundaries over altitude and Mach number."""
    return kind == "boundary" and {ALTITUDE, MACH} <= set(names)


def points(rows: Sequence[Row], names: Sequence[str]) -> list[dict[str, Any]]:
    """The matched points: altitude [m], Mach number, true and equivalent airspeed [m/s], dynamic pressure [Pa], `onset` (False:
    free of flutter again above), the Mach numbers between which it lies; and the values of whatever else was swept.

    Empty for a section without a pitch frequency of its own, and where no margin passes 1."""
    others = [n for n in names if n not in (ALTITUDE, MACH)]
    groups: dict[tuple[Any, ...], list[dict[str, Any]]] = {}
    for row in rows:
        group = (row.overrides[ALTITUDE], *(row.overrides[n] for n in others))
        groups.setdefault(group, []).extend((row.result or {}).get("points", []))
    found = []
    for group, machs in groups.items():
        for m in by_value.matched(machs):
            low, high = m["between"]
            about = dict(zip(("altitude", *others), group, strict=True))
            place = {name: m[name] for name in ("mach", *by_value.SPEEDS, "onset")}
            found.append(about | place | {"mach_below": low, "mach_above": high})
    return sorted(found, key=lambda p: ([str(p[n]) for n in others], p["altitude"], p["mach"]))


def as_csv(found: Sequence[dict[str, Any]], names: Sequence[str]) -> bytes:
    """`points` as CSV."""
    text = io.StringIO()
    others = [n for n in names if n not in (ALTITUDE, MACH)]
    writer = csv.DictWriter(text, [*others, *COLUMNS], lineterminator="\n")
    writer.writeheader()
    writer.writerows(found)
    return text.getvalue().encode("utf-8")


def lines(found: Sequence[dict[str, Any]], rows: Sequence[Row]) -> list[str]:
    """A line a point, and one for each altitude of the sweep that has none."""
    said = [
        f"  altitude {p['altitude']:g} m: {'flutters from' if p['onset'] else 'free again from'} about Mach {p['mach']:.4f}, "
        f"{p['airspeed']:.4g} m/s true, {p['equivalent_airspeed']:.4g} m/s EAS, q {p['dynamic_pressure'] / 1e3:.4g} kPa"
        for p in found
    ]
    without = sorted({row.overrides[ALTITUDE] for row in rows} - {p["altitude"] for p in found})
    if without:
        where = ", ".join(f"{a:g}" for a in without)
        said.append(f"  altitude {where} m: the margin is known to pass 1 between no two of the Mach numbers swept")
    return said
