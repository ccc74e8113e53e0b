"""Archives run for real in FMPy, libcosim and ecos, against our own master's Jacobi.

All three pass on what every FMU had at the end of the step before, to all at once: Jacobi without extrapolation. So motion and
loads must be the same numbers wherever the steps are; 1e-9 of each signal's largest value is what this file demands."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.case.case import Case
from aeroslosh.master.cosim import system_file as assemblies
from aeroslosh.master.flutter.setup import FlutterSetup
from aeroslosh.master.ssp import archive as ssp_archive
from aeroslosh.master.ssp import system as ssp_system
from aeroslosh.master.ssp.system import Coupled

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import (
    LOADS,
    MOTION,
    SLOSH,
    STEPS,
    Fmu,
    Host,
    Sizes,
    difference,
    even,
    files,
    marched,
    nanoseconds,
    small,
    system_of,
)

SAME = 1e-9
STARTS = """
[components.stand]
fmu = "structure.fmu"
[components.stand.parameters]
mass = 300.0
static_imbalance = 10.0
inertia = 60.0
omega_h = 25.0
omega_alpha = 9.0
initial_alpha = 0.02
initial_h_dot = 0.01
trim_lift = -367.875
trim_moment = 73.575
[components.tank]
fmu = "slosh_ems.fmu"
parameters = {{ tank_x = 0.2, tank_y = 0.1, damping_ratio = 0.005, modes = 5, parametric = false }}
[system]
wires = [
  "stand.h -> tank.h", "stand.h_dot -> tank.h_dot", "stand.h_ddot -> tank.h_ddot",
  "stand.alpha -> tank.alpha", "stand.alpha_dot -> tank.alpha_dot", "stand.alpha_ddot -> tank.alpha_ddot",
  "tank.force_y -> stand.slosh_force_y", "tank.moment -> stand.slosh_moment",
]
[coupling]
scheme = "jacobi"
predictor_order = {order}
[run]
end = {end}
step = {step}
"""
STAND = (*(name.replace("structure", "stand") for name in MOTION), "tank.force_x", "tank.force_y", "tank.moment")


@dataclass
class Exported:
    """An archive, and the master's march of the same system. Shape of `march`: (steps, signals)."""

    path: Path
    coupled: Coupled
    signals: tuple[str, ...]
    march: np.ndarray

    def check(self, host: Host, tool: str) -> None:
        """Run the tool and compare."""
        found = host(tool, self.path, self.coupled.dt, len(self.march), self.signals)
        assert difference(found, self.march) < SAME


def exported(case: Case, fmu: Fmu, folder: Path, sizes: Sizes = even) -> Exported:
    """A flutter case as an archive, and marched."""
    fmus = files(fmu, case)
    coupled = ssp_system.from_case(case, fmus)
    ssp_archive.write(coupled, folder / "case.ssp")
    signals = MOTION + LOADS + (SLOSH if case.slosh.model != "none" else ())
    with FlutterSetup(case, fmus, case.flow.mach) as setup:
        setup.start(case.flutter.V_f)
        march = marched(setup.system, sizes(coupled, STEPS), signals, case.coupling.extrapolated)
    return Exported(folder / "case.ssp", coupled, signals, march)


@pytest.fixture(scope="module", params=[("none", 1), ("ems", 0), ("ems", 1), ("rbf", 1), ("vof", 0), ("vof", 1)], ids=str)
def flutter(request: pytest.FixtureRequest, fmu: Fmu, tmp_path_factory: pytest.TempPathFactory) -> Exported:
    """Section, flow and liquid: forced pitch, released after 65 of 130 steps. Order 1: the FMUs predict."""
    model, order = request.param
    return exported(small(model, f"coupling.predictor_order={order}"), fmu, tmp_path_factory.mktemp("ssp"))


@pytest.mark.parametrize("tool", ["fmpy", "libcosim", "ecos"])
def test_flutter(flutter: Exported, host: Host, tool: str) -> None:
    """Motion and loads over forced phase and free motion, with every liquid."""
    h, alpha, slosh_loads = flutter.march[:, 0], flutter.march[:, 3], flutter.march[:, len(MOTION) + len(LOADS) :]
    assert np.abs(h[70:]).max() > 1e-3 and np.abs(alpha).max() > 0.01  # it moves, and was released
    assert slosh_loads.size == 0 or np.abs(slosh_loads[70:]).max() > 1.0
    flutter.check(host, tool)


def test_libcosim_to_the_bit(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """libcosim's steps are differences of times in nanoseconds: equal but for rounding. A flow solved to its default tolerance
    makes 1e-9 of that rounding (docs/ssp.md); at libcosim's very steps our master has the same numbers."""
    loose = small("ems", "aero.tolerance=auto", "aero.max_subiterations=auto")
    exported(loose, fmu, tmp_path, nanoseconds).check(host, "libcosim")


def start(text: str, fmu: Fmu, folder: Path, steps: int) -> Exported:
    """The system file `text`, exported and marched."""
    file = folder / "starts.toml"
    file.write_text(text, encoding="utf-8")
    assembly = assemblies.load(file)
    system, found = system_of(assembly, fmu)
    system.initialize()
    coupled = ssp_system.from_assembly(assembly, found)
    march = marched(system, even(coupled, steps), STAND, assembly.coupling.predictor_order)
    system.close()
    ssp_archive.write(coupled, folder / "starts.ssp")
    return Exported(folder / "starts.ssp", coupled, STAND, march)


@pytest.mark.parametrize("tool", ["fmpy_started", "libcosim", "ecos"])
def test_system_file_that_starts_in_motion(fmu: Fmu, host: Host, tmp_path: Path, tool: str) -> None:
    """Tilted and moving at the start, whole loads in an algebraic loop with the accelerations: initial values must agree."""
    start(STARTS.format(order=0, end=1.5, step=0.01), fmu, tmp_path, 150).check(host, tool)


def test_fmpy_starts_every_input_at_zero(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """What docs/ssp.md warns of: FMPy's first step differs in a system that starts in motion. If this fails, FMPy has changed:
    take the warning out, and `fmpy_started` with it."""
    moving = start(STARTS.format(order=0, end=1.5, step=0.01), fmu, tmp_path, 3)
    found = host("fmpy", moving.path, moving.coupled.dt, 3, moving.signals)
    assert difference(found, moving.march) > 0.1


@pytest.mark.parametrize("tool", ["fmpy_started", "libcosim", "ecos"])
def test_prediction_of_the_fmus_is_that_of_the_master(fmu: Fmu, host: Host, tmp_path: Path, tool: str) -> None:
    """Plain FMUs under our Jacobi of order 1, predicting FMUs in tools that predict nothing."""
    held = start(STARTS.format(order=0, end=0.3, step=0.01), fmu, tmp_path, 30)
    linear = start(STARTS.format(order=1, end=0.3, step=0.01), fmu, tmp_path, 30)
    assert difference(held.march, linear.march) > 1e-3  # it matters
    linear.check(host, tool)


def test_libcosim_takes_the_step_that_the_archive_says(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    """Of 1000001 ns the nearest number of seconds is cut off to 1000000: hosts.py compares libcosim's clock with the step."""
    assert int(1.000001e-3 * 1e9) == 1000000
    start(STARTS.format(order=0, end=0.05000005, step=1.000001e-3), fmu, tmp_path, 50).check(host, "libcosim")
