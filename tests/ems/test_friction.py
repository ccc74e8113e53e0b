"""What friction makes of linear slosh: the number that tells its error, against two-phase flow over viscosities and fills."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_ems.fmu import SloshEms
from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.friction import MODES, THICK, Friction
from aeroslosh.fmus.tank.frozen import Load, residual_load
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import layer_damping, modes, stokes_damping, wave_frequencies
from aeroslosh.fmus.tank.motion import SectionMotion, course

GAS = 0.1  # kg/m3: linear slosh has none
STEPS, CYCLES, RISE = 40, 6, 1.5


def motion(t: float, omega: float, kind: str, size: float) -> SectionMotion:
    """Harmonic from rest: a quintic rise over RISE periods."""
    rise = RISE * 2.0 * math.pi / omega
    s = min(t / rise, 1.0)
    r, r1, r2 = 10 * s**3 - 15 * s**4 + 6 * s**5, 30 * s**2 * (1 - s) ** 2 / rise, 60 * s * (1 - s) * (1 - 2 * s) / rise**2
    sin, cos = math.sin(omega * t), math.cos(omega * t)
    values = (r * sin, r1 * sin + r * omega * cos, r2 * sin + 2 * r1 * omega * cos - r * omega**2 * sin)
    names = {"surge": ("x", "x_dot", "x_ddot"), "pitch": ("alpha", "alpha_dot", "alpha_ddot")}[kind]
    return SectionMotion(**dict(zip(names, (size * v for v in values), strict=True)))


def marched(tank: Tank, viscosity: float, ratio: float, kind: str, cells: tuple[int, int]) -> tuple[float, float]:
    """Validity of the face of slosh_ems after six periods at `ratio` of the first wave's frequency, and by how much its residual
    loads (force along, moment over half a length) differ from those of slosh_vof, rms over rms."""
    omega = ratio * float(wave_frequencies(tank, np.array([1.0]))[0])
    step = 2.0 * math.pi / omega / STEPS
    size = 1e-3 * tank.depth / max(1.0, ratio**2) / (1.0 if kind == "surge" else tank.length)
    ems = SloshEms(instance_name="test", resources="")
    ems.tank_length, ems.tank_height, ems.fill_level = tank.length, tank.height, tank.fill_level
    ems.tank_x, ems.tank_y, ems.liquid_viscosity = tank.x, tank.y, viscosity
    ems.prepare()
    ems.initialize()
    numerics = Numerics(wall_layer=True)
    flow = Flow(Grid(tank, *cells), Fluids(gas_density=GAS, liquid_viscosity=viscosity), numerics)
    flow.start(SectionMotion())
    weight = GAS * (tank.height - tank.depth) * tank.length * tank.gravity
    rows = []
    for i in range(1, STEPS * CYCLES + 1):
        before, now = motion((i - 1) * step, omega, kind, size), motion(i * step, omega, kind, size)
        ems.__dict__.update(now._asdict())
        ems.step((i - 1) * step, step)
        flow.advance(before, now, step)
        seen = flow.loads(now)
        liquid = Load(seen.force_x, seen.force_y + weight, seen.moment - weight * tank.x)
        theirs = residual_load(liquid, tank, now)
        rows.append((ems.force_x_residual, ems.moment_residual, theirs.force_x, theirs.moment))
    loads = np.array(rows) - np.mean(rows, axis=0)
    arm = np.array([1.0, 2.0 / tank.length])
    error = np.sqrt(np.sum(np.mean(((loads[:, :2] - loads[:, 2:]) * arm) ** 2, axis=0)))
    return ems.validity, float(error / np.sqrt(np.sum(np.mean((loads[:, 2:] * arm) ** 2, axis=0))))


def tank(shape: float, length: float = 0.5) -> Tank:
    """Half full, depth over length `shape`, off the axis."""
    return Tank(length, 2.0 * shape * length, x=0.3 * length, y=0.1 * length)


CASES = [
    (shape, viscosity, ratio, kind)
    for shape, kind in ((0.15, "surge"), (0.15, "pitch"), (0.5, "surge"), (0.5, "pitch"), (0.06, "surge"))
    for viscosity in (1e-6, 1e-4, 1e-3, 1e-2)
    for ratio in ((0.77, 1.5) if kind == "pitch" else (0.77, 1.5, 5.0))
    # left out: where the flow takes its time (1e-3 shows the same), and where the number is cautious: 1.04 in surge of a deep
    # tank at 1e-2 m2/s, right within 0.12 to 0.18, but in pitch wrong by 0.5 (docs/ems.md)
    if (shape, viscosity, kind) not in ((0.06, 1e-2, "surge"), (0.5, 1e-2, "surge"))
]


@pytest.mark.parametrize(("shape", "viscosity", "ratio", "kind"), CASES)
def test_validity_tells_the_error_against_two_phase_flow(shape: float, viscosity: float, ratio: float, kind: str) -> None:
    """More than 0.35 wrong: it says so; less than 0.15: it does not. In between is its edge, meant for 0.25."""
    validity, error = marched(tank(shape), viscosity, ratio, kind, (64, 32) if viscosity < 2e-4 else (32, 16))
    print(f"depth {shape} l, {viscosity:g} m2/s, {ratio} omega_1, {kind}: validity {validity:.2f}, error {error:.3f}")
    assert not (error > 0.35 and validity < 1.0)
    assert not (error < 0.15 and validity > 1.0)


def test_the_cases_lie_on_both_sides() -> None:
    """Otherwise the test above would show nothing."""
    told = [marched(tank(0.15), viscosity, 0.77, "surge", (32, 16))[0] > 1.0 for viscosity in (1e-6, 1e-5, 1e-4, 1e-3, 1e-2)]
    assert told == [False, False, False, True, True]


def watched(of: Friction, of_tank: Tank, ratio: float, cycles: int = CYCLES) -> float:
    omega = ratio * float(wave_frequencies(of_tank, np.array([1.0]))[0])
    step = 2.0 * math.pi / omega / STEPS
    seen = of.start(SectionMotion())
    for i in range(STEPS * cycles):
        ends = [motion((i + k) * step, omega, "surge", 1e-4) for k in (0, 1)]
        seen = of.advance(seen, course(*ends, step), ends[1], step)
    return of.number(seen)


def test_a_tank_four_times_as_long_bears_eight_times_the_viscosity() -> None:
    """A scale model: viscosity goes with length times speed, l^1.5 sqrt(g)."""
    for viscosity in (1e-6, 1e-4, 1e-3):
        small, large = tank(0.15), tank(0.15, 2.0)
        numbers = [watched(Friction(small, viscosity), small, 0.77), watched(Friction(large, 8.0 * viscosity), large, 0.77)]
        assert numbers[0] == pytest.approx(numbers[1], rel=1e-9)


def test_without_viscosity_friction_does_nothing() -> None:
    one = tank(0.15)
    assert watched(Friction(one, 0.0), one, 0.77) == pytest.approx(0.0, abs=1e-12)  # rounding, of any linear algebra
    # nor at rest, where only the first wave's damping ratio tells
    still = Friction(one, 1e-4)
    assert (
        still.number(still.start(SectionMotion()))
        == still.thick
        == pytest.approx(float(stokes_damping(one, modes(one, 1).omega, 1e-4)[0]) / THICK)
    )


def test_far_above_the_first_wave_the_inertia_of_the_layers_is_all() -> None:
    """What slosh_rbf, which follows nothing, takes: an upper bound of what is seen there."""
    one = tank(0.15)
    for viscosity in (1e-5, 1e-4, 1e-3):
        friction = Friction(one, viscosity)
        assert 0.6 * friction.far_above < watched(friction, one, 20.0) <= 1.02 * friction.far_above


def test_layers_and_bulk_make_up_the_damping() -> None:
    one = tank(0.3)
    omega = modes(one, MODES).omega
    wave = (2.0 * np.arange(1, MODES + 1) - 1.0) * np.pi / one.length
    bulk = 2.0 * 1e-4 * wave**2 / omega
    np.testing.assert_allclose(layer_damping(one, omega, 1e-4) + bulk, stokes_damping(one, omega, 1e-4), rtol=1e-14)
