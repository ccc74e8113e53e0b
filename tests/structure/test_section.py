"""The section against independent solutions: frequencies, free and loaded motion, energy, frozen liquid."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eig

from aeroslosh.fmus.structure.protocol import ForcedPitch, Run
from aeroslosh.fmus.structure.section import Array, Section, SectionData, SectionError

DAMPED = SectionData(
    damping_ratio_h=0.02,
    damping_ratio_alpha=0.05,
    liquid_mass=7.0,
    liquid_static_moment=5.0,
    liquid_inertia=6.0,
    liquid_stiffness=-2.0e4,
)
START = np.array([0.01, -0.02, 0.6, 1.5])


def reference(section: Section, y: Array, load_start: Array, load_end: Array, duration: float) -> Array:
    """Integrate the equations of motion with a Runge-Kutta method of order 8. Shapes: (4,), (2,), (2,)."""

    def rate(t: float, y: Array) -> Array:
        load = load_start + (load_end - load_start) * t / duration
        return np.concatenate([y[2:], np.linalg.solve(section.M, load - section.C @ y[2:] - section.K @ y[:2])])

    return solve_ivp(rate, (0.0, duration), y, method="DOP853", rtol=1e-13, atol=1e-15).y[:, -1]


def test_wind_off_frequencies_of_isogai_a() -> None:
    # x_alpha = 1.8, r_alpha^2 = 3.48, omega_h = omega_alpha = 100 rad/s: 71.34 and 533.77 rad/s
    m, b = 57.73, 0.5
    section = Section(SectionData(mass=m, static_imbalance=m * 1.8 * b, inertia=m * 3.48 * b * b))
    np.testing.assert_allclose(section.natural_frequencies(), [71.34, 533.77], atol=0.01)


def test_default_section_is_isogai_a() -> None:
    np.testing.assert_allclose(Section(SectionData()).natural_frequencies(), [71.34, 533.77], atol=0.01)


def test_uncoupled_frequencies_are_the_parameters() -> None:
    section = Section(SectionData(static_imbalance=0.0, omega_h=30.0, omega_alpha=70.0))
    np.testing.assert_allclose(section.natural_frequencies(), [30.0, 70.0], rtol=1e-13)


@pytest.mark.parametrize("duration", [1e-5, 8.7e-4, 0.02, 0.3])
def test_motion_under_a_linear_load_agrees_with_runge_kutta(duration: float) -> None:
    section = Section(DAMPED)
    load_start, load_end = np.array([3.0e3, -1.0e3]), np.array([-5.0e3, 4.0e3])
    got = section.propagate(START, load_start, load_end, duration)
    np.testing.assert_allclose(
        got / [1, 1, 100, 100],
        reference(section, START, load_start, load_end, duration) / [1, 1, 100, 100],
        rtol=0.0,
        atol=1e-10 * np.abs(START).max(),
    )


def test_free_motion_agrees_with_the_complex_modes() -> None:
    section = Section(DAMPED)
    A = np.block(
        [
            [np.zeros((2, 2)), np.eye(2)],
            [-np.linalg.solve(section.M, section.K), -np.linalg.solve(section.M, section.C)],
        ]
    )
    values, vectors = eig(A)
    t = 0.25
    exact = (vectors @ (np.exp(values * t) * np.linalg.solve(vectors, START))).real
    np.testing.assert_allclose(section.propagate(START, np.zeros(2), np.zeros(2), t), exact, rtol=1e-10, atol=1e-12)


def test_static_load_gives_static_deflection() -> None:
    section = Section(SectionData(damping_ratio_h=0.5, damping_ratio_alpha=0.5))
    load = np.array([1000.0, -200.0])
    y = section.propagate(START, load, load, 100.0)
    np.testing.assert_allclose(y[:2], load / [57.73e4, 50.2251e4], rtol=1e-9)


def test_one_step_is_as_good_as_many_under_a_linear_load() -> None:
    section = Section(DAMPED)
    total, load_start, load_end = 0.05, np.array([2.0e3, 500.0]), np.array([-1.0e3, 900.0])
    once = section.propagate(START, load_start, load_end, total)
    run = Run(section, ForcedPitch(), START, load_start)
    cuts = np.array([0.0, 0.011, 0.013, 0.02, 0.041, 0.0499, 1.0 * total])
    for start, end in itertools.pairwise(cuts):
        run.advance(end - start, load_start + (load_end - load_start) * end / total)
    np.testing.assert_allclose(run.y, once, rtol=1e-12, atol=1e-13)


def test_interpolated_load_converges_with_second_order() -> None:
    section = Section(DAMPED)

    def load(t: float) -> Array:
        return np.array([2.0e3 * np.sin(90.0 * t), 1.0e3 * np.cos(150.0 * t)])

    def end(steps: int) -> Array:
        run = Run(section, ForcedPitch(), START, load(0.0))
        for i in range(steps):
            run.advance(0.1 / steps, load(0.1 * (i + 1) / steps))
        return run.y[:2]

    exact = end(12800)
    counts = np.array([50, 100, 200, 400])
    errors = [np.abs(end(int(n)) - exact).max() for n in counts]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(2.0, abs=0.05)


def test_energy_is_conserved_without_damping() -> None:
    section = Section(SectionData(liquid_mass=7.0, liquid_static_moment=5.0, liquid_inertia=6.0))
    run = Run(section, ForcedPitch(), START, np.zeros(2))
    start = section.energy(run.y)
    for _ in range(5000):
        run.advance(8.7e-4, np.zeros(2))
    assert section.energy(run.y) == pytest.approx(start, rel=1e-9)


def test_energy_changes_by_the_work_of_the_load() -> None:
    section = Section(SectionData())
    run, work = Run(section, ForcedPitch(), START, np.zeros(2)), 0.0
    start = section.energy(run.y)
    for i in range(4000):
        before = run.y
        load = np.array([900.0 * np.sin(0.02 * i), 500.0 * np.cos(0.03 * i) - 500.0])
        mean = 0.5 * (run.load + load)
        run.advance(2e-5, load)
        work += float(mean @ (run.y - before)[:2])
    assert section.energy(run.y) - start == pytest.approx(work, rel=1e-4)


def test_damping_takes_energy_away_at_the_known_rate() -> None:
    zeta, omega = 0.01, 100.0
    section = Section(SectionData(static_imbalance=0.0, damping_ratio_h=zeta))
    y = section.propagate(np.array([0.01, 0.0, 0.0, 0.0]), np.zeros(2), np.zeros(2), 1.0)
    damped = omega * np.sqrt(1.0 - zeta**2)
    exact = 0.01 * np.exp(-zeta * omega) * (np.cos(damped) + zeta * omega / damped * np.sin(damped))
    assert y[0] == pytest.approx(exact, rel=1e-10)


def test_frozen_liquid_is_mass_of_the_section() -> None:
    """A liquid carried frozen moves like the same mass built in, its weight like a pitch spring."""
    wet = Section(SectionData(liquid_mass=30.0, liquid_static_moment=27.0, liquid_inertia=25.0, liquid_stiffness=300.0))
    dry = Section(
        SectionData(
            mass=87.73,
            static_imbalance=78.957,
            inertia=75.2251,
            omega_h=100.0 * np.sqrt(57.73 / 87.73),
            omega_alpha=np.sqrt((50.2251e4 + 300.0) / 75.2251),
        )
    )
    for section in (wet, dry):
        section.C[:] = 0.0
    np.testing.assert_allclose(
        wet.propagate(START, np.ones(2), np.ones(2), 0.2),
        dry.propagate(START, np.ones(2), np.ones(2), 0.2),
        rtol=1e-10,
    )
    assert wet.natural_frequencies()[0] < Section(SectionData()).natural_frequencies()[0]


def test_acceleration_is_consistent_with_the_load_and_the_motion() -> None:
    section = Section(DAMPED)
    load, d = np.array([1.0e3, 2.0e3]), 1e-6
    ahead = section.propagate(START, load, load, d)[2:]
    behind = section.propagate(START, load, load, 2 * d)[2:]
    numerical = (4.0 * ahead - behind - 3.0 * START[2:]) / (2.0 * d)
    np.testing.assert_allclose(section.acceleration(START, load), numerical, rtol=1e-5)


@pytest.mark.parametrize(
    ("data", "words"),
    [
        (SectionData(static_imbalance=54.0), "mass matrix is not positive definite"),
        (SectionData(liquid_static_moment=40.0), "mass matrix is not positive definite"),
        (SectionData(mass=-1.0), "mass matrix is not positive definite"),
        (SectionData(liquid_stiffness=-5.1e5), "pitch stiffness is negative"),
    ],
)
def test_impossible_sections_are_refused(data: SectionData, words: str) -> None:
    with pytest.raises(SectionError, match=words) as caught:
        Section(data)
    assert "Remedy" in str(caught.value)
