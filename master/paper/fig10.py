"""Figure 10: C_L at Mach 0.70, 3 degrees against the number of cells, with order of convergence and grid convergence index.

The paper's four meshes hold about 2,300, 4,000, 8,100 and 16,000 elements; its C_L values are in the figure only. Nested meshes
stand beside. Index: Roache, J. Fluids Eng. 116 (1994) 405, doi:10.1115/1.2910291."""

from __future__ import annotations

import math
from typing import Any

from ..api.simulate import simulate
from ..pictures import canvas, look
from .claims import Claim, at_most
from .outcome import Outcome, Table
from .work import Work

MACH, ALPHA_DEG, AIRFOIL, FARFIELD = 0.70, 3.0, "NACA 64A010", 25.0
PAPER = ((90, 26), (118, 34), (168, 48), (238, 68))
NESTED = ((84, 24), (168, 48), (336, 96))
SMALL = ((64, 16), (80, 20), (96, 24))
PAPER_INDEX = 0.0017  # section IV A, on 8,100 elements
SAFETY = 1.25
Family = dict[int, float]


def make(work: Work) -> Outcome:
    """C_L on both families."""
    sizes = {"paper's sizes": work.pick(PAPER, SMALL), "nested": work.pick(NESTED, SMALL)}
    computed = {cells: lift(work, cells) for cells in dict.fromkeys(c for family in sizes.values() for c in family)}
    families = {name: {a * n: computed[a, n] for a, n in family} for name, family in sizes.items()}
    coarse, middle, fine = families["nested"].values()
    cells = tuple(families["nested"])
    ratio = math.sqrt(cells[2] / cells[1])
    p = order(coarse, middle, fine, ratio)
    found = index(middle, fine, ratio, p)
    remarks = [
        f"order {p:.2f} on nested meshes; C_L on {cells[1]:,} cells is {abs(middle / fine - 1):.3%} off {cells[2]:,} cells, "
        f"and the index there {found:.3%}",
        "the paper's refinement ratio of 1.5 is 1.41 by its numbers of elements (the root of 8,100/4,000 and of 16,000/8,100)",
    ]
    conditions = [
        f"O-mesh, outer boundary at {FARFIELD:g} chords, no viscosity; sizes around x normal: "
        + ", ".join(f"{a} x {n}" for a, n in computed),
        "the index is taken with the order limited to 2 where more was observed: it must not profit from a lucky triple",
    ]
    rows = [(name, n, value) for name, family in families.items() for n, value in family.items()]
    tables = {"lift": Table(("family", "cells", "C_L [–]"), rows)}
    return Outcome([judged(found)], conditions, tables, lambda: draw(families), remarks)


def judged(found: float) -> Claim:
    """The index of the mesh that all flows are computed on, against the paper's."""
    what = "grid convergence index of the mesh used (paper: 8,100 elements, here 8,064)"
    return at_most(what, "section IV A", 100.0 * PAPER_INDEX, 100.0 * found, "another mesh and scheme", " %")


def lift(work: Work, cells: tuple[int, int]) -> float:
    """C_L of the steady flow on an O-mesh of cells (around, normal)."""
    values = {
        "mach": MACH, "mean_alpha": math.radians(ALPHA_DEG), "airfoil": AIRFOIL, "farfield_chords": FARFIELD,
        "cells_around": cells[0], "cells_normal": cells[1],
    }  # fmt: skip
    still = {"time": [0.0, 1e-5], "alpha": [0.0, 0.0]}
    return float(simulate(work.fmu("aero"), still, parameters=values)["C_L"][0])


def order(coarse: float, middle: float, fine: float, ratio: float) -> float:
    """Observed order of convergence of three values on meshes refined by `ratio` each way; nan when not monotone."""
    quotient = (coarse - middle) / (middle - fine)
    return math.log(quotient) / math.log(ratio) if quotient > 0 else math.nan


def index(middle: float, fine: float, ratio: float, p: float) -> float:
    """Grid convergence index of the middle mesh, relative, with an order of at most 2; nan where there is no order."""
    p = min(p, 2.0)
    return SAFETY * abs(middle / fine - 1) / (1 - ratio**-p) if p > 0 else math.nan


def draw(families: dict[str, Family]) -> Any:
    """C_L over 1/N."""
    figure, axis = canvas.subplots(figsize=(7.0, 5.0), layout="constrained")
    looks = ((look.BLUE, "o", "-"), (look.ORANGE, "s", "--"))
    for (name, family), (colour, mark, dash) in zip(families.items(), looks, strict=True):
        axis.plot([1e4 / n for n in family], list(family.values()), color=colour, marker=mark, ls=dash, label=name, mfc="white")
    finest = list(families["nested"].values())[-1]
    band = finest * (1 - PAPER_INDEX), finest * (1 + PAPER_INDEX)
    axis.axhspan(*band, color=look.GREY, alpha=0.15, lw=0, label="± the paper's index, 0.17 %")
    axis.set(xlabel="$10^4$ / number of cells [–]", ylabel="lift coefficient $C_L$ [–]")
    figure.suptitle(f"Fig. 10: {AIRFOIL}, Euler flow, Mach {MACH:.2f}, incidence {ALPHA_DEG:g}°", fontsize=11)
    canvas.legend(figure, axis)
    return figure
