"""The page of a sweep: what became of every point, the map or curves over the swept keys with a slider over V_f, the motions."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np

from ..case.fuel_tank import LABEL
from ..results import history_file
from ..results.past_run import PastRun
from ..results.point_file import Record
from . import about, marches, ticks
from .chart import Chart, Dots, Line, Tiles
from .markup import Markup, join, paragraph, section, table, tag
from .words import sentence, with_error

V_F = "flutter.V_f"
ROWS, MOTIONS = 400, 40
COLOURS = {"damped": "blue", "flutter": "red", "divergence": "purple", "limit cycle": "sky"}
SHAPES = {"damped": "circle", "flutter": "square", "divergence": "triangle", "neutral": "diamond", "limit cycle": "diamond"}
STROKES = ("grey", "purple", "ink", "sky", "grey", "purple")  # of lines that join points, each second one dashed
Row = dict[str, Any]
Range = tuple[float, float] | None


def build(run: PastRun) -> tuple[str, list[Markup]]:
    """Title and parts of the page of a sweep's folder."""
    records = run.points
    names = list(dict.fromkeys(name for r in records.values() for name in r.overrides))
    kinds = {r.kind for r in records.values()}
    rows = [row for key, record in records.items() for row in _rows(key, record)]
    rows.sort(
        key=lambda row: [
            (isinstance(row.get(n), str), str(row.get(n)) if isinstance(row.get(n), str) else row.get(n)) for n in names
        ]
    )
    verdicts = Counter(str(row["verdict"]) for row in rows)
    count = ", ".join(f"{n} {word}" for word, n in verdicts.most_common())
    liquids = ", ".join(sorted({LABEL.get(row["slosh"], str(row["slosh"])) for row in rows if row.get("slosh")}))
    title = f"Sweep over {' and '.join(names)}{', ' + liquids if liquids else ''}: {len(records)} points"
    parts = [section("What was found", paragraph(f"{len(records)} points: {count}."), _broken(rows))]
    boundary = kinds == {"boundary"}
    value, label = ("V_f", "neutral V_f [–]") if boundary else ("growth_rate", "growth rate σ/ω_α (above 0: unstable) [–]")
    axes = [*names, "mach"] if boundary and "flow.mach" not in names else names
    parts.append(section("Over what was swept", _drawn(rows, axes, value, label, liquids)))
    parts.append(section("Motions", None if boundary else _motions(run, rows)))
    parts.append(section("Points", _table(rows, names, boundary)))
    failed = [(key, r.cause) for key, r in records.items() if r.status == "failed"]
    parts.append(section("Failures", table(("point", "cause"), failed)))
    spent = {
        "wall_seconds": sum(r.wall_seconds for r in records.values()),
        "cpu_seconds": sum(r.cpu_seconds for r in records.values()),
    }
    parts.append(section("Coupling health", _health(rows)))
    parts.append(
        section("Cost", about.cost(spent, [("points started more than once", sum(r.attempts > 1 for r in records.values()))]))
    )
    return title, parts


def _rows(key: str, record: Record) -> list[Row]:
    """A row a point, or a Mach number of a boundary."""
    result = record.result or {}
    found = result.get("points", []) if record.kind == "boundary" else [result]
    base = {"point": key, "status": record.status} | record.overrides
    return [
        base | {"verdict": r.get("verdict") or record.status, "result": r}
        | {k: r.get(k) for k in ("mach", "V_f", "V_f_uncertainty", "growth_rate", "growth_rate_uncertainty", "frequency", "slosh",
                                 "slosh_holds", "slosh_validity", "outcome")}
        for r in found or [{}]
    ]  # fmt: skip


def _broken(rows: list[Row]) -> Markup | None:
    bad = [row for row in rows if row["slosh_holds"] is False]
    said = f"In {len(bad)} of {len(rows)} the slosh model does not hold: no verdict there, crosses in the charts."
    return paragraph(said, class_="note") if bad else None


