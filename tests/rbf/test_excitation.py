"""Excitations: positions, rates and accelerations belong together, energy lies where it is asked for, seeds decide everything."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import make_interp_spline

from aeroslosh.fmus.slosh_rbf.training.excitation import (
    ExcitationError,
    Mode,
    Motion,
    aprbs,
    aprbs_raw,
    burst,
    carried,
    chirp,
    multisine,
    released,
    sine,
)  # fmt: skip
from aeroslosh.fmus.slosh_rbf.training.intensity import balanced, effective_gravity, intensity, scaled_to
from aeroslosh.fmus.slosh_rbf.training.plan import SHORT, standard
from aeroslosh.fmus.slosh_rbf.training.signals import Array, instants
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion, body_force

TIMES = instants(4.0, 1e-3)
TANK = Tank(0.5, 0.15)
PEAKS = (1e-3, 4e-3, 5e-4)
MODES = Mode(45.0, 0.4, 0.3, 0.2), Mode(90.0, -3.0, -0.4)

SMOOTH: dict[str, Callable[[Array], Motion]] = {
    "aprbs": lambda t: aprbs(1, t, *PEAKS),
    "schroeder": lambda t: multisine(1, t, *PEAKS),
    "random": lambda t: multisine(1, t, *PEAKS, phases="random"),
    "burst": lambda t: burst(1, t, *PEAKS),
    "chirp": lambda t: chirp(t, *PEAKS, phase=0.7),
    "sine": lambda t: sine(t, 70.0, *PEAKS, phase=0.7),
    "growing": lambda t: sine(t, 70.0, *PEAKS, growth=1.5),
    "decaying": lambda t: sine(t, 70.0, *PEAKS, growth=-1.5),
    "released": lambda t: released(t, 4e-3, 60.0, *MODES),
    "carried": lambda t: carried(released(t, 4e-3, 60.0, *MODES), 1.8, 0.1),
    "smoothed": lambda t: aprbs_raw(1, t, 1e-3, 4e-3, smooth=0.04),
}


def spectrum(signal: Array, step: float) -> tuple[Array, Array]:
    """Frequencies [rad/s] and energy in each, as a share of all."""
    energy = np.abs(np.fft.rfft((signal - signal.mean()) * np.hanning(signal.size))) ** 2
    return 2.0 * np.pi * np.fft.rfftfreq(signal.size, step), energy / energy.sum()


def share(signal: Array, low: float, high: float, step: float = 1e-3) -> float:
    omega, energy = spectrum(signal, step)
    return float(energy[(omega >= low) & (omega <= high)].sum())


@pytest.mark.parametrize("kind", SMOOTH)
def test_rates_and_accelerations_are_derivatives(kind: str) -> None:
    fine = instants(4.0, 2.5e-4)
    motion = SMOOTH[kind](fine)
    inner = slice(20, -20)
    for column in (0, 3, 6):
        value, rate, acceleration = motion.motions[:, column : column + 3].T
        if not np.any(value):
            continue
        spline = make_interp_spline(fine, value, 5)
        for order, wanted, tolerance in ((1, rate, 1e-6), (2, acceleration, 3e-4)):
            gap = np.abs(spline.derivative(order)(fine) - wanted)[inner]
            assert gap.max() < tolerance * np.abs(wanted).max(), (column, order)


@pytest.mark.parametrize("kind", [kind for kind in SMOOTH if kind != "smoothed"])
def test_starts_from_rest(kind: str) -> None:
    motion = SMOOTH[kind](TIMES)
    largest = np.abs(motion.motions).max(axis=0)
    assert np.all(np.abs(motion.motions[0]) <= 1e-12 * largest)
    # nor does it start with a blow: the second sample is as good as at rest
    assert np.all(np.abs(motion.motions[1, 2::3]) <= 0.02 * largest[2::3])


def test_peaks_are_those_asked_for() -> None:
    for kind in ("aprbs", "schroeder", "random", "burst", "chirp", "sine", "growing", "decaying"):
        motion = SMOOTH[kind](TIMES)
        np.testing.assert_allclose(np.abs(motion.motions[:, ::3]).max(axis=0), PEAKS, rtol=1e-12)
        assert [motion.parameters[name] for name in ("h", "alpha", "x")] == list(PEAKS)


@pytest.mark.parametrize("make", [aprbs, burst, multisine, aprbs_raw])
def test_the_seed_decides(make: Callable[..., Motion]) -> None:
    first, again, other = (make(seed, TIMES, 1e-3, 1e-2) for seed in (3, 3, 4))
    assert np.array_equal(first.motions, again.motions)
    assert not np.allclose(first.motions[:, 3], other.motions[:, 3], atol=1e-3)
    # streams of their own: plunge and pitch differ, and pitch is the same without plunge
    h, alpha = first.motions[:, 0] / 1e-3, first.motions[:, 3] / 1e-2
    assert abs(np.corrcoef(h, alpha)[0, 1]) < 0.5
    if make is not multisine:  # which deals its frequencies to those that move
        np.testing.assert_allclose(make(3, TIMES, 0.0, 1e-2).motions[:, 3:6], first.motions[:, 3:6], rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize("kind", SMOOTH)
def test_the_step_does_not_change_the_motion(kind: str) -> None:
    fine, coarse = SMOOTH[kind](TIMES), SMOOTH[kind](instants(4.0, 4e-3))
    assert coarse.motions.shape == (1001, 9)
    # peaks are taken at the instants: between coarse ones the motion may go higher
    scale = np.abs(fine.motions).max(axis=0) + 1e-30
    assert np.abs((fine.every(4).motions - coarse.motions) / scale).max() < 0.03


def test_aprbs_lies_in_its_band() -> None:
    motion = aprbs(5, TIMES, 1e-3, 1e-2, low=35.0, high=105.0)
    for column in (0, 3):
        assert share(motion.motions[:, column], 30.0, 115.0) > 0.93
        assert share(motion.motions[:, column + 2], 30.0, 125.0) > 0.97
        assert share(motion.motions[:, column + 2], 210.0, np.inf) < 1e-4
        # nowhere empty: each of seven parts of the band has some of it
        edges = np.linspace(35.0, 105.0, 8)
        assert min(share(motion.motions[:, column], a, b) for a, b in pairwise(edges)) > 0.01
    low = aprbs(5, TIMES, 1e-3, low=0.0, high=20.0)
    assert share(low.motions[:, 0], 0.0, 22.0) > 0.98


def test_chirp_and_multisine_fill_the_band() -> None:
    for motion in (chirp(TIMES, 1e-3, 1e-3), multisine(2, TIMES, 1e-3, 1e-3)):
        accelerations = motion.motions[:, 5]
        assert share(accelerations, 33.0, 107.0) > 0.99
        assert 0.3 < share(accelerations, 35.0, 70.0) < 0.7
    both = multisine(2, TIMES, 1e-3, 1e-3, ramp=0.0)
    h, alpha = (np.abs(np.fft.rfft(both.motions[:-1, column])) for column in (0, 3))
    lines = slice(23, 67)
    assert np.all((h[lines] > 1e-6 * h.max()) != (alpha[lines] > 1e-6 * alpha.max()))  # every line in one of them


def test_schroeder_phases_are_low_peaked() -> None:
    def crest(phases: str, seed: int) -> float:
        q = multisine(seed, TIMES, alpha=1.0, phases=phases, power=0.0, ramp=0.0).motions[:, 3]
        return float(np.abs(q).max() / np.sqrt(np.mean(q**2)))

    assert crest("schroeder", 1) < 1.9
    assert crest("schroeder", 1) < 0.8 * np.mean([crest("random", seed) for seed in range(5)])


def test_raw_aprbs_is_the_papers() -> None:
    """Levels change at multiples of N samples alone, half of the plateaus keep theirs, the spectrum is that of the theory."""
    times = instants(800.0, 0.02)
    motion = aprbs_raw(1, times, 1.0, hold=2, keep=0.5)
    jumps = np.flatnonzero(np.diff(motion.motions[:, 0])) + 1
    assert np.all(jumps % 2 == 0)
    assert abs(jumps.size / 20000 - 0.5) < 0.02
    assert not np.any(motion.motions[:, 1:3])
    # power of the plateaus kept with probability p: (1 − p²)/(1 − 2 p cos(omega T) + p²), by averages over 80 parts
    power = np.mean(np.abs(np.fft.rfft(motion.motions[:-1:2, 0].reshape(80, 250) * np.hanning(250), axis=1)) ** 2, axis=0)
    angle = np.linspace(0.0, np.pi, power.size)
    theory = (1.0 - 0.25) / (1.0 - np.cos(angle) + 0.25)
    ratio = (power / theory)[2:]
    np.testing.assert_allclose(ratio / ratio.mean(), 1.0, atol=0.5)
    np.testing.assert_allclose(ratio[:40].mean() / ratio[-40:].mean(), 1.0, atol=0.15)


def test_smoothing_joins_the_same_levels() -> None:
    fine = instants(2.0, 1e-3)
    raw, smooth = aprbs_raw(1, fine, 1.0), aprbs_raw(1, fine, 1.0, smooth=0.03)
    settled = np.arange(fine.size) % 40 >= 30
    np.testing.assert_allclose(smooth.motions[settled, 0], raw.motions[settled, 0], atol=1e-9)
    assert np.isfinite(smooth.motions).all() and np.abs(smooth.motions[:, 2]).max() > 1.0


def test_sine_grows_and_leads() -> None:
    motion = sine(TIMES, 60.0, 1.0, 1.0, phase=0.7, growth=1.2)
    t = TIMES[2000:]
    h, alpha = motion.motions[2000:, 0], motion.motions[2000:, 3]
    basis = np.exp(1.2 * t)[:, None] * np.stack([np.sin(60.0 * t), np.cos(60.0 * t)], axis=1)
    (a, b), (c, d) = (np.linalg.lstsq(basis, q, rcond=None)[0] for q in (h, alpha))
    np.testing.assert_allclose(np.linalg.norm(basis @ [a, b] - h), 0.0, atol=1e-10)
    np.testing.assert_allclose(np.arctan2(b, a) - np.arctan2(d, c), 0.7, rtol=1e-9)


def test_released_follows_the_protocol() -> None:
    """Forced pitch as the structure's (plunge at rest), then two modes: the free part satisfies their fourth-order recursion."""
    motion = released(TIMES, 4e-3, 60.0, *MODES, cycles=2.0)
    end, period = 4.0 * np.pi / 60.0, 2.0 * np.pi / 60.0
    t = motion.times
    forced = (t > period) & (t < end - 0.13 * period)
    np.testing.assert_allclose(motion.motions[forced, 3], 4e-3 * np.sin(60.0 * t[forced]), atol=1e-15)
    assert not np.any(motion.motions[forced, 0])
    free = t > end + 0.13 * period
    rates = np.array([complex(m.growth, m.frequency) for m in MODES])
    roots = np.exp(1e-3 * np.concatenate([rates, rates.conj()]))
    for column in (0, 3):
        q = motion.motions[free, column]
        assert np.abs(np.convolve(q, np.poly(roots).real, mode="valid")).max() < 1e-9 * np.abs(q).max()


