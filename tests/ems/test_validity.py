"""The outputs that say where linear slosh ends: gravity, wave height, parametric resonance."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_ems.validity import WAVES, Gate
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import wave_frequencies
from aeroslosh.fmus.tank.motion import SectionMotion, course

TANK = Tank(length=0.5, height=0.15, x=0.7, y=0.2)
G, OMEGA = 9.81, wave_frequencies(TANK, np.arange(1.0, WAVES + 1.0))


def gate(tank: Tank = TANK, parametric: bool = False, damping: float = 0.01) -> Gate:
    return Gate(tank, parametric, OMEGA, np.full(WAVES, damping))


def test_frequencies_of_both_symmetries() -> None:
    np.testing.assert_allclose(OMEGA[[0, 2, 4]], [5.20302, 12.81623, 17.39835], rtol=1e-6)
    np.testing.assert_allclose(OMEGA[[1, 3, 5, 7]], [9.5276, 15.3441, 19.1637, 22.1942], rtol=5e-6)


def test_effective_gravity_signs() -> None:
    """Falling makes it less, a nose-up acceleration lets the aft tank fall, the tilted tank feels the cosine."""
    assert gate().effective_gravity(SectionMotion()) == G
    assert gate().effective_gravity(SectionMotion(h_ddot=2.0)) == pytest.approx(G - 2.0)
    assert gate().effective_gravity(SectionMotion(alpha_ddot=2.0)) == pytest.approx(G - 0.7 * 2.0)
    assert gate().effective_gravity(SectionMotion(alpha=0.5)) == pytest.approx(G * math.cos(0.5))
    assert gate().effective_gravity(SectionMotion(alpha_dot=2.0)) == pytest.approx(G - 4.0 * TANK.centre_y)


@pytest.mark.parametrize(("parametric", "edge"), [(False, 0.3), (True, 1.0)])
def test_uneven_gravity(parametric: bool, edge: float) -> None:
    one = gate(parametric=parametric)
    assert one.measure(SectionMotion(), 0.0) == 0.0
    assert one.measure(SectionMotion(h_ddot=-0.3 * G), 0.0) == pytest.approx(0.3 / edge)
    # about the tank's own centre gravity changes along the surface only: half a length away
    centred = gate(Tank(length=0.5, height=0.15, y=0.0375), parametric)
    assert centred.measure(SectionMotion(alpha_ddot=0.3 * G / 0.25), 0.0) == pytest.approx(0.3 / edge)


def test_wave_height_over_depth_and_roof() -> None:
    assert gate().measure(SectionMotion(), -0.2 * 0.075) == pytest.approx(1.0)
    nearly_full = gate(Tank(length=0.5, height=0.15, fill_level=0.96))
    assert nearly_full.measure(SectionMotion(), 0.006) == pytest.approx(1.0)
    assert gate(Tank(length=0.5, height=0.15, fill_level=1.0)).measure(SectionMotion(), 0.0) == 0.0


def watched(one: Gate, size: float, drive: float, cycles: int) -> np.ndarray:
    """|Y| of each wave after cycles of plunge acceleration of `size` g, twelve steps a cycle."""

    def motion(t: float) -> SectionMotion:
        a = size * G / drive**2
        return SectionMotion(
            h=-a * math.sin(drive * t), h_dot=-a * drive * math.cos(drive * t), h_ddot=size * G * math.sin(drive * t)
        )

    Y, step = one.start(), 2.0 * math.pi / drive / 12
    for i in range(12 * cycles):
        Y = one.advance(Y, course(motion(i * step), motion((i + 1) * step), step), step)
    return np.abs(Y)


@pytest.mark.parametrize("wave", [1, 2])
@pytest.mark.parametrize("detuning", [0.98, 1.0, 1.01, 1.03])
def test_resonance_output_is_the_tongue_of_the_damped_mathieu_equation(wave: int, detuning: float) -> None:
    size, damping, omega = 0.06, 0.01, float(OMEGA[wave - 1])
    seen = watched(gate(damping=damping), size, 2.0 * omega * detuning, 150)
    expected = size / (4.0 * damping) / math.sqrt(1.0 + ((detuning - 1.0) / damping) ** 2)
    assert seen[wave - 1] == pytest.approx(expected, rel=0.03, abs=0.02)
    assert (expected > 1.0) == (detuning in (1.0, 1.01))
    assert np.argmax(seen) == wave - 1


def test_pitch_of_a_tank_off_the_axis_counts_as_its_plunge() -> None:
    """Nose-up about an axis ahead of the tank lets it fall."""
    one, step, omega = gate(), 0.05, 2.0 * float(OMEGA[0])
    Y = [one.start(), one.start(), one.start()]
    for i in range(100):
        for k, (plunge, pitch) in enumerate(((1.0, 0.0), (0.0, 1.0 / 0.7), (1.0, -1.0 / 0.7))):
            ends = [SectionMotion(h_ddot=plunge * math.sin(omega * t), alpha_ddot=pitch * math.sin(omega * t))
                    for t in (i * step, (i + 1) * step)]  # fmt: skip
            Y[k] = one.advance(Y[k], course(*ends, step), step)
    np.testing.assert_allclose(Y[1], Y[0], rtol=1e-12)
    np.testing.assert_allclose(Y[2], 0.0, atol=1e-12)


def test_resonance_output_stays_low_elsewhere_and_where_gravity_is_steady() -> None:
    assert watched(gate(), 0.06, 1.3 * float(OMEGA[-1]) * 2.0, 150).max() < 0.3
    steady = SectionMotion(h_ddot=-0.5 * G)
    one, Y, path = gate(), gate().start(), course(steady, steady, 0.05)
    for _ in range(2000):
        Y = one.advance(Y, path, 0.05)
    assert np.abs(Y).max() == pytest.approx(0.25, rel=1e-3)


def test_undamped_waves_are_caught_within_their_first_growth() -> None:
    """Without damping every sustained drive at twice the frequency is unstable; |Y| passes 1 after 2/(size omega)."""
    size, omega = 0.1, float(OMEGA[0])
    cycles = math.ceil(2.0 / (size * omega) / (math.pi / omega))
    assert watched(gate(damping=0.0), size, 2.0 * omega, cycles - 2)[0] < 1.0
    assert watched(gate(damping=0.0), size, 2.0 * omega, cycles + 2)[0] > 1.0


def test_a_full_tank_is_valid_at_any_acceleration() -> None:
    """It has no surface that could break."""
    full = Tank(0.5, 0.15, fill_level=1.0)
    gate = Gate(full, False, np.ones(12), np.full(12, 0.01))
    assert gate.measure(SectionMotion(h_ddot=50.0), 0.0) == 0.0