def _drawn(rows: list[Row], names: list[str], value: str, label: str, liquids: str) -> Markup:
    """A map of two swept numbers, curves over each; where V_f is swept with others, also curves at one V_f, with a slider."""
    known = [row for row in rows if row[value] is not None]
    numbers = [n for n in names if all(_number(row[n]) for row in known) and len({row[n] for row in known}) > 1]
    if not known or not numbers:
        return paragraph("Nothing that could be drawn: no two numbers were swept, or no point has a result.")
    charts: list[Markup] = []
    if len(numbers) == 2 and len({tuple(row[n] for n in numbers) for row in known}) == len(known):
        charts.append(_map(known, numbers, value, label, liquids))
    for name in numbers:
        charts.append(_curve(known, name, numbers, value, label, liquids))
    slider = None
    rest = [n for n in numbers if n != V_F]
    if V_F in numbers and rest and value == "growth_rate":
        places = sorted({row[V_F] for row in known})
        seen = ticks.limits(np.array([0.0, *(row[value] for row in known)]))  # the same axis wherever the slider stands
        choices = []
        for V_f in places:
            here = [row for row in known if row[V_F] == V_f]
            drawn = [
                _curve(here, n, rest, value, label, liquids, f"V_f {V_f:g}", seen)
                for n in rest
                if len({row[n] for row in here}) > 1
            ]
            if drawn:
                choices.append(
                    tag("div", tag("div", *drawn, class_="charts"), class_="choice", data_value=f"{V_f:g}", data_number=V_f)
                )
        if len(choices) > 1:
            slider = join([tag("h3", "At one V_f"), tag("div", *choices, class_="picker", data_name="V_f")])
    return join([tag("div", *charts, class_="charts"), slider])


def _map(known: list[Row], numbers: list[str], value: str, label: str, liquids: str) -> Markup:
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    from ..pictures import look

    x, y = (sorted({row[n] for row in known}) for n in numbers)
    values = np.array([row[value] for row in known])
    signed = value == "growth_rate"
    ramp = [to_hex(c) for c in look.signed()] if signed else [to_hex(c) for c in colormaps[look.EVEN](np.linspace(0, 1, 255))]
    most = float(np.abs(values).max()) or 1.0
    low, high = (-most, most) if signed else (float(values.min()), float(values.max()) or 1.0)
    edges = [_edges(np.array(axis, dtype=float)) for axis in (x, y)]
    boxes, colours, texts = [], [], []
    for row in known:
        i, j = x.index(row[numbers[0]]), y.index(row[numbers[1]])
        boxes.append((edges[0][i], edges[0][i + 1], edges[1][j], edges[1][j + 1]))
        share = (row[value] - low) / (high - low) if high > low else 0.5
        colours.append(ramp[round(254 * min(1.0, max(0.0, share)))])
        texts.append(f"{row['point']}: {value.replace('_', ' ')} {row[value]:.4g}, {row['verdict']}")
    bad = [row for row in known if row["slosh_holds"] is False]
    places = [np.array([row[n] for row in bad]) for n in numbers]
    crosses = [Dots(places[0], places[1], "slosh model does not hold", "ink", "cross")] if bad else []
    spoken = [_spoken(n) for n in numbers]
    chart = Chart(
        f"{sentence(label.split(' [')[0])}, {liquids}",
        spoken[0],
        spoken[1],
        [Tiles(boxes, colours, texts), *crosses],
        height=260.0,
    )
    gradient = f"background: linear-gradient(90deg, {', '.join(ramp[::16])})"
    scale = tag("div", f"{low:.3g}", tag("span", "", class_="ramp", style=gradient), f"{high:.3g}", class_="scale")
    return tag("div", chart.html(), scale)


