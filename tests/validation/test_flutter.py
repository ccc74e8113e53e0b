"""Flutter of the Isogai A section through the FMUs: neutral V_f, SU2's histories, linear theory, coupling and step errors.

Prints the figures it judges. Source of the linear values: Possio's integral equation for a thin airfoil (its limit at Mach 0 is
Theodorsen's, NACA Report 496); it gives V_f 2.281 at Mach 0.3 and 2.080 at Mach 0.5 for this section.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

from aeroslosh.master.analysis.damping import analyse
from aeroslosh.master.boundary import solve
from support import possio, sections
from support.paths import DATA

pytestmark = pytest.mark.validation
Run = Callable[..., dict[str, Any]]


def settings(**values: Any) -> list[str]:
    """Command-line overrides from section__key = value."""
    return [word for name, value in values.items() for word in ("--set", f"{name.replace('__', '.')}={value}")]


def neutral(run: Run, mach: float, **values: Any) -> tuple[float, float]:
    """Neutral V_f and its frequency over omega_alpha."""
    point = run("boundary", "--mach", str(mach), *settings(**values))["points"][0]
    assert point["converged"], point
    return point["crossings"][0]["V_f"], point["crossings"][0]["frequency"]


@pytest.mark.parametrize(("mach", "low", "high"), [(0.825, 0.59, 0.63), (0.85, 0.50, 0.53)])
def test_neutral_flutter_speed(aeroslosh: Run, mach: float, low: float, high: float) -> None:
    V_f, frequency = neutral(aeroslosh, mach)
    print(f"\nMach {mach}: neutral V_f {V_f:.4f}, frequency {frequency:.4f}")
    assert low <= V_f <= high


@pytest.mark.parametrize(
    ("mach", "V_f", "rate_limit"),
    # At Mach 0.825 the difference to SU2 is 0.003: ours is converged in grid, step and farfield to 0.0003 (docs/aero.md); SU2's
    # own neutral V_f on two meshes, 0.59 and 0.63, differ by as much.
    [(0.825, 0.612, 0.0035), (0.85, 0.439, 0.002)],
)
def test_history_from_su2s_start_follows_its_first_mode(aeroslosh: Run, mach: float, V_f: float, rate_limit: float) -> None:
    table = np.loadtxt(DATA / f"su2_isA_{round(1000 * mach):04d}_{round(1000 * V_f):04d}.csv", delimiter=",", comments="#")
    theirs = analyse(table[:, 0], table[:, 1:3].T)
    cycles = table[-1, 0] / (2 * np.pi)
    result = aeroslosh(
        "point", "--mach", str(mach), "--vf", str(V_f),
        *settings(flutter__forced_cycles=0, flutter__free_cycles=cycles, flutter__initial_alpha_dot=0.01),
    )  # fmt: skip
    assert theirs is not None
    print(
        f"\nMach {mach}, V_f {V_f}: growth {result['growth_rate']:.5f}, SU2 {theirs.growth_rate:.5f}; "
        f"frequency {result['frequency']:.4f}, SU2 {theirs.frequency:.4f}"
    )
    assert abs(result["growth_rate"] - theirs.growth_rate) < rate_limit
    assert result["frequency"] == pytest.approx(theirs.frequency, rel=0.01)
    with netcdf_file(next(result["folder"].glob("history*.nc")), mmap=False) as history:
        tau, alpha = np.array(history.variables["tau"][:]), np.array(history.variables["alpha"][:])
    ours = np.interp(table[:, 0], tau, alpha)
    difference = np.sqrt(np.mean((ours - table[:, 2]) ** 2)) / np.std(table[:, 2])
    print(f"rms difference of alpha(t) over its std: {difference:.3f}")
    assert difference < 0.15


@pytest.mark.parametrize(("mach", "linear"), [(0.3, 2.281), (0.5, 2.080)])
def test_thin_sections_flutter_as_linear_theory_says(aeroslosh: Run, mach: float, linear: float) -> None:
    """Thickness raises the lift slope and so lowers V_f, by 4 to 6 percent at 10 percent thickness; extrapolated to none, the
    marched values meet the thin-airfoil value within 1 percent."""
    common: dict[str, Any] = {"flutter__free_cycles": 3, "flutter__V_f": linear, "boundary__tolerance": 5e-4}
    thickness = np.array([0.04, 0.06, 0.08, 0.10])
    values = np.array([neutral(aeroslosh, mach, flow__airfoil=f'"64A0{round(100 * t):02d}"', **common)[0] for t in thickness])
    thin = np.polyval(np.polyfit(thickness, values, 2), 0.0)
    print(f"\nMach {mach}: V_f at 4, 6, 8, 10 percent {values}, at none {thin:.4f}")
    print(f"linear theory {linear}: {thin / linear - 1:+.2%}")
    print(f"64A010 against linear theory: {values[-1] / linear - 1:+.2%}")
    assert thin == pytest.approx(linear, rel=0.01)
    assert np.all(np.diff(values) < 0)
    assert values[-1] == pytest.approx(linear, rel=0.07)


def zeta(result: dict[str, Any]) -> float:
    return float(result["damping_ratio"])


def test_implicit_coupling_agrees_with_gauss_seidel(aeroslosh: Run) -> None:
    explicit = zeta(aeroslosh("point"))
    implicit = zeta(aeroslosh("point", *settings(coupling__scheme='"implicit"')))
    print(f"\ndamping ratio: Gauss–Seidel {explicit:.6f}, implicit {implicit:.6f}, difference {explicit - implicit:.1e}")
    assert abs(explicit - implicit) < 1e-4


@pytest.mark.parametrize(("mach", "V_f"), [(0.825, 0.612), (0.85, 0.439), (0.8, 0.78), (0.7, 1.4)])
def test_half_the_step_and_twice_the_subiterations_change_nothing(aeroslosh: Run, mach: float, V_f: float) -> None:
    where = ["--mach", str(mach), "--vf", str(V_f)]
    coarse = aeroslosh("point", *where)
    steps = coarse["steps_per_cycle"]
    fine = aeroslosh(
        "point", *where, *settings(flutter__steps_per_cycle=2 * steps, aero__tolerance=2e-4, aero__max_subiterations=60)
    )
    print(f"\nMach {mach}, V_f {V_f}: damping ratio {zeta(coarse):.5f} at {steps} steps a cycle, {zeta(fine):.5f} at {2 * steps}")
    assert abs(zeta(coarse) - zeta(fine)) < 3e-4


def test_a_heavy_section_at_low_reduced_frequency(fmu: Callable[[str], Path]) -> None:
    """Mass ratio 300, Mach 0.2, where the phase of the lift at k = 0.09 decides: Euler at 4 and 8 percent of thickness,
    extrapolated to none, against Possio's plate."""
    fmus = {name: fmu(name) for name in ("structure", "aero")}
    found = []
    for airfoil in ("NACA 0004", "NACA 0008"):
        case = sections.named(0.35, 0.2, 0.25, 0.5, 300.0)
        case.flow.airfoil, case.flow.mach, case.aero.farfield_chords = airfoil, 0.2, 100.0
        case.boundary.mach, case.boundary.V_f_range = [0.2], [0.1, 3.0]
        [point] = solve.solve(case, fmus, lambda text: None)
        found.append(min(c.V_f for c in point.crossings if c.kind == "flutter"))
    case.flutter.V_f = found[0]
    plate = possio.neutral(case, 0.2, lambda omega: np.zeros((2, 2)), found[0], (0.594,))
    thin = 2.0 * found[0] - found[1]
    print(f"\nmu 300, Mach 0.2: 4 % {found[0]:.4f}, 8 % {found[1]:.4f}, 0 % {thin:.4f}, Possio {plate:.4f}")
    assert thin == pytest.approx(plate, rel=0.005)
    assert found[1] < found[0] < thin
