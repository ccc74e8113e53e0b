"""Random typical sections, as wide as an engineer meets them, for properties that must hold for every one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from aeroslosh.master.analysis.crossings import Crossing
from aeroslosh.master.boundary import solve
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup
from aeroslosh.master.linear.model import BAND as BAND_K

from . import theory

BAND = 5e-4  # growth rates that are neutral, over omega_alpha
TOLERANCE = 2e-3  # what step and coupling may change a growth rate by
AT_DIVERGENCE = 0.011  # relative distance in V_f within which neutral is said: the steady slopes are not sure of more
NEAR = 0.02  # relative distance within which a crossing is the exact one


def draw(seed: int) -> Case:
    """Section number `seed`: axis at 0.2 to 0.6, x_alpha −0.3 to 0.5, r2 0.1 to 1, frequency ratio 0.1 to 2, mass ratio 5 to 300,
    structural damping 0 to 3 %; V_f 0.1 to 3, half of the time within 20 % of the flutter of a quasi-steady guess."""
    rng = np.random.default_rng([14, seed])
    case = Case(name=f"section_{seed}")
    s = case.section
    while True:
        s.elastic_axis = float(rng.uniform(0.2, 0.6))
        s.x_alpha = float(rng.uniform(-0.3, 0.5))
        s.r2_alpha = float(rng.uniform(0.1, 1.0))
        if s.r2_alpha > s.x_alpha**2 + 0.02:
            break
    s.frequency_ratio = float(rng.uniform(0.1, 2.0))
    s.mass_ratio = float(np.exp(rng.uniform(np.log(5.0), np.log(300.0))))
    s.damping_ratio_h, s.damping_ratio_alpha = (float(x) for x in rng.uniform(0.0, 0.03, 2))
    case.flow.mach = 0.3
    case.flutter.V_f = float(np.exp(rng.uniform(np.log(0.1), np.log(3.0))))
    case.boundary.V_f_range = [0.1, 3.0]
    case.output.pictures = case.output.fields = False
    return case


def named(axis: float, x_alpha: float, r2_alpha: float, ratio: float, mass_ratio: float) -> Case:
    """A section by its numbers, without structural damping."""
    case = draw(0)
    s = case.section
    s.elastic_axis, s.x_alpha, s.r2_alpha, s.frequency_ratio, s.mass_ratio = axis, x_alpha, r2_alpha, ratio, mass_ratio
    s.damping_ratio_h = s.damping_ratio_alpha = 0.0
    return case


@dataclass(frozen=True)
class Point:
    """A verdict beside the exact one. `error`: growth rate fitted less exact, nan where another pole is critical."""

    seed: int
    verdict: str
    exact: str
    rate: float
    error: float
    cycles: float
    wrong: bool
    reason: str


@dataclass(frozen=True)
class Boundary:
    """Crossings beside the exact ones; `worst`: largest relative error of V_f."""

    seed: int
    names: list[str]
    missed: list[tuple[float, float, str]]
    invented: list[tuple[float, str]]
    worst: float
    marches: int
    marched: int
    outcome: str


def point(fmus: dict[str, Path], seed: int) -> Point:
    """March section `seed` at its V_f. A verdict is wrong when it says stable of an unstable section or the other way round, by
    more than the step's own error, or calls a divergence flutter while no oscillation grows (or the other way round)."""
    case = draw(seed)
    V_f, mach = case.flutter.V_f, case.flow.mach
    with FlutterSetup(case, fmus, mach) as setup:
        march = flutter_march.march(setup, V_f)
    exact, oscillations = theory.spectrum(case, mach, V_f), theory.eigenvalues(case, mach, V_f)
    real = exact[np.abs(exact.imag) <= 1e-6].real
    static, dynamic = float(np.max(real, initial=-1.0)), float(np.max(oscillations.real, initial=-1.0))
    rate = max(static, dynamic)
    truth = "neutral" if abs(rate) <= BAND else "damped" if rate < 0.0 else "divergence" if static >= dynamic else "flutter"
    said = str(march.verdict)
    unsafe = said in ("damped", "limit cycle") and rate > TOLERANCE
    unfounded = said in ("flutter", "divergence") and rate < -TOLERANCE
    mistaken = (said == "divergence" and static < -TOLERANCE) or (said == "flutter" and dynamic < -TOLERANCE)
    at_divergence = abs(V_f / theory.divergence(case) - 1.0) < AT_DIVERGENCE
    careless = said == "neutral" and abs(rate) > TOLERANCE and not at_divergence
    error = march.fit.growth_rate - dynamic if march.fit is not None and march.fit.frequency else float("nan")
    cycles = (march.tau.size - march.release) / march.scales.steps_per_cycle
    return Point(seed, said, truth, rate, error, cycles, unsafe or unfounded or mistaken or careless, march.reason)


def boundary(fmus: dict[str, Path], seed: int) -> Boundary:
    """All neutral V_f of section `seed`."""
    return bounded(fmus, draw(seed), seed)


def bounded(fmus: dict[str, Path], case: Case, seed: int = -1) -> Boundary:
    """All neutral V_f of `case`, beside those of theory within the reduced frequencies that the linear model knows."""
    mach, (low, high) = case.flow.mach, case.boundary.V_f_range
    case.boundary.mach = [mach]
    [found] = solve.solve(case, fmus, lambda text: None)
    exact = theory.crossings(case, mach, low, high)

    def same(c: Crossing, e: tuple[float, float, str]) -> bool:
        return c.direction == e[2] and (c.frequency > 0.0) == (e[1] > 0.0) and abs(c.V_f / e[0] - 1.0) < NEAR

    seen = [e for e in exact if e[1] <= BAND_K * e[0] * np.sqrt(case.section.mass_ratio)]
    missed = [e for e in seen if not any(same(c, e) for c in found.crossings)]
    invented = [(c.V_f, c.name) for c in found.crossings if not any(same(c, e) for e in exact)]
    errors = [min(abs(c.V_f / e[0] - 1.0) for c in found.crossings if same(c, e)) for e in seen if e not in missed]
    return Boundary(
        seed,
        [c.name for c in found.crossings],
        missed,
        invented,
        max(errors, default=0.0),
        len(found.marches),
        sum(c.source == "march" for c in found.crossings),
        found.outcome,
    )
