"""Gas that can be compressed: springs of gas, sound, a static balance, conservation, stiff gas, the solver's term."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
import scipy.sparse
import scipy.sparse.linalg
from scipy.optimize import brentq, least_squares

from aeroslosh.fmus.slosh_vof import step
from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.multigrid import plan
from aeroslosh.fmus.slosh_vof.pressure import solve
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.slosh_vof.ribs import parse
from aeroslosh.fmus.slosh_vof.shape import Shape, fractions
from aeroslosh.fmus.slosh_vof.surface import flat
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from support.motions import REST, harmonic, march

SEA_LEVEL = 101325.0
LENGTH, HEIGHT, OPEN, NX, NY = 0.1, 0.4, 0.05, 20, 80  # a U: a rib in the middle, open at its foot
VIOLENT = harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075)


def legs(pressure: float, fill: float = 0.5, gravity: float = 9.81, **numerics: float) -> Flow:
    tank = Tank(LENGTH, HEIGHT, fill_level=fill, gravity=gravity)
    fluids = Fluids(gas_pressure=pressure, liquid_viscosity=0.0, gas_viscosity=0.0)
    return Flow(Grid(tank, NX, NY, ribs=parse(f"x=0 open=0:{OPEN}")), fluids, Numerics(wall_slip=True, **numerics))


@cache
def shares(rows: int) -> np.ndarray:
    """Gradient [1/m] of the pressure at the surface above pressures of 1 Pa on each column: `rows` of liquid, same cells."""
    dx, dy = LENGTH / NX, HEIGHT / NY
    index = np.arange(NX * rows).reshape(rows, NX)
    below = np.zeros((rows, NX - 1))
    below[:] = dy / dx
    below[round(OPEN / dy) :, NX // 2 - 1] = 0.0
    upward = np.full((rows - 1, NX), dx / dy)
    pairs = [(index[:, :-1], index[:, 1:], below), (index[:-1], index[1:], upward)]
    first = np.concatenate([np.r_[a.ravel(), b.ravel()] for a, b, _ in pairs])
    second = np.concatenate([np.r_[b.ravel(), a.ravel()] for a, b, _ in pairs])
    values = np.concatenate([np.r_[k.ravel(), k.ravel()] for _, _, k in pairs])
    off = scipy.sparse.csr_matrix((values, (first, second)), shape=(index.size, index.size))
    surface = np.zeros(index.size)
    surface[index[-1]] = 2.0 * dx / dy
    matrix = scipy.sparse.diags(np.asarray(off.sum(axis=1)).ravel() + surface) - off
    sides = np.zeros((index.size, NX))
    sides[index[-1], np.arange(NX)] = 2.0 * dx / dy
    inside = scipy.sparse.linalg.splu(matrix.tocsc()).solve(sides)
    return np.asarray((np.eye(NX) - inside[index[-1]]) * 2.0 / dy)


def theory(pressure: float, depth: float) -> float:
    """Frequency [rad/s] of the legs against each other: waves and gas of both legs, potential flow on the same cells.

    η'' = −(1/ρ) ∂p/∂n, p = (ρ_l − ρ_g) g η + γ p₀ mean(η of the leg)/(its gas's height) on the surface; between whole rows by the
    square of the period.
    """
    dy, half, periods = HEIGHT / NY, NX // 2, []
    low = math.floor(depth / dy + 1e-9)
    for rows in (low, low + 1):
        leg = np.kron(np.eye(2), np.full((half, half), 1.0 / half))
        spring = 9.81 * 0.9988 * np.eye(NX) + 1.4 * pressure / (1000.0 * (HEIGHT - depth)) * leg
        squares, shapes = np.linalg.eig(shares(rows) @ spring)
        shapes = shapes.real / np.linalg.norm(shapes.real, axis=0)
        piston = int(np.argmax(np.abs(shapes[:half].sum(axis=0) - shapes[half:].sum(axis=0))))
        periods.append(1.0 / squares.real[piston])
    return float(1.0 / math.sqrt(periods[0] + (depth / dy - low) * (periods[1] - periods[0])))


def oscillation(flow: Flow, rough: float, h: float, cycles: float = 6.0) -> tuple[float, float]:
    """Frequency and damping ratio after a push along the tank is taken away; rough [rad/s]: a first guess."""
    flow.start_from(flat(flow.grid, 0.0), SectionMotion(x_ddot=2e-3 * rough**2))
    count = round(cycles * 2.0 * math.pi / rough / h)
    t, seen = h * np.arange(1, count + 1), []
    for _ in t:
        flow.advance(REST, REST, h)
        seen.append(flow.fractions[:, : NX // 2].sum())
    v = np.array(seen) / np.ptp(seen)

    def misfit(p: np.ndarray) -> np.ndarray:
        return np.asarray((p[0] * np.cos(p[1] * t) + p[2] * np.sin(p[1] * t)) * np.exp(-p[3] * t) + p[4] - v)

    fit = least_squares(misfit, [0.5 * np.sign(v[0] - v.mean()), rough, 0.0, 0.0, v.mean()], xtol=1e-12)
    return abs(float(fit.x[1])), float(fit.x[3] / abs(fit.x[1]))


@pytest.mark.parametrize(
    ("pressure", "fill"), [(1e4, 0.5), (SEA_LEVEL, 0.5), (1e6, 0.5), (SEA_LEVEL, 0.505), (SEA_LEVEL, 0.5075)]
)
def test_two_legs_on_springs_of_gas(pressure: float, fill: float) -> None:
    """Also where the surface stands inside cells, less and more than half full: all gas is compressed, whatever cell it is in."""
    wanted = theory(pressure, HEIGHT * fill)
    h = 0.02 / wanted
    seen, damping = oscillation(legs(pressure, fill, max_step=h, tolerance=1e-9), wanted, h)
    print(f"{pressure:g} Pa, fill {fill}: {seen:.4f} of {wanted:.4f} rad/s, {100 * (seen / wanted - 1):+.3f} %, ζ {damping:.4f}")
    assert seen == pytest.approx(wanted, rel=2e-3)
    assert 0.0 < damping < 0.004


def test_second_order_in_time() -> None:
    """Springs of gas at ωΔt = 0.4, 0.2 and 0.1: frequency and damping against those at 0.02."""
    rough, found = theory(1e6, 0.2), []
    for share in (0.02, 0.1, 0.2, 0.4):
        h = share / rough
        found.append(oscillation(legs(1e6, max_step=h, tolerance=1e-10), rough, h, 12.0))
    errors = [abs(omega / found[0][0] - 1.0) for omega, _ in found[1:]]
    lost = [damping - found[0][1] for _, damping in found[1:]]
    print("ωΔt 0.1, 0.2, 0.4: frequency", [f"{e:.1e}" for e in errors], "damping", [f"{d:.1e}" for d in lost])
    assert errors[1] / errors[0] > 3.3 and errors[2] / errors[1] > 3.0
    assert errors[2] < 0.1 and abs(lost[2]) < 0.1 and abs(lost[1]) < 0.35 * abs(lost[2])


def test_sound_along_the_tank() -> None:
    """A jerk of a tank with hardly any liquid: the pressures at its walls swing against each other with 2 L/c."""
    tank = Tank(0.5, 0.15, fill_level=1 / 16)  # one row of cells
    flow = Flow(
        Grid(tank, 100, 16),
        Fluids(gas_pressure=SEA_LEVEL),
        Numerics(wall_slip=True, max_step=2e-5),
        (Probe(0.0, 0.1), Probe(0.5, 0.1)),
    )
    flow.start(REST)
    jerk, seen = SectionMotion(x_ddot=1.0), []
    t = 4e-5 * np.arange(1, 601)
    for _ in t:
        flow.advance(jerk, jerk, 4e-5)
        west, east = flow.pressures()
        seen.append(west[0] - east[0])
    p = np.array(seen)
    rough = math.pi / 0.5 * math.sqrt(1.4 * SEA_LEVEL / 1.2)

    def misfit(x: np.ndarray) -> np.ndarray:
        return np.asarray(x[0] + x[1] * np.cos(x[2] * t) + x[3] * np.cos(3 * x[2] * t) - p)

    fit = least_squares(misfit, [p.mean(), -0.5, rough, 0.0], xtol=1e-12)
    print(f"sound: {fit.x[2]:.1f} rad/s, theory {rough:.1f}; mean {fit.x[0]:.4f} Pa, amplitude {fit.x[1]:.4f} Pa")
    assert fit.x[2] == pytest.approx(rough, rel=4e-3)
    # a triangle between 0 and 2 ρ a L; the liquid is left behind too and squeezes its 15th part of the gas's volume
    swing = 16 / 15 * 1.2 * 0.5
    assert fit.x[0] == pytest.approx(swing, rel=0.03)
    assert abs(fit.x[1]) == pytest.approx(swing * 8.0 / math.pi**2, rel=0.03)


def test_a_static_balance_far_from_the_start() -> None:
    """Legs of 0.25 and 0.15 m, their gas in balance at the start; at three times the weight p V^γ of both tells the levels."""
    tank, start = Tank(LENGTH, HEIGHT), 2000.0
    fluids = Fluids(gas_pressure=start, liquid_viscosity=1e-3)
    flow = Flow(Grid(tank, NX, NY, ribs=parse(f"x=0 open=0:{OPEN}")), fluids)
    heights = np.repeat([0.25, 0.15], NX // 2)
    flow.start_from(np.clip((heights - 0.005 * np.arange(NY)[:, None]) / 0.005, 0.0, 1.0), REST)
    gas = HEIGHT - np.array([0.25, 0.15])
    q = 1000.0 * flow.grid.inner(flow.state[step.Q])
    first = start + np.array([q[60:, 0].mean(), q[60:, -1].mean()])
    assert first[1] - first[0] == pytest.approx(981.0, rel=0.005)
    assert (first * gas).sum() / gas.sum() == pytest.approx(start, rel=2e-3)

    def unbalance(sunk: float) -> float:
        now = first * (gas / (gas + np.array([sunk, -sunk]))) ** 1.4
        return float(now[0] - now[1] + 3.0 * 9.81 * 998.8 * (0.1 - 2.0 * sunk))

    sunk = float(brentq(unbalance, 0.0, 0.049))
    heavy = SectionMotion(h_ddot=-2.0 * 9.81)
    flow.advance(heavy, heavy, 8.0)
    seen = 0.25 - flow.fractions[:, : NX // 2].sum() * 0.005 / (NX // 2)
    print(f"sunk {1e3 * seen:.2f} mm, theory {1e3 * sunk:.2f} mm")
    assert seen == pytest.approx(sunk, rel=5e-3)
    assert flow.volume == pytest.approx(0.5 * LENGTH * HEIGHT, rel=1e-13)


def test_stiff_gas_is_gas_that_cannot_be_compressed() -> None:
    """What goes through the opening, and the loads' difference, fall as 1/p; with 0 there is no term at all."""
    motion = harmonic(6.0, 0.2, surge=0.01)
    swings, loads = [], []
    for pressure in (0.0, 1e6, 1e7):
        grid = Grid(Tank(0.5, 0.15), 50, 20, ribs=parse("x=0 open=0:0.03"))
        flow = Flow(grid, Fluids(gas_pressure=pressure), Numerics(tolerance=1e-11))
        assert (flow.gas is None) == (pressure == 0.0) and len(flow.state) == step.STATE_ROWS + (pressure > 0.0)
        flow.start(motion(0.0))
        rows, aft = [], []
        for k in range(50):
            flow.advance(motion(0.01 * k), motion(0.01 * (k + 1)), 0.01)
            rows.append(flow.loads(motion(0.01 * (k + 1)))[:3])
            aft.append(flow.fractions[:, 25:].mean())
        swings.append(np.ptp(aft))
        loads.append(np.array(rows))
    gaps = [np.abs(rows - loads[0]).max() / np.abs(loads[0][:, 0]).max() for rows in loads[1:]]
    print("stiff gas: through the opening", [f"{s:.2e}" for s in swings], "loads", [f"{g:.2e}" for g in gaps])
    assert swings[0] < 1e-9
    assert swings[1] / swings[2] == pytest.approx(10.0, rel=0.05)
    assert gaps[0] / gaps[1] == pytest.approx(10.0, rel=0.2) and gaps[1] < 3e-3


@pytest.mark.parametrize("ribs", ["", "x=0 open=0:0.03", "x=0.06; x=-0.1 open=0.1:0.15"])
@pytest.mark.parametrize("pressure", [2e4, SEA_LEVEL, 1e7])
def test_violent_motion_keeps_liquid_and_gas(ribs: str, pressure: float) -> None:
    """Two seconds of breaking waves and roof hits, soft to stiff gas: volume and gas's mass to round-off in every compartment, no
    more liquid in a cell than the cell holds, loads of the size they have without the term, as many steps."""
    rows, steps = [], []
    for value in (pressure, 0.0):
        flow = Flow(Grid(Tank(0.5, 0.15), 50, 16, ribs=parse(ribs)), Fluids(gas_pressure=value))
        flow.start(VIOLENT(0.0))
        before = kept(flow)
        count, loads = 0, []
        for k in range(200):
            report = flow.advance(VIOLENT(0.01 * k), VIOLENT(0.01 * (k + 1)), 0.01)
            assert report.converged
            count += report.steps
            loads.append(flow.loads(VIOLENT(0.01 * (k + 1)))[:3])
            assert flow.fractions.min() > -1e-9 and flow.fractions.max() < 1.0 + 1e-4
        np.testing.assert_allclose(kept(flow), before, rtol=2e-13)
        rows.append(np.std(loads, axis=0))
        steps.append(count)
    print(f"{ribs!r}, {pressure:g} Pa: std of loads {rows[0].round(1)}, without {rows[1].round(1)}; steps {steps}")
    assert rows[0][1] == pytest.approx(rows[1][1], rel=0.1)
    assert steps[0] < 2.0 * steps[1]


def kept(flow: Flow) -> np.ndarray:
    """Liquid, and gas's mass, of each compartment [cells]."""
    amounts = [flow.fractions]
    if flow.gas is not None:
        amounts.append(flow.grid.inner(flow.state[step.GAS]))
    return np.array([amount[:, first:last].sum() for amount in amounts for first, last in flow.grid.rooms])


def energy(flow: Flow) -> float:
    """Kinetic energy, weight's and the gas's [J/m] in a tank at rest."""
    grid, inner = flow.grid, flow.grid.inner
    rho, c = inner(flow.work[step.RHO]), flow.fractions
    u, v = inner(flow.state[step.U]), inner(flow.state[step.V])
    area = grid.dx * grid.dy
    moving = 0.25 * ((rho[:, 1:] + rho[:, :-1]) * u[:, :-1] ** 2).sum() + 0.25 * ((rho[1:] + rho[:-1]) * v[:-1] ** 2).sum()
    gas, share = inner(flow.state[step.GAS]), np.maximum(1.0 - c, 1e-12)
    density = np.where(c <= 0.5, gas / share, 1.0)
    squeezed = (share * (density**1.4 - 1.0)).sum() / 0.4 * flow.fluids.gas_pressure
    return float(area * (moving + 9.81 * (rho * inner(grid.y)).sum() + squeezed))


def test_energy_does_not_grow() -> None:
    """A tank full of spray is held: what liquid and gas have falls, tenth by tenth of a second."""
    flow = Flow(Grid(Tank(0.5, 0.15), 50, 16), Fluids(gas_pressure=SEA_LEVEL))
    flow.start(VIOLENT(0.0))
    for k in range(150):
        flow.advance(VIOLENT(0.01 * k), VIOLENT(0.01 * (k + 1)), 0.01)
    now, seen = SectionMotion(), []
    for _ in range(20):
        flow.advance(now, now, 0.1)
        seen.append(energy(flow))
    falls = -np.diff(seen)
    print(f"energy {seen[0]:.3f} to {seen[-1]:.3f} J/m, smallest fall {falls.min():.1e}")
    assert falls.min() > -0.02 * np.ptp(seen)
    assert np.ptp(seen) > 0.1 and seen[-1] == min(seen)


@pytest.mark.parametrize("ribs", ["", "x=0.065; x=-0.1 open=0:0.03"])
@pytest.mark.parametrize("degrees", [0.0, 20.0])
def test_liquid_at_rest_stays_at_rest(ribs: str, degrees: float) -> None:
    grid = Grid(Tank(0.5, 0.15), 50, 20, ribs=parse(ribs))
    flow = Flow(grid, Fluids(gas_pressure=SEA_LEVEL), Numerics(tolerance=1e-12))
    motion = SectionMotion(alpha=math.radians(degrees))
    flow.start(motion)
    flow.advance(motion, motion, 0.5)
    assert np.abs(flow.state[[step.U, step.V]]).max() < 1e-8
    assert flow.loads(motion).force_y == pytest.approx(-9.81 * 0.0375 * 1001.2, rel=1e-8)


def test_compartments_full_and_empty() -> None:
    """A column fills the west one to the roof, the east one holds gas alone: no cushion there, nothing but one here."""
    grid = Grid(Tank(0.5, 0.15), 50, 20, ribs=parse("x=0"))
    flow = Flow(grid, Fluids(gas_pressure=SEA_LEVEL))
    flow.start_from(fractions(Shape(column=0.25), grid, 0.0), VIOLENT(0.0))
    for k in range(50):
        assert flow.advance(VIOLENT(0.01 * k), VIOLENT(0.01 * (k + 1)), 0.01).converged
    end = VIOLENT(0.5)
    assert flow.fractions[:, :25].min() > 1.0 - 1e-5 and flow.fractions[:, 25:].max() == 0.0
    assert flow.loads(end).force_y == pytest.approx(-37.5 * (9.81 - end.h_ddot), rel=0.2)
    q = 1000.0 * grid.inner(flow.state[step.Q])
    assert abs(q[:, 25:].mean()) < 5.0 and abs(q[-1, :25].mean()) < 1e-6


def test_a_snapshot_repeats_to_the_bit() -> None:
    def tank() -> Flow:
        return Flow(Grid(Tank(0.5, 0.15), 40, 16, ribs=parse("x=0 open=0:0.03")), Fluids(gas_pressure=2e4))

    flow = tank()
    flow.start(VIOLENT(0.0))
    march(flow, VIOLENT, 0.2, 0.01)
    saved, runs = flow.save(), []
    for again in (flow, flow, tank()):
        again.restore(saved)
        for k in range(20, 40):
            again.advance(VIOLENT(0.01 * k), VIOLENT(0.01 * (k + 1)), 0.01)
        runs.append([value.hex() for value in again.loads(VIOLENT(0.4))])
    assert runs[0] == runs[1] == runs[2]


def test_steps_of_any_length() -> None:
    """Communication steps of 0.1 ms to 50 ms tell the same; tiny ones among long ones do not stir what is at rest."""
    motion = harmonic(8.0, 0.3, surge=0.004)
    ends = []
    for h in (1e-4, 5e-3, 5e-2):
        flow = legs(SEA_LEVEL, max_step=2e-3)
        flow.start(motion(0.0))
        ends.append(march(flow, motion, 0.4, h)[1][-1])
    for late in ends[1:]:
        assert np.abs(late[:3] - ends[0][:3]).max() < 5e-3 * np.abs(ends[0][0])
    flow, tilted = Flow(Grid(Tank(0.5, 0.15), 50, 16), Fluids(gas_pressure=SEA_LEVEL)), SectionMotion(alpha=0.1)
    flow.start(tilted)
    for k in range(60):
        flow.advance(tilted, tilted, 1e-8 if k % 2 else 0.05)
        assert abs(flow.loads(tilted).force_x) < 0.1  # of 368 N


@pytest.mark.parametrize("stiffness", [1e-6, 1e-2, 1e3])
@pytest.mark.parametrize("ribs", ["", "x=-0.115; x=0.065"])
def test_the_solver_with_a_diagonal_against_a_direct_solution(ribs: str, stiffness: float) -> None:
    """From hardly any to a large one, in gas alone: no constant is free where there is gas."""
    grid = Grid(Tank(0.5, 0.15), 100, 30, ribs=parse(ribs))
    rows, columns = np.mgrid[:30, :100]
    c = grid.zeros()
    grid.inner(c)[:] = (rows + 0.5) / 30 < 0.5 + 0.2 * np.cos(0.07 * columns)
    rho, s = 0.0012 + 0.9988 * c, grid.stride
    kx, ky, own = grid.zeros(), grid.zeros(), grid.zeros()
    kx[:-1] = 2.0 / (rho[:-1] + rho[1:]) * grid.dy / grid.dx
    ky[:-s] = 2.0 / (rho[:-s] + rho[s:]) * grid.dx / grid.dy
    kx, ky = kx * grid.open_x, ky * grid.open_y
    grid.inner(own)[:] = stiffness * (grid.inner(c) < 0.5)
    index = np.arange(3000).reshape(30, 100)
    pairs = [(index[:, :-1], index[:, 1:], grid.inner(kx)[:, :-1]), (index[:-1], index[1:], grid.inner(ky)[:-1])]
    first = np.concatenate([np.r_[a.ravel(), b.ravel()] for a, b, _ in pairs])
    second = np.concatenate([np.r_[b.ravel(), a.ravel()] for a, b, _ in pairs])
    values = np.concatenate([np.r_[k.ravel(), k.ravel()] for _, _, k in pairs])
    off = scipy.sparse.csr_matrix((values, (first, second)), shape=(3000, 3000))
    full = scipy.sparse.diags(np.asarray(off.sum(axis=1)).ravel() + grid.inner(own).ravel()) - off
    rhs, q = grid.zeros(), grid.zeros()
    grid.inner(rhs)[:] = np.random.default_rng(2).standard_normal((30, 100))
    exact = scipy.sparse.linalg.spsolve(full.tocsc(), grid.inner(rhs).ravel()).reshape(30, 100)
    levels, length = plan(100, 30, grid.dx, grid.dy)
    coarse, work = np.zeros((8, length), dtype=np.float32), np.zeros((3, grid.size))
    iterations, left = solve(q, rhs, kx, ky, 1e-10, 200, levels, coarse, work, own)
    print(f"{ribs!r}, {stiffness:g}: {iterations} iterations")
    assert left <= 1.0 and iterations <= 100
    assert np.abs(grid.inner(q) - exact).max() < 1e-5 * np.abs(exact).max()
