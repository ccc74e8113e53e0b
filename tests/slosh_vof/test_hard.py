"""Motions, fills, shapes and density ratios that break weaker solvers: no crash, volume kept, loads of the right size."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof import step
from aeroslosh.fmus.slosh_vof.flow import Flow, FlowError, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from support.motions import REST, harmonic, march, random

VIOLENT = harmonic(25.0, 0.05, pitch=math.radians(4.0), plunge=0.0075)
SHORT = 1.0


def survives(flow: Flow, motion=VIOLENT, duration: float = SHORT) -> np.ndarray:  # type: ignore[no-untyped-def]
    flow.start(motion(0.0))
    volume = flow.volume
    _, loads = march(flow, motion, duration, 0.01)
    assert np.isfinite(loads).all()
    assert abs(flow.volume / volume - 1.0) < 1e-13
    assert flow.fractions.min() > -1e-9
    assert flow.fractions.max() < 1.0 + 1e-4
    # weight and inertia of the whole, whatever the surface does
    fluid = flow.grid.tank.mass * (1 + flow.fluids.gas_density / flow.grid.tank.density * (1 / flow.grid.tank.fill_level - 1))
    h_ddot = np.array([motion(0.01 * (k + 1)).h_ddot for k in range(len(loads))])
    rigid = -fluid * (9.81 - h_ddot)
    assert np.corrcoef(loads[:, 1], rigid)[0, 1] > 0.9 or np.ptp(h_ddot) == 0.0
    return loads


@pytest.mark.parametrize("fill", [0.05, 0.1, 0.3, 0.5, 0.7, 0.9, 0.95])
def test_fills(fill: float) -> None:
    survives(Flow(Grid(Tank(0.5, 0.15, fill_level=fill), 60, 20)))


@pytest.mark.parametrize("ratio", [1.0, 10.0, 1e3, 1e4])
def test_density_ratios(ratio: float) -> None:
    survives(Flow(Grid(Tank(0.5, 0.15), 60, 20), Fluids(gas_density=1000.0 / ratio)))


@pytest.mark.parametrize(
    ("length", "height", "nx", "ny"), [(0.6, 0.15, 64, 16), (0.1, 0.4, 16, 64), (0.1, 0.4, 64, 16), (0.5, 0.15, 16, 16)]
)
def test_shapes(length: float, height: float, nx: int, ny: int) -> None:
    survives(Flow(Grid(Tank(length, height), nx, ny)))


def test_fast_pitch() -> None:
    """One degree at 100 rad/s: 4.4 g at the ends of the tank."""
    survives(Flow(Grid(Tank(0.5, 0.15), 60, 20)), harmonic(100.0, 0.05, pitch=math.radians(1.0)), 0.5)


def test_random_motion() -> None:
    survives(Flow(Grid(Tank(0.5, 0.15), 60, 20)), random(1, plunge=0.15, pitch=0.05, surge=0.05), 3.0)


def test_acceleration_upside_down_ejects_the_liquid() -> None:
    """Three g downwards with a ripple: the liquid goes to the roof and its weight hangs there."""
    flow = Flow(Grid(Tank(0.5, 0.15), 60, 20))
    flow.start(REST, 0.004)
    volume = flow.volume
    thrown = SectionMotion(h_ddot=4 * 9.81)
    flow.advance(thrown, thrown, 2.0)
    shares = flow.fractions.sum(axis=1) / flow.fractions.sum()
    assert (shares * (np.arange(20) + 0.5)).sum() > 13.0  # 15 where all lies against the roof
    mean = np.mean([(flow.advance(thrown, thrown, 0.01), flow.loads(thrown).force_y)[1] for _ in range(100)])
    assert mean == pytest.approx(3 * 9.81 * (37.5 + 0.045), rel=0.02)
    assert abs(flow.volume / volume - 1.0) < 1e-13


def test_thin_and_thick_fluids_without_a_step_limit_problem() -> None:
    survives(Flow(Grid(Tank(0.5, 0.15), 40, 16), Fluids(liquid_viscosity=1e-3, surface_tension=0.0728)))
    survives(Flow(Grid(Tank(0.5, 0.15), 40, 16), Fluids(liquid_viscosity=0.0, gas_viscosity=0.0), Numerics(wall_slip=True)))


def test_a_lost_flow_says_so() -> None:
    """Velocities that no step can follow: an error with a remedy, not a hang."""
    flow = Flow(Grid(Tank(0.5, 0.15), 32, 16))
    flow.start(REST)
    flow.state[step.U] = 1e9 * flow.grid.open_x
    with pytest.raises(FlowError, match="Remedy"):
        flow.advance(REST, REST, 0.01)
