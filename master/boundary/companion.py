"""What mesh, step, outer boundary and amplitude may change in a neutral V_f, by two coarse linear models beside the one in use.

Mesh, step and outer boundary are coarsened together by the same factor, so that what they change is one error that falls with
it; a second coarse model swept by half the amplitude tells what the amplitude changes. At a crossing's V_f the eigenvalue of its
mode is compared, not the V_f of two crossings: a model that has the crossing elsewhere, or not at all, tells as much. The change
of a growth rate over V_f passes through zero somewhere, and a crossing there is no better known for it: what the neighbourhood
changes (rms over V_f within a tenth) is the least. All
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
BESIDE = (0.9, 0.95, 1.05, 1.1)  # of V_f


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
            found = {
                "discretisation": SHARE * self._change(self.model, self.coarse, c) / c.slope,
                "amplitude": self._change(self.half, self.coarse, c) / c.slope,
            }
        else:
            found = {}
        return {name: value for name, value in found.items() if math.isfinite(value)}

    def _change(self, one: LinearModel, other: LinearModel, c: LinearCrossing) -> float:
        """Growth rate by `other` less that by `one`, of the mode of `c` at its V_f, over omega_alpha; at least as large as the
        rms of the same beside it."""
        here, *beside = (
            _near(other, V_f, mode).real - _near(one, V_f, mode).real
            for V_f, mode in ((share * c.V_f, self._mode(c, share)) for share in (1.0, *BESIDE))
        )
        known = [value for value in beside if math.isfinite(value)]
        least = math.sqrt(sum(value**2 for value in known) / len(known)) if known else 0.0
        return math.copysign(max(abs(here), least), here)

    def _mode(self, c: LinearCrossing, share: float) -> complex:
        """Of the model in use, its eigenvalue that is the mode of `c`, at `share` of its V_f; nan where it has none."""
        return _near(self.model, share * c.V_f, 1j * c.frequency)

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


def _near(model: LinearModel, V_f: float, mode: complex) -> complex:
    """The eigenvalue at `V_f` that is the nearest to `mode`, over omega_alpha; nan of a model without any."""
    values = model.eigenvalues(V_f)
    return complex(values[np.argmin(np.abs(values - mode))]) if values.size and np.isfinite(mode) else complex(math.nan, math.nan)
