"""What a tool that exchanges values once a step (Jacobi) adds to a growth rate: the figures of docs/ssp.md.

`python -m studies.ssp_lag [--fmus DIR] [--small]` exports a dry section, one with frozen fuel and one with sloshing fuel at
several steps, with and without the FMUs' prediction of their inputs, marches what the archive says by our master's Jacobi without
extrapolation, which FMPy, libcosim and ecos were shown to equal (tests/ssp/test_ssp_hosts.py), and fits the growth rate. Beside
it the master's own default (Gauss-Seidel, extrapolated) at the same step.

Theory: without prediction motion and loads are each a step late, which adds a growth rate in proportion to the step; with linear
prediction what is left is of second order.
"""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

import numpy as np

from aeroslosh.master.analysis.damping import Fit, analyse
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales
from aeroslosh.master.cosim.scheme import Jacobi
from aeroslosh.master.cosim.system import System
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter import span
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.fmi.component import Component
from aeroslosh.master.ssp import system as ssp_system

ROOT = Path(__file__).resolve().parents[1]
CASES = {  # name → case file, overrides, steps a period
    "dry, Mach 0.825, V_f 0.612": ("isogai_a.toml", [], 75),
    "frozen fuel, Mach 0.80, V_f 0.7": ("paper_s.toml", ["slosh.model=frozen"], 86),
    "sloshing fuel (ems), the same": ("paper_s.toml", ["slosh.model=ems"], 86),
}
COARSE = ["aero.cells_around=64", "aero.cells_normal=16"]


def load(name: str, refined: int, extra: list[str]) -> Case:
    """The case of that name at `refined` times its steps a period."""
    file, overrides, steps = CASES[name]
    return cases.load(ROOT / "cases" / file, [*overrides, *extra, f"flutter.steps_per_cycle={refined * steps}"])


def exported(case: Case, fmus: dict[str, Path], prediction: str) -> float:
    """Growth rate of what the archive says, marched by Jacobi without extrapolation."""
    coupled = ssp_system.from_case(case, fmus, prediction)
    components = []
    for part in coupled.parts:
        component = Component(part.path, part.name)
        component.set_all(part.values)
        components.append(component)
    system, scheme, s = System(components, coupled.wires), Jacobi(0), scales(case, case.flow.mach, case.flutter.V_f)
    try:
        system.initialize()
        scheme.reset(system)
        structure = system["structure"]
        motion = np.zeros((2, coupled.steps + 1))
        for step in range(1, coupled.steps + 1):
            scheme.step(system, coupled.dt)
            motion[:, step] = structure.get("h") / s.half_chord, structure.get("alpha")
    finally:
        system.close()
    release = span.length(case, s)[0]
    tau = s.omega_alpha * coupled.dt * np.arange(coupled.steps + 1)
    return _rate(analyse(tau[release:], motion[:, release:]))


def own(case: Case, fmus: dict[str, Path]) -> float:
    """Growth rate of the master's own march, as the case says."""
    with FlutterSetup(case, fmus, case.flow.mach) as setup:
        return _rate(flutter_march.march(setup, case.flutter.V_f).fit)


def _rate(fit: Fit | None) -> float:
    if fit is None:
        raise RuntimeError("no mode can be fitted to the free response")
    return fit.growth_rate


def row(name: str, refined: int, folder: Path, extra: list[str]) -> dict[str, float]:
    """Growth rates [1/omega_alpha]: `own`, and exported with prediction `none` and `linear`."""
    case = load(name, refined, extra)
    fmus = find_fmus(folder, case.slosh.model)
    return {"own": own(case, fmus)} | {word: exported(case, fmus, word) for word in ("none", "linear")}


def main() -> None:
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    words.add_argument("--small", action="store_true", help="coarse mesh: seconds")
    options = words.parse_args()
    extra = COARSE if options.small else []
    print("| case | steps a period | master | late by a step | predicted | error, late | error, predicted |\n|" + "---|" * 7)
    for name, (_, _, steps) in CASES.items():
        for refined in (1, 2, 4):
            now = row(name, refined, options.fmus, extra)
            rates = [f"{now[word]:+.5f}" for word in ("own", "none", "linear")]
            errors = [f"{now[word] - now['own']:+.1e}" for word in ("none", "linear")]
            print("| " + " | ".join([name, str(refined * steps), *rates, *errors]) + " |", flush=True)


if __name__ == "__main__":
    main()
    sys.stdout.flush()
    os._exit(0)  # pythonfmu releases its interpreter twice at exit
