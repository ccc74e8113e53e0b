"""The frozen liquid: exact rigid motion, what a section carries, and that the split changes no equation of motion."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from aeroslosh.fmus.structure.section import Section, SectionData
from aeroslosh.fmus.tank.frozen import Load, carried_load, constants, frozen_load, residual_load, static_load, to_inertial
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion

TANK = Tank(length=0.5, height=0.15, x=0.7, y=0.2, density=800.0)
MOVING = SectionMotion(0.03, -0.2, 4.0, 0.4, 1.5, -20.0, 0.1, 0.3, -2.0)


def position(t: float, point: np.ndarray) -> np.ndarray:
    """Inertial position of wing points, shape (2, n), in a smooth motion."""
    h, a, x = 0.1 * math.sin(3 * t), 0.4 * math.sin(5 * t), 0.05 * math.sin(7 * t)
    s, c = math.sin(a), math.cos(a)
    return np.array([[x], [-h]]) + np.array([[c, s], [-s, c]]) @ point


def test_frozen_load_is_that_of_a_rigid_body_of_many_points() -> None:
    """Against second differences of the positions of a grid of mass points with the liquid's own moments."""
    t, dt = 0.37, 1e-4
    # two Gauss points a direction have the area, centre and inertia of the rectangle
    gx, gy = np.meshgrid([-1.0, 1.0], [-1.0, 1.0])
    points = np.stack(
        [TANK.x + gx.ravel() * TANK.length / math.sqrt(12), TANK.centre_y + gy.ravel() * TANK.depth / math.sqrt(12)]
    )
    acceleration = (position(t + dt, points) - 2 * position(t, points) + position(t - dt, points)) / dt**2
    force = -0.25 * TANK.mass * (acceleration + np.array([[0.0], [TANK.gravity]]))
    arm = position(t, points) - position(t, np.zeros((2, 1)))
    moment = float(np.sum(arm[1] * force[0] - arm[0] * force[1]))
    h, a, x = (size * math.sin(w * t) for size, w in ((0.1, 3), (0.4, 5), (0.05, 7)))
    rates = [size * w * math.cos(w * t) for size, w in ((0.1, 3), (0.4, 5), (0.05, 7))]
    motion = SectionMotion(h, rates[0], -9 * h, a, rates[1], -25 * a, x, rates[2], -49 * x)
    np.testing.assert_allclose(frozen_load(TANK, motion), [force[0].sum(), force[1].sum(), moment], rtol=1e-5)


def test_at_rest_all_is_the_static_load() -> None:
    rest = SectionMotion()
    assert frozen_load(TANK, rest) == pytest.approx(Load(0.0, -30.0 * 9.81, 30.0 * 9.81 * 0.7))
    assert carried_load(TANK, rest) == pytest.approx(static_load(TANK))
    assert residual_load(static_load(TANK), TANK, rest) == pytest.approx((0.0, 0.0, 0.0))
    assert constants(TANK)["static_moment"] == static_load(TANK).moment


def test_carried_load_is_the_frozen_load_to_first_order() -> None:
    """The gap falls with the square of the motion, once the moment of surge, which no section carries, is put aside."""

    def gap(size: float) -> np.ndarray:
        motion = SectionMotion(*(size * np.array(MOVING)))
        surge = Load(0.0, 0.0, TANK.mass * TANK.centre_y * motion.x_ddot)
        return np.abs(np.subtract(np.subtract(frozen_load(TANK, motion), carried_load(TANK, motion)), np.negative(surge)))

    assert np.all(gap(1e-2) > 1e-6)
    np.testing.assert_array_less(gap(1e-3), 0.0101 * gap(1e-2))


def test_split_changes_no_equation_of_motion() -> None:
    """Section with frozen liquid and residual = dry section and whole load less static load, at any amplitude, for any load."""
    rng = np.random.default_rng(1)
    dry = SectionData(mass=230.9, static_imbalance=415.6, inertia=803.5, omega_h=50.0, omega_alpha=60.0)
    given = {name: value for name, value in constants(TANK).items() if name.startswith("liquid_")}
    carrying = replace(dry, **given)
    for _ in range(5):
        motion, whole = SectionMotion(*rng.normal(size=9)), Load(*rng.normal(scale=100.0, size=3))
        q, acceleration = np.array([motion.h, motion.alpha]), np.array([motion.h_ddot, motion.alpha_ddot])

        def left(data: SectionData, q: np.ndarray = q, acceleration: np.ndarray = acceleration) -> np.ndarray:
            section = Section(data)
            return section.M @ acceleration + section.K @ q

        def right(load: Load) -> np.ndarray:
            return np.array([-load.force_y, load.moment])  # plunge is positive down

        less_static = Load(*np.subtract(whole, static_load(TANK)))
        residual = residual_load(whole, TANK, motion)
        gap = (left(carrying) - right(residual)) - (left(dry) - right(less_static))
        np.testing.assert_allclose(gap, 0.0, atol=1e-9)


def test_residual_of_an_exactly_frozen_liquid_is_what_the_linear_section_leaves_out() -> None:
    whole = frozen_load(TANK, MOVING)
    residual = residual_load(whole, TANK, MOVING)
    assert residual == pytest.approx(tuple(np.subtract(whole, carried_load(TANK, MOVING))))
    small = SectionMotion(h_ddot=1e-6, alpha=1e-6, alpha_ddot=1e-6)
    np.testing.assert_allclose(residual_load(frozen_load(TANK, small), TANK, small), 0.0, atol=1e-9)


def test_turning_to_inertial_axes() -> None:
    """Nose-up by a right angle: what pushed aft along the chord pushes down."""
    assert to_inertial(2.0, 0.0, 5.0, math.pi / 2) == pytest.approx((0.0, -2.0, 5.0))
    assert to_inertial(0.0, 3.0, 5.0, math.pi / 2) == pytest.approx((3.0, 0.0, 5.0))
