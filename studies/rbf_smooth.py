"""What output feedback costs: the paper's network on smooth motions, sampled well, one step ahead and in free run.

`python -m studies.rbf_smooth [--records FOLDER] [--csv FILE]`. Band-limited random plunge and pitch (35 to 105 rad/s), 4 s each:
four records to fit, one to choose size, spread and ridge by, two to judge. Delays 5 and 3; inputs are the motion (h/l, alpha) or
the drive that the liquid feels. Beside it linear feedback, and what needs no training: slosh_ems, the bilinear equations.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from aeroslosh.fmus.slosh_rbf.feedback import INPUTS, Feedback, columns
from aeroslosh.fmus.slosh_rbf.memory import Array
from aeroslosh.fmus.slosh_rbf.network import untrained
from aeroslosh.fmus.slosh_rbf.surrogate import Surrogate, inputs
from aeroslosh.fmus.slosh_rbf.training.dataset import Planned, generate, read
from aeroslosh.fmus.slosh_rbf.training.dataset import Record as Found
from aeroslosh.fmus.slosh_rbf.training.excitation import aprbs
from aeroslosh.fmus.slosh_rbf.training.feedback_fit import fit
from aeroslosh.fmus.slosh_rbf.training.intensity import intensity
from aeroslosh.fmus.slosh_rbf.training.plan import TANK, settings
from aeroslosh.fmus.slosh_rbf.training.signals import instants
from aeroslosh.master.paper.surrogate import DELAYS, FINE, ROOM, SHAPE, in_tank, nrmse, predictions, search
from aeroslosh.master.training.tank_records import LINEAR_LOADS, Drive

from .rbf_experiment import GAS, VISCOSITY, arguments, show, write

LEVELS = {"A": (0.0005, 0.2), "B": (0.002, 0.5)}
"""Peaks of plunge [m] and pitch [deg]."""
DURATION, RAMP = 4.0, 0.2
STRIDES = (1, 10)
"""Samples of 2 ms and, as the paper's, of 20 ms."""
TRAINING, CHECK, TEST = slice(0, 4), slice(4, 5), slice(5, 7)
SIZES = (30, 100)
MODES = ("one step", "free run")
Pair = tuple[Array, Array]


@dataclass(frozen=True)
class Samples:
    """A record every 2 ms: inputs by kind (n, columns), whole loads (n, 3) in tank axes over m_T g and m_T g l by the two-phase
    solver, by slosh_ems and by the bilinear equations."""

    inputs: dict[str, Array]
    loads: Array
    linear: Array
    bilinear: Array


class Row(NamedTuple):
    """NRMSE [%] of F_x, F_y, M_z over the test records (after the rise from rest), mean of the records; D: their largest."""

    level: str
    D: float
    step: float
    inputs: str
    model: str
    mode: str
    F_x: float
    F_y: float
    M_z: float


def plan(level: str) -> list[Planned]:
    """Seven records of a level."""
    h, degrees = LEVELS[level]
    times = instants(DURATION, FINE)
    motions = [aprbs(50 + k, times, h, math.radians(degrees), ramp=RAMP) for k in range(TEST.stop)]
    return [Planned(replace(m, name=f"smooth_{level}_{m.seed}"), settings(TANK), "paper") for m in motions]


def sampled(record: Found, linear: Drive) -> Samples:
    """Inputs and loads of a record, with the models that need no training."""
    motion = record.motion
    base = Surrogate(untrained("bilinear", True), TANK, VISCOSITY, GAS)
    ems = linear(settings(TANK, None), motion.times, motion.motions)
    drives = inputs(base, motion.motions)
    return Samples(
        {kind: columns(kind, drives, motion.motions, TANK.length) for kind in INPUTS},
        in_tank(np.stack([record.loads[n] for n in LINEAR_LOADS], axis=1), motion),
        in_tank(np.stack([ems[n] for n in LINEAR_LOADS], axis=1), motion),
        in_tank(base.run(motion.motions, FINE), motion),
    )


