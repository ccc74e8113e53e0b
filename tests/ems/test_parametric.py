"""Slosh under changing gravity against Newton's law in inertial axes, energy balance and the Mathieu equation."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from aeroslosh.fmus.slosh_ems.linear import LinearSlosh
from aeroslosh.fmus.slosh_ems.parametric import ParametricSlosh, SurfaceLost
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.fmus.tank.motion import SectionMotion, at, course
from aeroslosh.fmus.tank.oscillators import Array, Complex

TANK = Tank(length=0.5, height=0.15, x=0.7, y=0.2, density=800.0)
G = TANK.gravity
WAY = np.array([  # quintics in time over a second: h, alpha, x
    [0.00, 0.10, -0.8, 1.2, 0.9, -1.3],
    [0.02, 0.30, 0.5, -1.9, 0.4, 0.6],
    [0.01, -0.2, 0.7, 0.3, -1.5, 0.8],
])  # fmt: skip


def slosh(kind: type[LinearSlosh], count: int, damping: float = 0.0, limit: str = "low") -> LinearSlosh:
    return kind(TANK, modes(TANK, count, limit), np.full(count, damping))


def motion(t: float, way: Array = WAY) -> SectionMotion:
    """Motion on the quintics."""
    values = []
    for row in way:
        curve = np.polynomial.Polynomial(row)
        values += [curve(t), curve.deriv(1)(t), curve.deriv(2)(t)]
    return SectionMotion(*map(float, values))


def piece(start: float, duration: float, way: Array = WAY) -> Array:
    """Course of a part of the quintics, without error however long. Shape: (9, 6)."""
    rows = []
    for row in way:
        curve = np.polynomial.Polynomial(row)(np.polynomial.Polynomial([start, duration]))
        for order in range(3):
            rows.append(np.pad(curve.deriv(order).coef / duration**order, (0, order)))
    return np.array(rows)


def march(model: LinearSlosh, way: Array, w: Complex, times: Array) -> Complex:
    for start, end in itertools.pairwise(times):
        w = model.advance(w, piece(start, end - start, way), end - start)
    return w


def turn(a: float) -> tuple[Array, Array]:
    """Rotation from wing to inertial axes at pitch a, and its derivative by a."""
    s, c = math.sin(a), math.cos(a)
    return np.array([[c, s], [-s, c]]), np.array([[-s, c], [-c, -s]])


def newton(model: ParametricSlosh, t: float, y: Array, damping: float) -> tuple[Array, Array, Array]:
    """Accelerations s'' of the masses from R_s·(R'' + g) = 0, their inertial positions less the axis, their accelerations.

    R(t, s) = axis + Q(alpha) r(s) with the parabola r(s); nothing here is shared with the model but its parameters.
    Shapes: y (2 n,), results (n,), (2, n), (2, n).
    """
    n, m = len(y) // 2, motion(t)
    s, v = y[:n], y[n:]
    k = model.modes.omega**2 / G
    r = np.stack([TANK.x + s, TANK.centre_y + model.modes.height + 0.5 * k * s**2])
    r_s, r_ss = np.stack([np.ones(n), k * s]), np.stack([np.zeros(n), k])
    Q, Q_a = turn(m.alpha)
    axis = np.array([[m.x_ddot], [-m.h_ddot]])
    without = axis + Q_a @ r * m.alpha_ddot - Q @ r * m.alpha_dot**2 + 2.0 * m.alpha_dot * (Q_a @ r_s) * v + Q @ r_ss * v**2
    R_s = Q @ r_s
    a = -np.sum(R_s * (without + np.array([[0.0], [G]])), axis=0) / np.sum(R_s**2, axis=0)
    a = a - 2.0 * damping * model.modes.omega * v
    return a, Q @ r, without + R_s * a


def reference(model: ParametricSlosh, s: Array, v: Array, end: float, damping: float) -> tuple[Array, Array]:
    """Displacements and velocities at `end` by a Runge-Kutta method of order 8."""
    n = len(s)

    def rate(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], newton(model, t, y, damping)[0]])

    y = solve_ivp(rate, (0.0, end), np.concatenate([s, v]), method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]
    return y[:n], y[n:]


@pytest.mark.parametrize("damping", [0.0, 0.05])
@pytest.mark.parametrize("steps", [3, 40])
def test_motion_of_the_masses_agrees_with_newton_in_inertial_axes(steps: int, damping: float) -> None:
    model = slosh(ParametricSlosh, 5, damping)
    s, v = np.array([0.03, -0.01, 4e-3, 2e-3, -1e-3]), np.array([0.1, 0.05, -0.04, 0.02, 0.01])
    w = march(model, WAY, model.oscillators.amplitude(s, v), np.linspace(0.0, 1.0, steps + 1))
    s_end, v_end = reference(model, s, v, 1.0, damping)
    np.testing.assert_allclose(model.oscillators.displacement(w), s_end, rtol=0.0, atol=1e-9 * np.abs(s_end).max())
    np.testing.assert_allclose(model.oscillators.velocity(w), v_end, rtol=0.0, atol=1e-9 * np.abs(v_end).max())


@pytest.mark.parametrize("limit", ["low", "high"])
def test_load_is_that_of_the_accelerated_masses(limit: str) -> None:
    """Modes on their tracks, the fixed mass; what is left out in the limit "high" hangs in the tank by vertical forces alone."""
    model = slosh(ParametricSlosh, 5, 0.05, limit)
    s, v = np.array([0.03, -0.01, 4e-3, 2e-3, -1e-3]), np.array([0.1, 0.05, -0.04, 0.02, 0.01])
    t = 0.6
    m, p = motion(t), model.modes
    _, place, acceleration = newton(model, t, np.concatenate([s, v]), 0.05)
    # the fixed mass, at rest on the wing
    Q, Q_a = turn(m.alpha)
    r = np.array([[TANK.x, TANK.x], [TANK.centre_y + p.fixed_height, TANK.centre_y + p.rest_height]])
    fixed = np.array([[m.x_ddot], [-m.h_ddot]]) + Q_a @ r * m.alpha_ddot - Q @ r * m.alpha_dot**2
    place, acceleration = np.hstack([Q @ r, place]), np.hstack([fixed, acceleration])
    mass = np.concatenate([[p.fixed_mass, p.rest_mass], p.mass])
    force = -mass * (acceleration + np.array([[0.0], [G]]))
    force[0, 1] = 0.0
    assert (p.rest_mass > 0.0) == (limit == "high")
    moment = float(np.sum(place[1] * force[0] - place[0] * force[1])) - p.fixed_inertia * m.alpha_ddot
    moment += p.rest_tilt * G * math.sin(m.alpha)
    load = model.load(model.oscillators.amplitude(s, v), m)
    np.testing.assert_allclose(load, [force[0].sum(), force[1].sum(), moment], rtol=1e-12)


def test_work_of_the_loads_is_the_change_of_energy() -> None:
    """Nothing but the load's work on the moving tank changes the energy of the masses: no energy is invented."""
    model = slosh(ParametricSlosh, 5)
    p = model.modes
    w = model.oscillators.amplitude(np.array([0.03, -0.01, 4e-3, 2e-3, -1e-3]), np.zeros(5))

    def energy(w: Complex, m: SectionMotion) -> float:
        s, v = model.oscillators.displacement(w), model.oscillators.velocity(w)
        k = p.omega**2 / G
        x, y = TANK.x + np.append(0.0, s), TANK.centre_y + np.append(p.fixed_height, p.height + 0.5 * k * s**2)
        u, mass = np.stack([np.append(0.0, v), np.append(0.0, k * s * v)]), np.append(p.fixed_mass, p.mass)
        Q, Q_a = turn(m.alpha)
        speed = np.array([[m.x_dot], [-m.h_dot]]) + m.alpha_dot * Q_a @ np.stack([x, y]) + Q @ u
        height = -m.h + (Q @ np.stack([x, y]))[1]
        kinetic = 0.5 * float(mass @ np.sum(speed**2, axis=0)) + 0.5 * p.fixed_inertia * m.alpha_dot**2
        return kinetic + G * float(mass @ height) + p.rest_tilt * G * math.cos(m.alpha)

    nodes, weights = np.polynomial.legendre.leggauss(5)
    before, work, step = energy(w, motion(0.0)), 0.0, 0.02
    for i in range(50):
        path = piece(i * step, step)
        for node, weight in zip(0.5 * (nodes + 1.0), 0.5 * weights, strict=True):
            # the way to the node is the same polynomials over a shorter step
            m = at(path, node)
            part = model.advance(w, path * node ** np.arange(6.0), node * step)
            load = model.load(part, m)
            work -= step * weight * (load.force_x * m.x_dot - load.force_y * m.h_dot + load.moment * m.alpha_dot)
        w = model.advance(w, path, step)
    change = energy(w, motion(1.0)) - before
    assert abs(change) > 1.0
    assert work == pytest.approx(change, rel=1e-9)


