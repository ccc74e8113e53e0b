"""Steady and unsteady loads against figures published by others, from meshes and boundaries like theirs. Prints what it judges.

The tables, what is not verified, and why we differ where we do: docs/published.md. Sources: heads of tests/data/published/*.
Others put no vortex at their outer boundary: where they do not, ours is taken out too, which at Mach 0.8 moves lift by 1 to 2 %.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator
from scipy.optimize import brentq

from aeroslosh.fmus.aero.airfoil import Section
from aeroslosh.fmus.aero.control import Settings
from aeroslosh.fmus.aero.farfield import Farfield
from aeroslosh.fmus.aero.field import Motion
from aeroslosh.fmus.aero.loads import Coefficients
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import o_mesh
from support import possio
from support.paths import DATA

pytestmark = pytest.mark.validation
PUBLISHED = DATA / "published"
FINE = (336, 96)


def table(name: str) -> list[dict[str, str]]:
    """Rows of a published table."""
    text = (PUBLISHED / name).read_text(encoding="utf-8").splitlines()
    return list(csv.DictReader(line for line in text if not line.startswith("#")))


@pytest.fixture
def no_vortex(monkeypatch: pytest.MonkeyPatch) -> None:
    """The plain stream outside, as the reference has it."""
    with_vortex = Farfield.set
    monkeypatch.setattr(Farfield, "set", lambda self, incidence, lift: with_vortex(self, incidence, 0.0))


def steady(airfoil: str | Section, cells: tuple[int, int], mach: float, alpha_deg: float, farfield: float) -> Coefficients:
    flow = Flow(o_mesh(airfoil, *cells, farfield), mach, 0.25, Settings(steady_tolerance=1e-7, steady_iterations=20000))
    flow.solve_steady(np.radians(alpha_deg))
    return flow.coefficients


def extended_0012(folder: Path) -> tuple[Path, float]:
    """Coordinate file of the NACA 0012 whose sides go on beyond the chord until they meet, and where they do [chords]."""

    def half(x: np.ndarray | float) -> np.ndarray | float:
        return 0.6 * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1015 * x**4)

    end = float(brentq(half, 0.9, 1.1, xtol=1e-14))
    x = 0.5 * end * (1.0 - np.cos(np.linspace(0.0, np.pi, 251)))
    y = np.append(half(x[:-1]), 0.0)
    rows = np.vstack([np.column_stack([x, y])[::-1], np.column_stack([x, -y])[1:]])
    path = folder / "extended_0012.dat"
    np.savetxt(path, rows, fmt="%.9f", header="NACA 0012 prolonged to a point", comments="")
    return path, end


def test_lift_of_vassberg_and_jameson_without_shock(no_vortex: None, tmp_path: Path) -> None:
    """Mach 0.5, 1.25 degrees: their lift on 2,048 x 2,048 cells differs by 0.07 percent from what they extrapolate, ours on two
    meshes by 0.01 percent; 0.1 percent is asked."""
    path, length = extended_0012(tmp_path)
    assert length == pytest.approx(1.0089304, abs=1e-7)
    theirs = {int(row["cells"]): float(row["cl"]) for row in table("vassberg_jameson_2010.csv") if row["mach"] == "0.5"}
    ours = {cells: length * steady(str(path), cells, 0.5, 1.25, 150.0).lift for cells in ((84, 24), (168, 48), FINE)}
    coarse, middle, fine = ours.values()
    print(f"\nC_L {coarse:.5f} {middle:.5f} {fine:.5f}, order {np.log2(abs(coarse - middle) / abs(middle - fine)):.1f}; "
          f"theirs on 2,048 x 2,048 {theirs[2048]:.5f}, extrapolated {theirs[0]:.5f} ({fine / theirs[0] - 1:+.3%})")  # fmt: skip
    assert fine == pytest.approx(theirs[0], rel=1e-3)
    assert fine == pytest.approx(theirs[2048], rel=2e-3)


def test_lift_of_vassberg_and_jameson_with_shocks(no_vortex: None, tmp_path: Path) -> None:
    """Mach 0.8, 1.25 degrees: their lift falls with every refinement, at an order of 0.28 at last, so that there is a span and no
    value: ours falls too and lies in it."""
    path, length = extended_0012(tmp_path)
    theirs = {int(row["cells"]): float(row["cl"]) for row in table("vassberg_jameson_2010.csv") if row["mach"] == "0.8"}
    found = [steady(str(path), cells, 0.8, 1.25, 150.0) for cells in ((84, 24), (168, 48), FINE)]
    lifts = [length * c.lift for c in found]
    print(f"\nC_L {lifts}, C_D {[length * c.drag for c in found]}; theirs {theirs}")
    assert theirs[0] < lifts[2] < theirs[256]
    assert lifts[0] > lifts[1] > lifts[2]
    assert lifts[2] == pytest.approx(theirs[2048], rel=6e-3)  # what they change by from 512 to 2,048 is 0.8 percent


@pytest.mark.parametrize(
    ("mach", "alpha_deg", "lift", "drag", "moment"),
    # lift and moment: the reference's change over its levels and ours from half the cells, together; drag: of the wave drag the
    # same, without a shock what the reference has left of an error
    [
        (0.5, 2.0, 0.0025, 3e-4, 2e-4),
        (0.778, 2.03, 0.008, 3e-4, 8e-4),
        (0.8, 1.25, 0.010, 4e-4, 1.2e-3),
        (0.803, -0.1, 0.05, 3e-4, 4e-4),
    ],
)
def test_naca_0012_follows_cfl3d(no_vortex: None, mach: float, alpha_deg: float, lift: float, drag: float, moment: float) -> None:
    """The same section (closed by −0.1036), boundary at 80 chords."""
    rows = [row for row in table("cfl3d_euler.csv") if row["section"] == "0012" and float(row["mach"]) == mach]
    theirs = rows[-1]
    ours = steady("0012", FINE, mach, alpha_deg, 80.0)
    print(f"\nMach {mach}, {alpha_deg}°: C_L {ours.lift:.5f} C_D {ours.drag:.5f} C_M {ours.moment:.5f}; CFL3D "
          f"{theirs['cl']} {theirs['cd']} {theirs['cm']} ({ours.lift / float(theirs['cl']) - 1:+.2%} of lift)")  # fmt: skip
    assert ours.lift == pytest.approx(float(theirs["cl"]), rel=lift)
    assert ours.drag == pytest.approx(float(theirs["cd"]), abs=drag)
    assert ours.moment == pytest.approx(float(theirs["cm"]), abs=moment)


def rae_2822_by_pchip() -> Section:
    """The tabulated RAE 2822 with sides between the points as the reference drew them, close to its kinks included."""
    rows = np.loadtxt(PUBLISHED / "rae2822.dat", skiprows=3)
    nose = int(np.argmin(rows[:, 0]))
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 200)))
    upper, lower = (PchipInterpolator(side[:, 0], side[:, 1])(x) for side in (rows[: nose + 1][::-1], rows[nose:]))
    contour = np.vstack([np.column_stack([x, upper])[::-1], np.column_stack([x, lower])[1:]])
    return Section("RAE 2822", contour, np.empty((0, 2)), "RAE 2822")


@pytest.mark.parametrize(("mach", "alpha_deg"), [(0.725, 2.55), (0.73, 3.19)])
def test_rae_2822_follows_cfl3d(no_vortex: None, mach: float, alpha_deg: float) -> None:
    """The points have five digits and lie far apart: how they are joined decides on 1.2 percent of lift, and 1.5 are asked with
    the reference's way to join them, 2.5 with ours."""
    theirs = [row for row in table("cfl3d_euler.csv") if row["section"] == "2822" and float(row["mach"]) == mach][-1]
    cl, cd, cm = (float(theirs[key]) for key in ("cl", "cd", "cm"))
    for name, section, rel in (("spline", str(PUBLISHED / "rae2822.dat"), 0.025), ("pchip", rae_2822_by_pchip(), 0.015)):
        ours = steady(section, (168, 48), mach, alpha_deg, 80.0)
        print(f"\nMach {mach}, {alpha_deg}°, {name}: C_L {ours.lift:.4f} C_D {ours.drag:.5f} C_M {ours.moment:.4f}; "
              f"CFL3D {cl} {cd} {cm} ({ours.lift / cl - 1:+.2%} of lift)", end="")  # fmt: skip
        assert ours.lift == pytest.approx(cl, rel=rel)
        assert ours.drag == pytest.approx(cd, abs=2e-3)
        assert ours.moment == pytest.approx(cm, abs=0.012)


