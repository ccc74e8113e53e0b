"""Linear slosh of a rectangular tank against tabulated values, identities and an independent finite-element solution.

Tank: 0.5 m long, liquid 0.075 m deep, g = 9.81 m/s². The apparent masses marked FEM agree with a quadratic finite-element solve
of the potential problem to all digits given.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.tank.liquid import Tank, TankError
from aeroslosh.fmus.tank.modes import lid_inertia, modes, stokes_damping
from aeroslosh.fmus.tank.motion import SectionMotion, body_force
from aeroslosh.fmus.tank.potential import pitch_force, pitch_inertia, surge_mass

TANK = Tank(length=0.5, height=0.15, density=1.0 / 0.0375)  # one kilogram of liquid


def test_modal_table() -> None:
    m = modes(TANK, 8)
    np.testing.assert_allclose(m.omega[:4], [5.20302, 12.81623, 17.39835, 20.74345], rtol=1e-6)
    np.testing.assert_allclose(m.mass[:4], [0.755460, 0.056589, 0.013516, 0.005001], atol=5e-7)
    np.testing.assert_allclose(m.height[:5], [-0.036142, -0.027085, -0.015139, -0.004734, 0.003136], atol=5e-7)
    np.testing.assert_allclose(m.stiffness[:3], [20.45136, 9.29514, 4.09121], rtol=1e-6)


@pytest.mark.parametrize(
    ("count", "limit", "mass", "height", "inertia"),
    [
        (1, "low", 0.244540, 0.111654, 1.556891e-2),
        (3, "low", 0.174435, 0.166488, 1.373787e-2),
        (8, "low", 0.164491, 0.176469, 1.344992e-2),
        (3, "high", 0.162818, 0.178033, 1.341074e-2),
    ],
)
def test_fixed_part(count: int, limit: str, mass: float, height: float, inertia: float) -> None:
    m = modes(TANK, count, limit)
    assert m.fixed_mass == pytest.approx(mass, abs=1e-6)
    assert m.fixed_height == pytest.approx(height, abs=2e-6)
    assert m.fixed_inertia == pytest.approx(inertia, rel=3e-6)


@pytest.mark.parametrize(("length", "depth"), [(0.5, 0.075), (1.0, 0.5), (0.57, 0.15), (0.3, 0.36)])
def test_identities(length: float, depth: float) -> None:
    tank = Tank(length=length, height=2 * depth)
    m = modes(tank, 4000)
    # the static tilt of the surface moves the liquid's centre of mass as the springs do
    assert float(np.sum(m.mass / m.omega**2)) * tank.gravity == pytest.approx(tank.mass * length**2 / (12 * depth), rel=1e-6)
    assert m.fixed_mass * m.fixed_height + float(np.sum(m.mass * m.height)) == pytest.approx(0.0, abs=1e-9 * tank.mass)
    total = m.fixed_inertia + m.fixed_mass * m.fixed_height**2 + float(np.sum(m.mass * m.height**2))
    assert total == pytest.approx(m.lid_inertia, rel=1e-12)


def test_lid_inertia_is_less_than_frozen_and_tends_to_it_for_thin_layers() -> None:
    assert lid_inertia(TANK) == pytest.approx(1.960434e-2, rel=1e-6)
    assert lid_inertia(TANK) / (TANK.mass * (0.5**2 + 0.075**2) / 12) == pytest.approx(0.920302, rel=1e-6)
    thin = Tank(length=1.0, height=0.002)
    assert lid_inertia(thin) / (thin.mass * (1.0 + 0.001**2) / 12) == pytest.approx(1.0, abs=1e-5)


@pytest.mark.parametrize(("omega", "fem"), [(4.0, 0.0787110), (6.0, -0.0760316), (0.5, 0.0377679)])
def test_surge_against_fem(omega: float, fem: float) -> None:
    tank = Tank(length=0.5, height=0.15)
    assert surge_mass(tank, omega) / 1000.0 == pytest.approx(fem, rel=1e-4)


@pytest.mark.parametrize(("omega", "force", "inertia"), [(4.0, 0.0237812, 0.0144584), (6.0, -0.0268261, -5.60341e-3)])
def test_pitch_against_fem(omega: float, force: float, inertia: float) -> None:
    tank = Tank(length=0.5, height=0.15)
    assert pitch_force(tank, omega) / 1000.0 == pytest.approx(force, rel=1e-4)
    assert pitch_inertia(tank, omega) / 1000.0 == pytest.approx(inertia, rel=1e-4)


def test_stokes_damping_of_water() -> None:
    m = modes(Tank(length=0.5, height=0.15), 3)
    np.testing.assert_allclose(stokes_damping(TANK, m.omega, 1e-6), [0.0019, 0.0008, 0.0005], atol=6e-5)


def test_frozen_liquid() -> None:
    tank = Tank(length=0.5, height=0.15, x=1.8, y=0.02, density=800.0)
    assert tank.mass == pytest.approx(30.0)
    assert tank.static_moment == pytest.approx(54.0)
    assert tank.centre_y == pytest.approx(-0.0175)
    assert tank.inertia == pytest.approx(30.0 * ((0.25 + 0.075**2) / 12 + 1.8**2 + 0.0175**2))
    assert tank.stiffness == pytest.approx(30.0 * 9.81 * 0.0175)


def test_body_force_is_gravity_less_the_acceleration_of_the_point() -> None:
    """Against second differences of the point's position."""
    point, g, dt = (0.7, -0.2), 9.81, 1e-4

    def motion(t: float) -> SectionMotion:
        h, a, x = (amplitude * math.sin(w * t) for amplitude, w in ((0.1, 3.0), (0.4, 5.0), (0.05, 7.0)))
        rates = [amplitude * w * math.cos(w * t) for amplitude, w in ((0.1, 3.0), (0.4, 5.0), (0.05, 7.0))]
        return SectionMotion(h, rates[0], -9.0 * h, a, rates[1], -25.0 * a, x, rates[2], -49.0 * x)

    def position(t: float) -> np.ndarray:
        m = motion(t)
        s, c = math.sin(m.alpha), math.cos(m.alpha)
        return np.array([m.x + point[0] * c + point[1] * s, -m.h - point[0] * s + point[1] * c])

    t = 0.37
    acceleration = (position(t + dt) - 2 * position(t) + position(t - dt)) / dt**2
    felt = np.array([0.0, -g]) - acceleration
    s, c = math.sin(motion(t).alpha), math.cos(motion(t).alpha)
    expected = felt @ np.array([c, -s]), felt @ np.array([s, c])
    np.testing.assert_allclose(body_force(motion(t), *point, g), expected, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("values", [{"length": 0.0}, {"fill_level": 0.0}, {"fill_level": 1.2}, {"density": -1.0}])
def test_impossible_tanks_are_refused(values: dict[str, float]) -> None:
    with pytest.raises(TankError, match="Remedy"):
        Tank(**{"length": 0.5, "height": 0.15, **values})
