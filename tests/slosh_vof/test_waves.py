"""Waves against theory: frequency with two fluids, second order, capillarity, linear forcing, time order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.surface import from_heights
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes, stokes_damping
from support.motions import REST, harmonic, march


def frequency(times: np.ndarray, values: np.ndarray, guess: float) -> tuple[float, float]:
    """Frequency and decay rate [rad/s, 1/s] of a damped cosine."""
    scale = np.abs(values).max()

    def misfit(p: np.ndarray) -> np.ndarray:
        return np.asarray(
            (p[0] * np.cos(p[1] * times) + p[2] * np.sin(p[1] * times)) * np.exp(-p[3] * times) + p[4] - values / scale
        )

    fit = least_squares(misfit, [values[0] / scale, guess, 0.0, 0.0, 0.0], xtol=1e-12)
    return float(fit.x[1]), float(fit.x[3])


def two_fluids(k: float, below: float, above: float, gas: float, sigma: float = 0.0) -> float:
    """Frequency of small waves between liquid of 1000 kg/m3 and gas, depths [m] (Lamb, Hydrodynamics, article 231)."""
    return math.sqrt((9.81 * k * (1000.0 - gas) + sigma * k**3) / (1000.0 / math.tanh(k * below) + gas / math.tanh(k * above)))


@pytest.mark.parametrize(("fill", "gas", "most"), [(0.5, 1.2, 3e-4), (0.3, 1.2, 3e-4), (0.8, 1.2, 5e-4), (0.5, 300.0, 2e-3)])
def test_frequency_of_the_first_mode(fill: float, gas: float, most: float) -> None:
    """Gas is carried upwind: the heavier it is or the faster it must move through a thin layer, the more it drags."""
    flow = Flow(Grid(Tank(0.5, 0.15, fill_level=fill), 100, 30), Fluids(gas_density=gas), Numerics(wall_slip=True))
    flow.start(REST, 2e-4)
    times, loads = march(flow, lambda t: REST, 8.0, 0.02)
    theory = two_fluids(math.pi / 0.5, 0.15 * fill, 0.15 * (1 - fill), gas)
    seen, decay = frequency(times, loads[:, 2], theory)
    print(f"fill {fill}, gas {gas}: {100 * (seen / theory - 1):+.4f} %, decay {decay / theory:.1e}")
    assert seen == pytest.approx(theory, rel=most)
    assert 0.0 < decay < (5e-4 if gas < 2.0 else 5e-3) * theory


@pytest.mark.parametrize(("cells", "viscosity"), [((50, 16), 1e-6), ((100, 30), 1e-6), ((50, 16), 5e-6)])
def test_damping_of_walls(cells: tuple[int, int], viscosity: float) -> None:
    """Laminar layers damp the first mode and slow it as much (Landau and Lifshitz, Fluid Mechanics, section 25).

    With the wall layer most of it is there on any grid, on the grid alone much less.
    """
    tank = Tank(0.5, 0.15)
    omega = modes(tank, 1).omega
    theory = float(stokes_damping(tank, omega, viscosity)[0])
    seen = []
    for layer in (True, False):
        flow = Flow(Grid(tank, *cells), Fluids(gas_density=0.1, liquid_viscosity=viscosity), Numerics(wall_layer=layer))
        flow.start(REST, 2e-4)
        times, loads = march(flow, lambda t: REST, 8.0, 0.02)
        found, decay = frequency(times, loads[:, 2], float(omega[0]))
        seen.append((decay / found, 1.0 - found / omega[0]))
    print(f"{cells}, {viscosity}: theory {theory:.5f}, layer {seen[0][0]:.5f} slower {seen[0][1]:.5f}, grid {seen[1][0]:.5f}")
    assert 0.8 * theory < seen[0][0] < 1.05 * theory
    assert 0.6 * theory < seen[0][1] < 1.7 * theory
    assert seen[1][0] < 0.8 * seen[0][0]


def test_second_order_standing_wave() -> None:
    """Depth half the length: the part of the wall's height that does not change sign with the amplitude.

    eta2 = a² k (c0 + c2 cos 2 w t − (c0 + c2) cos w2 t), c0 = (1 + T²)/(8 T), c2 = (3 − T²)/(8 T³), T = tanh k h,
    w2² = 2 g k tanh 2 k h; derived from the potential problem to second order.
    """
    length, a = 1.0, 0.01
    k = math.pi / length
    flow = Flow(
        Grid(Tank(length, 0.8, fill_level=0.625), 100, 80), Fluids(gas_density=0.1), Numerics(wall_slip=True, max_step=2e-3)
    )
    flow.start(REST, a)
    times, second = 0.01 * np.arange(1, 201), []
    for _ in times:
        flow.advance(REST, REST, 0.01)
        west, east = flow.wave_heights
        second.append(0.5 * (west + east))
    t2 = math.tanh(k * 0.5)
    w, w2 = math.sqrt(9.81 * k * t2), math.sqrt(2 * 9.81 * k * math.tanh(2 * k * 0.5))
    c0, c2 = (1 + t2**2) / (8 * t2), (3 - t2**2) / (8 * t2**3)
    theory = a**2 * k * (c0 + c2 * np.cos(2 * w * times) - (c0 + c2) * np.cos(w2 * times))
    gap = np.sqrt(np.mean((np.array(second) - theory) ** 2)) / np.std(theory)
    print(f"second order: {100 * gap:.1f} %")
    assert gap < 0.05


def test_capillary_wave() -> None:
    """Surface tension twenty times that of water doubles the frequency of a 5 cm wave."""
    tank = Tank(0.05, 0.05)
    flow = Flow(
        Grid(tank, 48, 48), Fluids(liquid_viscosity=0.0, gas_viscosity=0.0, surface_tension=1.456), Numerics(wall_slip=True)
    )
    flow.start_from(from_heights(flow.grid, lambda x: 5e-4 * np.cos(2 * np.pi * x / 0.05)), REST)
    heights = []
    times = 0.002 * np.arange(1, 151)
    for _ in times:
        flow.advance(REST, REST, 0.002)
        heights.append(flow.wave_heights[0])
    k = 2 * math.pi / 0.05
    theory = two_fluids(k, 0.025, 0.025, 1.2, 1.456)
    assert theory > 1.5 * two_fluids(k, 0.025, 0.025, 1.2)
    seen, _ = frequency(times, np.array(heights), theory)
    assert seen == pytest.approx(theory, rel=0.01)


def test_pressure_in_a_drop() -> None:
    """Laplace: sigma over the radius, in hardly any gravity."""
    tank = Tank(0.02, 0.02, gravity=1e-6)
    flow = Flow(Grid(tank, 64, 64), Fluids(surface_tension=0.0728, gas_density=1.0))
    points = (np.arange(16) + 0.5) / 16 - 0.5
    grid = flow.grid
    x = grid.inner(grid.x)[..., None, None] + points[:, None] * grid.dx
    y = grid.inner(grid.y)[..., None, None] + points[None, :] * grid.dy
    flow.start_from((x**2 + y**2 < 0.005**2).mean(axis=(-2, -1)), REST)
    flow.advance(REST, REST, 0.002)
    jump = flow.pressure[30:34, 30:34].mean() - flow.pressure[:4, :4].mean()
    assert jump == pytest.approx(0.0728 / 0.005, rel=0.01)


def test_second_order_in_time() -> None:
    """Forces of a pitching tank against those with steps eight times shorter."""
    motion = harmonic(12.0, 0.2, pitch=math.radians(0.3))
    series = []
    for longest in (1e-3, 2e-3, 4e-3, 8e-3):
        flow = Flow(Grid(Tank(0.5, 0.15), 50, 16), numerics=Numerics(max_step=longest, tolerance=1e-10))
        flow.start(motion(0.0))
        _, loads = march(flow, motion, 0.8, 0.016)
        series.append(loads[:, :3])
    errors = [np.std(s[:, 0] - series[0][:, 0]) / np.std(series[0][:, 0]) for s in series[1:]]
    print("time step 2, 4, 8 ms:", [f"{100 * e:.4f} %" for e in errors])
    assert errors[2] < 0.002
    assert errors[2] / errors[1] > 2.2


def test_long_communication_steps_lose_nothing() -> None:
    """The motion inside a step follows its end values: 0.1 s steps against 0.001 s steps."""
    motion = harmonic(math.pi, 1.0, pitch=math.radians(1.0))
    ends = []
    for step in (1e-3, 1e-2, 1e-1):
        flow = Flow(Grid(Tank(0.5, 0.15), 50, 16))
        flow.start(motion(0.0))
        _, loads = march(flow, motion, 2.0, step)
        ends.append(loads[:: round(0.1 / step)][-10:] if step == 0.1 else loads[round(0.1 / step) - 1 :: round(0.1 / step)][-10:])
    for late in ends[1:]:
        assert np.abs(late[:, 0] - ends[0][:, 0]).max() < 2e-3 * np.abs(ends[0][:, 0]).max()
        assert np.abs(late[:, 2] - ends[0][:, 2]).max() < 2e-3 * np.abs(ends[0][:, 2]).max()
