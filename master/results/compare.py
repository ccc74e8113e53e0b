"""Do two runs tell the same? Settings, provenance, results, scheme statistics, cost and histories of two runs, side by side.

Only results and histories make runs different; settings and provenance say why they are, cost never counts. With a tolerance the
headline numbers and the channels of the physics are judged, without one every bit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from ..base.errors import AeroSloshError
from . import history_file
from .history_difference import HistoryDifference, difference
from .past_run import PastRun, flat

HEADLINE = (
    "verdict", "growth_rate", "frequency", "damping_ratio", "V_f", "mach", "slosh", "limit_cycle_amplitude_deg", "direction",
    "converged", "failure", "status", "outcome", "end_time",
)  # fmt: skip
SCHEME = (
    "scheme",
    "steps",
    "steps_per_cycle",
    "unconverged_steps",
    "marches",
    "release_index",
    "mean_subiterations",
    "mean_passes",
)
SIGNIFICANT = 2.0  # combined standard deviations


@dataclass(frozen=True)
class Difference:
    """One number, word or setting that differs. None where one side has none.

    group        "settings", "provenance", "results", "scheme", "details" or "cost"
    place        Mach number, crossing, march or file it belongs to; "" for the whole run
    change       B − A; `relative` to the larger of the two (a growth rate to the frequency)
    sigmas       |B − A| in combined uncertainties (root of the sum of squares), where the runs tell them
    counts       whether it makes the runs different
    """

    group: str
    place: str
    name: str
    a: Any
    b: Any
    unit: str = ""
    change: float | None = None
    relative: float | None = None
    sigmas: float | None = None
    counts: bool = False

    @property
    def ratio(self) -> float | None:
        """B / A of two numbers."""
        return self.b / self.a if self.change is not None and self.a else None

    @property
    def significant(self) -> bool | None:
        """Whether the change exceeds what the uncertainties explain; None where they are not told."""
        return None if self.sigmas is None else self.sigmas > SIGNIFICANT


@dataclass
class Comparison:
    """What `compare` found. `only_a`, `only_b`: points, crossings and histories of one run alone."""

    a: PastRun
    b: PastRun
    tolerance: float
    differences: list[Difference] = field(default_factory=list)
    histories: list[HistoryDifference] = field(default_factory=list)
    only_a: list[str] = field(default_factory=list)
    only_b: list[str] = field(default_factory=list)
    same_numbers: int = 0  # results, scheme statistics and details that agree to the bit

    @property
    def different(self) -> bool:
        """Whether the runs tell something else, by the tolerance."""
        marched = self.histories_judged and any(h.differs(self.tolerance) for h in self.histories)
        return bool(self.only_a or self.only_b) or marched or any(d.counts for d in self.differences)

    @property
    def points_apart(self) -> list[str]:
        """The points of both sweeps that differ."""
        places = {d.place for d in self.differences if d.counts}
        if self.histories_judged:
            places |= {h.name for h in self.histories if h.differs(self.tolerance)}
        # what belongs to a point is named like it, with ", Mach 0.8" or "_m01" behind
        return [n for n in self.a.points if any(p == n or p.startswith((f"{n},", f"{n}_")) for p in places)]

    def of(self, group: str) -> list[Difference]:
        """The differences of a group."""
        return [d for d in self.differences if d.group == group]

    @property
    def histories_judged(self) -> bool:
        """A boundary's marches are the way of its search: only without a tolerance must two searches go the same way."""
        searched = self.a.kind == "boundary" or any(p.kind == "boundary" for p in self.a.points.values())
        return self.tolerance == 0.0 or not searched

    def take(self, place: str, pair: Iterable[dict[str, Any]], judged: bool = True) -> None:
        """Compare two sets of numbers, nested or not. judged: whether they count where there is a tolerance."""
        a, b = (flat(side) for side in pair)
        for name in [*a, *(n for n in b if n not in a)]:
            group = _group(name, judged)
            x, y = a.get(name), b.get(name)
            if x == y and type(x) is type(y):
                self.same_numbers += group != "cost"
                continue
            change, relative, sigmas = _apart(name, a, b)
            if self.tolerance > 0.0:
                counts = group == "results" and (relative is None or relative > self.tolerance)
            else:
                counts = group != "cost"
            self.differences.append(Difference(group, place, name, x, y, "", change, relative, sigmas, counts))


def compare(a: PastRun, b: PastRun, tolerance: float = 0.0) -> Comparison:
    """Compare two runs of one kind. tolerance: relative, to a number's value and a channel's range; 0: to the bit.

    Raises AeroSloshError for runs of two kinds, a tolerance that is none, and files that cannot be read.
    """
    if not (math.isfinite(tolerance) and tolerance >= 0.0):
        raise AeroSloshError(f"--tolerance {tolerance:g}", "command line", "a relative difference from 0, e.g. 1e-6")
    if a.kind != b.kind:
        where = f"{a.path} is a {a.kind}, {b.path} a {b.kind}"
        raise AeroSloshError("The two are of different kinds", where, "compare runs of one command, or two histories")
    found = Comparison(a, b, tolerance)
    if a.settings and b.settings:
        _named(found, "settings", a.settings, b.settings, a.units | b.units)
    _named(found, "provenance", a.provenance, b.provenance, {})
    if a.kind == "boundary":
        _boundary(found, "", (a.result, b.result))
    elif a.kind == "sweep":
        _sweep(found)
    else:
        found.take("", (a.result, b.result))
    if a.path.is_dir() is b.path.is_dir():  # a lone result.json has no histories to miss
        _histories(found)
    return found


