"""Flutter boundaries of the paper's section with each model of the fuel, shared by the figures that show them."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..api.boundary import boundary
from ..api.case import Case
from ..case.fuel_tank import LABEL
from ..pictures import canvas, look
from .outcome import Table
from .work import Work

MACH = (0.70, 0.80, 0.825, 0.85)
"""The paper has four Mach numbers and does not list them: 0.80, those of its Fig. 11 up to 0.85, and a subsonic one."""
SCATTER = {0.70: 0.016, 0.80: 0.006, 0.825: 0.012, 0.85: 0.007}
"""Standard deviation of V_f of single two-phase marches, which are chaotic: ensembles on 100 x 30 cells (docs/breaking-fuel.md);
at 0.825 that of two marches alone, 0.697 and 0.680."""
STYLE: dict[str, dict[str, Any]] = {
    "none": {"color": look.INK, "ls": "-", "marker": "o"},
    "frozen": {"color": look.GREY, "ls": "--", "marker": "s"},
    "ems": {"color": look.SKY, "ls": "-", "marker": "x"},
    "rbf": {"color": look.PURPLE, "ls": "-.", "marker": "^"},
    "vof": {"color": look.ORANGE, "ls": "-", "marker": "D"},
}
AMPLITUDE = "forced pitch of 1°, as the paper's"


class Onset(NamedTuple):
    """The lowest onset of flutter at a Mach number: V_f and its standard deviation, two-phase scatter included; frequency over
    omega_alpha; largest validity of the slosh model. nan where none was found."""

    slosh: str
    mach: float
    V_f: float
    doubt: float
    frequency: float
    validity: float
    marches: int
    cpu_seconds: float


def coarse(work: Work, case: Case) -> Case:
    """`case`, on a coarse mesh and without coarse companions where the task is small."""
    if not work.small:
        return case
    changes = {"aero.cells_around": 64, "aero.cells_normal": 16, "flutter.companion": False, "boundary.companion": False}
    tank = {} if case["slosh.model"] == "none" else {"slosh.cells_x": 30, "slosh.cells_y": 16}
    return case.changed(changes | tank)


def crossings(work: Work, name: str, slosh: str, mach: tuple[float, ...], changes: dict[str, Any] | None = None) -> list[Any]:
    """Points of a boundary (as in its result.json) of the built-in case `name`, computed once for all figures."""
    case = coarse(work, Case.load(name).changed({"slosh.model": slosh, **(changes or {})}))
    told = "_".join([name, slosh, *(f"{k}={v}" for k, v in (changes or {}).items())])

    def compute() -> list[Any]:
        found = boundary(case, mach=list(mach), fmus=work.fmus, workers=work.workers)
        return [{k: p[k] for k in ("mach", "outcome", "crossings", "cost")} for p in found.data["points"]]

    return list(work.shared(f"boundary_{told}", compute))


def onsets(work: Work, slosh: str) -> dict[float, Onset]:
    """Mach number → onset of the section of cases/paper_s.toml with one model of the fuel."""
    mach = work.pick(MACH, (MACH[1],))
    return {p["mach"]: onset(slosh, p) for p in crossings(work, "paper_s", slosh, mach)}


def onset(slosh: str, point: dict[str, Any]) -> Onset:
    """Of one point of a boundary."""
    found = [c for c in point["crossings"] if c["direction"] == "onset"]
    if not found:
        return Onset(slosh, point["mach"], math.nan, math.nan, math.nan, math.nan, 0, 0.0)
    first = min(found, key=lambda c: float(c["V_f"]))
    doubt = float(first["V_f_uncertainty"] or 0.0)
    if slosh == "vof":
        doubt = math.hypot(doubt, SCATTER.get(point["mach"], max(SCATTER.values())))
    validity = first["slosh_validity"]
    return Onset(
        slosh, point["mach"], float(first["V_f"]), doubt, float(first["frequency"]),
        math.nan if validity is None else float(validity), point["cost"]["marches"], point["cost"]["cpu_seconds"],
    )  # fmt: skip


def table(found: dict[str, dict[float, Onset]]) -> Table:
    """All onsets."""
    header = (
        "slosh", "Mach", "V_f", "V_f standard deviation", "frequency [omega_alpha]", "slosh validity", "marches", "CPU [s]",
    )  # fmt: skip
    return Table(header, [tuple(o) for by_mach in found.values() for o in by_mach.values()])


def shifts(found: dict[float, Onset], dry: dict[float, Onset]) -> str:
    """By how much V_f differs from the dry section's, in words."""
    return ", ".join(f"Mach {m:g} {100 * (o.V_f / dry[m].V_f - 1):+.1f} %" for m, o in found.items())


def conditions(work: Work) -> list[str]:
    """What is chosen for the boundaries."""
    return [
        "Isogai A ratios on a chord of 2 m, so that the tank fits (cases/paper_s.toml): 30 kg/m of fuel, 13 % of the "
        f"section's mass, in a tank of 0.5 x 0.15 m, half full, its centre at the section's centre of gravity; {AMPLITUDE}, "
        "two forced cycles; the linear model of the air predicts, two to four marches confirm",
        f"Mach {', '.join(f'{m:g}' for m in work.pick(MACH, MACH[1:2]))}: fewer than docs/slosh_boundary.md has, to save time",
        "error bars: two standard deviations of fit, mesh and amplitude; for the two-phase flow also what one chaotic march "
        "may be off by (standard deviation 0.016, 0.006, 0.012, 0.007 in V_f at Mach "
        "0.70, 0.80, 0.825, 0.85: docs/breaking-fuel.md; at 0.825 that of two marches)",
    ]


def draw(found: dict[str, dict[float, Onset]], title: str, marked: dict[str, tuple[float, float]] | None = None) -> Any:
    """V_f over Mach number with two standard deviations; below, the change against the dry section. marked: label → Mach and V_f
    of points of the paper."""
    figure, (top, low) = canvas.subplots(
        2, 1, figsize=(7.4, 8.2), sharex=True, gridspec_kw={"height_ratios": [1.7, 1.0]}, layout="constrained"
    )
    dry = found["none"]
    for model, by_mach in found.items():
        mach = list(by_mach)
        V_f, bars = [o.V_f for o in by_mach.values()], [2.0 * o.doubt for o in by_mach.values()]
        shown: dict[str, Any] = {"mfc": "none", "ms": 7, "capsize": 3, **STYLE[model]}
        top.errorbar(mach, V_f, bars, label=LABEL[model], **shown)
        if model != "none":
            change = [100.0 * (v / dry[m].V_f - 1.0) for m, v in zip(mach, V_f, strict=True)]
            low.errorbar(mach, change, [100.0 * e / dry[m].V_f for e, m in zip(bars, mach, strict=True)], **shown)
    for k, (label, (mach_, V)) in enumerate((marked or {}).items()):
        top.plot(mach_, V, "v^P*"[k % 4], color=look.BLUE, ms=8, mfc="none", ls="none", label=f"paper: {label}")
    low.axhline(0.0, color=look.INK, lw=0.8)
    top.set(ylabel=look.SPEED_INDEX.replace("flutter speed index", "neutral"))
    low.set(xlabel=look.MACH, ylabel="change against dry [%]")
    figure.suptitle(title, fontsize=11)
    canvas.legend(figure, top)
    return figure
