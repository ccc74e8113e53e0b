"""Networks with output feedback: regressors, training, free run, bounds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from aeroslosh.fmus.slosh_rbf.feedback import INPUTS, Feedback, columns, free_run, gaussians, one_step, regressors
from aeroslosh.fmus.slosh_rbf.network import NetworkError
from aeroslosh.fmus.slosh_rbf.training.basis import k_means
from aeroslosh.fmus.slosh_rbf.training.feedback_fit import fit

Array = np.ndarray


def coefficients(outputs: int) -> tuple[Array, ...]:
    """a, b (outputs, outputs), c, d (2, outputs), e (outputs,) of `system`."""
    rng = np.random.default_rng(99)
    c, d, e = rng.standard_normal((2, outputs)), rng.standard_normal((2, outputs)), rng.standard_normal(outputs)
    return 0.5 * np.eye(outputs) + 0.1 * rng.standard_normal((outputs, outputs)), -0.3 * np.eye(outputs), c, d, e


def system(count: int, seed: int, outputs: int = 3) -> tuple[Array, Array]:
    """Inputs (count, 2) and loads (count, outputs) of y(k) = y(k−1) a + y(k−2) b + u(k) c + u(k−3) d + e; at rest before."""
    u = np.random.default_rng(seed).standard_normal((count, 2))
    u[:4] = 0.0
    a, b, c, d, e = coefficients(outputs)
    y = np.tile(np.linalg.solve((np.eye(outputs) - a - b).T, e), (count, 1))
    for k in range(3, count):
        y[k] = y[k - 1] @ a + y[k - 2] @ b + u[k] @ c + u[k - 3] @ d + e
    return u, y


def curved(count: int, seed: int) -> tuple[Array, Array]:
    """As `system`, seen through tanh: bounded, not linear."""
    u, y = system(count, seed)
    return u, np.tanh(0.5 * y)


def trained(centres: int = 20, inputs: str = "motion", delays: tuple[int, int] = (5, 3), seed: int = 0) -> Feedback:
    return fit("net", inputs, delays, 0.1, [curved(500, 1), curved(300, 2)], 0.15, 0.3, centres, ridge=1e-6, seed=seed)


def test_regressors_by_hand() -> None:
    u = np.array([[1.0, 10.0], [2.0, 20.0], [3.0, 30.0], [4.0, 40.0]])
    y = np.array([[0.1], [0.2], [0.3], [0.4]])
    # sample 2: u(2), u(1), y(1), y(0); sample 3: one later
    assert np.array_equal(regressors(u, y, (1, 2)), [[3, 30, 2, 20, 0.2, 0.1], [4, 40, 3, 30, 0.3, 0.2]])
    assert np.array_equal(regressors(u, y, (0, 1)), [[2, 20, 0.1], [3, 30, 0.2], [4, 40, 0.3]])
    assert np.array_equal(regressors(u, y, (0, 0)), u)


def test_columns_are_motion_or_drive() -> None:
    motions, drives = np.arange(18.0).reshape(2, 9), np.arange(10.0).reshape(2, 5)
    assert np.array_equal(columns("motion", drives, motions, 0.5), [[0.0, 3.0], [18.0, 12.0]])
    assert np.array_equal(columns("drive", drives, motions, 0.5), drives[:, :4])


@pytest.mark.parametrize("outputs", [1, 3])
def test_linear_system_is_found_exactly(outputs: int) -> None:
    net = fit("arx", "motion", (3, 2), 0.1, [system(400, 1, outputs)], 0.15, 0.3, ridge=0.0)
    net.check()
    u, y = system(2000, 7, outputs)
    free = free_run(net, u, y[0])
    assert np.abs(free - y).max() < 1e-10 * np.abs(y).max()
    a, b, *_ = coefficients(outputs)
    companion = np.block([[a.T, b.T], [np.eye(outputs), np.zeros((outputs, outputs))]])
    assert net.radius() == pytest.approx(np.abs(np.linalg.eigvals(companion)).max(), abs=1e-10)


@pytest.mark.parametrize("centres", [0, 20])
@pytest.mark.parametrize("delays", [(5, 3), (0, 1), (3, 0), (2, 5)])
def test_free_run_is_one_step_fed_with_its_own_loads(centres: int, delays: tuple[int, int]) -> None:
    net = trained(centres, delays=delays)
    u, y = curved(200, 3)
    free = free_run(net, u, y[0])
    again = one_step(net, regressors(u, free, delays))
    assert np.abs(again - free[max(delays) :]).max() < 1e-11


def test_free_run_starts_from_a_past_that_stood_still() -> None:
    net = trained()
    u = curved(50, 3)[0]
    start = np.array([0.1, -0.2, 0.3])
    before = np.repeat(u[:1], 5, axis=0)
    past = np.vstack([np.tile(start, (5, 1)), np.zeros((1, 3))])
    first = one_step(net, regressors(np.vstack([before, u[:1]]), past, net.delays))
    assert np.abs(free_run(net, u, start)[0] - first[0]).max() < 1e-12


def test_gaussians_are_those_of_their_formula() -> None:
    z, c = np.random.default_rng(0).standard_normal((7, 4)), np.random.default_rng(1).standard_normal((3, 4))
    by_hand = [[np.exp(-sum((a - b) ** 2 for a, b in zip(x, p, strict=True)) / (2.0 * 1.5**2)) for p in c] for x in z]
    np.testing.assert_allclose(gaussians(z, c, 1.5), by_hand, rtol=1e-13)


def test_gaussians_stay_bounded_with_any_weights() -> None:
    rng = np.random.default_rng(5)
    net = trained(30)
    wild = replace(
        net, weights=100.0 * rng.standard_normal(net.weights.shape), linear=10.0 * rng.standard_normal(net.linear.shape)
    )
    wild.check()
    u = rng.uniform(-5.0, 5.0, (100_000, 2))
    loads = free_run(wild, u, np.zeros(3))
    bound = (np.abs(wild.weights).sum(axis=0) + np.abs(wild.linear[-1])) * wild.output_scale + np.abs(wild.output_shift)
    assert np.isfinite(loads).all() and np.all(np.abs(loads) <= bound)
    assert np.abs(loads).max() > 0.01 * bound.max()  # the bound is not reached by doing nothing


def test_growing_feedback_is_refused() -> None:
    net = fit("arx", "motion", (3, 2), 0.1, [system(400, 1)], 0.15, 0.3)
    net.check()
    linear = net.linear.copy()
    linear[2 * 4 : -1] *= 4.0
    with pytest.raises(NetworkError, match=r"grows by 1\.\d+ a step.*Remedy"):
        replace(net, linear=linear).check()
    # without output delays nothing can grow
    fit("fir", "motion", (3, 0), 0.1, [system(400, 1)], 0.15, 0.3).check()


def test_mistakes_are_refused() -> None:
    net, (u, y) = trained(), curved(100, 3)
    with pytest.raises(NetworkError, match="start"):
        free_run(net, u, np.zeros(2))
    with pytest.raises(NetworkError, match=r"inputs \(100, 4\)"):
        free_run(net, np.hstack([u, u]), np.zeros(3))
    with pytest.raises(NetworkError, match="regressors"):
        one_step(net, regressors(u, y, (5, 2)))
    with pytest.raises(NetworkError, match="longer"):
        regressors(u[:5], y[:5], (5, 3))
    with pytest.raises(NetworkError, match="as long as each other"):
        regressors(u, y[:-1], (5, 3))
    with pytest.raises(NetworkError, match="4 inputs 'drive'"):
        fit("net", "drive", (5, 3), 0.1, [(u, y)], 0.15, 0.3)
    with pytest.raises(NetworkError, match="inputs 'motion'"):
        fit("net", "motion", (5, 3), 0.1, [], 0.15, 0.3)
    broken = (
        replace(net, shift=net.shift[:-1]), replace(net, weights=net.weights[:, :2]), replace(net, centres=net.centres[:-1]),
        replace(net, scale=0.0 * net.scale), replace(net, spread=float("nan")), replace(net, inputs="drive"),
        replace(net, output_scale=net.output_scale * np.nan), replace(net, linear=net.linear[:-1]),
    )  # fmt: skip
    for other in broken:
        with pytest.raises(NetworkError, match="Remedy"):
            other.check()


def test_a_coordinate_at_rest_does_no_harm() -> None:
    u, y = curved(300, 1)
    u[:, 0] = 0.1  # plunge stays where it is: its mean is known to rounding alone
    for centres in (0, 20):
        net = fit("net", "motion", (5, 3), 0.1, [(u, y)], 0.15, 0.3, centres, ridge=1e-6)
        moved = u + np.array([1e-3, 0.0])  # a plunge never seen, of half a millimetre
        difference = free_run(net, moved, y[0]) - free_run(net, u, y[0])
        assert np.isfinite(difference).all() and np.abs(difference).max() < 1e-3


def test_k_means_and_training_repeat_by_seed() -> None:
    points = np.random.default_rng(3).standard_normal((300, 4))
    a, b, c = (k_means(points, 10, np.random.default_rng(seed)) for seed in (1, 1, 2))
    np.testing.assert_allclose(a, b, rtol=1e-12)
    assert np.abs(a - c).max() > 1e-3
    one, same, other = trained(seed=1), trained(seed=1), trained(seed=2)
    np.testing.assert_allclose(one.centres, same.centres, rtol=1e-9)
    np.testing.assert_allclose(one.weights, same.weights, rtol=1e-6, atol=1e-9 * np.abs(one.weights).max())
    assert np.abs(one.centres - other.centres).max() > 1e-3 * np.abs(one.centres).max()


def test_inputs_have_a_width_each() -> None:
    assert INPUTS == {"motion": 2, "drive": 4}
    net = trained()
    assert net.width == 2 * 6 + 3 * 3 == net.shift.size and net.outputs == 3
