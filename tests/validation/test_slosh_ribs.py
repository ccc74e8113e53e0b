"""Ribs in slosh_vof against theory: frequencies of compartments, the damping of slats, a violent run of compartments."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import least_squares

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.ribs import parse
from aeroslosh.fmus.slosh_vof.surface import from_heights
from aeroslosh.fmus.tank.liquid import Tank
from support.motions import REST, march, random

pytestmark = pytest.mark.validation

LENGTH, DEPTH, HEIGHT = 0.5, 0.075, 0.15
TANK = Tank(LENGTH, HEIGHT)


def first_mode(length: float, gas: float = 1.2) -> float:
    """Frequency [rad/s] of the first mode of two fluids in a tank of `length` [m]."""
    k = math.pi / length
    return math.sqrt(9.81 * k * (1000.0 - gas) / (1000.0 / math.tanh(k * DEPTH) + gas / math.tanh(k * (HEIGHT - DEPTH))))


def fitted(times: np.ndarray, values: np.ndarray, guess: float) -> tuple[float, float]:
    """Frequency and decay rate [rad/s, 1/s] of a damped cosine."""
    scale = np.abs(values).max()

    def misfit(p: np.ndarray) -> np.ndarray:
        wave = p[0] * np.cos(p[1] * times) + p[2] * np.sin(p[1] * times)
        return np.asarray(wave * np.exp(-p[3] * times) + p[4] - values / scale)

    fit = least_squares(misfit, [values[0] / scale, guess, 0.0, 0.1, 0.0], xtol=1e-12)
    return float(fit.x[1]), float(fit.x[3])


def test_a_closed_rib_in_the_middle_makes_two_half_tanks() -> None:
    """omega² = g k tanh(k h) with k = 2 pi / L (and the gas above); both halves in phase, as surge drives them."""
    flow = Flow(Grid(TANK, 100, 30, ribs=parse("x=0")), numerics=Numerics(wall_slip=True))
    flow.start_from(from_heights(flow.grid, lambda x: 2e-4 * np.cos(2.0 * np.pi * (x % 0.25) / 0.5)), REST)
    times, loads = march(flow, lambda t: REST, 6.0, 0.02)
    theory = first_mode(0.5 * LENGTH)
    seen, decay = fitted(times, loads[:, 2], theory)
    print(f"half tanks: {100 * (seen / theory - 1):+.4f} %, decay {decay / seen:.1e}")
    assert seen == pytest.approx(theory, rel=1e-3)
    assert 0.0 < decay < 1e-3 * seen


def test_slots_on_floor_and_roof_lower_and_damp_the_first_mode() -> None:
    """From 2 mm, floor slots of 15 to 60 mm of the 75 mm of liquid, 40 mm open on the roof."""
    undivided, seen = first_mode(LENGTH), []
    for slot in (0.06, 0.04, 0.02):
        flow = Flow(Grid(TANK, 100, 30, ribs=parse(f"x=0 open=0:{slot},0.11:0.15")), numerics=Numerics(wall_slip=True))
        flow.start(REST, 2e-3)
        times, loads = march(flow, lambda t: REST, 6.0, 0.02)
        frequency, decay = fitted(times, loads[:, 2], 0.8 * undivided)
        print(
            f"{1e3 * slot:.0f} mm: frequency {frequency / undivided:.3f} of the undivided, damping ratio {decay / frequency:.4f}"
        )
        seen.append((frequency / undivided, decay / frequency))
    frequencies, ratios = np.array(seen).T
    assert (np.diff([1.0, *frequencies]) < 0.0).all() and frequencies[-1] < 0.9
    assert (np.diff([1e-3, *ratios]) > 0.0).all() and ratios[-1] > 0.04


def loss(solidity: float) -> float:
    """Pressure loss coefficient of slats (Tait 2008, doi:10.1016/j.engstruct.2008.02.017, after Weisbach), for the speed far from
    them."""
    contraction = 0.405 * math.exp(-math.pi * solidity) + 0.595
    return (1.0 / (contraction * (1.0 - solidity)) - 1.0) ** 2


def slats(solidity: float, omega: float) -> float:
    """Damping ratio over amplitude [1/m] of the first mode by slats in the middle: work of the loss K ρ u |u| / 2 in a period
    over 4 π times the wave's energy ρ g a² L / 4, u of potential flow."""
    k = math.pi / LENGTH
    y = np.linspace(0.0, DEPTH, 2001)
    speed = omega * np.cosh(k * y) / math.sinh(k * DEPTH)
    lost = 0.5 * loss(solidity) * 8.0 / (3.0 * omega) * np.trapezoid(speed**3, y)
    return float(lost / (4.0 * math.pi * 9.81 * LENGTH / 4.0))