@pytest.mark.parametrize("limit", ["low", "high"])
def test_small_motions_are_those_of_the_linear_model(limit: str) -> None:
    """The difference falls with the square of the motion."""
    gaps = []
    for size in (1e-3, 1e-4):
        way = size * WAY
        loads = []
        for kind in (LinearSlosh, ParametricSlosh):
            model = slosh(kind, 4, limit=limit)
            w = march(model, way, model.start(motion(0.0, way)), np.linspace(0.0, 1.0, 11))
            loads.append(np.array(model.load(w, motion(1.0, way))))
        gaps.append(np.abs(loads[1] - loads[0]))
        assert np.all(np.abs(loads[0] - [0.0, -TANK.mass * G, TANK.static_moment * G]) > 5.0 * gaps[-1])
    np.testing.assert_array_less(gaps[1], 0.012 * gaps[0])


def test_steps_of_any_length_give_the_same() -> None:
    model = slosh(ParametricSlosh, 60)
    loads = []
    for steps in (1, 7, 160):
        w = march(model, WAY, model.start(motion(0.0)), np.linspace(0.0, 0.8, steps + 1))
        loads.append(model.load(w, motion(0.8)))
    np.testing.assert_allclose(loads[0], loads[2], rtol=3e-9)
    np.testing.assert_allclose(loads[1], loads[2], rtol=3e-9)


