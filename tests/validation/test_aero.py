"""Aerodynamics alone: grid convergence, exact lift, forced pitch against SU2, order in time. Prints the figures it judges."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.aero.control import Settings
from aeroslosh.fmus.aero.field import Motion
from aeroslosh.fmus.aero.loads import pressure_coefficient
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import o_mesh
from support.paths import DATA

pytestmark = pytest.mark.validation


def steady(
    airfoil: str, cells: tuple[int, int], mach: float, alpha_deg: float, farfield: float = 200.0, axis: float = 0.25
) -> Flow:
    flow = Flow(o_mesh(airfoil, *cells, farfield), mach, axis, Settings(steady_tolerance=3e-8, steady_iterations=20000))
    flow.solve_steady(np.radians(alpha_deg))
    return flow


def test_lift_converges_on_nested_grids() -> None:
    """Mach 0.70, 3 degrees (the paper's section IV A)."""
    lifts = {}
    for cells in ((84, 24), (168, 48), (336, 96)):
        flow = steady("64A010", cells, 0.7, 3.0)
        lifts[cells[0] * cells[1]] = flow.coefficients.lift
        print(f"\n{cells[0] * cells[1]:6d} cells  C_L {flow.coefficients.lift:.5f}  C_D {flow.coefficients.drag:.5f}", end="")
    coarse, middle, fine = lifts.values()
    print(f"\nchange 8,064 to 32,256: {abs(middle / fine - 1):.3%}")
    assert abs(middle / fine - 1) < 0.0015
    assert np.log2(abs(coarse - middle) / abs(middle - fine)) > 1.8


@pytest.mark.parametrize(("airfoil", "alpha"), [("64A010", 2.0), ("0012", 2.0), ("2412", 1.0)])
@pytest.mark.parametrize("mach", [0.1, 0.2])
def test_lift_at_low_speed_is_exact(airfoil: str, alpha: float, mach: float) -> None:
    """Conformal map with the Prandtl–Glauert factor; 0.3 percent."""
    flow = steady(airfoil, (168, 48), mach, alpha)
    exact = flow.mesh.circle.lift_coefficient(np.radians(alpha)) / np.sqrt(1 - mach**2)
    lift = flow.coefficients.lift
    print(f"\n{airfoil} Mach {mach}: C_L {lift:.5f}, exact {exact:.5f} ({lift / exact - 1:+.3%})")
    assert flow.coefficients.lift == pytest.approx(exact, rel=0.003)


def test_subcritical_flow_has_no_drag() -> None:
    drag = steady("64A010", (168, 48), 0.5, 2.0).coefficients.drag
    print(f"\nC_D at Mach 0.50, 2 degrees: {drag:.1e}")
    assert abs(drag) < 5e-5


def test_lift_does_not_depend_on_the_farfield() -> None:
    lifts = [
        steady("64A010", (168, cells), 0.7, 3.0, farfield).coefficients.lift
        for farfield, cells in ((12, 44), (25, 48), (100, 58))
    ]
    print("\nC_L with the boundary at 12, 25, 100 chords:", lifts)
    assert np.ptp(lifts) / lifts[-1] < 0.001


def forced_pitch(
    cells: tuple[int, int], steps: int, periods: int, tolerance: float, farfield: float = 200.0
) -> dict[str, complex]:
    """First harmonics of the last period relative to the pitch: amplitude and phase of C_L and C_M. Davis case (AGARD CT6)."""
    mach, k, axis, amplitude = 0.796, 0.202, 0.248, np.radians(1.01)
    flow = Flow(o_mesh("64A010", *cells, farfield), mach, axis, Settings(tolerance=tolerance, max_subiterations=60))
    flow.solve_steady(0.0)
    omega = 2 * k * mach
    dt = 2 * np.pi / omega / steps
    rows = []
    for i in range(1, periods * steps + 1):
        s, c = amplitude * np.sin(omega * i * dt), amplitude * np.cos(omega * i * dt)
        flow.step(Motion(alpha=s, alpha_dot=omega * c, alpha_ddot=-(omega**2) * s), float(s), dt)
        rows.append((i * dt * omega, flow.coefficients.lift, flow.coefficients.moment))
    last = np.array(rows[-steps:])
    turn = 2j * np.exp(-1j * last[:, 0])
    return {name: complex(np.mean(last[:, n] * turn)) for name, n in (("C_L", 1), ("C_M", 2))}


def test_forced_pitch_follows_su2() -> None:
    """3 percent and 3 degrees in the third period."""
    table = np.loadtxt(DATA / "su2_ct6.csv", delimiter=",", comments="#")
    third = table[(table[:, 1] > 2) & (table[:, 1] <= 3)]
    turn = 2j * np.exp(-2j * np.pi * third[:, 1])
    ours = forced_pitch((168, 48), 64, 3, 3e-3)
    for name, column in (("C_L", 3), ("C_M", 4)):
        theirs = complex(np.mean(third[:, column] * turn))
        ratio = ours[name] / theirs
        print(f"\n{name}: ours {abs(ours[name]):.5f} at {np.degrees(np.angle(ours[name])):.2f}, SU2 {abs(theirs):.5f} at "
              f"{np.degrees(np.angle(theirs)):.2f} degrees", end="")  # fmt: skip
        assert abs(abs(ratio) - 1) < 0.03
        assert abs(np.degrees(np.angle(ratio))) < 3


def test_march_is_second_order_in_time() -> None:
    """Harmonics of the second period at 24, 48 and 96 steps a period against 288."""
    fine = forced_pitch((96, 32), 288, 2, 1e-4)
    errors = [abs(forced_pitch((96, 32), steps, 2, 1e-4)["C_M"] - fine["C_M"]) / abs(fine["C_M"]) for steps in (24, 48, 96)]
    orders = np.log2(np.array(errors[:-1]) / np.array(errors[1:]))
    print("\nerrors", errors, "orders", orders)
    assert orders.min() > 1.7


@pytest.mark.parametrize(("mach", "k"), [(0.3, 0.02), (0.7, 0.02), (0.7, 0.1)])
def test_unsteady_loads_do_not_depend_on_the_outer_boundary(mach: float, k: float) -> None:
    """Default distance against 800 chords, 0.1 % and 0.1 degrees; at 25 chords up to 1 % and 0.9 degrees were reflected."""
    near = harmonics("64A010", (168, 48), mach, k, 0.25, 0.2, 200.0)
    far = harmonics("64A010", (168, 72), mach, k, 0.25, 0.2, 800.0)
    for name in near:
        ratio = near[name] / far[name]
        print(f"\n{name} at 200 over 800 chords: {abs(ratio) - 1:+.3%}, {np.degrees(np.angle(ratio)):+.3f} degrees", end="")
        assert abs(abs(ratio) - 1) < 0.001
        assert abs(np.degrees(np.angle(ratio))) < 0.1


@pytest.mark.parametrize(("mean", "amplitude"), [(3.16, 4.59), (4.86, 2.44)])
def test_every_step_of_a_large_pitch_converges(mean: float, amplitude: float) -> None:
    """AGARD-R-702, CT2 and CT3: the nose shock forms and goes within a period."""
    steps: list[bool] = []
    harmonics("0012", (240, 72), 0.6, 0.081, 0.25, amplitude, 200.0, mean_deg=mean, periods=2, least=144, converged=steps)
    print(f"\n{len(steps) - sum(steps)} of {len(steps)} steps above tolerance", end="")
    assert all(steps)


def harmonics(
    airfoil: str, cells: tuple[int, int], mach: float, k: float, axis: float, amplitude_deg: float, farfield: float,
    *, mean_deg: float = 0.0, periods: int = 3, least: int = 48, converged: list[bool] | None = None,
) -> dict[str, complex]:  # fmt: skip
    """First harmonics of C_L and C_M over the last period of a pitch that grows over its first one, relative to the amplitude.

    Steps of at most 0.5 chords of travel and 0.8 of sound, at least `least` a period; `converged` takes what each step said."""
    flow = Flow(o_mesh(airfoil, *cells, farfield), mach, axis, Settings(tolerance=1e-2 if mean_deg else 1e-3))
    mean, amplitude = np.radians(mean_deg), np.radians(amplitude_deg)
    flow.solve_steady(mean)
    omega = 2 * k * mach
    period = 2 * np.pi / omega
    steps = max(least, int(np.ceil(period / min(0.8, 0.5 / mach))))
    rows = []
    for i in range(1, periods * steps + 1):
        r = min(i / steps, 1.0)
        grown = r**3 * (10 - 15 * r + 6 * r * r)
        rate = 30 * r * r * (1 - r) ** 2 / period
        bend = 60 * r * (1 - r) * (1 - 2 * r) / period**2
        s, c = np.sin(omega * i * period / steps), np.cos(omega * i * period / steps)
        motion = Motion(
            alpha=mean + amplitude * grown * s,
            alpha_dot=amplitude * (rate * s + grown * omega * c),
            alpha_ddot=amplitude * (bend * s + 2 * rate * omega * c - grown * omega**2 * s),
        )
        report = flow.step(motion, float(motion.alpha), period / steps)
        if converged is not None:
            converged.append(report.converged)
        rows.append((omega * i * period / steps, flow.coefficients.lift, flow.coefficients.moment))
    last = np.array(rows[-steps:])
    turn = 2j * np.exp(-1j * last[:, 0]) / amplitude
    return {name: complex(np.mean(last[:, n] * turn)) for name, n in (("C_L", 1), ("C_M", 2))}


def test_surface_pressure_follows_su2() -> None:
    """Mach 0.796, no incidence: the curve away from the shock, and where the shock stands. SU2 smears it over 6 percent."""
    flow = steady("64A010", (168, 48), 0.796, 0.0)
    middle = 0.5 * (flow.mesh.node[0, 1:] + flow.mesh.node[0, :-1])[:, 0]
    x, cp = middle[:84][::-1], pressure_coefficient(flow.pressure, 0.796)[:84][::-1]
    rows = [line.split(",") for line in (DATA / "su2_cp.csv").read_text().splitlines() if line.startswith("upper")]
    su2_x, su2_cp = np.array([[float(row[1]), float(row[3])] for row in rows]).T

    def shock(at: np.ndarray, values: np.ndarray) -> float:
        """Where C_p rises through −0.5 behind 45 percent chord."""
        behind = at > 0.45
        return float(np.interp(-0.5, values[behind][:8], at[behind][:8]))

    away = (su2_x > 0.03) & (su2_x < 0.97) & (np.abs(su2_x - 0.5) > 0.06)
    rms = float(np.sqrt(np.mean((np.interp(su2_x[away], x, cp) - su2_cp[away]) ** 2)))
    places = shock(x, cp), shock(su2_x, su2_cp)
    print(f"\nrms of C_p away from the shock {rms:.4f}; shock at x/c {places[0]:.3f}, SU2 {places[1]:.3f}")
    assert rms < 0.012
    assert abs(places[0] - places[1]) < 0.015
