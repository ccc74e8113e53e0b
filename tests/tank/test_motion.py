"""The course of a motion inside a communication step: exact for quintics, sixth order for the rest, robust to tables that lie."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.tank.motion import AGREEMENT, SectionMotion, at, course

STEP = 0.02
COORDINATES = {"h": 0, "alpha": 3, "x": 6}


def on(curves: list[np.polynomial.Polynomial], t: float) -> SectionMotion:
    """Section motion on polynomials of time for h, alpha, x."""
    return SectionMotion(*(float(curve.deriv(order)(t)) for curve in curves for order in range(3)))


def harmonic(t: float, omega: float) -> SectionMotion:
    values = []
    for size, phase in ((0.01, 0.3), (0.02, 1.1), (0.005, -0.7)):
        s, c = math.sin(omega * t + phase), math.cos(omega * t + phase)
        values += [size * s, size * omega * c, -size * omega**2 * s]
    return SectionMotion(*values)


def test_quintics_are_kept() -> None:
    rows = ([1.0, -2.0, 3.0, 40.0, -50.0, 600.0], [0.1, 0.2, -5.0, 6.0, 70.0, -80.0], [0.0, 3.0, 1.0, -9.0, 8.0, 7.0])
    curves = [np.polynomial.Polynomial(row) for row in rows]
    table = course(on(curves, 0.0), on(curves, STEP), STEP)
    for share in (0.0, 0.13, 0.5, 0.9, 1.0):
        np.testing.assert_allclose(at(table, share), on(curves, share * STEP), rtol=1e-11)


def test_rates_and_accelerations_are_derivatives_of_the_positions() -> None:
    table = course(harmonic(0.0, 40.0), harmonic(STEP, 40.0), STEP)
    for row in COORDINATES.values():
        position = np.polynomial.Polynomial(table[row])
        np.testing.assert_allclose(table[row + 1, :5], position.deriv().coef / STEP, rtol=1e-12)
        np.testing.assert_allclose(table[row + 2, :4], position.deriv(2).coef / STEP**2, rtol=1e-12)


def test_both_ends_are_met_and_neighbours_join() -> None:
    start, middle, end = (harmonic(t, 40.0) for t in (0.0, STEP, 1.7 * STEP))
    first, second = course(start, middle, STEP), course(middle, end, 0.7 * STEP)
    np.testing.assert_allclose(at(first, 0.0), start, rtol=1e-14)
    np.testing.assert_allclose(at(first, 1.0), middle, rtol=1e-11)
    np.testing.assert_allclose(at(second, 0.0), middle, rtol=1e-14)


def test_error_between_the_ends_is_of_sixth_order_and_of_fourth_in_accelerations() -> None:
    def worst(step: float) -> tuple[float, float]:
        table = course(harmonic(0.0, 40.0), harmonic(step, 40.0), step)
        gaps = [np.abs(np.subtract(at(table, share), harmonic(share * step, 40.0))) for share in (0.2, 0.5, 0.8)]
        worst = np.max(gaps, axis=0)
        return float(worst[3]), float(worst[5])

    coarse, fine = worst(0.02), worst(0.01)
    assert 5.5 < math.log2(coarse[0] / fine[0]) < 6.5
    assert 3.5 < math.log2(coarse[1] / fine[1]) < 4.5


def test_accelerations_alone_are_linear_and_leave_the_positions() -> None:
    """A table that gives accelerations only: they count, and no motion is invented from the positions."""
    start, end = SectionMotion(alpha_ddot=1.0, x_ddot=-2.0), SectionMotion(alpha_ddot=3.0, x_ddot=-2.0)
    middle = at(course(start, end, STEP), 0.25)
    assert middle.alpha_ddot == pytest.approx(1.5)
    assert middle.x_ddot == pytest.approx(-2.0)
    assert middle[:5] == (0.0,) * 5


def test_positions_alone_are_cubic_and_leave_the_accelerations() -> None:
    """Accelerations of zero contradict positions that move: no spikes of acceleration are invented."""
    middle = at(course(SectionMotion(h=0.0), SectionMotion(h=0.01), STEP), 0.5)
    assert middle.h == pytest.approx(0.005)
    assert middle.h_ddot == 0.0


def test_one_coordinate_that_lies_does_not_spoil_the_others() -> None:
    start, end = harmonic(0.0, 40.0), harmonic(STEP, 40.0)
    table = course(start._replace(h_ddot=0.0), end._replace(h_ddot=0.0), STEP)
    honest = course(start, end, STEP)
    np.testing.assert_array_equal(table[3:], honest[3:])
    np.testing.assert_array_equal(table[2], 0.0)


@pytest.mark.parametrize(("gap", "believed"), [(0.9 * AGREEMENT, True), (1.1 * AGREEMENT, False)])
def test_the_edge_of_agreement(gap: float, believed: bool) -> None:
    """Mean acceleration off by a share of the larger end value."""
    a = 5.0
    end = SectionMotion(h=0.5 * (1.0 + gap) * a * STEP**2, h_dot=(1.0 + gap) * a * STEP, h_ddot=a)
    table = course(SectionMotion(h_ddot=a), end, STEP)
    assert bool(np.any(table[2, 2:] != 0.0)) == believed


def test_four_steps_a_period_still_agree() -> None:
    step = 2.0 * math.pi / 40.0 / 4.2
    for i in range(20):
        table = course(harmonic(i * step, 40.0), harmonic((i + 1) * step, 40.0), step)
        assert np.all(table[[0, 3, 6], 5] != 0.0)


@pytest.mark.parametrize("place", [0.0, 1e6])
def test_standstill_far_from_the_origin_is_standstill(place: float) -> None:
    here = SectionMotion(h=place, alpha=0.3, x=-place)
    for share in (0.0, 0.4, 1.0):
        assert at(course(here, here, STEP), share) == pytest.approx(here)
    np.testing.assert_array_equal(course(here, here, STEP)[[1, 2, 4, 5, 7, 8]], 0.0)


def test_rounding_of_positions_is_no_contradiction() -> None:
    """Creeping far from the origin: the rounding of the positions exceeds what the tiny accelerations move."""
    curve = np.polynomial.Polynomial([1e3, 1e-3, 5e-10])
    curves = [curve, 1e-3 * curve, 0.0 * curve]
    middle = at(course(on(curves, 0.0), on(curves, STEP), STEP), 0.5)
    assert middle.h_dot == pytest.approx(on(curves, 0.5 * STEP).h_dot, rel=1e-6)
