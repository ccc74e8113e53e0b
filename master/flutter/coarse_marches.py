"""What mesh, step, outer boundary and amplitude may change in a march's growth rate, by two coarse marches beside it.

Mesh, step and outer boundary are coarsened together by the same factor, so that what they change is one error that falls with
it; a second coarse march forced by half the amplitude tells what the amplitude changes. Together they cost about 0.6 of the
march that they stand beside.

A two-phase liquid costs as much whatever the air's mesh, and scatters by itself. What the air's mesh and step change is told by
two marches that carry the liquid frozen, fine and coarse: the flow sees a motion of the same frequency. The tank's own mesh is
not in it, nor the amplitude, which is no error of a result that is said at an amplitude.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from pathlib import Path

from ..base.errors import AeroSloshError
from ..case.case import Case
from . import march as flutter_march
from .march import March
from .setup import FlutterSetup

PARTS = ("discretisation", "amplitude")
TWO_PHASE = ("amplitude", "tank mesh")
"""Parts of a march with a two-phase liquid that nothing here tells."""
COARSER = 1.5  # the ratio of cell sizes, steps and distances of the outer boundary
SHARE = 1.0  # of the difference to the coarse march that the own one is taken to be off: an order of 1.7 (docs/boundary.md)
SAME_MODE = 0.25  # difference of poles, relative to the frequency, within which two marches tell of one mode
SLOW = 0.05  # instead of that share of a frequency, over omega_alpha, for a mode that hardly oscillates


@dataclasses.dataclass(frozen=True)
class Change:
    """Signed changes of growth rate and frequency, over omega_alpha, by part; `missing` are the parts that could not be had."""

    growth_rate: dict[str, float] = dataclasses.field(default_factory=dict)
    frequency: dict[str, float] = dataclasses.field(default_factory=dict)
    missing: tuple[str, ...] = ()
    marches: tuple[March, ...] = ()
    steady_cpu: float = 0.0  # [s]


def coarser(cells: tuple[int, int]) -> tuple[int, int]:
    """Cells around and normal of the next coarser mesh, no fewer than the aero FMU takes."""
    return max(64, round(cells[0] / COARSER)), max(16, round(cells[1] / COARSER))


def coarse_case(case: Case) -> Case:
    """`case` on a coarser mesh with a nearer outer boundary; the step is a march's (`coarse_steps`)."""
    around, normal = coarser((case.aero.cells_around, case.aero.cells_normal))
    distance = max(5.0, case.aero.farfield_chords / COARSER)
    aero = dataclasses.replace(case.aero, cells_around=around, cells_normal=normal, farfield_chords=distance)
    return dataclasses.replace(case, aero=aero)


def frozen(case: Case) -> Case:
    """`case` with the liquid carried as frozen mass."""
    slosh = dataclasses.replace(case.slosh, model="frozen", predictor="none", members=1, parameters={})
    return dataclasses.replace(case, slosh=slosh)


def change(
    open_setup: Callable[[Case, float], FlutterSetup],
    case: Case,
    march: March,
    pole: complex,
    say: Callable[[str], None] = lambda text: None,
) -> Change:
    """What coarse marches tell of the mode at `pole` (growth rate and frequency over omega_alpha) in `march`, of `case`. A part
    that cannot be had is missing, and said."""
    two_phase = case.slosh.model == "vof"
    if two_phase:
        case = frozen(case)
    rough, f, mach, V_f = coarse_case(case), case.flutter, march.scales.mach, march.scales.V_f
    steps = max(12, round(march.scales.steps_per_cycle / COARSER))
    amplitude = f.forced_amplitude_deg
    cells = f"{rough.aero.cells_around} x {rough.aero.cells_normal}"
    shares, untold = ((1.0,), TWO_PHASE) if two_phase else ((1.0, 0.5), ())
    degrees = " and ".join(f"{share * amplitude:g}" for share in shares)
    say(f"error bar: marches on {cells} cells, {degrees} degrees" + (", with the liquid frozen" if two_phase else ""))
    marches: list[March] = []
    fine: list[March] = []  # with the liquid frozen, in place of the march itself
    steady_cpu = 0.0
    try:
        if two_phase:
            with open_setup(case, mach) as setup:
                fine.append(flutter_march.march(setup, V_f))
                steady_cpu += setup.steady_cpu
            pole = _nearest(fine[0], pole)
        with open_setup(rough, mach) as setup:
            for share in shares:
                flutter = dataclasses.replace(
                    f,
                    steps_per_cycle=steps,
                    forced_amplitude_deg=share * amplitude,
                    initial_alpha_dot=share * f.initial_alpha_dot,
                )
                setup.case = dataclasses.replace(rough, flutter=flutter)
                marches.append(flutter_march.march(setup, V_f))
            steady_cpu += setup.steady_cpu
    except AeroSloshError as error:
        say(f"error bar: no coarse march: {error.what}")
        return Change(missing=(PARTS[0], *untold) if two_phase else PARTS, marches=(*fine, *marches), steady_cpu=steady_cpu)
    coarse, *halved = (_nearest(other, pole) for other in marches)
    parts = dict(zip(PARTS, (SHARE * (pole - coarse), *(half - coarse for half in halved)), strict=False))
    known = {name: value for name, value in parts.items() if math.isfinite(value.real)}
    missing = tuple(name for name in parts if name not in known)
    if missing:
        say(f"error bar: the coarse marches do not show this mode; not in it: {', '.join(missing)}")
    rates = {name: value.real for name, value in known.items()}
    frequencies = {name: value.imag for name, value in known.items()} if pole.imag else {}
    return Change(rates, frequencies, missing + untold, (*fine, *marches), steady_cpu)


def beside(case: Case, fmus: dict[str, Path], march: March, say: Callable[[str], None] = lambda text: None) -> Change:
    """What coarse marches tell of the critical mode of `march`, of `case`; nothing where it has none."""
    if march.failure is not None or march.fit is None:
        return Change()
    pole = complex(march.fit.growth_rate, march.fit.frequency)
    return change(lambda of, mach: FlutterSetup(of, fmus, mach), case, march, pole, say)


def widened(march: March, told: Change) -> March:
    """`march` whose error bars hold what coarse marches tell: in results, histories and pictures alike."""
    if march.fit is None:
        return march
    fit = dataclasses.replace(
        march.fit,
        growth_rate_uncertainty=math.hypot(march.fit.growth_rate_uncertainty, *told.growth_rate.values()),
        frequency_uncertainty=math.hypot(march.fit.frequency_uncertainty, *told.frequency.values()),
        contributions=march.fit.contributions | told.growth_rate,
    )
    return dataclasses.replace(march, fit=fit)


def _nearest(march: March, pole: complex) -> complex:
    """The fitted pole of `march` that is the mode at `pole`; nan where none is near."""
    if march.failure is not None or march.fit is None:
        return complex(math.nan, math.nan)
    modes = march.fit.modes if pole.imag else march.fit.reals
    poles = [complex(m.growth_rate, m.frequency) for m in modes]
    near = min(poles, key=lambda p: abs(p - pole), default=complex(math.inf, 0.0))
    within = max(SAME_MODE * pole.imag, SLOW)
    return near if abs(near - pole) <= within else complex(math.nan, math.nan)
