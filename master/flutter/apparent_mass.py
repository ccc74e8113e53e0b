"""Which coupling a section needs for the mass of the air that moves with it.

A scheme that passes loads on once a step extrapolates them: by a parabola, whose error moves growth rates by 1e-5 at the usual
steps, where a line's moves them by 3e-4 (docs/verdict.md). The part of a load that is proportional to the acceleration, the
apparent mass of the flow, is then fed back a step late: an error that grows with its ratio to the section's own mass, and
divergence beyond 1/7 with a parabola, a third with a line (Causin, Gerbeau and Nobile, Comput. Methods Appl. Mech. Engrg. 194,
2005, doi 10.1016/j.cma.2004.12.005). Of the thin airfoil the apparent mass is known: pi rho b² [[1, −a b], [−a b, b² (1/8 +
a²)]] (Theodorsen, NACA Report 496, 1935)."""

from __future__ import annotations

import dataclasses
import math
from typing import TYPE_CHECKING

import numpy as np

from ..base.errors import AeroSloshError
from ..case.case import Case
from ..case.scales import scales
from ..cosim.coupling_settings import Coupling

if TYPE_CHECKING:
    from ..case.fuel_tank import Liquid

PARABOLA = 2  # order of the extrapolation
ACCURATE = 0.07  # ratio up to which loads extrapolated by a parabola are passed on once a step: half of what is stable
LINE = 0.2  # ratio up to which growth rates are within 5e-4 when they are extrapolated by a line (docs/coupling.md)
STABLE = {0: 1.0, 1: 1.0 / 3.0, 2: 1.0 / 7.0}  # ratio beyond which such a march diverges, whatever its step, by order


def ratio(case: Case, mach: float, liquid: Liquid | None = None) -> float:
    """The largest ratio of the flow's apparent mass to that of the section, with the frozen `liquid` it carries."""
    s, a = scales(case, mach, case.flutter.V_f), 2.0 * case.section.elastic_axis - 1.0
    b = s.half_chord
    own = np.array([[s.mass, s.static_imbalance], [s.static_imbalance, s.inertia]])
    if liquid is not None:
        own = own + liquid.matrices()[0]
    air = math.pi * s.density * b**2 * np.array([[1.0, -a * b], [-a * b, b**2 * (0.125 + a**2)]])
    return float(np.max(np.linalg.eigvals(np.linalg.solve(own, air)).real))


def coupling(case: Case, mach: float, liquid: Liquid | None = None) -> tuple[Coupling, str]:
    """The coupling for `case`, and what to say of it: implicit where apparent mass needs it and the case does not choose.

    Raises AeroSloshError where the case chooses a scheme that diverges."""
    c, share = case.coupling, ratio(case, mach, liquid)
    if c.scheme == "implicit":
        return c, ""
    chosen = c.predictor_order != "auto"
    if not chosen and share <= ACCURATE:
        return dataclasses.replace(c, predictor_order=PARABOLA), ""
    if chosen and share <= min(LINE, 0.5 * STABLE[c.extrapolated]):
        return c, ""
    air = f"the air that moves with the section has {share:.0%} of its mass"
    if "coupling.scheme" not in case.given:
        return dataclasses.replace(c, scheme="implicit"), f"coupled implicitly: {air}"
    if share > STABLE[c.extrapolated]:
        raise AeroSloshError(
            f"{air[0].upper()}{air[1:]}: a march that passes loads on once a step diverges",
            f'{case.source or case.name}, coupling.scheme = "{c.scheme}"',
            'coupling.scheme = "implicit", or leave the key out',
        )
    if share <= LINE:
        return c, ""
    return c, f"{air}: growth rates are wrong by more than 5e-4 with coupling.scheme = {c.scheme}; implicit is right"
