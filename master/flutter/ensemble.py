"""A point marched several times from starts that differ by next to nothing (`slosh.members`), as one outcome.

Each member is the case with another `slosh.seed` (0: a level surface; else waves of case.fuel_tank.PERTURBATION), so that any of
them can be marched again alone. What members tell together: analysis.members.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable, Sequence

from ..analysis.members import Ensemble, Member
from ..case.case import Case
from ..cosim.loop import Cost, Watcher
from . import march as flutter_march
from .march import March
from .setup import FlutterSetup


def seeds(case: Case) -> list[int]:
    """Of the members of `case`: its own first. A liquid without scatter has one."""
    return [case.slosh.seed + n for n in range(case.slosh.members if case.slosh.model == "vof" else 1)]


def member(case: Case, seed: int) -> Case:
    """One member of `case`, a case of its own."""
    return dataclasses.replace(case, slosh=dataclasses.replace(case.slosh, seed=seed, members=1))


def of_march(march: March, seed: int) -> Member:
    """What counts of `march`."""
    fit = march.fit if march.failure is None else None
    if fit is None:
        return Member(seed, math.nan, math.nan, math.nan, march.verdict)
    return Member(seed, fit.growth_rate, fit.growth_rate_uncertainty, fit.frequency, march.verdict)


def marches(setup: FlutterSetup, V_f: float, watch: Callable[[], Watcher | None] = lambda: None) -> list[March]:
    """The members' marches one after the other; a failure ends them and is the last."""
    case, done = setup.case, list[March]()
    try:
        for seed in seeds(case):
            setup.case = member(case, seed)
            done.append(flutter_march.march(setup, V_f, None, watch()))
            if done[-1].failure is not None:
                break
    finally:
        setup.case = case
    return done


def averaged(march: March, ensemble: Ensemble, band: float) -> March:
    """`march`, of the first member, with growth rate, frequency, their error bars and the verdict of the ensemble."""
    said = ensemble.judged(band)
    fit, mode = march.fit, march.fit.flutter if march.fit is not None else None
    if fit is not None and mode is not None and mode.frequency and len(ensemble.known) > 1:
        frequency, frequency_error = ensemble.frequency
        mean = dataclasses.replace(
            mode, growth_rate=ensemble.mean, frequency=frequency, growth_rate_std=ensemble.error, frequency_std=frequency_error
        )
        fit = dataclasses.replace(
            fit,
            flutter=mean,
            modes=[mean if m is mode else m for m in fit.modes],
            growth_rate=ensemble.mean,
            growth_rate_uncertainty=ensemble.error,
            frequency=frequency,
            frequency_uncertainty=frequency_error,
            contributions={"members": ensemble.error},
        )
    return dataclasses.replace(
        march, fit=fit, verdict=said.verdict, reason=said.reason, settled=said.settled, remedy=said.remedy, ensemble=ensemble
    )


def march(setup: FlutterSetup, V_f: float, watch: Callable[[], Watcher | None] = lambda: None) -> March:
    """The point as an ensemble, or as one march where the case asks for one member. A member that fails is the outcome."""
    if len(seeds(setup.case)) == 1:
        return flutter_march.march(setup, V_f, None, watch())
    done = marches(setup, V_f, watch)
    if done[-1].failure is not None:
        return done[-1]
    found = Ensemble(tuple(of_march(m, s) for m, s in zip(done, seeds(setup.case), strict=True)))
    whole = averaged(done[0], found, setup.case.flutter.neutral_band)
    return dataclasses.replace(whole, cost=_total(done))


def _total(done: Sequence[March]) -> Cost:
    """The cost of all."""
    costs = [m.cost for m in done]
    cpu = {name: sum(c.cpu[name] for c in costs) for name in costs[0].cpu}
    return Cost(cpu, sum(c.wall for c in costs), sum(c.total_cpu for c in costs), sum(c.steps for c in costs))
