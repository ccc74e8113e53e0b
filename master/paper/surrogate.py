"""The paper's surrogate as it has it, on its excitation: records of the two-phase tank, networks with their own output fed back.

Tank of 0.5 x 0.15 m, half full; 1,000 samples of 0.02 s; networks of Gaussians and a constant with 5 delayed inputs (plunge,
pitch) and 3 delayed loads (walls, whole), fitted on samples 1 to 900 (size, spread and ridge by the last 100 of these), judged on
901 to 1000. The paper leaves open, and is taken here:

amplitude   mean of the free cycles of our own Fig. 11 (a): pitch 0.636 deg, plunge 0.0204 half chords of 0.5 m. It is the
            largest level of the signal
N           2 samples (0.04 s, near half a period of 100 rad/s), levels kept with probability 0.5
jumps       a position cannot jump: each change of level takes `smooth` seconds. "at rest": one sample, the least there is: the
            tank is at rest again at every sample; "moving": half a period of 100 rad/s, at every other sample it accelerates
axis        through the tank's centre
CFD         slosh_vof.fmu at 100 x 30 cells, told of the motion every 2 ms"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ...fmus.slosh_rbf.body import from_load
from ...fmus.slosh_rbf.feedback import Feedback, free_run, one_step, regressors
from ...fmus.slosh_rbf.memory import Array
from ...fmus.slosh_rbf.training.dataset import Planned, Record, generate, read
from ...fmus.slosh_rbf.training.excitation import Motion, aprbs_raw
from ...fmus.slosh_rbf.training.feedback_fit import fit
from ...fmus.slosh_rbf.training.plan import TANK, settings
from ...fmus.slosh_rbf.training.signals import instants
from ..training.tank_records import LINEAR_LOADS, Drive
from .work import Work

STEP, FINE = 0.02, 2e-3
SAMPLES, TRAINED, VALIDATED = 1000, 900, 100
DELAYS = (5, 3)
PITCH, PLUNGE = 0.0111, 0.0102
"""Mean amplitudes of the free cycles at Mach 0.825, V_f 0.612 [rad, m]: 0.01152, 0.01090, 0.01097, 0.01112; h/b 0.0204."""
SEEDS = (1, 2, 3)
SHAPE, ROOM = TANK.depth / TANK.length, TANK.height / TANK.length
WEIGHT = TANK.mass * TANK.gravity
LOADS = ("west", "east", "F_x", "F_y", "M_z")
WALLS, WHOLE = slice(0, 2), slice(2, 5)
SIZES = (30, 100, 300)
RIDGES = (1e-12, 1e-8, 1e-4)
FACTORS = (2.0, 8.0)
"""Spreads tried, over the root of the number of regressors."""


class Variant(NamedTuple):
    """Peaks of plunge [m] and pitch [rad], and the time that a change of level takes [s]."""

    h: float
    alpha: float
    smooth: float


VARIANTS = {
    "pitch, at rest": Variant(0.0, PITCH, STEP),
    "both, at rest": Variant(PLUNGE, PITCH, STEP),
    "both, moving": Variant(PLUNGE, PITCH, math.pi / 100.0),
    "a tenth, moving": Variant(0.1 * PLUNGE, 0.1 * PITCH, math.pi / 100.0),
}
SHOWN = ("pitch, at rest", "both, moving")
"""Those of the paper's figures here; docs/slosh_rbf_paper.md has all."""


@dataclass(frozen=True)
class Samples:
    """A record every 0.02 s: u (n, 2) = h/l, alpha; loads (n, 5) over m_T g and m_T g l, the whole ones in tank axes about the
    liquid's centre; CPU of the record [s]."""

    u: Array
    loads: Array
    cpu: float


def motion(variant: str, seed: int) -> Motion:
    """The excitation, every 2 ms."""
    v = VARIANTS[variant]
    made = aprbs_raw(seed, instants((SAMPLES - 1) * STEP, FINE), h=v.h, alpha=v.alpha, sample=STEP, smooth=v.smooth)
    return replace(made, name=f"{variant.replace(', ', '_').replace(' ', '_')}_{seed}")


def records(work: Work, variants: Iterable[str] = SHOWN) -> dict[tuple[str, int], Samples]:
    """The samples of each variant and seed; records that the shared folder does not hold yet are computed. Raises ComponentError
    where the FMU fails."""
    keys = list(itertools.product(variants, work.pick(SEEDS, SEEDS[:1])))
    drive = Drive.of(work.fmu("slosh_vof"))
    plan = [Planned(motion(*key), settings(TANK, work.pick((100, 30), (30, 16))), "paper") for key in keys]
    size = work.pick("records", "records_small")
    paths = generate(plan, work.folder(size), drive, drive.model, progress=lambda p: work.say(f"  record {p.name}"))
    return {key: sampled(read(path)) for key, path in zip(keys, paths, strict=True)}