def _histories(found: Comparison) -> None:
    """Histories of one name, and the means of their solver channels."""
    a, b = found.a.histories, found.b.histories
    # a sweep's points have been matched already
    for name in [n for n in a if n in b] if found.a.points else _matched(found, "history", a, b):
        sides = [{h.name[len(h.path.stem) :]: h for h in history_file.read(run.histories[name])} for run in (found.a, found.b)]
        for march in _matched(found, "history", *({f"{name}{tail}": h for tail, h in side.items()} for side in sides)):
            pair = [side[march[len(name) :]] for side in sides]
            found.histories.append(difference(march, *pair))
            for channel in ("subiterations", "passes"):
                if all(channel in h.values and h.size > 1 for h in pair):
                    means = [{f"mean_{channel}": float(h.values[channel][1:].mean())} for h in pair]
                    found.take(march, means, judged=False)


def _named(found: Comparison, group: str, a: dict[str, Any], b: dict[str, Any], units: dict[str, str]) -> None:
    for name in [*a, *(n for n in b if n not in a)]:
        if a.get(name) != b.get(name):
            found.differences.append(Difference(group, "", name, a.get(name), b.get(name), units.get(name, "")))


def _matched(found: Comparison, what: str, a: dict[str, Any], b: dict[str, Any]) -> list[str]:
    """Names on both sides; those on one side are noted, where they count."""
    if what != "history" or found.histories_judged:
        found.only_a += [f"{what} {name}" for name in a if name not in b]
        found.only_b += [f"{what} {name}" for name in b if name not in a]
    return [name for name in a if name in b]


def _sweep(found: Comparison) -> None:
    """Point by point of the same overrides; those in one sweep alone are told as such."""
    for name in _matched(found, "point", found.a.points, found.b.points):
        records = [run.points[name] for run in (found.a, found.b)]
        found.take(name, ({"status": r.status, "cause": r.cause, "determined": r.determined} for r in records))
        results = [r.result or {} for r in records]
        if all("points" in result for result in results):
            _boundary(found, f"{name}, ", results)
        else:
            found.take(name, results)


def _boundary(found: Comparison, where: str, results: Sequence[dict[str, Any]]) -> None:
    """Point by point of Mach, crossing by crossing of its direction; then linear models and marches in their order."""
    points = [{f"{where}Mach {p['mach']:g}": p for p in result["points"]} for result in results]
    found.take(where.rstrip(", "), ({k: v for k, v in result.items() if k != "points"} for result in results))
    for place in _matched(found, "point", *points):
        a, b = (side[place] for side in points)
        # V_f and frequency of a point are those of its lowest crossing, said below
        left_out = ("crossings", "marches", "linear", "V_f", "V_f_uncertainty", "frequency", "outcome")
        found.take(place, ({k: v for k, v in p.items() if k not in left_out} for p in (a, b)))
        found.take(place, ({"outcome": p.get("outcome")} for p in (a, b)), judged=False)  # the crossings in words
        crossings = [_by_direction(p.get("crossings") or [], place) for p in (a, b)]
        for name in _matched(found, "crossing", *crossings):
            found.take(name, (crossings[0][name], crossings[1][name]))
        found.take(f"{place}, linear model", [p.get("linear") or {} for p in (a, b)], judged=False)
        marches = [p.get("marches") or [] for p in (a, b)]
        found.take(place, ({"marches": len(m)} for m in marches))
        for n, (x, y) in enumerate(zip(*marches, strict=False), start=1):
            found.take(f"{place}, march {n}", (x, y), judged=False)


def _by_direction(crossings: list[dict[str, Any]], place: str) -> dict[str, dict[str, Any]]:
    """Crossings by name: "Mach 0.85, onset", "Mach 0.85, recovery", "Mach 0.85, onset 2", counted from the lowest V_f."""
    named: dict[str, dict[str, Any]] = {}
    for crossing in sorted(crossings, key=lambda c: c["V_f"]):
        count = sum(c["direction"] == crossing["direction"] for c in named.values()) + 1
        named[f"{place}, {crossing['direction']}{f' {count}' if count > 1 else ''}"] = crossing
    return named


def _group(name: str, judged: bool) -> str:
    words = name.replace("[", ".").split(".")
    if "cost" in words:
        return "cost"
    if words[0] in SCHEME:
        return "scheme"
    return "results" if name in HEADLINE and judged else "details"


def _apart(name: str, a: dict[str, Any], b: dict[str, Any]) -> tuple[float | None, float | None, float | None]:
    """Change, relative change and combined uncertainties in it of a number on both sides; None for what is not told."""
    x, y = _number(a.get(name)), _number(b.get(name))
    if x is None or y is None:
        return None, None, None
    scale = max(abs(x), abs(y))
    if name == "growth_rate":  # near neutral its own value is no measure
        scale = max((abs(v) for side in (a, b) if (v := _number(side.get("frequency"))) is not None), default=scale)
    elif name == "damping_ratio":
        scale = 1.0
    change = y - x
    u, v = (_number(side.get(f"{name}_uncertainty")) for side in (a, b))
    sigmas = abs(change) / math.hypot(u, v) if u is not None and v is not None and (u or v) else None
    return change, abs(change) / scale if scale else 0.0, sigmas


def _number(value: Any) -> float | None:
    return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None
