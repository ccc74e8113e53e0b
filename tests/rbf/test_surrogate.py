"""The surrogate's memory, base and network against what is known exactly."""

from __future__ import annotations

import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_ems.linear import LinearSlosh
from aeroslosh.fmus.slosh_rbf.body import from_load, to_load
from aeroslosh.fmus.slosh_rbf.memory import MODES, SECOND, Memory
from aeroslosh.fmus.slosh_rbf.network import Network, NetworkError, Weights, load, untrained
from aeroslosh.fmus.slosh_rbf.readout import EVEN, MIRROR, ODD, SPACE
from aeroslosh.fmus.slosh_rbf.surrogate import Record, State, Surrogate, tabulate
from aeroslosh.fmus.slosh_rbf.training.excitation import Motion, carried
from aeroslosh.fmus.tank.frozen import static_load
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.fmus.tank.motion import SectionMotion, course

TANK = Tank(0.5, 0.15, 1.0, 0.5, 1.8, 0.1, 800.0, 9.81)


def swing(times: np.ndarray, h: float = 2e-3, alpha: float = 0.01, x: float = 0.0, omega: float = 40.0) -> np.ndarray:
    """Smoothly started plunge, pitch and surge at related frequencies: motions (n, 9) from closed forms."""
    out = np.zeros((len(times), 9))
    for column, size, w in ((0, h, omega), (3, alpha, 0.7 * omega), (6, x, 1.3 * omega)):
        # sin^4 of a slow phase times a sine would be long-winded: 1 − cos starts at rest with finite acceleration
        out[:, column] = size * (1.0 - np.cos(w * times))
        out[:, column + 1] = size * w * np.sin(w * times)
        out[:, column + 2] = size * w**2 * np.cos(w * times)
    return out


def random_network(seed: int, centres: int = 40, size: float = 1e-2) -> Network:
    """Weights of no meaning."""
    r = np.random.default_rng(seed)
    weights = Weights(
        True, size * r.normal(size=(ODD, 2)), size * r.normal(size=EVEN), r.normal(size=(centres, SPACE)), np.full(centres, 0.3),
        1.0 / r.uniform(0.1, 1.0, SPACE), size * r.normal(size=(centres, 2)), size * r.normal(size=centres), np.zeros(centres),
        np.full(3, 0.05),
    )  # fmt: skip
    spread = (weights.centres * weights.inverse_scales * weights.sharpness[:, None]) ** 2
    return Network("random", weights._replace(still=2.0 * np.exp(-0.5 * spread.sum(axis=1))), np.ones(SPACE), 0.15, 0.3)


def test_the_linear_base_is_the_equivalent_mechanical_system() -> None:
    """Small motions: the base without products of gamma equals slosh_ems with as many modes (1e-6 of loads: squares of 1e-4)."""
    times = 2e-3 * np.arange(400)
    motions = swing(times, 1e-6, 1e-5, 1e-6)
    surrogate = Surrogate(untrained("ems", False), TANK, 1e-6, 0.0)
    memory = Memory(TANK, 1e-6)
    ems = LinearSlosh(TANK, modes(TANK, MODES), memory.damping)
    w = ems.start(SectionMotion(*motions[0]))
    true = [ems.load(w, SectionMotion(*motions[0]))]
    for a, b in itertools.pairwise(motions):
        w = ems.advance(w, course(SectionMotion(*a), SectionMotion(*b), 2e-3), 2e-3)
        true.append(ems.load(w, SectionMotion(*b)))
    found = surrogate.run(motions, 2e-3)
    swinging = np.array(true) - np.array(static_load(TANK))
    assert np.max(np.abs(found - true) / np.abs(swinging).max(axis=0)) < 1e-3
    assert np.abs(swinging).max() < 1.0  # small they are


def test_rest_stays_rest_and_a_tilt_gives_the_static_load() -> None:
    """Weight of liquid and gas through their centres; a tilted level surface shifts the liquid's."""
    gas = 1.2
    surrogate = Surrogate(untrained("bilinear", True), TANK, 1e-6, gas)
    rest = surrogate.run(np.zeros((50, 9)), 2e-3)
    # with any weights nothing is added at rest (1e-12 of the weight: rounding)
    trained = Surrogate(random_network(6), TANK, 1e-6, gas).run(np.zeros((50, 9)), 2e-3)
    assert np.abs(trained - rest).max() < 1e-9
    weight = static_load(TANK).force_y - gas * 0.5 * 0.075 * 9.81
    assert rest == pytest.approx(np.tile([0.0, weight, -1.8 * weight], (50, 1)), abs=1e-9)
    tilt = np.zeros((50, 9))
    tilt[:, 3] = 0.05
    loads = surrogate.run(tilt, 2e-3)
    assert np.ptp(loads, axis=0) == pytest.approx(np.zeros(3), abs=1e-9)
    assert loads[0, :2] == pytest.approx([0.0, weight], abs=2e-3 * abs(weight) * 0.05)
    depth, length, m, g = 0.075, 0.5, TANK.mass, 9.81
    s, t = np.sin(0.05), np.tan(0.05)
    # centre of a liquid with a level surface in a tilted box, tank axes from its centre at rest (exact geometry)
    across, along = length**2 * t**2 / (24 * depth), length**2 * t / (12 * depth)
    x = TANK.x + along
    y = TANK.centre_y + across
    exact = m * g * (x * np.cos(0.05) + y * s) - 1.8 * (weight + m * g) * np.cos(0.05)
    # the centre rises with the square of the tilt: second order in 0.05
    assert loads[0, 2] == pytest.approx(exact, abs=4e-3 * m * g * along)


