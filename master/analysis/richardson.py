"""A value on three meshes: observed order, extrapolated value, grid convergence index.

Celik et al., Procedure for Estimation and Reporting of Uncertainty Due to Discretization in CFD Applications, J. Fluids Eng.
130(7), 2008, doi 10.1115/1.2960953.
"""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass
from typing import Any

SAFETY = 1.25  # of the grid convergence index on three meshes (95 %)
LOWEST, FORMAL = 0.5, 2.0  # the order used: below it the extrapolation leaps, the scheme's own above
ROUNDING = 1e-12  # relative difference of values that are the same
ROUNDS = 100  # of the fixed point for the order; it takes about ten


@dataclass(frozen=True)
class GridStudy:
    """`cells` and `values` of three meshes, the finest first.

    behaviour     "monotone", "oscillating" (the differences change sign) or "diverging" (they grow with refinement)
    order         observed; nan unless monotone
    order_used    the observed one, limited to LOWEST … FORMAL; nan unless monotone
    extrapolated  to no cell size; the finest mesh's value unless monotone
    error         of the finest mesh: extrapolated − finest; unless monotone the largest difference of two meshes
    gci           relative half width of a 95 % band about the finest mesh's value
    """

    cells: tuple[tuple[int, int], ...]
    values: tuple[float, ...]
    behaviour: str
    order: float
    order_used: float
    extrapolated: float
    error: float
    gci: float

    def as_data(self) -> dict[str, Any]:
        """For JSON, which has no nan."""
        data = dataclasses.asdict(self)
        return {name: None if isinstance(value, float) and math.isnan(value) else value for name, value in data.items()}


def study(cells: list[tuple[int, int]], values: list[float]) -> GridStudy:
    """`values` on meshes of `cells` (around, normal), the finest first. The cell size is (around · normal)^−1/2."""
    (fine, medium, coarse), sizes = values, [1.0 / math.sqrt(a * n) for a, n in cells]
    r21, r32 = sizes[1] / sizes[0], sizes[2] / sizes[1]
    e21, e32 = medium - fine, coarse - medium
    meshes, numbers = tuple(cells), tuple(values)
    widest = max(values) - min(values)
    order = _order(e21, e32, r21, r32) if e21 * e32 > 0.0 and widest > ROUNDING * abs(fine) else math.nan
    if not order > 0.0:
        if widest <= ROUNDING * abs(fine):  # the mesh does not matter at all
            return GridStudy(meshes, numbers, "monotone", math.nan, math.nan, fine, 0.0, 0.0)
        behaviour = "oscillating" if e21 * e32 < 0.0 else "diverging"
        return GridStudy(meshes, numbers, behaviour, math.nan, math.nan, fine, widest, SAFETY * widest / abs(fine))
    used = min(max(order, LOWEST), FORMAL)
    error = -e21 / (r21**used - 1.0)
    return GridStudy(meshes, numbers, "monotone", order, used, fine + error, error, SAFETY * abs(error / fine))


def _order(e21: float, e32: float, r21: float, r32: float) -> float:
    """p of (r32^p − 1) r21^p / (r21^p − 1) = e32 / e21, by Celik's fixed point; at most 0: the differences grow."""
    p = math.log(e32 / e21) / math.log(r21)
    for _ in range(ROUNDS):
        if not 1e-6 < p < 50.0:
            return p
        q = math.log((r21**p - 1.0) / (r32**p - 1.0))
        new = (math.log(e32 / e21) + q) / math.log(r21)
        if abs(new - p) < 1e-10:
            return new
        p = new
    return p