@pytest.mark.parametrize(
    ("cells", "solidity", "amplitude", "most"),
    [
        ((100, 30), 0.5, 0.004, 0.1), ((100, 30), 0.5, 0.008, 0.1), ((200, 60), 0.5, 0.004, 0.2), ((200, 60), 0.5, 0.008, 0.2),
        ((100, 60), 0.75, 0.002, 0.25), ((100, 60), 0.75, 0.004, 0.25), ((200, 120), 0.75, 0.004, 0.25),
    ],
)  # fmt: skip
def test_slats_damp_as_their_pressure_loss_says(cells: tuple[int, int], solidity: float, amplitude: float, most: float) -> None:
    """Slats every 10 mm: quadratic damping, 1/a grows linearly. The loss is that of steady flow."""
    slots = ",".join(f"{y:.4f}:{y + 0.01 * (1.0 - solidity):.4f}" for y in 0.01 * np.arange(15))
    flow = Flow(Grid(TANK, *cells, ribs=parse(f"x=0 open={slots}")), Fluids(gas_density=0.1), Numerics(wall_slip=True))
    flow.start(REST, amplitude)
    shape = np.cos(np.pi * (np.arange(cells[0]) + 0.5) / cells[0])

    def size() -> float:
        return float(2.0 * np.mean(flow.fractions.sum(axis=0) * flow.grid.dy * shape) / amplitude)

    times, sizes = 0.02 * np.arange(201), [size()]
    for _ in times[1:]:
        flow.advance(REST, REST, 0.02)
        sizes.append(size())
    omega = first_mode(LENGTH, 0.1)

    def misfit(p: np.ndarray) -> np.ndarray:
        return np.asarray(p[2] * np.cos(p[0] * times + p[1]) / (1.0 + abs(p[2]) * amplitude * p[3] * p[0] * times) - sizes)

    fit = least_squares(misfit, [omega, 0.0, 1.0, 10.0])
    theory = slats(solidity, omega)
    print(f"{cells}, solidity {solidity}, {1e3 * amplitude:g} mm: damping ratio {fit.x[3]:.2f} a, theory {theory:.2f} a, "
          f"frequency {fit.x[0] / omega:.4f}")  # fmt: skip
    assert fit.x[3] == pytest.approx(theory, rel=most)
    assert fit.x[0] == pytest.approx(omega, rel=0.03)


def test_three_compartments_in_random_motion() -> None:
    """Three seconds of breaking waves: each compartment keeps its liquid, volume fractions as good as the pressure."""
    grid = Grid(TANK, 90, 30, ribs=parse("x=-0.1; x=0.05"))
    flow = Flow(grid)
    motion = random(2, plunge=0.15, pitch=0.05, surge=0.05)
    flow.start(motion(0.0))
    before = [flow.fractions[:, first:last].sum() for first, last in grid.rooms]
    _, loads = march(flow, motion, 3.0, 0.01)
    assert np.isfinite(loads).all()
    for (first, last), volume in zip(grid.rooms, before, strict=True):
        assert flow.fractions[:, first:last].sum() == pytest.approx(volume, rel=1e-13)
    assert flow.fractions.min() > -1e-9 and flow.fractions.max() < 1.0 + 1e-4
