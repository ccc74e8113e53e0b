"""Friction of the front and the back wall: its rate against a solved channel flow, the decay of a wave, the load on the tank."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.linalg import solve_banded
from scipy.optimize import curve_fit

from aeroslosh.fmus.slosh_vof import step
from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.side_walls import rate
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from support.motions import REST, harmonic, march


def channel(viscosity: float, omega: float, width: float, points: int = 4001) -> float:
    """The same by finite differences: iω u = 1 + ν u'', no slip; real part of the pressure gradient per mean velocity."""
    z = width / (points - 1)
    bands = np.zeros((3, points - 2), dtype=complex)
    bands[0, 1:] = bands[2, :-1] = -viscosity / z**2
    bands[1] = 1j * omega + 2.0 * viscosity / z**2
    u = solve_banded((1, 1), bands, np.ones(points - 2, dtype=complex))
    return float((1.0 / (u.sum() * z / width)).real)


@pytest.mark.parametrize(
    ("viscosity", "omega", "width"), [(1e-6, 4.0, 0.062), (5e-5, 4.1, 0.062), (1e-3, 4.0, 0.062), (1e-2, 1.0, 0.01)]
)
def test_the_rate_is_that_of_oscillating_channel_flow(viscosity: float, omega: float, width: float) -> None:
    assert rate(viscosity, omega, width) == pytest.approx(channel(viscosity, omega, width), rel=1e-3)


def test_the_rate_of_thin_and_of_thick_layers_and_of_none() -> None:
    assert rate(1e-8, 4.0, 1.0) == pytest.approx(2.0 * math.sqrt(1e-8 * 4.0 / 2.0), rel=1e-3)
    assert rate(1e-2, 1e-6, 0.01) == pytest.approx(12.0 * 1e-2 / 0.01**2, rel=1e-6)
    assert rate(1e-6, 1e4, 10.0) == pytest.approx(2.0 * math.sqrt(1e-6 * 1e4 / 2.0) / 10.0, rel=1e-3)  # no overflow
    assert rate(0.0, 4.0, 0.1) == rate(1e-6, 0.0, 0.1) == 0.0


def decay(width: float, omega_friction: float) -> tuple[float, float]:
    """Damping ratio and frequency [rad/s] of a small first standing wave between slip walls."""
    tank = Tank(0.5, 0.15, width=width)
    fluids = Fluids(gas_density=0.1, liquid_viscosity=1e-5)
    flow = Flow(Grid(tank, 50, 16), fluids, Numerics(wall_slip=True, side_wall_omega=omega_friction))
    flow.start(REST, 1e-3)
    times, heights = 0.02 * np.arange(1, 301), []
    for _ in times:
        flow.advance(REST, REST, 0.02)
        heights.append(flow.wave_heights[0])

    def wave(t: np.ndarray, size: float, zeta: float, omega: float, phase: float) -> np.ndarray:
        return size * np.exp(-zeta * omega * t) * np.cos(omega * t + phase)

    found, _ = curve_fit(wave, times, heights, [1e-3, 0.01, 5.2, 0.0])
    return float(found[1]), float(found[2])


def test_a_wave_decays_at_half_the_rate() -> None:
    """a'' + λ a' + ω² a = 0: damping ratio λ/(2ω), here 5 %."""
    tank = Tank(0.5, 0.15, width=0.02)
    omega = float(modes(tank, 1).omega[0])
    (free, _), (held, frequency) = decay(0.02, 0.0), decay(0.02, omega)
    wanted = rate(1e-5, omega, 0.02) / (2.0 * omega)
    print(f"damping ratio {held - free:.5f}, theory {wanted:.5f}; frequency {frequency:.4f} of {omega:.4f} rad/s")
    assert wanted > 0.04
    assert held - free == pytest.approx(wanted, rel=0.01)
    assert frequency == pytest.approx(omega * math.sqrt(1.0 - wanted**2), rel=2e-3)


def test_the_walls_friction_is_part_of_the_load() -> None:
    """A wave in a tank at rest: the force on the tank is what the fluids' momentum loses, friction included."""
    tank, h = Tank(0.5, 0.15, width=0.02), 1e-3
    flow = Flow(Grid(tank, 50, 16), Fluids(liquid_viscosity=1e-4), Numerics(max_step=h, wall_slip=True, side_wall_omega=5.0))
    flow.start(REST, 0.02)
    grid, momenta, forces = flow.grid, [], []
    for k in range(201):
        if k:
            flow.advance(REST, REST, h)
        mass = 0.5 * grid.dx * grid.dy * tank.width * (lambda r: r[:, 1:] + r[:, :-1])(grid.inner(flow.work[step.RHO]))
        u, a = grid.inner(flow.state[step.U]), grid.inner(flow.state[step.AX])
        momenta.append(float((mass * (u + 0.5 * h * a)[:, :-1]).sum()))  # at half steps, as the solver conserves it
        forces.append(flow.loads(REST).force_x)
    force = np.array(forces)[1:]
    gap = force + np.diff(momenta) / h
    drag = rate(1e-4, 5.0, 0.02) * np.array(momenta)[:-1]
    print(f"gap {np.std(gap):.2e} N, friction {np.std(drag):.2e} N, force {np.std(force):.2e} N")
    assert np.std(drag) > 0.1 * np.std(force)
    assert np.std(gap) < 0.02 * np.std(drag)


def test_off_is_off_and_a_narrow_tank_takes_longer_steps_down() -> None:
    tank = Tank(0.5, 0.15, width=0.02)
    assert Flow(Grid(tank, 32, 16)).sides is None
    thick = Flow(Grid(Tank(0.5, 0.15, width=1e-3), 32, 16), Fluids(liquid_viscosity=1e-3), Numerics(side_wall_omega=5.0))
    lam = rate(1e-3, 5.0, 1e-3)
    assert thick.numbers.max_step <= 0.2 / lam
    motion = harmonic(5.0, 0.3, pitch=0.05)
    thick.start(motion(0.0))
    _, loads = march(thick, motion, 0.1, 0.01)
    assert np.isfinite(loads).all()