def _curve(
    known: list[Row], name: str, numbers: list[str], value: str, label: str, liquids: str, about_: str = "", y_range: Range = None
) -> Markup:
    """Dots over one key, by verdict."""
    dots: list[Line | Dots] = []
    others = [n for n in numbers if n != name]
    if len(others) == 1:  # points of one value of the other key belong together
        for other in sorted({row[others[0]] for row in known}):
            line = sorted((float(row[name]), float(row[value])) for row in known if row[others[0]] == other)
            if len(line) > 1 and len({x for x, _ in line}) == len(line):
                x, y = np.array(line).T
                dots.append(
                    Line(
                        x,
                        y,
                        f"{_spoken(others[0]).split(' [')[0].split(' (')[0]} {other:g}",
                        STROKES[len(dots) % len(STROKES)],
                        bool(len(dots) % 2),
                    )
                )
    dots = dots if len(dots) <= 6 else []
    for verdict in dict.fromkeys(str(row["verdict"]) for row in known):
        mine = [row for row in known if str(row["verdict"]) == verdict]
        x, y = np.array([float(row[name]) for row in mine]), np.array([float(row[value]) for row in mine])
        error = np.array([2.0 * (row.get(f"{value}_uncertainty") or 0.0) for row in mine])
        texts = [f"{row['point']}: {with_error(row[value], row.get(f'{value}_uncertainty'))}, {verdict}" for row in mine]
        dots.append(Dots(x, y, verdict, COLOURS.get(verdict, "ink"), SHAPES.get(verdict, "cross"), False, error, texts))
    what, over = (text.split(" [")[0].split(" (")[0] for text in (label, _spoken(name)))
    title = ", ".join(filter(None, [f"{sentence(what)} over {over}", liquids, about_]))
    return Chart(title, _spoken(name), label, list(dots), zero=value == "growth_rate", y_range=y_range).html()


def _motions(run: PastRun, rows: list[Row]) -> Markup | None:
    choices: list[Markup] = []
    for row in rows[:MOTIONS]:
        found = history_file.read(run.histories[row["point"]]) if row["result"] else []
        if not found or found[0].size < 2 or "tau" not in found[0].values:
            continue
        named = marches.title(row["result"], LABEL.get(row["slosh"], str(row["slosh"])))
        inner = join(
            [paragraph(f"{row['verdict']}: {row['result'].get('reason', '')}"), marches.motion(found[0], row["result"], named)]
        )
        number = row[V_F] if _number(row.get(V_F)) else len(choices)
        choices.append(tag("div", inner, class_="choice", data_value=row["point"], data_number=number))
    if not choices:
        return None
    more = paragraph(f"The first {MOTIONS} of {len(rows)} points.", class_="small") if len(rows) > MOTIONS else None
    return join([tag("div", *choices, class_="picker", data_name="Point"), more])


def _table(rows: list[Row], names: list[str], boundary: bool) -> Markup:
    value = ("neutral V_f", "V_f") if boundary else ("growth rate σ/ω_α", "growth_rate")
    head = (*names, *(("Mach",) if "flow.mach" not in names else ()), "verdict", value[0], "frequency ω/ω_α")
    lines = []
    for row in rows[:ROWS]:
        number = row[value[1]]
        told = "" if number is None else with_error(number, row.get(f"{value[1]}_uncertainty"))
        mach = (row["mach"],) if "flow.mach" not in names else ()
        keys = [f"{row[n]:g}" if _number(row.get(n)) else str(row.get(n, "")) for n in names]
        lines.append((*keys, *mach, row["verdict"], told, row["frequency"]))
    more = paragraph(f"The first {ROWS} of {len(rows)}; sweep.csv has all.", class_="small") if len(rows) > ROWS else None
    return join([table(head, lines), more])


def _health(rows: list[Row]) -> Markup:
    total: Counter[str] = Counter()
    for row in rows:
        for m in row["result"].get("marches", [row["result"]]):
            total["steps"] += m.get("steps") or 0
            for name, n in (m.get("unconverged_steps") or {}).items():
                total[f"steps in which {name} did not converge"] += n
    return table(("", "all points"), sorted(total.items(), key=lambda item: item[0] != "steps")) if total else Markup("")


def _edges(values: np.ndarray) -> np.ndarray:
    """Borders of the tiles around sorted values: half way between neighbours. Shape: (n + 1,)."""
    if values.size == 1:
        return np.array([values[0] - 0.5, values[0] + 0.5])
    inner = 0.5 * (values[1:] + values[:-1])
    return np.concatenate([[2 * values[0] - inner[0]], inner, [2 * values[-1] - inner[-1]]])


def _spoken(name: str) -> str:
    """A key as the axis names it, without formulas."""
    from ..pictures import look

    return look.words(name).replace("$V_f$", "V_f").replace("$\\mu$", "μ").replace("$", "")


def _number(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)
