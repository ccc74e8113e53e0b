"""Small cases, and our master's own march of them at the steps that a tool takes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from aeroslosh.master.case import case as cases
from aeroslosh.master.case import fuel_tank
from aeroslosh.master.case.case import Case
from aeroslosh.master.cosim import system_file as assemblies
from aeroslosh.master.cosim.scheme import Jacobi
from aeroslosh.master.cosim.system import System
from aeroslosh.master.cosim.system_file import Assembly
from aeroslosh.master.ssp.system import Coupled

ROOT = Path(__file__).parents[2]
SMALL = [  # coarse meshes; 65 steps forced, then free; steps solved so well that rounding in the step stays rounding
    "aero.tolerance=1e-4",
    "aero.max_subiterations=200",
    "aero.cells_around=64",
    "aero.cells_normal=16",
    "slosh.cells_x=32",
    "slosh.cells_y=16",
    "flutter.forced_cycles=0.75",
    "flutter.forced_ramp_cycles=0.5",
    "flutter.free_cycles=1.5",
]
MOTION = tuple(f"structure.{name}" for name in ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot"))
LOADS = ("aero.lift", "aero.moment")
SLOSH = ("slosh.force_x", "slosh.force_y_residual", "slosh.moment_residual")
STEPS = 130

Fmu = Callable[[str], Path]
Sizes = Callable[[Coupled, int], np.ndarray]
Host = Callable[[str, Path, float, int, Sequence[str]], np.ndarray]


def small(model: str, *overrides: str) -> Case:
    """The fuel case on coarse meshes."""
    return cases.load(ROOT / "cases" / "paper_s.toml", [f"slosh.model={model}", *SMALL, *overrides])


def files(fmu: Fmu, case: Case) -> dict[str, Path]:
    """FMUs of a case, up to date."""
    return {name: fmu(name) for name in ("structure", "aero", *fuel_tank.needed([case.slosh.model]))}


def system_of(assembly: Assembly, fmu: Fmu) -> tuple[System, dict[str, Path]]:
    """The system of a system file whose FMUs are the product's."""
    found = {name: fmu(Path(part.fmu).stem) for name, part in assembly.components.items()}
    return assemblies.build(assembly, found), found


def marched(system: System, sizes: np.ndarray, signals: Sequence[str], order: int = 0) -> np.ndarray:
    """Our own Jacobi of predictor order `order`, steps of `sizes` [s], of a system just initialised. Shape: (sizes, signals)."""
    scheme = Jacobi(order)
    scheme.reset(system)
    places = [(system[c], system[c].output_index[name]) for c, _, name in (signal.partition(".") for signal in signals)]
    rows = []
    for dt in sizes.tolist():
        scheme.step(system, dt)
        rows.append([component.outputs.values[place] for component, place in places])
    return np.array(rows)


def even(coupled: Coupled, steps: int) -> np.ndarray:
    """Steps [s] of FMPy, ecos and our master: all the same number. Shape: (steps,)."""
    return np.full(steps, coupled.dt)


def nanoseconds(coupled: Coupled, steps: int) -> np.ndarray:
    """Steps [s] of libcosim, which counts nanoseconds and takes differences of times: the same but for rounding."""
    return np.diff(np.arange(steps + 1) * round(coupled.dt * 1e9) / 1e9)


def difference(found: np.ndarray, expected: np.ndarray) -> float:
    """The largest difference, each signal over its largest value; a signal that is always 0 counts as it is."""
    size = np.abs(expected).max(axis=0)
    return float((np.abs(found - expected).max(axis=0) / np.where(size > 0.0, size, 1.0)).max())