@pytest.mark.parametrize("ratio", [0.3, 0.1, 1.0, 1e-3, 1.0 / 3.0, 0.0])
@pytest.mark.parametrize("apart", [0.0, 1e-15, 1e-10])
def test_two_modes_that_are_one_cannot_be_released(ratio: float, apart: float) -> None:
    """Whatever a solver's rounding makes of a matrix that is singular, or nearly."""
    mode = Mode(45.0, 0.4, ratio, 0.2)
    other = mode._replace(ratio=ratio * (1.0 + apart), frequency=mode.frequency * (1.0 + apart))
    with pytest.raises(ExcitationError, match=r"the same, or nearly. Remedy"):
        released(TIMES, 4e-3, 60.0, mode, other)


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_modes_of_any_size_of_plunge_are_two(scale: float) -> None:
    motion = released(TIMES, 4e-3, 60.0, *(mode._replace(ratio=scale * mode.ratio) for mode in MODES))
    plain = released(TIMES, 4e-3, 60.0, *MODES)
    np.testing.assert_allclose(motion.motions[:, :3], scale * plain.motions[:, :3], atol=1e-9 * scale)


def test_carried_is_the_motion_of_the_point() -> None:
    """A tank behind the axis feels what a tank on an axis at its place feels."""
    motion = aprbs(1, TIMES, 1e-2, 0.1, 1e-2)
    there = carried(motion, 1.8, -0.2)
    for k in range(0, TIMES.size, 97):
        here = body_force(SectionMotion(*motion.motions[k]), 1.8, -0.2, 9.81)
        np.testing.assert_allclose(body_force(SectionMotion(*there.motions[k]), 0.0, 0.0, 9.81), here, rtol=1e-9, atol=1e-9)


