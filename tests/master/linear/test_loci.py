"""Root loci and neutral values of matrices whose eigenvalues are known."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial

from aeroslosh.master.linear import root_loci


def oscillators(*modes: tuple[Polynomial, Polynomial]):  # type: ignore[no-untyped-def]
    """A matrix with eigenvalues σ_i(p) ± i ω_i(p), mixed by a fixed similarity."""
    n = 2 * len(modes)
    mix = np.random.default_rng(1).normal(size=(n, n)) + 3.0 * np.eye(n)
    inverse = np.linalg.inv(mix)

    def matrix(p: float) -> np.ndarray:
        A = np.zeros((n, n))
        for i, (sigma, omega) in enumerate(modes):
            A[2 * i : 2 * i + 2, 2 * i : 2 * i + 2] = [[sigma(p), omega(p)], [-omega(p), sigma(p)]]
        return mix @ A @ inverse

    return matrix


GRID = np.geomspace(0.3, 3.0, 40)


def test_an_s_has_onset_recovery_and_onset() -> None:
    """One mode crosses at 0.55, 1.3 and 2.2; another, well damped, passes it in frequency."""
    s_shaped = 0.05 * Polynomial.fromroots([0.55, 1.3, 2.2])
    found = root_loci.follow(
        oscillators((s_shaped, Polynomial([0.8, 0.5])), (Polynomial([-0.2]), Polynomial([2.2, -0.3]))), GRID
    ).neutral
    assert [n.direction for n in found] == ["onset", "recovery", "onset"]
    assert [n.value for n in found] == pytest.approx([0.55, 1.3, 2.2], rel=1e-9)
    assert [n.frequency for n in found] == pytest.approx([1.075, 1.45, 1.9], rel=1e-9)
    assert [n.slope for n in found] == pytest.approx([s_shaped.deriv()(v) for v in (0.55, 1.3, 2.2)], rel=1e-5)
    assert len({n.branch for n in found}) == 1


def test_modes_that_pass_close_are_not_exchanged() -> None:
    """Frequencies cross at p = 1.5 with real parts 0.002 apart: each locus stays straight."""
    found = root_loci.follow(
        oscillators((Polynomial([-0.01]), Polynomial([0.5, 1.0])), (Polynomial([-0.012]), Polynomial([3.5, -1.0]))), GRID
    )
    for j in found.upper():
        frequency = found.eigenvalues[:, j].imag
        slope = np.sign(frequency[-1] - frequency[0])
        assert np.all(slope * np.diff(frequency) > 0)
    assert not found.neutral


def test_two_modes_turn_unstable_each_on_its_branch() -> None:
    found = root_loci.follow(
        oscillators((Polynomial([-0.1, 0.1]), Polynomial([1.0])), (Polynomial([-0.44, 0.2]), Polynomial([4.0]))), GRID
    ).neutral
    assert [(round(n.value, 6), round(n.frequency, 6)) for n in found] == [(1.0, 1.0), (2.2, 4.0)]
    assert found[0].branch != found[1].branch


def test_a_narrow_window_of_growth_is_found_when_the_grid_sees_it() -> None:
    found = root_loci.follow(oscillators((-1.0 * Polynomial.fromroots([1.0, 1.08]), Polynomial([1.0]))), GRID).neutral
    assert [n.direction for n in found] == ["onset", "recovery"]
    assert [n.value for n in found] == pytest.approx([1.0, 1.08], rel=1e-9)


def test_divergence_has_no_frequency() -> None:
    def matrix(p: float) -> np.ndarray:
        return np.array([[0.0, 1.0], [p - 1.0, -0.3]])  # stiffness 1 − p

    found = root_loci.follow(matrix, GRID)
    assert not found.neutral  # no oscillation turns unstable
    real = found.real()
    assert np.all(np.isnan(real[found.parameters < 0.97])) and np.all(real[found.parameters > 1.0] > 0.0)
    assert np.interp(0.0, real[~np.isnan(real)], found.parameters[~np.isnan(real)]) == pytest.approx(1.0, abs=0.01)