@pytest.mark.parametrize("step", [5e-4, 1e-3, 5e-3])
def test_the_communication_step_does_not_matter(step: float) -> None:
    """The same motion in steps of 0.5 to 5 ms: the same loads at common instants, to 0.1 % of their swing."""
    network = random_network(3)
    tank = replace(TANK, x=0.0, y=0.0)
    surrogate = Surrogate(network, tank, 1e-6, 1.2)
    base = surrogate.run(swing(2.5e-4 * np.arange(2401), omega=60.0), 2.5e-4)
    every = round(step / 2.5e-4)
    found = surrogate.run(swing(step * np.arange(2400 // every + 1), omega=60.0), step)
    assert np.max(np.abs(found - base[::every]) / base.std(axis=0)) < 1e-3


def test_step_by_step_is_the_whole_record_to_the_bit() -> None:
    motions = swing(2e-3 * np.arange(200), 1e-3, 5e-3, 1e-3)
    surrogate = Surrogate(random_network(1), TANK, 1e-6, 1.2)
    state = surrogate.start(motions[0])
    found = [state.answer[:3]]
    for a, b in itertools.pairwise(motions):
        state = surrogate.advance(state, a, b, 2e-3)
        found.append(state.answer[:3])
    assert np.allclose(found, surrogate.run(motions, 2e-3), rtol=1e-11, atol=1e-11)


def test_a_tank_in_the_mirror() -> None:
    """Seen from behind, surge, pitch, force along and moment change sign, for any weights (1e-12: rounding of sums)."""
    tank = replace(TANK, x=0.0, y=0.0)
    surrogate = Surrogate(random_network(5), tank, 1e-6, 1.2)
    motions = swing(2e-3 * np.arange(300), 1e-3, 8e-3, 1e-3)
    signs = np.array([1, 1, 1, -1, -1, -1, -1, -1, -1.0])
    here, there = surrogate.run(motions, 2e-3), surrogate.run(motions * signs, 2e-3)
    assert np.max(np.abs(here - there * [-1, 1, -1]) / np.abs(here).max(axis=0)) < 1e-11
    assert (MIRROR**2 == 1.0).all()


def test_bounded_motion_gives_bounded_loads_over_a_million_steps() -> None:
    """Any weights: nothing is fed back. Band-limited noise of two g, 10⁶ steps of 2 ms in ten parts of one march."""
    r = np.random.default_rng(0)
    surrogate = Surrogate(random_network(7, size=10.0), TANK, 1e-6, 1.2)
    n = 100_000
    spectrum = np.fft.rfft(r.normal(size=n))
    omega = 2.0 * np.pi * np.fft.rfftfreq(n, 2e-3)
    spectrum[(omega < 20.0) | (omega > 120.0)] = 0.0
    motions = np.zeros((n, 9))
    for column, size in ((0, 3e-3), (3, 0.03)):
        q = [np.fft.irfft((1j * omega) ** k * spectrum, n) for k in range(3)]
        motions[:, column : column + 3] = (size / np.abs(q[0]).max() * np.array(q)).T
    state = surrogate.start(motions[0])
    peaks = []
    for _ in range(10):
        state, loads = surrogate.march(state, motions, 2e-3)
        peaks.append(np.abs(loads).max(axis=0))
    peaks = np.array(peaks)
    assert np.isfinite(peaks).all()
    # the first part starts from rest; the slowest wave has died out within two per cent in the second
    assert (peaks[2:] <= 1.02 * peaks[1]).all()


def test_scale_models() -> None:
    """Four times the size: the same motion over lengths, twice as slow, gives loads over weight that are the same."""
    big = Tank(2.0, 0.6, 1.0, 0.5, 0.0, 0.0, 1000.0, 9.81)
    small = replace(big, length=0.5, height=0.15)
    motions = swing(2e-3 * np.arange(300), 1e-3, 8e-3, 1e-3)
    scaled = motions.copy()
    scaled[:, [0, 6]] *= 4.0
    scaled[:, [1, 7]] *= 2.0
    scaled[:, 4] /= 2.0
    scaled[:, 5] /= 4.0
    network = random_network(9)
    # without friction: the viscosity of the liquid does not scale
    one = Surrogate(network, small, 0.0, 1.2).run(motions, 2e-3)
    other = Surrogate(network, big, 0.0, 1.2).run(scaled, 4e-3)
    assert other / np.array([16.0, 16.0, 64.0]) == pytest.approx(one, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize(
    ("tank", "says"),
    [
        (replace(TANK, fill_level=0.3), "depth/length 0.15"),
        (replace(TANK, length=0.8), "depth/length"),
        (replace(TANK, height=0.1, fill_level=0.75), "roof"),
    ],
)
def test_tanks_that_a_network_does_not_know_are_refused(tank: Tank, says: str) -> None:
    with pytest.raises(NetworkError, match=says) as caught:
        Surrogate(random_network(0), tank, 1e-6, 1.2)
    assert "Remedy" in str(caught.value)
    Surrogate(untrained("bilinear", True), tank, 1e-6, 1.2)  # equations know every tank


def test_the_offset_is_exact() -> None:
    """A tank behind the axis is a tank on the axis with the motion of its own place, moments shifted."""
    far, near = TANK, replace(TANK, x=0.0, y=0.0)
    motions = swing(2e-3 * np.arange(300), 1e-3, 0.0, 1e-3)  # plunge and surge: no rotation, the motion is the same
    a = Surrogate(random_network(2), far, 1e-6, 1.2).run(motions, 2e-3)
    b = Surrogate(random_network(2), near, 1e-6, 1.2).run(motions, 2e-3)
    assert a[:, :2] == pytest.approx(b[:, :2], rel=1e-12, abs=1e-10)
    assert a[:, 2] == pytest.approx(b[:, 2] + far.y * b[:, 0] - far.x * b[:, 1], rel=1e-12, abs=1e-9)


def test_the_offset_is_exact_in_rotation_too() -> None:
    """Plunge and pitch of the axis carried to the tank (excitation.carried, from kinematics alone): the same forces, and the
    moment about the axis (1e-7 of the loads: between samples the quintics through the two motions differ)."""
    far, near = replace(TANK, y=0.0), replace(TANK, x=0.0, y=0.0)
    motions = swing(2e-3 * np.arange(300), 1e-3, 4e-3)
    moved = carried(Motion("m", "m", 0, {}, 2e-3 * np.arange(300), motions), far.x).motions
    a = Surrogate(random_network(2), far, 1e-6, 1.2).run(motions, 2e-3)
    b = Surrogate(random_network(2), near, 1e-6, 1.2).run(moved, 2e-3)
    arm = far.x * np.cos(motions[:, 3]), -far.x * np.sin(motions[:, 3])  # of the tank from the axis, aft and up
    scale = np.abs(b).max()
    assert np.abs(a[:, :2] - b[:, :2]).max() < 1e-7 * scale
    assert np.abs(a[:, 2] - (b[:, 2] + arm[1] * b[:, 0] - arm[0] * b[:, 1])).max() < 1e-7 * scale


def test_axes_there_and_back() -> None:
    r = np.random.default_rng(4)
    for tilt in (0.0, 0.3, -1.2):
        own = r.normal(size=3)
        fx, fy, m = to_load(own, TANK, tilt)
        assert from_load(*np.array([[fx], [fy], [m]]), TANK, np.array([tilt]))[0] == pytest.approx(own, rel=1e-12)


def test_a_network_in_a_file(tmp_path: Path) -> None:
    network = random_network(11)
    network.save(tmp_path / "n.npz")
    again = load(tmp_path / "n.npz")
    motions = swing(2e-3 * np.arange(100))
    loads = [Surrogate(n, TANK, 1e-6, 1.2).run(motions, 2e-3) for n in (network, again)]
    assert (loads[0] == loads[1]).all()
    (tmp_path / "bad.npz").write_bytes(b"nothing")
    with pytest.raises(NetworkError, match="is no network"):
        load(tmp_path / "bad.npz")
    broken = replace(network, weights=network.weights._replace(odd=np.full((ODD, 2), np.nan)))
    broken.save(tmp_path / "nan.npz")
    with pytest.raises(NetworkError, match="not finite"):
        load(tmp_path / "nan.npz")
    for field, value in (("reach", np.zeros(SPACE)), ("reach", np.ones(2)), ("shape", float("nan")), ("room", -1.0)):
        replace(network, **{field: value}).save(tmp_path / "odd.npz")
        with pytest.raises(NetworkError, match="make no sense"):
            load(tmp_path / "odd.npz")
    with pytest.raises(NetworkError, match="cannot be read"):
        load(tmp_path / "none.npz")


def test_a_table_holds_what_the_base_leaves() -> None:
    motions = swing(2e-3 * np.arange(100))
    base = Surrogate(untrained("bilinear", True), TANK, 1e-6, 1.2)
    table = tabulate(base, Record(2e-3, motions, base.run(motions, 2e-3)))
    assert np.abs(table.rest).max() < 1e-12
    assert (table.odd.shape, table.even.shape, table.space.shape) == ((100, ODD), (100, EVEN), (100, SPACE))
    assert isinstance(base.start(motions[0]), State) and base.start(motions[0]).w.shape == (MODES + SECOND,)