def networks(kind: str, pairs: list[Pair], stride: int) -> dict[tuple[str, str], Feedback]:
    """Networks by model and mode: of Gaussians, and linear; size, spread and ridge by the record CHECK."""
    width = pairs[0][0].shape[1] * (DELAYS[0] + 1) + pairs[0][1].shape[1] * DELAYS[1]
    step = stride * FINE / math.sqrt(TANK.length / TANK.gravity)

    def make(centres: int, factor: float, ridge: float) -> Feedback:
        return fit(kind, kind, DELAYS, step, pairs[TRAINING], SHAPE, ROOM, centres, factor * math.sqrt(width), ridge)

    def errors(net: Feedback) -> dict[str, float]:
        return {mode: float(np.mean(error(net, mode, pairs[CHECK], stride))) for mode in MODES}

    return {
        (model, mode): make(*best)
        for model, sizes in (("rbf", SIZES), ("arx", (0,)))
        for mode, best in search(make, errors, sizes).items()
    }


def error(net: Feedback, mode: str, pairs: list[Pair], stride: int) -> Array:
    """NRMSE [%] of a network, mean of records; infinite for a free run whose own feedback grows. Shape: (3,)."""
    if mode == "free run" and net.radius() >= 1.0:
        return np.full(3, math.inf)
    return apart([predictions(net, u, y)[mode] for u, y in pairs], [y for _, y in pairs], stride)


def apart(found: list[Array], true: list[Array], stride: int) -> Array:
    """NRMSE [%] after the rise from rest, mean of records. Shape: (3,)."""
    first = round(RAMP / FINE / stride)
    return np.asarray(np.mean([nrmse(a[first:], b[first:]) for a, b in zip(found, true, strict=True)], axis=0))


def study(level: str, samples: list[Samples], most: float) -> list[Row]:
    """Rows of a level, whose largest D is `most`."""
    rows = []

    def add(stride: int, kind: str, model: str, mode: str, errors: Array) -> None:
        rows.append(Row(level, most, stride * FINE, kind, model, mode, *(float(e) for e in errors)))

    for stride in STRIDES:
        thin = slice(None, None, stride)
        for kind in INPUTS:
            pairs = [(np.ascontiguousarray(s.inputs[kind][thin]), np.ascontiguousarray(s.loads[thin])) for s in samples]
            for (model, mode), net in networks(kind, pairs, stride).items():
                add(stride, kind, model, mode, error(net, mode, pairs[TEST], stride))
        true = [s.loads[thin] for s in samples[TEST]]
        add(stride, "none", "last load", "one step", apart([np.vstack([y[:1], y[:-1]]) for y in true], true, stride))
        add(stride, "motion", "slosh_ems", "free run", apart([s.linear[thin] for s in samples[TEST]], true, stride))
        add(stride, "motion", "bilinear", "free run", apart([s.bilinear[thin] for s in samples[TEST]], true, stride))
    return rows


def main() -> None:
    """Records, networks, table, data."""
    options = arguments().parse_args()
    drive, linear = Drive.of(options.fmus / "slosh_vof.fmu"), Drive.of(options.fmus / "slosh_ems.fmu", LINEAR_LOADS)
    rows = []
    for level in LEVELS:
        entries = plan(level)
        paths = generate(entries, options.records / f"smooth_{level}", drive, drive.model, progress=show)
        most = max(float(intensity(entry.motion.motions, TANK)[-1]) for entry in entries)
        rows += study(level, [sampled(read(path), linear) for path in paths], most)
    print("| level (D) | step | inputs | model | mode | F_x | F_y | M_z |\n|---|---|---|---|---|---|---|---|")
    for r in rows:
        words = f"{r.level} ({r.D:.2f}) | {1e3 * r.step:g} ms | {r.inputs} | {r.model} | {r.mode}"
        print(f"| {words} | {r.F_x:.3g} | {r.F_y:.3g} | {r.M_z:.3g} |".replace("inf", "grows"))
    if options.csv:
        write(options.csv, rows, Row._fields)


if __name__ == "__main__":
    main()