def test_intensity_is_that_of_the_body_force() -> None:
    tank = Tank(0.5, 0.15, x=0.4, y=0.1)
    motion = aprbs(1, TIMES, 2e-3, 1e-2, 1e-3)
    upward = [body_force(SectionMotion(*row), tank.x, tank.centre_y, tank.gravity)[1] for row in motion.motions]
    np.testing.assert_allclose(effective_gravity(motion.motions, tank), -np.array(upward), rtol=1e-13)
    course = intensity(motion.motions, tank)
    assert np.all(np.diff(course) >= 0.0)
    present = np.abs(-np.array(upward) / 9.81 - 1.0) + 0.25 * np.abs(motion.motions[:, 5]) / 9.81
    np.testing.assert_allclose(course[-1], present.max(), rtol=1e-12)


@pytest.mark.parametrize("target", [1e-4, 0.05, 1.0, 4.0])
def test_scaled_to_a_wanted_intensity(target: float) -> None:
    for motion in (aprbs(1, TIMES, 2e-3, 1e-2), sine(TIMES, 50.0, alpha=0.3), released(TIMES, 4e-3, 60.0, *MODES)):
        scaled = scaled_to(motion, TANK, target)
        np.testing.assert_allclose(intensity(scaled.motions, TANK)[-1], target, rtol=1e-11)
        factor = scaled.motions[2000, 4] / motion.motions[2000, 4]
        np.testing.assert_allclose(scaled.parameters["alpha"], factor * motion.parameters["alpha"], rtol=1e-12)
    with pytest.raises(ExcitationError, match="has no D"):
        scaled_to(sine(TIMES, 50.0), TANK, target)