def sampled(record: Record) -> Samples:
    """Every 0.02 s of a record."""
    every = slice(None, None, round(STEP / FINE))
    u = np.ascontiguousarray(record.motion.motions[every][:, [0, 3]] / np.array([TANK.length, 1.0]))
    return Samples(u, both(record)[every], float(record.attributes["cpu_s"]))


def both(record: Record) -> Array:
    """Wall and whole loads of a record, (n, 5)."""
    walls = np.stack([record.loads["force_west"], record.loads["force_east"]], axis=1) / WEIGHT
    return np.hstack([walls, in_tank(np.stack([record.loads[n] for n in LINEAR_LOADS], axis=1), record.motion)])


def in_tank(loads: Array, motion: Motion) -> Array:
    """Loads (n, 3) in inertial axes as `from_load` has them."""
    return from_load(loads[:, 0], loads[:, 1], loads[:, 2], TANK, motion.motions[:, 3])


def train(
    s: Samples, delays: tuple[int, int] = DELAYS, seed: int = 0, centres: int = 0, factor: float = 2.0, ridge: float = 1e-8,
    end: int = TRAINED, loads: slice = slice(None),
) -> Feedback:  # fmt: skip
    """A network of the samples up to `end`: linear, or with Gaussians of spread factor · root of the number of regressors."""
    y = s.loads[:end, loads]
    spread = factor * math.sqrt(2 * (delays[0] + 1) + y.shape[1] * delays[1])
    step = STEP / math.sqrt(TANK.length / TANK.gravity)
    return fit("paper", "motion", delays, step, [(s.u[:end], y)], SHAPE, ROOM, centres, spread, ridge, seed)


def chosen(s: Samples, seed: int, sizes: tuple[int, ...] = SIZES) -> dict[str, Feedback]:
    """The paper's network for "one step" and for "free run", its size, spread and ridge by samples 801 to 900 unseen."""
    first = TRAINED - VALIDATED
    u, y = s.u[:TRAINED], s.loads[:TRAINED]

    def make(end: int, centres: int, factor: float, ridge: float) -> Feedback:
        return train(s, DELAYS, seed, centres, factor, ridge, end)

    def errors(net: Feedback) -> dict[str, float]:
        return {mode: float(np.mean(nrmse(found[first:], y[first:]))) for mode, found in predictions(net, u, y).items()}

    return {mode: make(TRAINED, *best) for mode, best in search(lambda *a: make(first, *a), errors, sizes).items()}


def search(
    make: Callable[[int, float, float], Feedback], errors: Callable[[Feedback], dict[str, float]], sizes: tuple[int, ...]
) -> dict[str, tuple[int, float, float]]:
    """Number of Gaussians, factor of the spread, ridge with the least error, by mode."""
    best: dict[str, tuple[float, tuple[int, float, float]]] = {}
    for tried in itertools.product(sizes, FACTORS, RIDGES):
        for mode, error in errors(make(*tried)).items():
            best[mode] = min(best.get(mode, (math.inf, tried)), (error, tried))
    return {mode: tried for mode, (_, tried) in best.items()}


def predictions(net: Feedback, u: Array, y: Array) -> dict[str, Array]:
    """Loads like y (n, outputs): "one step" from the true loads before, "free run" from the inputs alone since sample 0."""
    first = max(net.delays)
    return {"one step": np.vstack([y[:first], one_step(net, regressors(u, y, net.delays))]), "free run": free_run(net, u, y[0])}


def nrmse(found: Array, true: Array) -> Array:
    """Rms error over std, of each column [%]."""
    return np.asarray(100.0 * np.sqrt(((found - true) ** 2).mean(axis=0)) / true.std(axis=0))


def percent(found: Array, true: Array) -> Array:
    """|error/load| of each sample and column [%]; its mean is the paper's measure."""
    return np.asarray(100.0 * np.abs(found / true - 1.0))


def prediction_seconds(net: Feedback, s: Samples, repeat: int = 200) -> float:
    """CPU time of a free run over samples 901 to 1000 [s]."""
    u = s.u[TRAINED:]
    free_run(net, u, s.loads[TRAINED])
    begin = time.process_time()
    for _ in range(repeat):
        free_run(net, u, s.loads[TRAINED])
    return (time.process_time() - begin) / repeat