def vertical(t: float, size: float, omega: float) -> SectionMotion:
    """Plunge whose acceleration is −size g cos(omega t)."""
    a = size * G / omega**2
    return SectionMotion(h=a * math.cos(omega * t), h_dot=-a * omega * math.sin(omega * t),
                         h_ddot=-a * omega**2 * math.cos(omega * t))  # fmt: skip


def floquet(omega: float, size: float, drive: float, damping: float) -> float:
    """Growth rate [1/s] of s'' + 2 zeta omega s' + omega² (1 + size cos(drive t)) s = 0 from its multipliers."""
    period = 2.0 * math.pi / drive

    def rate(t: float, y: Array) -> list[float]:
        return [y[1], -2.0 * damping * omega * y[1] - omega**2 * (1.0 + size * math.cos(drive * t)) * y[0]]

    columns = [solve_ivp(rate, (0.0, period), start, method="DOP853", rtol=1e-12, atol=1e-14).y[:, -1]
               for start in ([1.0, 0.0], [0.0, 1.0])]  # fmt: skip
    return math.log(np.abs(np.linalg.eigvals(np.array(columns).T)).max()) / period


@pytest.mark.parametrize(("detuning", "grows"), [(0.96, False), (0.98, True), (1.0, True), (1.02, True), (1.04, False)])
def test_waves_grow_where_the_mathieu_equation_says(detuning: float, grows: bool) -> None:
    """Growth a period, of the mode's own multipliers and of the equation's. Tongue: |detuning − 1| < 0.023."""
    damping, size = 0.01, 0.1
    model = slosh(ParametricSlosh, 1, damping)
    omega = float(model.modes.omega[0])
    drive = 2.0 * omega * detuning
    step, small, columns = 2.0 * math.pi / drive / 40, 1e-6, []
    for start in ((small, 0.0), (0.0, small)):
        w = model.oscillators.amplitude(*(np.array([value]) for value in start))
        for i in range(40):
            w = model.advance(w, course(vertical(i * step, size, drive), vertical((i + 1) * step, size, drive), step), step)
        columns.append([float(model.oscillators.displacement(w)[0]), float(model.oscillators.velocity(w)[0])])
    rate = math.log(np.abs(np.linalg.eigvals(np.array(columns).T / small)).max()) / (40 * step)
    assert (rate > 0.0) == grows
    assert rate == pytest.approx(floquet(omega, size, drive, damping), abs=1e-7 * omega)


@pytest.mark.parametrize(
    ("omega", "plunge", "pitch_deg", "share"),
    [(100.0, 3e-4, 0.2, 0.006), (100.0, 1e-3, 0.2, 0.025), (100.0, 2e-3, 0.5, 0.072), (6.28, 0.0746, 0.5, 0.244)],
)
def test_changing_gravity_matters_near_the_slosh_frequencies(omega: float, plunge: float, pitch_deg: float, share: float) -> None:
    """Share of force_x, rms, that changes with gravity; centred tank, smooth start of two cycles, eight modes."""
    tank, step = Tank(length=0.5, height=0.15), 2.0 * math.pi / omega / 72
    # growth s³ (10 − 15 s + 6 s²) with its derivatives, over two cycles, by polynomial arithmetic
    grow = np.polynomial.Polynomial([0.0, 0.0, 0.0, 10.0, -15.0, 6.0])(np.polynomial.Polynomial([0.0, omega / (4.0 * math.pi)]))

    def way(t: float) -> SectionMotion:
        f = [float(grow.deriv(k)(t)) for k in range(3)] if t * omega < 4.0 * math.pi else [1.0, 0.0, 0.0]
        s, c = math.sin(omega * t), omega * math.cos(omega * t)
        wave = (f[0] * s, f[1] * s + f[0] * c, f[2] * s + 2.0 * f[1] * c - f[0] * omega**2 * s)
        return SectionMotion(*(size * value for size in (plunge, math.radians(pitch_deg)) for value in wave))

    forces = []
    for kind in (LinearSlosh, ParametricSlosh):
        model = kind(tank, modes(tank, 8), np.full(8, 0.005))
        w, rows = model.start(way(0.0)), []
        for i in range(72 * (30 if omega > 50.0 else 4)):
            w = model.advance(w, course(way(i * step), way((i + 1) * step), step), step)
            rows.append(model.load(w, way((i + 1) * step)).force_x)
        forces.append(np.array(rows))
    assert float(np.std(forces[1] - forces[0]) / np.std(forces[1])) == pytest.approx(share, rel=0.1)


def test_lost_surfaces_are_clear_errors() -> None:
    model = slosh(ParametricSlosh, 3)
    falling = SectionMotion(h_ddot=3.0 * G)
    w = model.oscillators.amplitude(np.full(3, 1e-3), np.zeros(3))
    with pytest.raises(SurfaceLost, match=r"effective gravity was negative[\s\S]*Remedy"):
        for _ in range(300):
            w = model.advance(w, course(falling, falling, 0.01), 0.01)