def pitched(
    airfoil: str, mach: float, mean_deg: float, amplitude_deg: float, k: float, steps: int, settings: Settings
) -> tuple[dict[str, complex], np.ndarray]:
    """First harmonics over sin(ωt), of the second period of a pitch about the quarter chord, and of all steps: phase [deg],
    subiterations, residual, whether converged, C_N, C_M. 168 x 48 cells, boundary at 200 chords."""
    mean, amplitude, omega = np.radians(mean_deg), np.radians(amplitude_deg), 2.0 * k * mach
    dt = 2.0 * np.pi / omega / steps
    flow = Flow(o_mesh(airfoil, 168, 48, 200.0), mach, 0.25, settings)
    flow.solve_steady(mean)
    rows = []
    for i in range(1, 2 * steps + 1):
        phase = omega * i * dt
        s, c = amplitude * np.sin(phase), amplitude * np.cos(phase)
        motion = Motion(alpha=mean + s, alpha_dot=omega * c, alpha_ddot=-(omega**2) * s)
        report = flow.step(motion, float(mean + s), dt)
        load, alpha = flow.coefficients, mean + s
        normal = load.lift * np.cos(alpha) + load.drag * np.sin(alpha)
        rows.append((np.degrees(phase) % 360, report.subiterations, report.residual, report.converged, normal, load.moment,
                     load.lift))  # fmt: skip
    last = np.array(rows[steps:], dtype=float)
    turn = 2j * np.exp(-1j * np.radians(last[:, 0]))
    return {name: complex(np.mean(last[:, n] * turn)) for name, n in (("C_N", 4), ("C_M", 5), ("C_L", 6))}, last


