"""Pressure probes and wave gauges: hydrostatics at any tilt, means over face and time, phases kept apart, exact states."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Baffles, Grid
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from support.motions import REST, harmonic, march

TANK = Tank(0.5, 0.15)
PLACES = [(0.0, 0.01), (0.5, 0.06), (0.123, 0.0), (0.3, 0.0412), (0.25, 0.07), (0.49, 0.14), (0.2, 0.15)]
DEGREE = math.pi / 180


@pytest.mark.parametrize("degrees", [0.0, 4.0, -10.0])
def test_at_rest_probes_read_hydrostatic_pressure_at_any_tilt(degrees: float) -> None:
    """Walls, floor, roof and inside, in liquid and in gas; above the mean of the gas."""
    sensors = tuple(Probe(x, y) for x, y in PLACES)
    flow = Flow(Grid(TANK, 50, 20), numerics=Numerics(tolerance=1e-12), sensors=sensors)
    motion = SectionMotion(alpha=degrees * DEGREE)
    flow.start(motion)
    sin, cos, g = math.sin(motion.alpha), math.cos(motion.alpha), 9.81
    shares = flow.fractions
    x, y = (np.arange(50) + 0.5) * 0.01, (np.arange(20) + 0.5) * 0.0075
    up = y[:, None] * cos - (x - 0.25) * sin  # height of the cells' middles in inertial axes
    slope = math.tan(motion.alpha)
    level = 0.075 * cos  # a trapezium has the volume of the rectangle of its mean height
    assert shares.mean() == pytest.approx(0.5, rel=1e-12)
    gas_mean = float(((1.0 - shares) * 1.2 * g * (level - up)).sum() / (1.0 - shares).sum())
    for (px, py), (point, area, mean) in zip(PLACES, flow.pressures(), strict=True):
        depth = level - (py * cos - (px - 0.25) * sin)
        density = 1000.0 if py < 0.075 + (px - 0.25) * slope else 1.2
        assert point == pytest.approx(density * g * depth - gas_mean, abs=0.02), (px, py)
        assert area == mean == point


def test_the_mean_over_a_face_and_the_mean_over_time() -> None:
    """A face across the surface at rest; in motion the trailing mean against the sum over every internal step."""
    face = Probe(0.0, 0.07, 0.03)
    flow = Flow(Grid(TANK, 50, 20), Fluids(gas_density=0.1), sensors=(face,), window=0.05)
    flow.start(REST)
    point, area, _ = flow.pressures()[0]
    assert point == pytest.approx(9810.0 * 0.005, rel=2e-3)
    assert area == pytest.approx(9810.0 * 0.02**2 / 2 / 0.03, rel=0.01)
    motion = harmonic(5.0, 0.2, pitch=3 * DEGREE)
    h = 1e-3
    flow = Flow(Grid(TANK, 50, 20), numerics=Numerics(max_step=h), sensors=(face, Probe(0.25, 0.02)), window=0.05)
    flow.start(motion(0.0))
    rows = [flow.pressures()]
    for k in range(1500):
        report = flow.advance(motion(k * h), motion((k + 1) * h), h)
        assert report.steps == 1
        rows.append(flow.pressures())
    seen = np.array(rows)  # time, probe, (point, area, mean)
    assert np.ptp(seen[:, 0, 1]) > 300.0
    total = np.concatenate([np.zeros((1, 2)), np.cumsum(0.5 * h * (seen[1:, :, 1] + seen[:-1, :, 1]), axis=0)])
    window = round(0.05 / h)
    np.testing.assert_allclose(seen[window:, :, 2], (total[window:] - total[:-window]) / 0.05, rtol=0.0, atol=2.0)
    k = np.arange(1, window)
    np.testing.assert_allclose(seen[k, :, 2], total[k] / (k * h)[:, None], rtol=1e-10, atol=1e-8)
    np.testing.assert_allclose(seen[:, 1, 0], seen[:, 1, 1])  # a point is its own face


def test_a_window_shorter_than_a_step_and_one_of_nothing() -> None:
    motion = harmonic(9.0, 0.3, pitch=4 * DEGREE)
    flows = [Flow(Grid(TANK, 32, 16), sensors=(Probe(0.0, 0.02),), window=w) for w in (0.0, 1e-7, 1e-3)]
    for flow in flows:
        flow.start(motion(0.0))
        march(flow, motion, 0.4, 0.02)
    values = [flow.pressures()[0] for flow in flows]
    assert values[0][2] == values[0][1]
    assert values[1][2] == pytest.approx(values[1][1], rel=1e-3)
    assert values[2][2] == pytest.approx(values[2][1], rel=0.05)


def test_probes_do_not_change_the_flow_beyond_round_off() -> None:
    motion = harmonic(9.0, 0.3, pitch=2 * DEGREE)
    flows = [Flow(Grid(TANK, 32, 16), sensors=sensors) for sensors in ((), (Probe(0.0, 0.02, 0.01), Probe(0.2, 0.1)))]
    for flow in flows:
        flow.start(motion(0.0))
    without, with_probes = (march(flow, motion, 0.5, 0.01)[1] for flow in flows)
    np.testing.assert_allclose(with_probes, without, rtol=1e-7, atol=1e-7)


def test_wall_probes_add_up_to_the_walls_force() -> None:
    """Faces that cover a wall: their mean times its length is the force of its pressure, but for the datum."""
    motion = harmonic(9.0, 0.3, pitch=3 * DEGREE)
    flow = Flow(Grid(TANK, 50, 20), numerics=Numerics(wall_slip=True), sensors=(Probe(0.0, 0.075, 0.15), Probe(0.5, 0.075, 0.15)))
    flow.start(motion(0.0))
    forces, means = [], []
    for k in range(80):
        flow.advance(motion(0.01 * k), motion(0.01 * (k + 1)), 0.01)
        west, east = flow.pressures()
        means.append(0.15 * (east[1] - west[1]))
        forces.append(flow.loads(motion(0.01 * (k + 1))).force_x_tank)
    assert np.ptp(forces) > 20.0
    assert np.std(np.array(forces) - means) < 0.01 * np.std(forces)


def test_a_baffle_parts_what_its_sides_tell() -> None:
    """Surge: pressure jumps across the plate; a probe a tenth of a cell before it reads its own side."""
    tank = Tank(0.5, 0.15, fill_level=0.8)
    grid = Grid(tank, 50, 20, Baffles(1, 0.0, 0.6))
    sensors = (Probe(0.249, 0.01), Probe(0.251, 0.01), Probe(0.245, 0.01), Probe(0.255, 0.01))
    flow = Flow(grid, sensors=sensors)
    flow.start(SectionMotion(x_ddot=2.0))
    west, east, west_cell, east_cell = (row[0] for row in flow.pressures())
    assert abs(west - east) > 100.0
    assert abs(west - west_cell) < 0.2 * abs(west - east)
    assert abs(east - east_cell) < 0.2 * abs(west - east)


def test_gauges_read_the_column_between_the_middles_of_cells() -> None:
    flow = Flow(Grid(TANK, 50, 20))
    flow.start(REST, 0.01)
    x = np.array([0.005, 0.1, 0.2513, 0.495])
    np.testing.assert_allclose(flow.heights(x), 0.01 * np.cos(np.pi * x / 0.5), atol=2e-5)
    np.testing.assert_allclose(flow.heights(np.array([0.0, 0.5])), flow.wave_heights, rtol=1e-12)


def test_states_hold_the_rings() -> None:
    motion = harmonic(9.0, 0.3, pitch=3 * DEGREE)
    flow = Flow(Grid(TANK, 32, 16), sensors=(Probe(0.0, 0.05, 0.02),), window=0.03)
    flow.start(motion(0.0))
    march(flow, motion, 0.2, 0.01)
    kept = flow.save()
    runs = []
    for _ in range(2):
        rows = []
        for k in range(20, 30):
            flow.advance(motion(0.01 * k), motion(0.01 * (k + 1)), 0.01)
            rows.append(flow.pressures())
        runs.append(rows)
        flow.restore(kept)
    assert runs[0] == runs[1]
    assert runs[0][0] != runs[0][-1]


@pytest.mark.parametrize("sensor", [Probe(0.6, 0.1), Probe(0.1, -0.01), Probe(0.1, 0.1, -1.0), Probe(math.nan, 0.1)])
def test_probes_outside_are_refused(sensor: Probe) -> None:
    with pytest.raises(ValueError, match="Remedy"):
        Flow(Grid(TANK, 32, 16), sensors=(sensor,))


def test_a_negative_window_is_refused() -> None:
    with pytest.raises(ValueError, match="window"):
        Flow(Grid(TANK, 32, 16), sensors=(Probe(0.0, 0.0),), window=-1.0)
