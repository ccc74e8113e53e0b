"""Motions that excite a tank for identification: seeded, smooth, each with its rates and accelerations in closed form.

kind         what it is
aprbs_raw    the paper's: white noise, held for N samples, levels kept with a probability; positions jump (an option smooths)
aprbs        the same levels passed through a band in frequency: accelerations are finite and where they are wanted
multisine    many sines at once with interleaved frequencies, phases after Schroeder or random
burst        packets of one frequency with pauses
chirp        a sweep through a band
sine         one frequency, steady, growing or decaying
released     forced pitch cycles, then the free motion of two modes, as a flutter test has it

APRBS (amplitude-modulated pseudo-random binary signal): Nelles, Nonlinear System Identification (2001), section 17.7,
doi:10.1007/978-3-662-04323-3; levels held and kept: Norgaard et al., Neural Networks for Modelling and Control of Dynamic Systems
(2000). A jump of a position is an infinite acceleration, and it is accelerations that move the liquid: hence the smooth kinds.
Amplitudes are peaks at the given instants. The same seed gives the same motion at any step, up to that peak, and on any machine
up to rounding. Plunge, pitch and surge draw from streams of their own: leaving one out changes no other.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from . import signals as sg
from .signals import Array, product, rise

LOW, HIGH = 35.0, 105.0
"""Band of flutter motions of the sections of this project [rad/s]."""
DISTINCT = 1e-6
"""Two modes are two where the least part of a state that they can take over is above this share of the largest."""
COMMON = 3  # the random stream that all coordinates share, after those of plunge, pitch and surge


class ExcitationError(ValueError):
    """A motion that cannot be made; the text names the parameter and the remedy."""


@dataclass(frozen=True, eq=False)
class Motion:
    """A motion of the section: times (n,) [s] ascending; motions (n, 9), columns in the order of SectionMotion [m, rad, s].

    seed 0 where nothing is random. Raises ExcitationError for arrays that do not fit or are not finite."""

    name: str
    kind: str
    seed: int
    parameters: Mapping[str, Any]
    times: Array
    motions: Array

    def __post_init__(self) -> None:
        if self.times.ndim != 1 or self.motions.shape != (self.times.size, 9) or self.times.size < 2:
            shapes = f"times {self.times.shape}, motions {self.motions.shape}"
            raise ExcitationError(f"motion {self.name}: {shapes}. Remedy: times (n,), motions (n, 9), n of 2 or more")
        if not (np.all(np.isfinite(self.motions)) and np.all(np.diff(self.times) > 0.0)):
            raise ExcitationError(f"motion {self.name}: not finite, or times do not rise. Remedy: finite values at rising times")

    def scaled(self, h: float, alpha: float | None = None, x: float | None = None) -> Motion:
        """Plunge, pitch and surge times these factors (`h` alone: all times it), and the peaks in `parameters` too."""
        factors = {"h": h, "alpha": h if alpha is None else alpha, "x": h if x is None else x}
        peaks = {name: factor * self.parameters[name] for name, factor in factors.items() if name in self.parameters}
        motions = self.motions * np.repeat(list(factors.values()), 3)
        return replace(self, motions=motions, parameters={**self.parameters, **peaks})

    def every(self, stride: int) -> Motion:
        """The same motion at every so many instants."""
        return replace(self, times=self.times[::stride], motions=np.ascontiguousarray(self.motions[::stride]))


class Mode(NamedTuple):
    """A free mode: frequency [rad/s], growth [1/s], plunge over pitch [m/rad] and its lead [rad]."""

    frequency: float
    growth: float
    ratio: float
    phase: float = 0.0


def aprbs_raw(
    seed: int, times: Array, h: float = 0.0, alpha: float = 0.0, sample: float = 0.02, hold: int = 2, keep: float = 0.5,
    smooth: float = 0.0,
) -> Motion:  # fmt: skip
    """The paper's excitation (its section III B): u(t) = e(int[(t − 1)/N] + 1), t = 1, 2, …, of normal white noise e, where a
    plateau keeps the level before it with probability `keep` (its alpha, 0.5). h [m], alpha [rad]: peaks.

    sample [s] between two t, hold its N. smooth [s]: time that a change of level takes; with 0 positions jump while rates and
    accelerations say nothing of it. Sample `times` finer than `smooth`, or they will not see the change.
    """
    _check(hold >= 1 and sample > 0.0, f"hold = {hold}, sample = {sample}", "one sample or more, above 0 s")
    _check(0.0 <= keep < 1.0, f"keep = {keep}", "a probability from 0 and below 1")
    length = hold * sample
    _check(0.0 <= smooth <= length, f"smooth = {smooth} s", f"from 0 to the hold, {length:g} s: one change at a time")
    # an instant that falls on a change belongs to what comes after, whatever its last bits
    place = np.floor((times - times[0]) / length + 1e-9).astype(int)
    change = rise(times - times[0] - place * length, 0.0, smooth)
    signals = np.zeros((3, 3, times.size))
    for axis in range(2):
        levels = np.concatenate([[0.0], sg.plateaus(_stream(seed, axis), int(place[-1]) + 1, keep, normal=True)])
        jump = np.diff(levels)[place]
        signals[axis] = jump * change
        # from the level after it: a plateau's value is its level to the bit
        signals[axis, 0] = levels[place + 1] - jump * (1.0 - change[0])
    return _made("aprbs_raw", seed, times, signals, (h, alpha, 0.0), 0.0, sample=sample, hold=hold, keep=keep, smooth=smooth)


def aprbs(
    seed: int, times: Array, h: float = 0.0, alpha: float = 0.0, x: float = 0.0, low: float = LOW, high: float = HIGH,
    order: int = 6, keep: float = 0.5, ramp: float = 0.2,
) -> Motion:  # fmt: skip
    """Random levels, uniform, held for pi/high, kept with probability `keep`, through a band from `low` (0: no edge) to `high`
    [rad/s]. h, x [m], alpha [rad]: peaks. ramp [s]: rise from rest.

    order: of the filter's edges, 4 or more, run forwards and backwards (`signals.band`): no phase, twice the slope.
    Takes 30 ms for 4 s at 2 ms, and grows with the square of the length.
    """
    _check_band(low, high, open_below=True)
    _check(order >= 4, f"order = {order}", "4 or more: below, accelerations grow towards high frequencies")
    _check(0.0 <= keep < 1.0, f"keep = {keep}", "a probability from 0 and below 1")
    hold = np.pi / high
    # a period longer than the record: its end must not know its beginning
    count = int(np.ceil(1.25 * (times[-1] - times[0]) / hold)) + 8
    base = 2.0 * np.pi / (count * hold)
    omega = base * np.arange(1.0, np.ceil(4.0 * high / base))
    gain = sg.band(omega, low, high, order)
    levels = [sg.plateaus(_stream(seed, axis), count, keep, normal=False) for axis in range(3)]
    signals = sg.harmonics(times - times[0], omega, np.stack([gain * sg.stairs(omega, u, hold) for u in levels], axis=1))
    return _made("aprbs", seed, times, signals, (h, alpha, x), ramp, low=low, high=high, order=order, keep=keep)


def multisine(
    seed: int, times: Array, h: float = 0.0, alpha: float = 0.0, x: float = 0.0, low: float = LOW, high: float = HIGH,
    phases: str = "schroeder", power: float = 2.0, ramp: float = 0.2,
) -> Motion:  # fmt: skip
    """All harmonics of the record's length in a band, dealt in turn to the coordinates that move, so that their loads can be told
    apart. Amplitudes go as omega^−power (2: equal accelerations). h, x [m], alpha [rad]: peaks.

    phases: "schroeder" (low peaks; IEEE Trans. Inf. Theory 16 (1970) 85, doi:10.1109/TIT.1970.1054411) or "random".
    """
    _check_band(low, high)
    _check(phases in ("schroeder", "random"), f'phases = "{phases}"', '"schroeder" or "random"')
    base = 2.0 * np.pi / (times[-1] - times[0])
    omega = base * np.arange(np.ceil(low / base), np.floor(high / base) + 1.0)
    moving = [axis for axis, peak in enumerate((h, alpha, x)) if peak]
    _check(omega.size >= 4 * len(moving), f"{omega.size} harmonics in {low:g} to {high:g} rad/s", "a longer record or wider band")
    coefficients = np.zeros((omega.size, 3), dtype=complex)
    for place, axis in enumerate(moving):
        mine = slice(place, None, len(moving))
        lines = omega[mine]
        k = np.arange(lines.size)
        if phases == "schroeder":
            # the same phases in every coordinate would put their peaks together: each begins elsewhere in the record
            shift = _stream(seed, axis).random() * base * len(moving) * (times[-1] - times[0])
            angle = -np.pi * k * (k + 1.0) / lines.size + shift * k
        else:
            angle = 2.0 * np.pi * _stream(seed, axis).random(lines.size)
        coefficients[mine, axis] = lines**-power * np.exp(1j * angle)
    signals = sg.harmonics(times - times[0], omega, coefficients)
    return _made("multisine", seed, times, signals, (h, alpha, x), ramp, low=low, high=high, phases=phases, power=power)


def burst(
    seed: int, times: Array, h: float = 0.0, alpha: float = 0.0, x: float = 0.0, low: float = LOW, high: float = HIGH,
    cycles: tuple[float, float] = (3.0, 12.0), pause: tuple[float, float] = (0.0, 0.2),
) -> Motion:  # fmt: skip
    """Packets of one frequency, `cycles` long (least, most), with pauses [s] between them; the coordinates share frequency and
    envelope, each has its size and phase in every packet. h, x [m], alpha [rad]: peaks."""
    _check_band(low, high)
    _check(0.0 < cycles[0] <= cycles[1], f"cycles = {cycles}", "least and most, above 0")
    _check(0.0 <= pause[0] <= pause[1], f"pause = {pause}", "least and most, not below 0 s")
    common, own = _stream(seed, COMMON), [_stream(seed, axis) for axis in range(3)]
    signals = np.zeros((3, 3, times.size))
    begin = float(times[0])
    while begin < times[-1]:
        share = common.random(3)
        omega = low * (high / low) ** share[0]
        length = 2.0 * np.pi / omega * (cycles[0] + share[1] * (cycles[1] - cycles[0]))
        envelope = sg.hump(times, begin, length)
        for axis in range(3):
            size, angle = own[axis].random(2)
            carrier = sg.oscillation(times, 1j * omega, omega**-2 * np.exp(2j * np.pi * angle))
            signals[axis] += (0.1 + 0.9 * size) * product(carrier, envelope)
        begin += length + pause[0] + share[2] * (pause[1] - pause[0])
    limits = {"cycles": list(cycles), "pause": list(pause)}
    return _made("burst", seed, times, signals, (h, alpha, x), 0.0, low=low, high=high, **limits)


def chirp(
    times: Array, h: float = 0.0, alpha: float = 0.0, x: float = 0.0, start: float = LOW, end: float = HIGH, phase: float = 0.0,
    power: float = 2.0, ramp: float = 0.2,
) -> Motion:  # fmt: skip
    """A sweep from `start` to `end` [rad/s], linear in time, amplitude as omega^−power (2: equal accelerations).

    h, x [m], alpha [rad]: peaks; plunge leads pitch by `phase` [rad]. ramp [s]: rise from rest."""
    _check(start > 0.0 and end > 0.0, f"start = {start}, end = {end}", "frequencies above 0 rad/s")
    signals = np.stack([sg.sweep(times, start, end, lead, power) for lead in (phase, 0.0, 0.0)])
    return _made("chirp", 0, times, signals, (h, alpha, x), ramp, start=start, end=end, phase=phase, power=power)


def sine(
    times: Array, frequency: float, h: float = 0.0, alpha: float = 0.0, x: float = 0.0, phase: float = 0.0, growth: float = 0.0,
    ramp: float = 0.3,
) -> Motion:  # fmt: skip
    """exp(growth t) sin(frequency t) [1/s, rad/s], risen from rest in `ramp` [s]; plunge leads pitch by `phase` [rad].

    h, x [m], alpha [rad]: peaks of the record."""
    _check(frequency > 0.0, f"frequency = {frequency}", "above 0 rad/s")
    rate = complex(growth, frequency)
    signals = np.stack([sg.oscillation(times - times[0], rate, -1j * np.exp(1j * lead)) for lead in (phase, 0.0, 0.0)])
    return _made("sine", 0, times, signals, (h, alpha, x), ramp, frequency=frequency, growth=growth, phase=phase)


def released(
    times: Array, alpha: float, frequency: float, first: Mode, second: Mode, cycles: float = 2.0, blend: float = 0.125
) -> Motion:
    """Forced pitch of amplitude `alpha` [rad] at `frequency` [rad/s], risen within the first cycle, then two free modes that take
    angle, plunge and rates over from it.

    At a release the acceleration jumps; here it changes within `blend` forced periods about it, so that all stays smooth.
    Raises ExcitationError where the two modes cannot take every state over (equal modes).
    """
    _check(frequency > 0.0 and cycles > 0.0 and blend > 0.0, "frequency, cycles or blend", "values above 0")
    t, period = times - times[0], 2.0 * np.pi / frequency
    end, width = cycles * period, blend * period

    def forced(at: Array) -> Array:
        return product(alpha * sg.oscillation(at, 1j * frequency), rise(at, 0.0, min(1.0, cycles) * period))

    modes = [(complex(m.growth, m.frequency), m.ratio * np.exp(1j * m.phase)) for m in (first, second)]
    # columns: real and imaginary part of each mode's pitch; rows: plunge, pitch and their rates at the release
    columns = [np.array([s * c, c, rate * s * c, rate * c]).real for rate, s in modes for c in (1.0, 1j)]
    state = forced(np.array([end]))[:2, 0]
    system = np.stack(columns, axis=1)
    # in units of the forced motion and of the larger plunge, so that what is small is small on any machine
    plunge = max(abs(first.ratio), abs(second.ratio)) or 1.0
    scaled = system / np.array([plunge, 1.0, plunge * frequency, frequency])[:, None]
    spread = np.linalg.svd(scaled / np.linalg.norm(scaled, axis=0), compute_uv=False)
    _check(
        bool(spread[-1] > DISTINCT * spread[0]), "released: the two modes are the same, or nearly", "other frequencies or ratios"
    )
    sizes = np.linalg.solve(system, [0.0, state[0], 0.0, state[1]])
    # free modes are needed from the blend on alone; before it, a decaying one would be of any size
    late = np.maximum(t - end, -width)
    free = np.zeros((2, 3, times.size))
    for k, (rate, shape) in enumerate(modes):
        size = complex(sizes[2 * k], sizes[2 * k + 1])
        free[0] += sg.oscillation(late, rate, shape * size)
        free[1] += sg.oscillation(late, rate, size)
    over = rise(t, end - 0.5 * width, width)
    under = np.array([1.0, 0.0, 0.0])[:, None] - over
    signals = np.zeros((3, 3, times.size))
    signals[0] = product(over, free[0])
    signals[1] = product(over, free[1]) + product(under, forced(t))
    about = {
        "alpha": alpha,
        "frequency": frequency,
        "cycles": cycles,
        "blend": blend,
        "first": list(first),
        "second": list(second),
    }
    return Motion("released", "released", 0, about, times, _columns(signals))


def carried(motion: Motion, x: float, y: float = 0.0) -> Motion:
    """The motion of the wing-fixed point (x aft, y up of the axis) [m] as a motion of an axis there: what a tank with its centre
    at that point does."""
    h, alpha, surge = motion.motions.T.reshape(3, 3, -1)
    s, c, rate = np.sin(alpha[0]), np.cos(alpha[0]), alpha[1]
    sin = np.stack([s, c * rate, c * alpha[2] - s * rate**2])
    less = np.stack([c - 1.0, -s * rate, -s * alpha[2] - c * rate**2])
    moved = np.stack([h + x * sin - y * less, alpha, surge + x * less + y * sin])
    return replace(motion, motions=_columns(moved), parameters={**motion.parameters, "carried_x": x, "carried_y": y})


def _stream(seed: int, axis: int) -> np.random.Generator:
    return np.random.default_rng([seed, axis])


def _made(kind: str, seed: int, times: Array, signals: Array, peaks: tuple[float, ...], ramp: float, **about: Any) -> Motion:
    """The motion of signals (3, 3, n) that rise within `ramp` [s] and are scaled to their peaks."""
    window = rise(times, float(times[0]), ramp)
    shaped = [sg.to_peak(product(s, window), peak) if peak else np.zeros_like(s) for s, peak in zip(signals, peaks, strict=True)]
    given = dict(zip(("h", "alpha", "x"), peaks, strict=True)) | ({"ramp": ramp} if ramp else {})
    return Motion(f"{kind}_{seed}", kind, seed, given | about, times, _columns(np.stack(shaped)))


def _columns(signals: Array) -> Array:
    """(3 coordinates, 3 derivatives, n) as rows of SectionMotion, (n, 9)."""
    return np.ascontiguousarray(signals.reshape(9, -1).T)


def _check_band(low: float, high: float, open_below: bool = False) -> None:
    good = low < high and (low >= 0.0 if open_below else low > 0.0)
    _check(good, f"band from {low} to {high} rad/s", "a lower edge above 0 and below the upper one")


def _check(good: bool, what: str, remedy: str) -> None:
    if not good:
        raise ExcitationError(f"{what}. Remedy: {remedy}")
