"""The violent branch against what is known exactly: what it leaves alone, what it may not do, and what a fit must find."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.build.archive import ROOT
from aeroslosh.fmus.slosh_rbf import network, violent_network
from aeroslosh.fmus.slosh_rbf.feedback_tank import in_tank
from aeroslosh.fmus.slosh_rbf.network import NetworkError
from aeroslosh.fmus.slosh_rbf.surrogate import Surrogate
from aeroslosh.fmus.slosh_rbf.training import violent_fit, violent_plan
from aeroslosh.fmus.slosh_rbf.training.excitation import sine
from aeroslosh.fmus.slosh_rbf.violent_memory import BASIS, share
from aeroslosh.fmus.slosh_rbf.violent_network import WIDTH, Violent, ViolentWeights
from aeroslosh.fmus.slosh_rbf.violent_tank import ViolentSurrogate
from aeroslosh.fmus.tank.liquid import Tank

TANK = Tank(0.5, 0.15)
NETWORK = network.load(ROOT / "slosh_rbf" / "weights" / "default.npz")
BRANCH = violent_network.load(ROOT / "slosh_rbf" / "weights" / "branches" / "default.npz")


def random_branch(seed: int, size: float = 0.3, centres: int = 30) -> Violent:
    """Weights of no meaning."""
    r = np.random.default_rng(seed)
    shift, scale = np.array([-1.5, 1.5, 0.4, 0.0, 0.5, 0.5]), np.array([0.8, 0.7, 0.2, 2.0, 0.5, 0.1])
    weights = ViolentWeights(
        shift, scale, r.normal(size=(centres, WIDTH)), 1.0, size * r.normal(size=(centres, BASIS)), np.full(centres, 0.1),
        np.full(WIDTH, -3.0), np.full(WIDTH, 3.0), 3.0,
    )  # fmt: skip
    return Violent("random", weights, (0.3, 0.7), 0.3, 0.05)


def shaken(g: float, omega: float = 41.0, step: float = 2e-3, length: float = 1.2, arm: float = 1.8) -> np.ndarray:
    """Motions (n, 9) of a tank `arm` behind the axis of a pitch that is `g` times gravity there."""
    alpha = g * 9.81 / (arm * omega**2)
    times = step * np.arange(round(length / step) + 1)
    return sine(times, omega, h=0.0, alpha=alpha, ramp=0.15).motions


def behind(fill: float = 0.5) -> Tank:
    return replace(TANK, x=1.8, fill_level=fill)


def test_a_whole_surface_has_the_loads_of_the_network_alone_to_the_bit() -> None:
    """Up to D = 1 whatever the weights; and at 1.4 g as long as waves have not grown."""
    for g, length in ((0.3, 1.2), (0.8, 1.2), (1.4, 0.4)):
        motions = shaken(g, length=length)
        with_branch = ViolentSurrogate(NETWORK, random_branch(0, 5.0), behind(), 1e-6, 1.2).run(motions, 2e-3)
        assert (with_branch == Surrogate(NETWORK, behind(), 1e-6, 1.2).run(motions, 2e-3)).all()
    motions = shaken(7.0)
    broken = ViolentSurrogate(NETWORK, BRANCH, behind(), 1e-6, 1.2).run(motions, 2e-3)
    calm = Surrogate(NETWORK, behind(), 1e-6, 1.2).run(motions, 2e-3)
    assert np.abs(broken - calm)[:, 1].max() > TANK.mass * 9.81  # there it is another model


def test_the_share_is_nought_before_and_one_after_break_up_and_rises_between() -> None:
    assert share(1.0, 3.0) == share(5.0, -6.0) == 0.0
    assert share(2.0, -4.0) == share(30.0, 2.0) == 1.0
    rising = [share(1.0 + d, -6.0 + 2.0 * d) for d in np.linspace(0.0, 1.0, 20)]
    assert (np.diff(rising) > 0.0).all()


def test_step_by_step_is_the_whole_record() -> None:
    motions = shaken(7.0)
    surrogate = ViolentSurrogate(NETWORK, random_branch(1), behind(), 1e-6, 1.2)
    state = surrogate.start(motions[0])
    found = [state.answer[:3]]
    for a, b in itertools.pairwise(motions):
        state = surrogate.advance(state, a, b, 2e-3)
        found.append(state.answer[:3])
    assert np.allclose(found, surrogate.run(motions, 2e-3), rtol=1e-9, atol=1e-9)
    again = surrogate.advance(surrogate.start(motions[0]), motions[0], motions[1], 2e-3)
    assert again.answer[:3] == found[1]


@pytest.mark.parametrize("omega", [30.0, 41.0, 60.0])
@pytest.mark.parametrize("step", [1e-3, 4e-3])
def test_half_and_double_step_take_the_same_work(step: float, omega: float) -> None:
    """7 g: the work that the liquid takes out of 1.5 s of motion moves by less than 1 % against steps of 2 ms."""

    def work(step: float) -> float:
        motions = shaken(7.0, omega, step, 1.5)
        loads = ViolentSurrogate(NETWORK, BRANCH, behind(), 1e-6, 1.2).run(motions, step)
        return float(np.trapezoid(loads[:, 2] * motions[:, 4])) * step

    assert work(2e-3) < -10.0
    assert work(step) == pytest.approx(work(2e-3), rel=0.01)


def test_a_million_steps_at_seventy_g_stay_bounded() -> None:
    """Any weights: nothing is fed back, |r| is at most `limit` times Q. Ten parts of one march."""
    motions = np.tile(shaken(70.0, length=0.2)[:-1], (1, 1))
    times = 2e-3 * np.arange(100_000)
    alpha = 70.0 * 9.81 / (1.8 * 41.0**2)
    motions = np.zeros((len(times), 9))
    for k, wave in enumerate((np.sin(41.0 * times), 41.0 * np.cos(41.0 * times), -(41.0**2) * np.sin(41.0 * times))):
        motions[:, 3 + k] = alpha * wave
    surrogate = ViolentSurrogate(NETWORK, random_branch(2, 5.0), behind(), 1e-6, 1.2)
    state, peaks = surrogate.start(motions[0]), []
    for _ in range(10):
        state, loads = surrogate.march(state, motions, 2e-3)
        peaks.append(np.abs(loads).max(axis=0))
    assert np.isfinite(peaks).all()
    # frozen liquid and 3 Q of the branch, in both axes of the section
    assert np.max(np.array(peaks)[:, :2]) < 5.0 * 75.0 * TANK.mass * 9.81


def test_scale_models() -> None:
    """Four times the size, twice as slow: the same loads over weight (1e-6: slugs meet walls at the same pieces)."""
    small, big = replace(TANK, x=0.0), Tank(2.0, 0.6)
    motions = shaken(7.0, arm=1.8)
    scaled = motions * np.array([4.0, 2.0, 1.0, 1.0, 0.5, 0.25, 4.0, 2.0, 1.0])
    one = ViolentSurrogate(NETWORK, BRANCH, replace(small, x=1.8), 0.0, 1.2).run(motions, 2e-3)
    other = ViolentSurrogate(NETWORK, BRANCH, replace(big, x=7.2), 0.0, 1.2).run(scaled, 4e-3)
    assert other[:, 1] / 16.0 == pytest.approx(one[:, 1], rel=1e-6, abs=1e-6 * np.abs(one[:, 1]).max())


def test_which_tanks_the_branch_takes() -> None:
    """Fills between those trained on, with equations for the whole surface where the network knows another fill; else as
    before."""
    for fill in (0.31, 0.5, 0.69):
        found = in_tank(NETWORK, behind(fill), 1e-6, 1.2, BRANCH)
        assert isinstance(found, ViolentSurrogate)
        assert (found.calm.network is NETWORK) == (fill == 0.5)
    with pytest.raises(NetworkError, match="depth/length"):
        in_tank(NETWORK, behind(0.2), 1e-6, 1.2, BRANCH)
    assert isinstance(in_tank(NETWORK, behind(), 1e-6, 1.2), Surrogate)
    tall = replace(TANK, height=0.2, fill_level=0.375)  # the depth that is known, another room
    assert isinstance(in_tank(NETWORK, tall, 1e-6, 1.2, BRANCH), Surrogate)


def test_validity_says_what_the_loads_are() -> None:
    surrogate = ViolentSurrogate(NETWORK, BRANCH, behind(), 1e-6, 1.2)

    def worst(g: float, omega: float = 41.0) -> tuple[float, float]:
        motions = shaken(g, omega)
        state, most, spread = surrogate.start(motions[0]), 0.0, 0.0
        for a, b in itertools.pairwise(motions):
            state = surrogate.advance(state, a, b, 2e-3)
            most, spread = max(most, state.answer.validity), max(spread, state.answer.deviation)
        return most, spread

    calm, mean, outside = worst(0.4), worst(7.0), worst(70.0)
    assert calm[0] <= 1.0 and calm[1] == 0.0
    assert 1.0 < mean[0] <= 2.0 and mean[1] > 0.02 * 7.0 * TANK.mass * 9.81
    assert outside[0] > 2.0


def test_a_branch_in_a_file(tmp_path: Path) -> None:
    branch = random_branch(3)
    branch.save(tmp_path / "b.npz")
    again = violent_network.load(tmp_path / "b.npz")
    motions = shaken(5.0)
    loads = [ViolentSurrogate(NETWORK, b, behind(), 1e-6, 1.2).run(motions, 2e-3) for b in (branch, again)]
    assert (loads[0] == loads[1]).all()
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    with pytest.raises(NetworkError, match="no violent branch"):
        violent_network.load(tmp_path / "bad.npz")
    with pytest.raises(NetworkError, match="no violent branch"):
        violent_network.load(ROOT / "slosh_rbf" / "weights" / "default.npz")
    w = branch.weights
    for weights, says in (
        (w._replace(noise=np.full(len(w.noise), np.nan)), "not finite"),
        (w._replace(weights=w.weights[:, :-1]), "do not fit"),
        (w._replace(scale=np.zeros(WIDTH)), "make no sense"),
        (w._replace(high=w.low), "make no sense"),
    ):
        replace(branch, weights=weights).save(tmp_path / "odd.npz")
        with pytest.raises(NetworkError, match=says):
            violent_network.load(tmp_path / "odd.npz")
    replace(branch, fills=(0.7, 0.3)).save(tmp_path / "odd.npz")
    with pytest.raises(NetworkError, match="make no sense"):
        violent_network.load(tmp_path / "odd.npz")


def table(r: np.ndarray | None = None, g: float = 7.0, omega: float = 41.0, fill: float = 0.5) -> violent_fit.Table:
    """A steady plunge of `g`, with the force r over m_T g on top of that of the frozen liquid."""
    times = 2e-3 * np.arange(1001)
    motions = sine(times, omega, h=g * 9.81 / omega**2, alpha=1e-3, ramp=0.15).motions
    tank = replace(TANK, fill_level=fill)
    weight, gas = tank.mass * 9.81, 1.2 * 0.5 * 0.15 * (1.0 - fill) / tank.mass
    up = -(1.0 + gas) * weight * (1.0 - motions[:, 2] / 9.81) + weight * (0.0 if r is None else r)
    s, c = np.sin(motions[:, 3]), np.cos(motions[:, 3])
    loads = np.stack([up * s, up * c, np.zeros_like(up)], axis=1)
    return violent_fit.tabulate("t", tank, 1e-6, 1.2, motions, loads, 2e-3)


def test_a_drag_has_the_loss_factor_that_it_must() -> None:
    """r = −η a v/|v|max, in phase with the velocity, takes π m a X η out of a cycle (1 %: 77 samples a cycle)."""
    times = 2e-3 * np.arange(1001)
    true = 0.2 * 7.0 * np.cos(41.0 * times)  # h = sin is down, its rate down: the tank moves up with −cos
    found = violent_fit.loss(table(true), table(true).r)
    assert found[3:] == pytest.approx(0.2, rel=0.01)
    assert np.abs(violent_fit.loss(table(), table().r)).max() < 1e-3  # the frozen liquid takes nothing


def test_a_fit_finds_the_weights_that_made_its_records() -> None:
    """Records whose force a branch of few centres made are fitted by another of the same kind: loss factors to 0.02, R2 0.98."""
    plain = [table(g=g, omega=w, fill=f) for g in (3.0, 7.0, 12.0) for w in (30.0, 41.0, 55.0) for f in (0.4, 0.6)]
    maker = violent_fit.fit(plain, violent_fit.Settings(centres=6, ridges=(1e-3,)))[0]
    random = np.random.default_rng(0)
    maker = maker._replace(weights=0.1 * random.normal(size=maker.weights.shape), limit=9.0)
    made = [replace(t, r=violent_fit.predict(maker, t)) for t in plain]
    net, tried = violent_fit.choose(
        made[::2], made[1::2], [violent_fit.Settings(centres=12, spread=1.0, ridges=(1e-6, 1e-3), thin=2)]
    )
    assert (
        len(tried) == 2
        and min(r["loss_rms"] for r in tried)
        == violent_fit.measure(made[1::2], [violent_fit.predict(net, t) for t in made[1::2]])["loss_rms"]
    )
    seen = violent_fit.measure(made[::2], [violent_fit.predict(net, t) for t in made[::2]])
    assert seen["R2"] > 0.98 and seen["loss_rms"] < 0.02
    with pytest.raises(ValueError, match="samples"):
        violent_fit.fit([table(g=0.5)], violent_fit.Settings(centres=5))


def test_the_kernel_tells_what_the_fit_foretold() -> None:
    """The FMU's kernel and the training's arrays: the same read-out (1e-6 of the largest force)."""
    t = table()
    motions = sine(2e-3 * np.arange(1001), 41.0, h=7.0 * 9.81 / 41.0**2, alpha=1e-3, ramp=0.15).motions
    surrogate = ViolentSurrogate(NETWORK, BRANCH, TANK, 1e-6, 1.2)
    whole = t.share == 1.0
    loads = surrogate.run(motions, 2e-3)
    gas = 1.2 * 0.075 / (1000.0 * 0.075)
    up = loads[:, 1] * np.cos(motions[:, 3]) + loads[:, 0] * np.sin(motions[:, 3])
    r = up / (TANK.mass * 9.81) + (1.0 + t.p) * (1.0 + gas)
    expected = violent_fit.predict(BRANCH.weights, t)
    assert whole.sum() > 300
    assert np.abs(r - expected)[whole].max() < 1e-6 * np.abs(expected).max()


def test_noise_is_that_of_records_apart() -> None:
    """White noise of 0.2 Q on top of the prediction: told as 0.2, gone after a sample."""
    random = np.random.default_rng(1)
    t = table()
    noisy = replace(t, r=violent_fit.predict(BRANCH.weights, t) + 0.2 * t.Q * t.share * random.normal(size=t.Q.size))
    at, lasts = violent_fit.noise(BRANCH.weights, [noisy])
    assert np.average(at) == pytest.approx(0.2, rel=0.1)
    assert lasts < 1e-3


def test_the_plan_is_what_it_says() -> None:
    """Seeded, D from 1.3 to 24, fills between their ends, tests with twins that differ by 1e-5, names once."""
    sizes = violent_plan.Sizes(20, 6, 8, 8, (0.35, 0.65), (0.4,))
    plan = violent_plan.violent(TANK, sizes)
    again = violent_plan.violent(TANK, sizes)
    assert [p.motion.name for p in plan] == [p.motion.name for p in again]
    assert all((a.motion.motions == b.motion.motions).all() for a, b in zip(plan, again, strict=True))
    assert len({p.motion.name for p in plan}) == len(plan) == 20 + 6 + 8 + 16
    for p in plan:
        assert 0.35 <= p.parameters["fill_level"] <= 0.65 and p.parameters["tank_x"] == 0.0
        gamma = np.abs(p.motion.motions[:, 2] / 9.81).max()
        assert 0.2 < gamma < 25.0
    tests = {p.motion.name: p.motion for p in plan if p.split == "test"}
    for name, motion in tests.items():
        if not name.endswith("_twin"):
            gap = np.abs(tests[f"{name}_twin"].motions - motion.motions).max() / np.abs(motion.motions).max()
            assert math.isclose(gap, 1e-5, rel_tol=1e-3)