def test_balanced_accelerations() -> None:
    motion = balanced(aprbs(1, TIMES, 1.0, 1.0), TANK, 0.3, 0.6, 0.2)
    largest = np.abs(motion.motions[:, 2::3]).max(axis=0)
    np.testing.assert_allclose(largest, [0.3 * 9.81, 0.6 * 9.81 / 0.25, 0.0], rtol=1e-12)


@pytest.mark.parametrize(
    "make",
    [
        lambda: aprbs(1, TIMES, 1.0, low=100.0, high=50.0),
        lambda: aprbs(1, TIMES, 1.0, order=2),
        lambda: aprbs_raw(1, TIMES, 1.0, keep=1.0),
        lambda: aprbs_raw(1, TIMES, 1.0, hold=0),
        lambda: aprbs_raw(1, TIMES, 1.0, hold=1, smooth=0.03),
        lambda: multisine(1, TIMES, 1.0, phases="flat"),
        lambda: multisine(1, instants(0.2, 1e-3), 1.0, 1.0),
        lambda: burst(1, TIMES, 1.0, cycles=(5.0, 3.0)),
        lambda: sine(TIMES, 0.0, 1.0),
        lambda: replace(sine(TIMES, 5.0, 1.0), times=TIMES[:-1]),
        lambda: replace(sine(TIMES, 5.0, 1.0), times=TIMES[::-1]),
    ],
)
def test_bad_wishes_are_refused_with_a_remedy(make: Callable[[], Motion]) -> None:
    with pytest.raises(ExcitationError, match="Remedy: "):
        make()


def test_standard_plan() -> None:
    plan = standard()
    names = [entry.motion.name for entry in plan]
    assert len(set(names)) == len(names)
    coarse = [entry for entry in plan if not entry.motion.name.endswith("_fine")]
    splits = ("train", "validation", "test", "breakup")
    ours = {split: [entry for entry in coarse if entry.split == split] for split in splits}
    assert [len(entries) for entries in ours.values()] == [60, 10, 36, 10]
    reach = {split: [intensity(e.motion.motions, TANK)[-1] for e in entries] for split, entries in ours.items()}
    np.testing.assert_allclose([min(reach["train"]), max(reach["train"])], [0.05, 2.0], rtol=1e-9)
    np.testing.assert_allclose([min(reach["breakup"]), max(reach["breakup"])], [1.5, 4.0], rtol=1e-9)
    assert max(reach["test"]) < 1.3
    fine = [e for e in plan if e.motion.name.endswith("_fine")]
    assert {(e.parameters["cells_x"], e.parameters["cells_y"]) for e in fine} == {(200, 60)} and len(fine) == 46
    assert all(e.motion.times[-1] <= SHORT for e in plan if e.motion.kind == "sine")
    seeds = {split: {e.motion.seed for e in entries} - {0} for split, entries in ours.items()}
    assert not seeds["train"] & (seeds["validation"] | seeds["test"] | seeds["breakup"])