def words(z: complex) -> str:
    return f"{abs(z):.4f} at {np.degrees(np.angle(z)):.1f}°"


def test_slow_pitch_of_thin_sections_meets_linear_theory() -> None:
    """Mach 0.6 and k 0.0808 of AGARD CT1, no mean incidence, half a degree: NACA 0004, 0006, 0008 extrapolated to no thickness
    (second order: the effect is not linear in it) against Possio's plate. Lift within 1 percent; moment, which is small about the
    quarter chord, within 0.1 percent of the lift times the chord."""
    mach, k, amplitude = 0.6, 0.0808, 0.5
    thickness = np.array([0.04, 0.06, 0.08])
    found = [pitched(f"{round(100 * t):04d}", mach, 0.0, amplitude, k, 144, Settings(tolerance=3e-3))[0] for t in thickness]
    plate = possio.coefficients(mach, k, -0.5)[:, 1] * np.radians(amplitude)
    for name, exact in zip(("C_L", "C_M"), plate, strict=True):
        values = np.array([z[name] for z in found])
        thin = complex(np.polyval(np.polyfit(thickness, values, 2), 0.0))
        print(f"\n{name}: 4, 6, 8 % {', '.join(words(z) for z in values)}; none {words(thin)}, Possio {words(exact)}", end="")
        assert abs(thin - exact) < (0.01 if name == "C_L" else 0.001) * abs(plate[0])


@pytest.mark.parametrize(
    ("name", "mach", "mean_deg", "amplitude_deg", "k"),
    [
        ("CT1", 0.600, 2.89, 2.41, 0.0808),
        ("CT2", 0.600, 3.16, 4.59, 0.0811),
        ("CT3", 0.600, 4.86, 2.44, 0.0810),
        ("CT5", 0.755, 0.016, 2.51, 0.0814),
    ],
)
def test_agard_pitch_does_not_depend_on_how_hard_a_step_is_solved(
    name: str, mach: float, mean_deg: float, amplitude_deg: float, k: float
) -> None:
    """AGARD-R-702, NACA 0012. The measured loops are not at hand in numbers: what is judged is that steps which end above
    tolerance (where the shock at the nose grows and dies) move the loads by less than 0.5 percent and 0.5 degrees."""
    usual, rows = pitched("0012", mach, mean_deg, amplitude_deg, k, 144, Settings())
    hard, _ = pitched("0012", mach, mean_deg, amplitude_deg, k, 288, Settings(tolerance=3e-3, max_subiterations=60))
    above = rows[:, 3] == 0
    print(f"\n{name}: C_N {words(usual['C_N'])}, C_M {words(usual['C_M'])}; twice the steps {words(hard['C_N'])}, "
          f"{words(hard['C_M'])}; C_N {rows[:, 4].min():.4f} to {rows[:, 4].max():.4f}, C_M {rows[:, 5].min():.4f} to "
          f"{rows[:, 5].max():.4f}; {above.sum()} of {above.size} steps above tolerance, at phases "
          f"{[round(p) for p in rows[above, 0]]}, residuals {[f'{r:.2g}' for r in rows[above, 2]]}")  # fmt: skip
    for load in ("C_N", "C_M"):
        ratio = usual[load] / hard[load]
        assert abs(abs(ratio) - 1.0) < (0.005 if load == "C_N" else 0.02)
        assert abs(np.degrees(np.angle(ratio))) < (0.5 if load == "C_N" else 1.0)
    assert above.mean() < 0.1
