"""The plan of records in which the surface breaks: what the violent branch of a network is trained, chosen and tested on.

split        records
train        so many (`Sizes.train`) of 1.2 to 3.6 s, D from 1.3 to 24 in equal ratios within each kind, all from a level surface
validation   the same kinds, other seeds; centres and ridge are chosen by them
test         the same kinds, other seeds and fills that no training record has; each a second time with motions scaled by
             1 + 1e-5 (name + "_twin"): what a flow that is chaotic says of itself

kind         share  what it is
flight       0.6    forced pitch cycles, release, one mode that hardly grows or decays and one that dies out, as in a flutter
march swing        0.2    one frequency, steady, growing or decaying
burst        0.1    packets of one frequency with pauses: surfaces that break again
noise        0.1    random levels through a band

Besides, train has `Sizes.marches` of the kind "march": two forced cycles and a free mode whose amplitude stays nearly what it
was, at frequencies of flutter: what the branch is for.

The tank sits `arm` behind the axis, 1.8 m (cases/paper_s.toml) in three of five: that decides how much pitch goes with a plunge.
Fills lie between 0.3 and 0.7, two of five at 0.5.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ...tank.liquid import Tank
from .dataset import Planned
from .excitation import ExcitationError, Mode, Motion, aprbs, burst, carried, released, sine
from .intensity import scaled_to
from .plan import CELLS, NOTHING, STEP, settings
from .signals import Array, instants

MARCH = "march"
MARCHES = (29.0, 59.0)
"""Frequencies [rad/s] of the marches, for a tank of half a metre: those at which the sections of cases/ flutter."""
KINDS = {"flight": 0.6, "swing": 0.2, "burst": 0.1, "noise": 0.1}
LEAST, MOST = 1.3, 24.0
"""D of the records: from where surfaces begin to break to 3° of pitch at 1.8 m."""
SLOW, FAST = 22.0, 75.0
"""Frequencies [rad/s] for a tank of half a metre: those at which sections flutter (29 to 59) and what is near."""
FARTHEST = 0.2
"""Largest amplitude of displacement [m] for a tank of half a metre: slow motions of many g are no flutter."""
LENGTHS = (1.2, 2.0, 3.6)
SHARES = (0.65, 0.25, 0.1)
"""Lengths of records [s] and how many of each."""
ARM = 1.8


@dataclass(frozen=True)
class Sizes:
    """How many records of each split (`marches`: more of train), the fills they lie between and those of the tests."""

    train: int = 280
    marches: int = 150
    validation: int = 32
    test: int = 40
    fills: tuple[float, float] = (0.3, 0.7)
    test_fills: tuple[float, ...] = (0.5, 0.5, 0.4, 0.6, 0.35)


def violent(
    tank: Tank, sizes: Sizes, step: float = STEP, cells: tuple[int, int] = CELLS, gas_density: float = 1.2,
    more: Mapping[str, Any] = NOTHING,
) -> list[Planned]:  # fmt: skip
    """The plan of the module's text for a tank's length and height (its fill is that of the records), sampled every `step` [s].

    more: further parameters of the simulation. Raises ExcitationError where a motion cannot be made."""
    tank = replace(tank, x=0.0, y=0.0)
    plan: list[Planned] = []
    for split, count, seed in (
        ("train", sizes.train, 11000),
        ("validation", sizes.validation, 12000),
        ("test", sizes.test, 13000),
    ):
        for k, (motion, fill) in enumerate(_motions(tank, split, count, seed, step, sizes)):
            own = settings(replace(tank, fill_level=fill), cells, gas_density, more)
            named = replace(motion, name=f"violent_{split}_{k + 1:03d}_{motion.kind}")
            plan.append(Planned(named, own, split))
            if split == "test":
                twin = named.scaled(1.0 + 1e-5)
                plan.append(Planned(replace(twin, name=f"{named.name}_twin"), own, split))
    for k in range(sizes.marches):
        rng = np.random.default_rng([14000, k])
        fill = _fill(rng, sizes)
        # by the golden ratio: however many there are, they lie evenly, and more of them are the same and some more
        share = (0.5 + 0.6180339887 * k) % 1.0
        motion = _march(rng, 14000 + k, tank, fill, share, instants(LENGTHS[0], step))
        own = settings(replace(tank, fill_level=fill), cells, gas_density, more)
        plan.append(Planned(replace(motion, name=f"violent_train_{MARCH}_{k + 1:03d}"), own, "train"))
    return plan


def _fill(rng: np.random.Generator, sizes: Sizes) -> float:
    return 0.5 if rng.random() < 0.4 else sizes.fills[0] + (sizes.fills[1] - sizes.fills[0]) * rng.random()


def _motions(tank: Tank, split: str, count: int, seed: int, step: float, sizes: Sizes) -> Iterator[tuple[Motion, float]]:
    """Motions as the tank feels them, and fills; kinds dealt by their shares, D in equal ratios from end to end in each."""
    kinds = np.repeat(list(KINDS), [max(1, round(share * count)) for share in KINDS.values()])
    kinds = kinds[:count] if len(kinds) >= count else np.concatenate([kinds, np.repeat("flight", count - len(kinds))])
    for kind in KINDS:
        places = np.flatnonzero(kinds == kind)
        for k in range(len(places)):
            rng = np.random.default_rng([seed, list(KINDS).index(kind), k])
            share = (k + rng.random()) / len(places)
            if split == "test":
                fill = sizes.test_fills[k % len(sizes.test_fills)]
            else:
                fill = _fill(rng, sizes)
            length = float(rng.choice(LENGTHS, p=SHARES)) if kind != "burst" else LENGTHS[1]
            yield _motion(kind, rng, seed + 100 * list(KINDS).index(kind) + k, tank, fill, share, instants(length, step)), fill


def _motion(kind: str, rng: np.random.Generator, seed: int, tank: Tank, fill: float, share: float, times: Array) -> Motion:
    """One motion of a kind, carried to the tank, its D at `share` of the way from LEAST to MOST."""
    size = tank.length / 0.5
    slow, fast = SLOW / math.sqrt(size), FAST / math.sqrt(size)
    omega = slow * (fast / slow) ** rng.random()
    arm = size * (ARM if rng.random() < 0.6 else 0.5 * 10.0 ** rng.random())
    ratio = arm * 0.1 * 20.0 ** rng.random()  # plunge over pitch [m/rad]
    lead = 2.0 * np.pi * rng.random()
    growth = float(rng.uniform(-2.5, 1.5))
    if kind == "flight":
        first = Mode(min(max(omega * rng.uniform(0.8, 1.2), slow), fast), growth, ratio, lead)
        second = Mode(omega * rng.uniform(1.4, 2.2), rng.uniform(-10.0, -3.0), -ratio * rng.uniform(0.3, 1.5), 0.5 * rng.random())
        motion = released(times, 1e-3, omega, first, second, cycles=float(rng.integers(2, 5)))
    elif kind == "swing":
        motion = sine(times, omega, 1e-3 * ratio, 1e-3, phase=lead, growth=1.5 * growth, ramp=float(rng.uniform(0.05, 0.4)))
    elif kind == "burst":
        motion = burst(seed, times, 1e-3 * ratio, 1e-3, low=slow, high=fast, pause=(0.1, 0.5))
    elif kind == "noise":
        motion = aprbs(seed, times, 1e-3 * ratio, 1e-3, low=slow, high=fast)
    else:
        raise ExcitationError(f"kind '{kind}'. Remedy: one of {', '.join(KINDS)}")
    most = min(MOST, FARTHEST * size * omega**2 / tank.gravity)
    there = replace(
        tank, fill_level=fill, x=arm
    )  # D of a tank behind the axis is that of the carried motion: the geometry stays exact
    return carried(scaled_to(replace(motion, seed=seed), there, LEAST * (most / LEAST) ** share), arm)


def _march(rng: np.random.Generator, seed: int, tank: Tank, fill: float, share: float, times: Array) -> Motion:
    """Two forced cycles of pitch, then a mode of plunge and pitch nearly in phase that hardly grows or decays."""
    size = tank.length / 0.5
    slow, fast = (omega / math.sqrt(size) for omega in MARCHES)
    omega = slow * (fast / slow) ** rng.random()
    arm, forced = size * ARM * rng.uniform(0.7, 1.4), omega * rng.uniform(0.8, 1.25)
    ratio = arm * 0.1 * 20.0 ** rng.random()
    first = Mode(omega, float(rng.uniform(-2.0, 0.8)), ratio, float(rng.uniform(-1.0, 1.0)))
    second = Mode(omega * rng.uniform(1.1, 1.8), rng.uniform(-10.0, -3.0), -ratio * rng.uniform(0.5, 1.5), 0.3 * rng.random())
    motion = released(times, 1e-3, forced, first, second)
    least, most = 2.0 * LEAST, min(0.8 * MOST, FARTHEST * size * omega**2 / tank.gravity)
    there = replace(tank, fill_level=fill, x=arm)
    target = least * (most / least) ** share
    return carried(scaled_to(replace(motion, seed=seed), there, target), arm)
