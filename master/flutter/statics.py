"""Static divergence from the steady flow alone: the pitch moment's slope from two steady solutions.

A section diverges where the moment of the steady flow about the elastic axis takes all of the pitch stiffness:
I ω_α² + k_l = q c² dC_M/dα (Bisplinghoff, Ashley and Halfman, Aeroelasticity, 1955, section 8-2). No frequency and no growth rate
enters: an independent check of what marches and the linear model say of real poles."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass

from ..case.case import Case
from ..case.scales import Scales

STEP = math.radians(0.1)  # apart of the two steady solutions: small beside any shock's travel over a cell, large beside rounding


@dataclass(frozen=True)
class SteadySlopes:
    """dC_L/dα and dC_M/dα (about the elastic axis, nose-up) of the steady flow, per radian."""

    C_L: float
    C_M: float

    def stiffness(self, s: Scales, liquid: float = 0.0) -> float:
        """Pitch stiffness left at `s`, over the structure's own; `liquid`: stiffness of the liquid [N/rad per metre of span]."""
        own = s.inertia * s.omega_alpha**2
        return 1.0 + (liquid - self._taken(s)) / own

    def divergence(self, s: Scales, liquid: float = 0.0) -> float:
        """The V_f of static divergence in the stream of `s`, whose own V_f does not matter; inf where there is none."""
        taken = (self._taken(s) - liquid) / (s.inertia * s.omega_alpha**2 * s.V_f**2)
        return 1.0 / math.sqrt(taken) if taken > 0.0 else math.inf

    def _taken(self, s: Scales) -> float:
        """Stiffness that the flow takes [N/rad per metre of span]."""
        return 0.5 * s.density * s.speed**2 * (2.0 * s.half_chord) ** 2 * self.C_M


def tilted(case: Case, step: float) -> Case:
    """`case` at a mean incidence higher by `step` [rad]."""
    flow = dataclasses.replace(case.flow, mean_alpha_deg=case.flow.mean_alpha_deg + math.degrees(step))
    return dataclasses.replace(case, flow=flow)
