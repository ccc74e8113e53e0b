"""Does the slosh model hold in what was computed? A verdict or a boundary that rests on a model outside its limits is none.

Slosh FMUs with an output `validity` say how far they are from their limit: 1 is the edge, or their `validity_edge`. What counts
is the largest value of the whole march, forced part included: the waves at the release are those that the forced motion left,
and a surface once broken stays so. A crossing of a boundary rests on the marches nearest below and above its V_f; where there is
no crossing, the statement that there is none rests on all marches."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ..analysis.crossings import Crossing
from ..analysis.verdict import Verdict
from ..case.fuel_tank import EDGE, holds
from ..flutter.march import March

if TYPE_CHECKING:
    from ..boundary.search import BoundaryPoint


def validity(march: March) -> float | None:
    """The largest the slosh FMU told in the march; None where it tells none (dry, frozen, two-phase flow)."""
    told = march.history.get("slosh_validity")
    if told is None or not np.size(told):
        return None
    known = told[~np.isnan(told)]  # nan: after a failure
    return float(known.max()) if known.size else None


def edge(march: March) -> float:
    """Up to where the slosh FMU's validity lets a verdict stand: its `validity_edge`, or 1."""
    told = march.history.get("slosh_validity_edge")
    return float(np.nanmax(told)) if told is not None and np.size(told) else EDGE


def stands(march: March) -> bool:
    """Whether the slosh model held in a march."""
    return holds(validity(march), edge(march))


def point_stands(point: BoundaryPoint) -> bool:
    """Whether it held in what a Mach number of a boundary rests on."""
    return holds(of_point(point.crossings, point.marches), largest_edge(point.marches))


def largest_edge(marches: Sequence[March]) -> float:
    """Of marches with one slosh model; all have the same."""
    return max((edge(m) for m in marches), default=EDGE)


def verdict(march: March) -> Verdict:
    """The verdict that stands: `march.verdict` is one on the motion as computed."""
    return march.verdict if stands(march) else Verdict.UNDETERMINED


def remedy(march: March) -> str:
    """What to do about it: waves that are too high shrink with the motion, a liquid that is too viscous does not."""
    told = march.history["slosh_validity"]
    if told[0] > edge(march):  # at rest already
        return 'slosh.model = "vof": no motion is small enough for this liquid in this tank'
    worst = validity(march)
    assert worst is not None
    smaller = f"{1.1 * worst / edge(march):.2g} times smaller" if np.isfinite(worst) else "far smaller"
    return f'motions {smaller} (flutter.forced_amplitude_deg; fewer free cycles where they grow), or slosh.model = "vof"'


def of_crossing(crossing: Crossing, marches: Sequence[March]) -> float | None:
    """The larger validity of the marches nearest to a crossing from either side."""
    below = [m for m in marches if m.scales.V_f <= crossing.V_f]
    above = [m for m in marches if m.scales.V_f >= crossing.V_f]
    near = [*sorted(below, key=lambda m: -m.scales.V_f)[:1], *sorted(above, key=lambda m: m.scales.V_f)[:1]]
    return largest(near)


def of_point(crossings: Sequence[Crossing], marches: Sequence[March]) -> float | None:
    """That of a Mach number of a boundary."""
    marched = [c for c in crossings if c.source == "march"]
    if not marched:
        return largest(marches)
    return max((v for c in marched if (v := of_crossing(c, marches)) is not None), default=None)


def decided(point: BoundaryPoint) -> bool:
    """Whether the boundary at a Mach number is within its tolerance and rests on a model that holds."""
    return point.converged and point_stands(point)


def largest(marches: Sequence[March]) -> float | None:
    """Of all marches that tell one."""
    return max((v for m in marches if (v := validity(m)) is not None), default=None)
