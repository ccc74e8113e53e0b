"""Linear slosh against the closed forms of potential flow, its symmetry, its energy and its steps."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_ems.linear import LinearSlosh
from aeroslosh.fmus.tank.frozen import residual_load, static_load
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes, stokes_damping
from aeroslosh.fmus.tank.motion import SectionMotion, course
from aeroslosh.fmus.tank.oscillators import Array
from aeroslosh.fmus.tank.potential import harmonic_load

TANKS = {
    "centred": Tank(length=0.5, height=0.15),
    "off the axis": Tank(length=0.5, height=0.15, x=1.8, y=0.2, density=800.0, width=0.7),
    "deep": Tank(length=0.3, height=0.8, fill_level=0.45, x=-0.4, y=-0.5),
}
MOTIONS = {"surge": {"x": 2e-3}, "pitch": {"alpha": 3e-3}, "plunge": {"h": 1e-3}, "all": {"h": 1e-3, "alpha": -2e-3, "x": 1e-3}}


def slosh(tank: Tank, count: int = 100, limit: str = "low", damping: float = 0.0) -> LinearSlosh:
    return LinearSlosh(tank, modes(tank, count, limit), np.full(count, damping))


def harmonic(t: float, omega: float, h: float = 0.0, alpha: float = 0.0, x: float = 0.0) -> SectionMotion:
    s, c = math.sin(omega * t), math.cos(omega * t)
    return SectionMotion(*(value for size in (h, alpha, x) for value in (size * c, -size * omega * s, -size * omega**2 * c)))


def steady(model: LinearSlosh, omega: float, motion: SectionMotion) -> Array:
    """Displacements in the undamped steady state, in phase with the motion."""
    force = model.tank.gravity * motion.alpha - motion.x_ddot - model.lever * motion.alpha_ddot
    return force / (model.modes.omega**2 - omega**2)


@pytest.mark.parametrize("sizes", MOTIONS.values(), ids=MOTIONS)
@pytest.mark.parametrize("omega", [0.5, 4.0, 6.0])
@pytest.mark.parametrize("tank", TANKS.values(), ids=TANKS)
def test_forced_motion_is_that_of_the_closed_forms(tank: Tank, omega: float, sizes: dict[str, float]) -> None:
    """From the exact steady state, fifty steps a period, over three periods."""
    model, step = slosh(tank), 2.0 * math.pi / omega / 50
    motion = harmonic(0.0, omega, **sizes)
    w = model.oscillators.amplitude(steady(model, omega, motion), np.zeros(100))
    exact = np.array(harmonic_load(tank, omega, **sizes))
    scale = np.where(exact == 0.0, 1.0, np.abs(exact))
    for i in range(151):
        less_static = np.subtract(model.load(w, motion), static_load(tank))
        np.testing.assert_allclose(less_static / scale, exact / scale * math.cos(omega * i * step), rtol=0.0, atol=1e-6)
        following = harmonic((i + 1) * step, omega, **sizes)
        w, motion = model.advance(w, course(motion, following, step), step), following


@pytest.mark.parametrize(("limit", "gap"), [("low", 0.0128), ("high", 0.0023)])
def test_limits_of_few_modes_at_flutter_frequency(limit: str, gap: float) -> None:
    """Eight modes at 100 rad/s: apparent mass 0.15846 m_T but for this much; a hundred modes: 1.1e-4."""
    tank, motion = TANKS["centred"], harmonic(0.0, 100.0, x=1e-4)

    def mass(count: int, limit: str) -> float:
        model = slosh(tank, count, limit)
        w = model.oscillators.amplitude(steady(model, 100.0, motion), np.zeros(count))
        return -model.load(w, motion).force_x / motion.x_ddot / tank.mass

    assert mass(8, limit) / 0.15846 - 1.0 == pytest.approx(gap, abs=1e-4)
    assert abs(mass(100, limit) / 0.15846 - 1.0) < 2.2e-4


def test_surge_and_pitch_answer_each_other_alike() -> None:
    """Reciprocity: the moment of surge equals the force of pitch, for any excitation frequency."""
    tank = TANKS["off the axis"]
    model = slosh(tank, 30)
    for omega in (3.0, 9.0, 60.0):
        loads = []
        for sizes in ({"x": 1.0}, {"alpha": 1.0}):
            motion = harmonic(0.0, omega, **sizes)
            w = model.oscillators.amplitude(steady(model, omega, motion), np.zeros(30))
            loads.append(np.subtract(model.load(w, motion), static_load(tank)))
        assert loads[0][2] == pytest.approx(loads[1][0], rel=1e-9)


def test_a_held_tilt_moves_weight_but_makes_no_force() -> None:
    """Static tilt: no lateral force, the surface level, the moment of the liquid's moved centre; for few modes as for many."""
    tank = TANKS["off the axis"]
    for count, limit in ((1, "low"), (3, "high"), (50, "low")):
        model, tilted = slosh(tank, count, limit), SectionMotion(alpha=0.01)
        w = model.start(tilted)
        load = model.load(w, tilted)
        assert load.force_x == pytest.approx(0.0, abs=1e-12)
        assert load.force_y == pytest.approx(-tank.mass * 9.81)
        moved = tank.x + 0.01 * (tank.centre_y + tank.length**2 / (12 * tank.depth))
        assert load.moment == pytest.approx(tank.mass * 9.81 * moved)
        # nose up: the aft end is low, so the liquid stands higher there
        assert model.wave_height(w, tilted) == pytest.approx(0.01 * tank.length / 2)
        assert model.energy(w, tilted) == pytest.approx(0.0, abs=1e-15)


