"""Growth rate as a function of amplitude, from the envelopes of free motions, and the limit cycles that follow from it.

One march passes through a range of amplitudes: at each of them its envelope grows or decays at the rate that the motion has
there. Where the rate falls through zero with the amplitude there is a stable limit cycle, where it rises through zero an unstable
one: motions above it run away.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

SKIPPED = 1.5  # periods after the release that still hold other modes
BIN = 0.12  # of ln amplitude
SURE, QUIET = 3.0, 1e-5  # standard errors, and growth rate over omega_alpha, above which a rate has a sign
LAST, SETTLED = 8, 0.01  # windows over which a settled motion's amplitude stays within this share
FEWEST = 5  # windows without which a motion tells nothing


@dataclass(frozen=True)
class Envelope:
    """Amplitude (of the unit of the motion) and growth rate over omega_alpha there, each (n,)."""

    amplitude: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class Cycle:
    """A limit cycle: its amplitude with standard deviation, whether motions near it come to it, and dσ/d ln A there."""

    amplitude: float
    std: float
    stable: bool
    slope: float


def envelope(tau: np.ndarray, motion: np.ndarray, frequency: float) -> Envelope:
    """Of a free motion (n,) sampled at equidistant `tau` (n,), from its release on, that oscillates at about `frequency`.

    Amplitudes by least squares over windows of a period, half a period apart; empty for fewer than FEWEST windows."""
    none = Envelope(np.zeros(0), np.zeros(0))
    if not frequency > 0.0 or tau.size < 3:
        return none
    a_period = 2.0 * math.pi / frequency / float(tau[1] - tau[0])
    width, stride, begin = round(a_period), max(1, round(0.5 * a_period)), round(SKIPPED * a_period)
    starts = np.arange(begin, tau.size - width + 1, stride)
    if width < 8 or starts.size < FEWEST:
        return none
    sizes = np.empty(starts.size)
    for k, i in enumerate(starts):
        t = tau[i : i + width] - tau[i]
        design = np.column_stack([np.ones(width), t, np.cos(frequency * t), np.sin(frequency * t)])
        c = np.linalg.lstsq(design, motion[i : i + width], rcond=None)[0]
        sizes[k] = math.hypot(c[2], c[3])
    if not np.all(sizes > 0.0):
        return none
    logs, step = np.log(sizes), stride * float(tau[1] - tau[0])
    # two windows to either side are a period away: what a second frequency adds has turned once
    return Envelope(sizes[2:-2], (logs[4:] - logs[:-4]) / (4.0 * step))


def curve(found: Sequence[Envelope]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Amplitude, median rate and standard error in bins of ln amplitude that are BIN wide, rising. Shapes: (n,)."""
    whole = [e for e in found if e.amplitude.size]
    if not whole:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    amplitude, rate = np.concatenate([e.amplitude for e in whole]), np.concatenate([e.rate for e in whole])
    bins = np.floor(np.log(amplitude) / BIN).astype(int)
    members = [rate[bins == b] for b in np.unique(bins)]
    spreads = np.array([1.4826 * float(np.median(np.abs(m - np.median(m)))) for m in members])
    several = spreads[[m.size >= 3 for m in members]]
    least = float(np.median(several)) if several.size else 0.0  # one window alone does not tell how far it may be off
    sizes = [math.exp(float(np.mean(np.log(amplitude[bins == b])))) for b in np.unique(bins)]
    rows = [
        (size, float(np.median(m)), max(spread, least if m.size < 3 else 0.0) / math.sqrt(m.size))
        for size, m, spread in zip(sizes, members, spreads, strict=True)
    ]
    return tuple(np.array(column) for column in zip(*rows, strict=True))  # type: ignore[return-value]


def cycles(found: Sequence[Envelope]) -> list[Cycle]:
    """The limit cycles that the motions `found` show, by rising amplitude: where the rate changes its sign, and where a motion
    has settled."""
    amplitude, rate, error = curve(found)
    sure = np.flatnonzero(np.abs(rate) > np.maximum(SURE * error, QUIET))
    result: list[Cycle] = []
    for i, j in itertools.pairwise(sure):
        if rate[i] * rate[j] > 0.0:
            continue
        x, y = np.log(amplitude[[i, j]]), rate[[i, j]]
        slope = float((y[1] - y[0]) / (x[1] - x[0]))
        between = np.log(amplitude[i + 1 : j])  # bins in which nothing grows or decays
        place = float(np.mean(between)) if between.size else float(x[0] - y[0] / slope)
        doubt = max(float(np.max(error[[i, j]])) / abs(slope), 0.25 * float(x[1] - x[0]))
        result.append(Cycle(math.exp(place), math.exp(place) * doubt, slope < 0.0, slope))
    for e in found:
        size = _settled(e)
        if size and all(abs(math.log(c.amplitude / size)) > 2.0 * BIN for c in result):
            last = np.log(e.amplitude)
            slope = float((e.rate[-1] - e.rate[0]) / (last[-1] - last[0])) if last[-1] != last[0] else 0.0
            result.append(Cycle(size, 0.5 * float(np.ptp(e.amplitude[-LAST:])) + SETTLED * size, True, slope))
    return sorted(result, key=lambda c: c.amplitude)


def _settled(e: Envelope) -> float:
    """The amplitude at which a motion stays after it had come from another one; 0 else."""
    if e.amplitude.size < 2 * LAST or float(np.ptp(np.log(e.amplitude[-LAST:]))) > SETTLED:
        return 0.0
    size = float(np.mean(e.amplitude[-LAST:]))
    return size if abs(math.log(size / e.amplitude[0])) > BIN else 0.0
