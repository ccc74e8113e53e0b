"""Accelerations of fixed-point iterations on loops whose solution is known."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from aeroslosh.master.cosim.acceleration import Acceleration, Aitken, Constant, QuasiNewton, make
from aeroslosh.master.cosim.quasi_newton import least_squares

Map = Callable[[np.ndarray], np.ndarray]


def passes(faster: Acceleration, loop: Map, x: np.ndarray, tolerance: float, most: int = 60) -> int:
    """Passes until |H(x) − x| is below `tolerance` in every entry; `most` + 1 when it is not."""
    size = np.ones(x.size)
    faster.start()
    for count in range(1, most + 1):
        r = loop(x) - x
        if np.max(np.abs(r)) <= tolerance:
            faster.end()
            return count
        x = faster.next(x, r, size)
        if not np.isfinite(x).all():
            break
    return most + 1


def stiff(n: int, gain: float, seed: int = 0) -> Map:
    """H(x) = A x + b with singular values from `gain` down to a thousandth of it: repeated plainly, it explodes."""
    random = np.random.default_rng(seed)
    left, right = (np.linalg.qr(random.normal(size=(n, n)))[0] for _ in range(2))
    A, b = left @ np.diag(np.geomspace(gain, 1e-3 * gain, n)) @ right, random.normal(size=n)
    return lambda x: A @ x + b


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8])
@pytest.mark.parametrize("seed", range(5))
def test_quasi_newton_solves_a_stiff_linear_loop_in_n_plus_2_passes(n: int, seed: int) -> None:
    """n differences span the space: the pass after them is at the solution (1e-9 of values of order 1 to 1e3: rounding)."""
    loop = stiff(n, 50.0, seed)
    assert passes(QuasiNewton(filter=1e-12), loop, np.zeros(n), 1e-9 * 50.0) <= n + 2
    assert passes(Constant(1.0), loop, np.zeros(n), 1e-9 * 50.0) == 61


def test_quasi_newton_uses_earlier_steps() -> None:
    """A linear loop whose constant part moves: with the columns of the step before, two passes do, which is the least."""
    loop, shift = stiff(3, 20.0), np.array([1.0, -2.0, 0.5])
    reusing, forgetting = QuasiNewton(reuse=4, filter=1e-12), QuasiNewton(reuse=0, filter=1e-12)
    counts = {name: [passes(f, lambda x, k=k: loop(x) + k * shift, np.zeros(3), 1e-8) for k in range(4)]  # type: ignore[misc]
              for name, f in (("reusing", reusing), ("forgetting", forgetting))}  # fmt: skip
    assert counts["reusing"][1:] == [2, 2, 2]
    assert min(counts["forgetting"]) >= 4


def test_quasi_newton_on_a_nonlinear_loop() -> None:
    """x = cos(G x): converges where repeating alone does not."""
    G = np.array([[1.7, 0.4], [-0.3, 1.9]])
    assert passes(QuasiNewton(), lambda x: np.cos(G @ x), np.zeros(2), 1e-10) <= 12
    assert passes(Constant(1.0), lambda x: np.cos(G @ x), np.zeros(2), 1e-10) == 61


def test_dependent_columns_are_left_out() -> None:
    """Twice the same direction with noise: used, it would be divided by the noise; left out, the answer is the clean one."""
    v, w = np.array([1.0, 0.0, 0.0]), np.array([2.0, 1.0, 0.0])
    noisy = (v + np.array([0.0, 1e-9, 0.0]), w + np.array([0.0, 1.0, 5.0]))
    r = np.array([0.5, 0.3, 0.0])
    update, dropped = least_squares([(v, w), noisy], r, np.ones(3), 1e-6)
    assert dropped == 1
    assert update == pytest.approx(-0.5 * w, abs=1e-15)
    wild, kept = least_squares([(v, w), noisy], r, np.ones(3), 0.0)
    assert kept == 0 and np.max(np.abs(wild)) > 1e8


def test_sizes_weigh_the_entries() -> None:
    """One column cannot meet two residuals: the entry of the small unit counts more."""
    column = (np.array([1.0, 1.0]), np.array([1.0, 1.0]))
    update, _ = least_squares([column], np.array([1.0, 2.0]), np.array([1e-3, 1e3]), 1e-9)
    assert update == pytest.approx([-1.0, -1.0], rel=1e-9)


def test_a_restored_quasi_newton_goes_on_the_same() -> None:
    loop = stiff(4, 10.0)
    one, other = QuasiNewton(), QuasiNewton()
    for k in range(3):
        passes(one, lambda x, k=k: loop(x) + k, np.zeros(4), 1e-8)  # type: ignore[misc]
    other.restore(one.state())
    r = np.arange(4.0) + 1.0
    for f in (one, other):
        f.start()
    assert (one.next(np.ones(4), r, np.ones(4)) == other.next(np.ones(4), r, np.ones(4))).all()


def test_nothing_changes_nothing() -> None:
    """A residual that does not change says nothing: no division by zero, no jump."""
    for faster in (QuasiNewton(), Aitken(), Constant(0.5)):
        faster.start()
        x = np.zeros(2)
        for _ in range(4):
            x = faster.next(x, np.zeros(2), np.ones(2))
            assert (x == 0.0).all()


@pytest.mark.parametrize("name", ["constant", "aitken", "iqn-ils"])
def test_each_is_known_by_its_name(name: str) -> None:
    assert make(name, 1.0, 8, 1e-6).name == name
