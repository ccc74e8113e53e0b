"""What mesh, step, outer boundary and amplitude may change in a neutral V_f, by two coarse linear models beside the one in use.

Mesh, step and outer boundary are coarsened together by the same factor, so that what they change is one error that falls with
it; a second coarse model swept by half the amplitude tells what the amplitude changes. At a crossing's V_f the eigenvalue of its
mode is compared, not the V_f of two crossings: a model that has the crossing elsewhere, or not at all, tells as much. All
three have the same poles: fits that each find their own differ by that too, as much as by the mesh. Together the two cost about
four tenths of the model. `boundary.uncertainty` replaces them by marches (module `uncertainty`).
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..analysis.crossings import Crossing
from ..base.errors import AeroSloshError
from ..case.case import Case
from ..flutter.coarse_marches import COARSER, PARTS, SHARE, coarse_case
from ..flutter.setup import FlutterSetup
from ..linear import model as linear_model
from ..linear.model import LinearCrossing, LinearModel

NO_SLOPE = 1e-6  # dσ/dV_f below which a growth rate does not tell a V_f


@dataclass(frozen=True)
class Companion:
    """Coarse linear models beside `model`, at its amplitude and at half of it."""

    model: LinearModel
    coarse: LinearModel
    half: LinearModel

    def parts(self, c: LinearCrossing) -> dict[str, float]:
        """Changes of V_f, signed: what is taken to be left to the converged V_f, and what half the amplitude changes."""
        if not c.frequency:
            own, coarse, half = (m.divergence() for m in (self.model, self.coarse, self.half))
            found = {"discretisation": SHARE * (own - coarse), "amplitude": half - coarse}
        elif abs(c.slope) > NO_SLOPE:
            own, coarse, half = (_growth_rate(m, c) for m in (self.model, self.coarse, self.half))
            found = {"discretisation": SHARE * (coarse - own) / c.slope, "amplitude": (coarse - half) / c.slope}
        else:
            found = {}
        return {name: value for name, value in found.items() if math.isfinite(value)}

    def widened(self, crossing: Crossing, c: LinearCrossing) -> Crossing:
        """`crossing`, which is `c` marched or as it is, with these parts in its error bar."""
        parts = self.parts(c)
        missing = tuple(name for name in PARTS if name not in parts)
        return dataclasses.replace(crossing, parts=crossing.parts | parts, missing=crossing.missing + missing)


def identify(
    open_setup: Callable[[Case, float], FlutterSetup], model: LinearModel, say: Callable[[str], None] = lambda text: None
) -> Companion | None:
    """The companion of `model`; None, and said why, where the coarse mesh has no steady flow or the FMU fails on it."""
    rough = coarse_case(model.case)
    cells = f"{rough.aero.cells_around} x {rough.aero.cells_normal} cells"
    say(f"  error bar: sweeps on {cells}, {model.amplitude_deg:g} and {0.5 * model.amplitude_deg:g} degrees")
    try:
        with open_setup(rough, model.mach) as setup:
            coarse, half = (
                linear_model.identify(setup, amplitude, step=COARSER * linear_model.STEP, beside=model)
                for amplitude in (model.amplitude_deg, 0.5 * model.amplitude_deg)
            )
    except AeroSloshError as error:
        say(f"  error bar: no coarse model: {error.what}")
        return None
    return Companion(model, coarse, half)


def _growth_rate(model: LinearModel, c: LinearCrossing) -> float:
    """Of the mode of `c` at its V_f, over omega_alpha."""
    values = model.eigenvalues(c.V_f)
    return float(values[np.argmin(np.abs(values - 1j * c.frequency))].real) if values.size else math.nan