def test_vertical_residual_is_nothing_and_frozen_modes_leave_only_the_lid() -> None:
    tank = TANKS["off the axis"]
    model, motion = slosh(tank, 40), SectionMotion(0.01, 0.2, 3.0, 0.02, -0.4, 5.0)
    residual = residual_load(model.load(model.start(motion), motion), tank, motion)
    assert residual.force_y == 0.0
    assert abs(residual.moment) > 1.0


def test_free_waves_keep_their_energy() -> None:
    """A push, then rest: ten thousand uneven steps without damping."""
    tank = TANKS["off the axis"]
    model, rest = slosh(tank, 30), SectionMotion()
    w = model.advance(model.start(rest), course(rest, rest._replace(x_ddot=2.0), 0.3), 0.3)
    still, first = course(rest, rest, 1.0), model.energy(w, rest)
    assert first > 0.1
    for i in range(10_000):
        w = model.advance(w, still, 1e-3 * (1 + i % 7))
    assert model.energy(w, rest) == pytest.approx(first, rel=1e-10)


def test_work_of_the_loads_is_the_change_of_energy_and_of_heat() -> None:
    """Over a whole period of a damped steady state the work of the loads on the tank equals what the dampers take."""
    tank, count, omega = TANKS["off the axis"], 12, 5.0
    damping = stokes_damping(tank, modes(tank, count).omega, 1e-4)
    model = LinearSlosh(tank, modes(tank, count), damping)
    sizes = {"h": 1e-3, "alpha": 2e-3, "x": -1e-3}
    wn, motion = model.modes.omega, harmonic(0.0, omega, **sizes)
    force = tank.gravity * motion.alpha - motion.x_ddot - model.lever * motion.alpha_ddot
    response = force / (wn**2 - omega**2 + 2j * damping * wn * omega)
    heat = math.pi * omega * float(np.sum(2.0 * model.modes.mass * damping * wn * np.abs(response) ** 2))
    work, points = 0.0, 64
    for i in range(points):
        t = 2.0 * math.pi / omega * i / points
        m = harmonic(t, omega, **sizes)
        turned = response * np.exp(1j * omega * t)
        load = model.load(model.oscillators.amplitude(turned.real, (1j * omega * turned).real), m)
        power = load.force_x * m.x_dot - load.force_y * m.h_dot + load.moment * m.alpha_dot
        work -= power * 2.0 * math.pi / omega / points
    assert heat > 1e-6
    assert work == pytest.approx(heat, rel=1e-9)


def test_steps_of_any_length_give_the_same() -> None:
    """On a quintic motion, cut at different points."""
    tank = TANKS["off the axis"]
    model = slosh(tank, 60, damping=0.003)
    curves = [np.polynomial.Polynomial(c) for c in ([0, 0.01, -0.1, 0.3], [0.01, 0.0, 0.2, -0.3, 0.2, -0.05], [0, 0, 0.1, 0.2])]

    def motion(t: float) -> SectionMotion:
        return SectionMotion(*(float(curve.deriv(order)(t)) for curve in curves for order in range(3)))

    loads = []
    for times in (np.linspace(0.0, 1.0, 9), np.linspace(0.0, 1.0, 400), np.sort(np.append(np.linspace(0.0, 1.0, 12), 0.123456))):
        w = model.start(motion(0.0))
        for start, end in itertools.pairwise(times):
            w = model.advance(w, course(motion(start), motion(end), end - start), end - start)
        loads.append(model.load(w, motion(1.0)))
    np.testing.assert_allclose(loads[1], loads[0], rtol=1e-10)
    np.testing.assert_allclose(loads[2], loads[0], rtol=1e-10)


def test_free_decay_is_that_of_the_laminar_layers() -> None:
    tank = TANKS["centred"]
    damping = stokes_damping(tank, modes(tank, 1).omega, 2e-6)
    model, rest = LinearSlosh(tank, modes(tank, 1), damping), SectionMotion()
    w = model.oscillators.amplitude(np.array([0.01]), np.array([0.0]))
    first = model.energy(w, rest)
    for _ in range(100):
        w = model.advance(w, course(rest, rest, 0.1), 0.1)
    assert damping[0] == pytest.approx(0.0027, abs=5e-5)
    assert math.log(first / model.energy(w, rest)) == pytest.approx(2 * damping[0] * 5.20302 * 10.0, rel=0.02)


def test_a_full_tank_moves_as_a_closed_box() -> None:
    """No waves; frozen in surge and plunge, less inertia than frozen in pitch."""
    tank = Tank(length=0.5, height=0.15, fill_level=1.0)
    model = slosh(tank, 5)
    motion = SectionMotion(x_ddot=1.0, h_ddot=2.0, alpha_ddot=3.0)
    w = model.advance(model.start(SectionMotion()), course(SectionMotion(), motion, 0.1), 0.1)
    load = model.load(w, motion)
    assert load.force_x == pytest.approx(-tank.mass)
    assert load.force_y == pytest.approx(-tank.mass * (9.81 - 2.0))
    assert load.moment == pytest.approx(-3.0 * model.modes.lid_inertia)
    assert model.wave_height(w, motion) == 0.0
    assert model.energy(w, motion) == 0.0
