"""Exact states of a tank of two fluids, conservation, and the loads' balance."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

from aeroslosh.fmus.slosh_vof import step
from aeroslosh.fmus.slosh_vof.flow import Flow, FlowError, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Baffles, Grid
from aeroslosh.fmus.slosh_vof.surface import flat, from_heights
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import lid_inertia
from aeroslosh.fmus.tank.motion import SectionMotion, at, body_force, course
from support.momentum import momentum_gap
from support.motions import REST, Course, harmonic, march

WATER = 0.5 * 0.075 * 1000.0
AIR = 0.5 * 0.075 * 1.2


def fastest(flow: Flow) -> float:
    return float(np.abs(flow.state[[step.U, step.V]]).max())


@pytest.mark.parametrize("degrees", [0.0, 5.0, 20.0, 45.0, 80.0, 180.0])
def test_liquid_at_rest_stays_at_rest_in_a_tilted_tank(degrees: float) -> None:
    """To the round-off of an (almost) exact pressure, with its exact weight and lever."""
    flow = Flow(Grid(Tank(0.5, 0.15), 50, 16), numerics=Numerics(tolerance=1e-12))
    motion = SectionMotion(alpha=math.radians(degrees))
    flow.start(motion)
    flow.advance(motion, motion, 0.004)
    if degrees < 180.0:  # an unstable balance keeps only as long as round-off allows
        flow.advance(motion, motion, 0.5)
    assert fastest(flow) < 1e-9
    loads = flow.loads(motion)
    assert loads.force_x == pytest.approx(0.0, abs=1e-7)
    assert loads.force_y == pytest.approx(-9.81 * (WATER + AIR), rel=1e-9)
    # the weight acts at the liquid's centre
    grid = flow.grid
    density = 1.2 + 998.8 * flow.fractions
    x = grid.inner(grid.x) * math.cos(motion.alpha) + grid.inner(grid.y) * math.sin(motion.alpha)
    assert loads.moment == pytest.approx(9.81 * float((density * x).sum()) * grid.dx * grid.dy, rel=2e-3, abs=1e-7)


def test_a_tilted_surface_settles_to_level() -> None:
    """From a surface square to the tank: thick liquid comes to rest level."""
    flow = Flow(Grid(Tank(0.5, 0.15, fill_level=0.4), 50, 16), Fluids(liquid_viscosity=2e-3))
    motion = SectionMotion(alpha=math.radians(6.0))
    flow.start_from(flat(flow.grid, 0.0), motion)
    flow.advance(motion, motion, 0.3)
    assert fastest(flow) > 0.1
    flow.advance(motion, motion, 30.0)
    assert fastest(flow) < 2e-3
    assert np.abs(flow.fractions - flat(flow.grid, motion.alpha)).max() < 0.02


def test_a_full_tank_moves_as_frozen_in_translation_and_less_in_rotation() -> None:
    """Translation: the whole mass. Rotation: the inertia of liquid in a closed box, not of the solid."""
    tank = Tank(0.5, 0.15, fill_level=1.0, x=0.1, y=0.05)
    flow = Flow(Grid(tank, 100, 30))
    weight = tank.mass * tank.gravity
    flow.start(SectionMotion(h_ddot=3.0))
    assert flow.loads(REST).force_y == pytest.approx(-tank.mass * (9.81 - 3.0), rel=1e-9)
    flow.start(SectionMotion(x_ddot=2.0))
    loads = flow.loads(REST)
    assert loads.force_x == pytest.approx(-2.0 * tank.mass, rel=1e-6)
    assert loads.moment == pytest.approx(weight * tank.x - 2.0 * tank.mass * tank.y, rel=1e-6)
    flow.start(SectionMotion(alpha_ddot=5.0))
    inertia = (weight * tank.x - flow.loads(REST).moment) / 5.0 - tank.mass * (tank.x**2 + tank.y**2)
    assert inertia == pytest.approx(lid_inertia(tank), rel=2e-3)
    frozen = tank.mass * (tank.length**2 + tank.height**2) / 12.0
    assert inertia < 0.8 * frozen


def test_the_surface_of_a_spinning_tank_is_an_arc_about_the_axis() -> None:
    """Axis one metre above the tank, 10 rad/s, hardly any weight: the surface is a circle about the axis and stays there."""
    tank = Tank(0.5, 0.15, y=-1.0, gravity=0.01)
    grid = Grid(tank, 100, 30)
    spin = 10.0
    flow = Flow(grid)

    def motion(t: float) -> SectionMotion:
        return SectionMotion(alpha=spin * t, alpha_dot=spin)

    across = np.linspace(-0.25, 0.25, 2001)
    radius = brentq(lambda r: np.sqrt(r * r - across**2).mean() - 1.0, 1.0, 1.1)  # the liquid's volume

    def arc(x: np.ndarray) -> np.ndarray:
        return np.asarray(1.0 - np.sqrt(radius**2 - (x - 0.25) ** 2))

    flow.start_from(from_heights(grid, arc), motion(0.0))
    before = flow.fractions.sum(axis=0) * grid.dy
    assert np.ptp(before) > 0.025  # a centimetre would be noise, three are an arc
    march(flow, motion, 1.0, 0.01)
    after = flow.fractions.sum(axis=0) * grid.dy
    assert np.abs(after - before).max() < 1e-4
    # liquid pressed outwards: m R omega²
    lever = float((flow.fractions * -grid.inner(grid.y)).sum() / flow.fractions.sum())
    assert -flow.loads(motion(1.0)).force_y_tank == pytest.approx(100.0 * lever * WATER, rel=2e-3)


def test_volume_and_bounds() -> None:
    """A violent second: volume to round-off, volume fractions as good as the pressure."""
    motion = harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075)
    for tolerance, most in ((1e-6, 1e-5), (1e-12, 1e-10)):
        flow = Flow(Grid(Tank(0.5, 0.15), 50, 16), numerics=Numerics(tolerance=tolerance))
        flow.start(motion(0.0))
        volume = flow.volume
        march(flow, motion, 1.0, 0.02)
        assert abs(flow.volume / volume - 1.0) < 1e-13
        assert flow.fractions.min() > -1e-12
        assert flow.fractions.max() < 1.0 + most


@pytest.mark.parametrize(
    ("motion", "duration", "h", "most"),
    [
        (harmonic(4.0, 1.0, surge=1e-3), 2.0, 1e-3, 1e-4),
        (harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075), 1.0, 5e-4, 0.01),
        (harmonic(5.2, 1.0, surge=0.05), 2.0, 5e-4, 0.03),  # the roof is hit: one cell carries the impact
    ],
    ids=["gentle", "violent", "impact"],
)
def test_walls_carry_the_change_of_momentum(motion: Course, duration: float, h: float, most: float) -> None:
    gap = momentum_gap(Flow(Grid(Tank(0.5, 0.15), 100, 30), numerics=Numerics(max_step=h)), motion, duration, h)
    print(f"wall against momentum: x {gap[0]:.1e}, y {gap[1]:.1e}")
    assert gap[0] < most


def test_thick_liquid_damps_as_stokes_says() -> None:
    """A vortex in a full tank with slipping walls decays with ν (kx² + ky²): second order."""
    errors = []
    for n in (16, 32):
        grid = Grid(Tank(0.2, 0.2, fill_level=1.0), n, n)
        flow = Flow(grid, Fluids(liquid_viscosity=1e-3), Numerics(wall_slip=True, tolerance=1e-12, max_step=5e-4))
        flow.start(REST)
        k = np.pi / 0.2
        x, y = grid.x + 0.1, grid.y + 0.1
        small = 1e-4  # so that the flow does not carry itself
        flow.state[step.U] = small * np.sin(k * (x + 0.5 * grid.dx)) * np.cos(k * y) * grid.open_x
        flow.state[step.V] = -small * np.cos(k * x) * np.sin(k * (y + 0.5 * grid.dy)) * grid.open_y
        before = np.abs(flow.state[step.U]).max()
        flow.advance(REST, REST, 1.0)
        rate = -math.log(np.abs(flow.state[step.U]).max() / before)
        errors.append(abs(rate / (2e-3 * k**2) - 1.0))
    assert errors[1] < 0.002
    assert errors[0] / errors[1] > 3.0


def test_a_baffle_calms_the_wave_and_takes_its_load() -> None:
    """Half-height plate in the middle: the first mode is slower and the plate carries force."""
    plain, plated = (Flow(Grid(Tank(0.5, 0.15), 50, 16, Baffles(count, 0.0, 0.45))) for count in (0, 1))
    results = []
    for flow in (plain, plated):
        flow.start(REST, 0.004)
        times, loads = march(flow, lambda t: REST, 1.0, 0.01)
        turn = times[np.nonzero(np.diff(np.sign(loads[:, 2])))[0][0]]
        results.append((turn, loads))
    assert results[1][0] > 1.1 * results[0][0]
    walls = results[1][1][:, 5] + results[1][1][:, 6]
    assert np.abs(results[1][1][:, 3] - walls).max() > 0.2 * np.abs(results[1][1][:, 3]).max()
    assert np.abs(results[0][1][:, 3] - results[0][1][:, 5:7].sum(axis=1)).max() < 0.02 * np.abs(results[0][1][:, 3]).max()


def test_a_snapshot_repeats_to_the_bit() -> None:
    motion = harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075)
    flow = Flow(Grid(Tank(0.5, 0.15), 40, 16))
    flow.start(motion(0.0))
    march(flow, motion, 0.2, 0.01)
    kept = flow.save()
    runs = []
    for _ in range(2):
        flow.restore(kept)
        rows = []
        for k in range(20, 40):
            flow.advance(motion(0.01 * k), motion(0.01 * (k + 1)), 0.01)
            rows.append([value.hex() for value in flow.loads(motion(0.01 * (k + 1)))])
        runs.append(rows)
    assert runs[0] == runs[1]
    other = Flow(Grid(Tank(0.5, 0.15), 40, 16))
    other.restore(kept)
    other.advance(motion(0.2), motion(0.21), 0.01)
    assert [value.hex() for value in other.loads(motion(0.21))] == runs[0][0]


def test_tiny_steps_among_long_ones_do_not_stir_the_liquid() -> None:
    """What a tiny step undoes of the divergence left must not be repeated by the long step after it."""
    flow = Flow(Grid(Tank(0.5, 0.15), 50, 16))
    motion = SectionMotion(alpha=0.1)
    flow.start(motion)
    for k in range(60):
        flow.advance(motion, motion, 1e-8 if k % 2 else 0.05)
        assert abs(flow.loads(motion).force_x) < 1e-3
    with pytest.raises(FlowError, match="at least"):
        flow.advance(motion, motion, 1e-12)


def test_the_compiled_frame_force_is_that_of_the_section() -> None:
    """At both ends and inside a step, at a point off the axis."""
    start = SectionMotion(0.01, 0.3, 2.0, 0.1, 0.7, -5.0, 0.02, -0.1, 1.5)
    end = SectionMotion(0.04, 0.4, 3.0, 0.16, 0.5, -4.0, 0.01, 0.1, 0.5)
    table, frame = course(start, end, 0.1), np.zeros(5)
    for share in (0.0, 0.3, 1.0):
        step.frame_force(table, share, 9.81, frame)
        x, y = 0.4, -0.2
        along = frame[0] - frame[2] * y + frame[3] * x
        up = frame[1] + frame[2] * x + frame[3] * y
        np.testing.assert_allclose((along, up), body_force(at(table, share), x, y, 9.81), rtol=1e-12)
        assert frame[4] == pytest.approx(at(table, share).alpha_dot)
