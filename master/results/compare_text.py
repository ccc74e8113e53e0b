"""A comparison as people read it (a summary, then what differs) and as data for programs."""

from __future__ import annotations

import dataclasses
import math
from typing import Any

from .compare import Comparison, Difference
from .history_difference import Channel, HistoryDifference
from .summary import number

FEW = 8  # lines a group, unless all are asked for
LONG = 100  # characters of two values that still stand on one line
LABELS = ("date", "host")  # a run's, not of what it computed with: told with everything only
GROUPS = {
    "settings": "Settings",
    "provenance": "Provenance",
    "results": "Results",
    "scheme": "Scheme statistics",
    "details": "Details of the results",
    "cost": "Cost",
}


def summary(found: Comparison) -> str:
    """A few lines: same or different, by what, since when."""
    lines = [f"A  {found.a.path}", f"B  {found.b.path}", _judgement(found)]
    named = [line(d) for d in found.of("settings") if d.a is not None and d.b is not None]
    unknown = len(found.of("settings")) - len(named)
    named += [f"{unknown} key{'s' * (unknown > 1)} that one alone has"] * bool(unknown)
    if found.a.settings and found.b.settings:
        lines.append(f"  settings     {_listed(named)}")
    lines.append(f"  provenance   {_listed([d.name for d in found.of('provenance') if d.name not in LABELS])}")
    results = [line(d) for d in _largest(found)]
    if found.a.points:
        matched = len(found.a.points.keys() & found.b.points.keys())
        lines.append(f"  points       {matched} in both, {len(found.points_apart)} of them differ")
    rest = len(found.of("details"))
    lines.append(f"  results      {results[0] if results else 'the same' if not rest else 'the same but for details'}")
    lines += [f"               {text}" for text in results[1:4]]
    if len(results) > 4 or rest:
        more = [f"{len(results) - 4} more results"] * (len(results) > 4) + [f"{rest} details"] * bool(rest)
        lines.append(f"               and {', '.join(more)} (of {found.same_numbers + len(results) + rest} numbers)")
    for side, only in (("A", found.only_a), ("B", found.only_b)):
        if only:
            lines.append(f"  only in {side}    {_listed(only)}")
    if found.histories:
        lines.append(f"  histories    {_histories(found.histories)}")
    ratios = [f"{d.name.split('.', 1)[-1]} {d.ratio:.3g}" for d in found.of("cost") if d.place == "" and d.ratio][:2]
    if ratios:
        lines.append(f"  cost, B / A  {', '.join(ratios)}")
    return "\n".join(lines)


def details(found: Comparison, everything: bool = False) -> str:
    """What differs, group by group, the largest first; everything: all of it, and the channels that do not differ."""
    blocks = []
    for group, title in GROUPS.items():
        entries = [d for d in found.of(group) if everything or d.name not in LABELS]
        if group == "results":
            entries = _largest(found)
        elif group in ("details", "cost"):
            entries.sort(key=lambda d: -math.inf if d.relative is None else -d.relative)
        if group == "cost" and not everything:
            continue
        blocks.append(_block(title, [line(d) for d in entries], everything))
    histories = sorted(found.histories, key=lambda h: -(h.worst.relative if h.worst else math.inf))
    for h in histories if everything else histories[:FEW]:
        channels = sorted(h.channels, key=lambda c: -c.relative)
        rows = [_channel(c, h.axis) for c in channels if everything or c.largest > 0.0]
        rows += [f"{name}: in one of them alone" for name in h.missing]
        blocks.append(_block(f"History {h.name}{f' ({h.how})' if h.how else ''}", rows, everything))
    less = sum(any(c.largest > 0.0 for c in h.channels) or bool(h.missing) for h in histories[FEW:])
    if less and not everything:
        blocks.append(f"\nand {less} histories that differ less (--all)")
    return "\n".join(block for block in blocks if block)


def data(found: Comparison) -> dict[str, Any]:
    """All of it, as JSON takes it."""
    groups = {
        group: [
            {k: v for k, v in dataclasses.asdict(d).items() if k != "group"}
            | {"ratio": d.ratio, "significant": d.significant, "sigmas": d.sigmas}
            for d in found.of(group)
        ]
        for group in GROUPS
    }
    histories = [
        {
            "name": h.name,
            "same": h.same,
            "axis": h.axis,
            "how": h.how,
            "samples": {"a": h.sizes[0], "b": h.sizes[1], "compared": h.compared},
            "first_departure": number(h.first),
            "missing": h.missing,
            "channels": [
                {
                    "name": c.name,
                    "unit": c.unit,
                    "largest": number(c.largest),
                    "relative": number(c.relative),
                    "at": c.at,
                    "first_departure": number(c.first),
                }
                for c in h.channels
            ],
        }
        for h in found.histories
    ]
    return {
        "a": str(found.a.path),
        "b": str(found.b.path),
        "kind": found.a.kind,
        "same": not found.different,
        "tolerance": found.tolerance,
        **groups,
        "points_apart": found.points_apart,
        "only_in_a": found.only_a,
        "only_in_b": found.only_b,
        "histories": histories,
    }


