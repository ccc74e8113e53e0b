"""Results by value: what V_f and Mach number mean in m/s, Pa, Hz and kg/m, and where the given wing flutters in the given air."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import Any

from ..boundary.search import BoundaryPoint
from ..case import by_value, dimensions
from ..case.scales import Scales, scales

Row = dict[str, Any]
SPEEDS = ("airspeed", "equivalent_airspeed", "dynamic_pressure")


def finite(values: dict[str, float]) -> dict[str, float | None]:
    """JSON has no nan."""
    return {name: value if math.isfinite(value) else None for name, value in values.items()}


def of_march(s: Scales) -> dict[str, float | None]:
    """Stream, air and section of one march: m/s, Pa, K, kg/m3, m, kg/m, kg, kg m, Hz, N/m2, N/rad."""
    return finite(dimensions.stream(s) | dimensions.section(s))


def of_point(point: BoundaryPoint, V_f: float | None) -> dict[str, float | None] | None:
    """Stream and air at the Mach number of `point`, the wing's own V_f there (None: it has none) and the margin of the lowest
    neutral `V_f` (None: there is none) over it; None without a case."""
    if point.case is None:
        return None
    own, s = by_value.omega_alpha(point.case), scales(point.case, point.mach, 1.0)
    own_V_f = s.omega_alpha / own if own else None
    low, high = point.case.boundary.V_f_range
    searched = {"V_f_searched_from": low, "V_f_searched_to": high}
    return finite(dimensions.stream(s)) | searched | {"own_V_f": own_V_f, "margin": V_f / own_V_f if V_f and own_V_f else None}


def of_crossing(point: BoundaryPoint, V_f: float) -> dict[str, float | None] | None:
    """What the neutral `V_f` of `point` means (`dimensions.crossing`)."""
    if point.case is None:
        return None
    return dimensions.crossing(scales(point.case, point.mach, V_f), by_value.omega_alpha(point.case))


def matched(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Where the wing of the case flutters in its air: between neighbouring Mach numbers of which the lowest neutral V_f of one
    is above the wing's own and that of the other below, both linear in Mach. Nothing is said across a Mach number that has no
    margin or whose slosh model does not hold. Empty for a section without frequencies."""
    found = []
    for begin_row, end_row in itertools.pairwise(sorted(rows, key=lambda r: r["mach"])):
        first, second = _margin(begin_row), _margin(end_row)
        if not first or not second or (first > 1.0) is (second > 1.0):
            continue
        (low, begin), (high, end) = ((row["mach"], row["by_value"]) for row in (begin_row, end_row))
        before, after = begin["own_V_f"] * (first - 1.0), end["own_V_f"] * (second - 1.0)
        share = before / (before - after)
        ratio = (low + share * (high - low)) / low
        values = [begin["airspeed"] * ratio, begin["equivalent_airspeed"] * ratio, begin["dynamic_pressure"] * ratio**2]
        about = {"mach": low * ratio, "between": [low, high], "margins": [first, second], "onset": first > second}
        found.append(about | dict(zip(SPEEDS, values, strict=True)) | {"pressure_altitude": end["pressure_altitude"]})
    return found


def march_lines(data: dict[str, float | None], liquid: bool) -> list[str]:
    """Two lines of a summary."""
    dry = " without liquid" if liquid else ""
    return [
        f"  flight       {_stream(data)}",
        f"  section      {data['mass']:.4g} kg/m, {data['static_imbalance']:.4g} kg and {data['inertia']:.4g} kg m about the "
        f"elastic axis{dry}; plunge {data['plunge_frequency']:.4g} Hz, pitch {data['pitch_frequency']:.4g} Hz",
    ]


def point_lines(row: Row) -> list[str]:
    """The lines of a Mach number: its stream, and every neutral V_f by value."""
    if row.get("by_value") is None:
        return []
    own, d = row["by_value"]["own_V_f"], row["by_value"]
    lines = [f"          flight: {_stream(d)}"]
    if own and not d["V_f_searched_from"] <= own <= d["V_f_searched_to"]:
        searched = f"{d['V_f_searched_from']:g} to {d['V_f_searched_to']:g}"
        lines.append(f"          the wing's own V_f {own:.4f} is outside the V_f searched ({searched}): widen boundary.V_f_range")
    for c in row["crossings"]:
        d = c["by_value"]
        line = f"          V_f {c['V_f']:.4f}: neutral with a pitch frequency of {d['neutral_pitch_frequency']:.4g} Hz"
        if d["margin"] is not None:
            line += f"; margin {d['margin']:.4f} over the wing's own V_f {d['own_V_f']:.4f}"
            line += f": {d['flutter_airspeed']:.4g} m/s true, {d['flutter_equivalent_airspeed']:.4g} m/s EAS, "
            line += f"q {d['flutter_dynamic_pressure'] / 1e3:.4g} kPa with its own stiffness at this Mach number and density"
        lines.append(line)
    return lines


def matched_lines(rows: Sequence[Row]) -> list[str]:
    """Where the wing flutters in its air, in words; nothing for a section without frequencies."""
    margins = [(margin, row["mach"]) for row in rows if (margin := _margin(row))]
    if not margins:
        return []
    lines = []
    for found in matched(rows):
        a, b = found["between"]
        way = "flutters from" if found["onset"] else "is free of flutter again from"
        lines.append(
            f"  this wing in this air {way} about Mach {found['mach']:.4f}: {_stream(found)} (between Mach {a:g}, margin "
            f"{found['margins'][0]:.3f}, and {b:g}, margin {found['margins'][1]:.3f})"
        )
    least, mach = min(margins)
    if not lines:
        sides = {margin > 1.0 for margin, _ in margins}
        state = "on both sides of" if len(sides) > 1 else "above" if least > 1.0 else "below"
        count = (
            "every Mach number has its" if len(margins) == len(rows) else f"{len(margins)} of {len(rows)} Mach numbers have their"
        )
        ends = f"least margin {least:.3f} at Mach {mach:g}"
        lines.append(f"  {count} lowest neutral V_f {state} the wing's own: {ends}")
    return lines


def _margin(row: Row) -> float | None:
    """Margin of the lowest onset of a Mach number (or of its lowest crossing), the one that the table names; None where there is
    none, or where the slosh model does not hold."""
    return row["by_value"]["margin"] if row["by_value"] and row.get("slosh_holds") is not False else None


def _stream(d: dict[str, Any]) -> str:
    """Speeds, dynamic pressure and altitude in words."""
    speeds = f"{d['airspeed']:.4g} m/s true, {d['equivalent_airspeed']:.4g} m/s EAS, q {d['dynamic_pressure'] / 1e3:.4g} kPa"
    altitude = d["pressure_altitude"]
    return speeds + (f", pressure altitude {altitude + 0.0:.0f} m" if altitude is not None else "")