def _largest(found: Comparison) -> list[Difference]:
    """Results that differ: of many points the largest first, words before numbers; of one as they come."""
    results = found.of("results")
    many = found.a.kind in ("sweep", "boundary")
    return sorted(results, key=lambda d: -math.inf if d.relative is None else -d.relative) if many else results


def line(d: Difference) -> str:
    """One difference in words."""
    a, b = _pair(d)
    place = f"{d.place}: " if d.place else ""
    if len(a) + len(b) > LONG:
        return f"{place}{d.name}\n    A  {a}\n    B  {b}"
    text = f"{place}{d.name} {a} → {b}{f' {d.unit}' if d.unit else ''}"
    if d.change is None or d.relative is None:
        return text
    if d.group in ("scheme", "cost"):
        return text + (f" (× {d.ratio:.4g})" if d.ratio is not None else "")
    notes = [f"{d.change:+.2e}, {_percent(d.relative)}{' of the frequency' if d.name == 'growth_rate' else ''}"]
    if d.sigmas is not None:
        notes.append(f"{d.sigmas:.2g} of the combined uncertainty: {'significant' if d.significant else 'not significant'}")
    return f"{text} ({', '.join(notes)})"


def _judgement(found: Comparison) -> str:
    word = "DIFFERENT" if found.different else "SAME"
    if found.tolerance > 0.0:
        return f"{word} {'at' if found.different else 'within'} a tolerance of {found.tolerance:g}"
    return word if found.different else f"{word} to the bit, cost apart"


def _histories(histories: list[HistoryDifference]) -> str:
    same = sum(h.same for h in histories)
    apart = [h for h in histories if not h.same]
    if not apart:
        return f"{'the same' if same == 1 else f'all {same} the same'} to the bit"
    worst = max(apart, key=lambda h: h.worst.relative if h.worst else math.inf)
    text = f"{len(apart)} of {len(histories)} differ: " if len(histories) > 1 else ""
    if worst.worst is None:
        return f"{text}{worst.name} has nothing to compare"
    text += f"at most {_percent(worst.worst.relative)} of its range in {worst.worst.name}"
    first = min((h.first for h in apart if not math.isnan(h.first)), default=math.nan)
    return text + ("" if math.isnan(first) else f", apart since {_place(first, worst.axis)}")


def _channel(c: Channel, axis: str) -> str:
    if c.largest == 0.0:
        return f"{c.name}: the same"
    since = "" if math.isnan(c.first) else f", apart since {_place(c.first, axis)}"
    unit = "" if c.unit in ("", "1") else f" {c.unit}"
    return f"{c.name}: {c.largest:.3g}{unit}, {_percent(c.relative)} of its range, at {_place(c.at, axis)}{since}"


def _place(value: float, axis: str) -> str:
    return f"t = {value:.6g} s" if axis == "time" else f"{axis} = {value:.6g}"


def _percent(share: float) -> str:
    return f"{100.0 * share:.3g} %"


def _pair(d: Difference) -> tuple[str, str]:
    """Both values; numbers in as many digits as tell them apart."""
    if isinstance(d.a, float) and isinstance(d.b, float):
        return next((p for n in (5, 8, 11, 14) if (p := (f"{d.a:.{n}g}", f"{d.b:.{n}g}"))[0] != p[1]), (repr(d.a), repr(d.b)))
    absent = "absent" if d.group in ("settings", "provenance") else "none"
    return _value(d.a, absent), _value(d.b, absent)


def _value(value: Any, absent: str) -> str:
    if value is None:
        return absent
    return f'"{value}"' if isinstance(value, str) and (" " in value or not value) else str(value)


def _listed(words: list[str]) -> str:
    """How many, and the first of them."""
    if not words:
        return "the same"
    return ", ".join(words[:FEW]) + (f" and {len(words) - FEW} more" if len(words) > FEW else "")


def _block(title: str, rows: list[str], everything: bool) -> str:
    if not rows:
        return ""
    shown = rows if everything else rows[:FEW]
    more = [f"  and {len(rows) - len(shown)} more (--all)"] if len(rows) > len(shown) else []
    return "\n".join([f"\n{title}", *(f"  {row}" for row in shown), *more])
