"""Figure 14 and Table 1: the paper's surrogate as it has it, on its excitation, in its measure; what its figures are worth.

`python -m paper.rbf_experiment [--records FOLDER] [--csv FILE] [--picture FILE]`. Tank of 0.5 x 0.15 m, half full; 1,000 samples
of 0.02 s; networks of Gaussians and a constant with 5 delayed inputs (plunge, pitch) and 3 delayed loads (walls, whole), fitted
on samples 1 to 900 (size, spread and ridge by the last 100 of these), judged on 901 to 1000.

The paper leaves open, and is taken here:
amplitude   mean of the free cycles of our own Fig. 11 (a) (`python -m paper.fig11`): pitch 0.636 deg, plunge 0.0204 half chords
            of 0.5 m. It is the largest level of the signal
N           2 samples (0.04 s, near half a period of 100 rad/s), levels kept with probability 0.5
jumps       a position cannot jump: each change of level takes `smooth` seconds. "at rest": one sample, the least there is: the
            tank is at rest again at every sample; "moving": half a period of 100 rad/s, at every other sample it accelerates
axis        through the tank's centre
CFD         slosh_vof.fmu at 100 x 30 cells, told of the motion every 2 ms; "second grid" is the same at 200 x 60
"""

from __future__ import annotations

import argparse
import csv
import itertools
import math
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aeroslosh.fmus.slosh_rbf.body import from_load
from aeroslosh.fmus.slosh_rbf.feedback import Feedback, free_run, one_step, regressors
from aeroslosh.fmus.slosh_rbf.memory import Array
from aeroslosh.fmus.slosh_rbf.network import untrained
from aeroslosh.fmus.slosh_rbf.surrogate import Surrogate
from aeroslosh.fmus.slosh_rbf.training.dataset import Planned, Progress, Record, generate, read
from aeroslosh.fmus.slosh_rbf.training.excitation import Motion, aprbs_raw
from aeroslosh.fmus.slosh_rbf.training.feedback_fit import fit
from aeroslosh.fmus.slosh_rbf.training.intensity import intensity
from aeroslosh.fmus.slosh_rbf.training.plan import FINE as FINE_CELLS
from aeroslosh.fmus.slosh_rbf.training.plan import TANK, settings
from aeroslosh.fmus.slosh_rbf.training.signals import instants
from aeroslosh.master.training.tank_records import LINEAR_LOADS, Drive

ROOT = Path(__file__).resolve().parents[1]
STEP, FINE = 0.02, 2e-3
SAMPLES, TRAINED, VALIDATED = 1000, 900, 100
DELAYS = (5, 3)
PITCH, PLUNGE = 0.0111, 0.0102
"""Mean amplitudes of the free cycles at Mach 0.825, V_f 0.612 [rad, m]: 0.01152, 0.01090, 0.01097, 0.01112; h/b 0.0204."""
SEEDS = (1, 2, 3)
SHAPE, ROOM = TANK.depth / TANK.length, TANK.height / TANK.length
WEIGHT = TANK.mass * TANK.gravity
VISCOSITY, GAS = 1e-6, 1.2
LOADS = ("west", "east", "F_x", "F_y", "M_z")
WALLS, WHOLE = slice(0, 2), slice(2, 5)
RIDGES = (1e-12, 1e-8, 1e-4)
FACTORS = (2.0, 8.0)
"""Spreads tried, over the root of the number of regressors."""
INTERFOAM = 14.3 / 3.0
"""CPU seconds of interFoam a simulated second, violent slosh (C06) on the same cells: docs/slosh_vof.md."""


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


@dataclass(frozen=True)
class Samples:
    """A record every 0.02 s: u (n, 2) = h/l, alpha; loads (n, 5) over m_T g and m_T g l, the whole ones in tank axes about the
    liquid's centre; the same by the second grid; whole loads (n, 3) by slosh_ems and by the bilinear equations; D of the motion;
    CPU of the record [s]."""

    u: Array
    loads: Array
    fine: Array
    linear: Array
    bilinear: Array
    intensity: float
    cpu: float


class Row(NamedTuple):
    """A line of the table: errors of one model and one load on samples 901 to 1000.

    percent, median, worst: of |error/load| [%]; their mean is the paper's measure. nrmse: rms error over the load's std [%].
    crossings: share [%] of the samples where the load is below a tenth of its rms, and what these add to `percent`."""

    variant: str
    seed: int
    load: str
    model: str
    mode: str
    percent: float
    median: float
    worst: float
    nrmse: float
    crossings: float
    of_crossings: float


def plan() -> list[Planned]:
    """The records of all variants and seeds, each on both grids."""
    times = instants((SAMPLES - 1) * STEP, FINE)
    entries = []
    for (variant, v), seed in itertools.product(VARIANTS.items(), SEEDS):
        motion = aprbs_raw(seed, times, h=v.h, alpha=v.alpha, sample=STEP, smooth=v.smooth)
        name = f"{variant.replace(', ', '_').replace(' ', '_')}_{seed}"
        entries.append(Planned(replace(motion, name=name), settings(TANK), "paper"))
        entries.append(Planned(replace(motion, name=f"{name}_fine"), settings(TANK, FINE_CELLS), "paper"))
    return entries


def records(folder: Path, fmus: Path) -> dict[tuple[str, int], Samples]:
    """The samples of each variant and seed; records that `folder` does not hold yet are computed."""
    drive, linear = Drive.of(fmus / "slosh_vof.fmu"), Drive.of(fmus / "slosh_ems.fmu", LINEAR_LOADS)
    found = [read(path) for path in generate(plan(), folder, drive, drive.model, progress=show)]
    keys = itertools.product(VARIANTS, SEEDS)
    return {key: sampled(*pair, linear) for key, pair in zip(keys, zip(found[::2], found[1::2], strict=True), strict=True)}


def sampled(record: Record, fine: Record, linear: Drive) -> Samples:
    """Every 0.02 s of a record, with the models that need no training driven through the same motion at its own step."""
    motion, every = record.motion, slice(None, None, round(STEP / FINE))
    surrogate = Surrogate(untrained("bilinear", True), TANK, VISCOSITY, GAS)
    ems = linear(settings(TANK, None), motion.times, motion.motions)
    return Samples(
        np.ascontiguousarray(motion.motions[every][:, [0, 3]] / np.array([TANK.length, 1.0])),
        both(record)[every],
        both(fine)[every],
        in_tank(np.stack([ems[n] for n in LINEAR_LOADS], axis=1), motion)[every],
        in_tank(surrogate.run(motion.motions, FINE), motion)[every],
        float(intensity(motion.motions, TANK)[-1]),
        float(record.attributes["cpu_s"]),
    )


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


def chosen(s: Samples, seed: int) -> dict[str, Feedback]:
    """The paper's network for "one step" and for "free run", its size, spread and ridge by samples 801 to 900 unseen."""
    first = TRAINED - VALIDATED
    u, y = s.u[:TRAINED], s.loads[:TRAINED]

    def make(end: int, centres: int, factor: float, ridge: float) -> Feedback:
        return train(s, DELAYS, seed, centres, factor, ridge, end)

    def errors(net: Feedback) -> dict[str, float]:
        return {mode: float(np.mean(nrmse(found[first:], y[first:]))) for mode, found in predictions(net, u, y).items()}

    return {mode: make(TRAINED, *best) for mode, best in search(lambda *a: make(first, *a), errors, (30, 100, 300)).items()}


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


def judge(variant: str, seed: int, model: str, mode: str, found: Array, true: Array, loads: slice = slice(None)) -> Iterator[Row]:
    """Rows of the samples given, (n, loads) both."""
    percent = 100.0 * np.abs(found / true - 1.0)
    small = np.abs(true) < 0.1 * np.sqrt((true**2).mean(axis=0))
    for i, load in enumerate(LOADS[loads]):
        p, low = percent[:, i], small[:, i]
        numbers = (p.mean(), np.median(p), p.max(), nrmse(found, true)[i], 100.0 * low.mean(), p[low].sum() / len(p))
        yield Row(variant, seed, load, model, mode, *(float(x) for x in numbers))


def compare(all_samples: dict[tuple[str, int], Samples]) -> tuple[list[Row], dict[tuple[str, int], dict[str, Feedback]], float]:
    """All rows, the networks by variant and seed, and the CPU of one training with its search [s]."""
    rows: list[Row] = []
    nets: dict[tuple[str, int], dict[str, Feedback]] = {}
    test = slice(TRAINED, None)
    begin = time.process_time()
    for (variant, seed), s in all_samples.items():
        nets[variant, seed] = chosen(s, seed)
    cpu = (time.process_time() - begin) / len(nets)
    for (variant, seed), s in all_samples.items():
        y = s.loads
        found = {("rbf", mode): predictions(net, s.u, y)[mode] for mode, net in nets[variant, seed].items()}
        found |= {("arx", mode): loads for mode, loads in predictions(train(s), s.u, y).items()}
        found["last load", "one step"] = np.vstack([y[:1], y[:-1]])
        found["mean load", "free run"] = np.tile(y[:TRAINED].mean(axis=0), (SAMPLES, 1))
        found["second grid", "free run"] = s.fine
        for (model, mode), loads in found.items():
            rows += judge(variant, seed, model, mode, loads[test], y[test])
        for mode, loads in predictions(train(s, loads=WALLS), s.u, y[:, WALLS]).items():
            rows += judge(variant, seed, "arx, walls alone", mode, loads[test], y[test, WALLS], WALLS)
        for model, loads in (("slosh_ems", s.linear), ("bilinear", s.bilinear)):
            rows += judge(variant, seed, model, "free run", loads[test], y[test, WHOLE], WHOLE)
    return rows, nets, cpu


def mean(rows: list[Row], value: Callable[[Row], float], **wanted: str) -> float:
    """Over the seeds; NaN where there is no such row."""
    found = [value(row) for row in rows if all(getattr(row, key) == word for key, word in wanted.items())]
    return float(np.mean(found)) if found else math.nan


def tables(rows: list[Row]) -> Iterator[str]:
    """Markdown: percent and NRMSE by model for the loads of each variant, means over the seeds."""
    models = list(dict.fromkeys((row.model, row.mode) for row in rows))
    for variant in VARIANTS:
        yield f"\n{variant}: mean |error/load| (median) / NRMSE, %"
        yield "| model | " + " | ".join(LOADS) + " |\n|---|" + "---|" * len(LOADS)
        for model, mode in models:
            cells = []
            for load in LOADS:
                at = {"variant": variant, "model": model, "mode": mode, "load": load}
                p, m, e = (mean(rows, lambda r, k=k: float(getattr(r, k)), **at) for k in ("percent", "median", "nrmse"))  # type: ignore[misc]
                cells.append("–" if math.isnan(p) else f"{p:.3g} ({m:.2g}) / {e:.3g}")
            yield f"| {model}, {mode} | " + " | ".join(cells) + " |"


def costs(s: Samples, net: Feedback, training: float) -> Iterator[str]:
    """Table 1: our seconds beside the paper's, and where training pays."""
    u, repeat = s.u[TRAINED:], 200
    free_run(net, u, s.loads[TRAINED])
    begin = time.process_time()
    for _ in range(repeat):
        free_run(net, u, s.loads[TRAINED])
    predicted, vof = (time.process_time() - begin) / repeat, s.cpu / SAMPLES
    yield "\n| | paper | here, slosh_vof | interFoam on the same cells |\n|---|---|---|---|"
    foam = INTERFOAM * STEP
    yield f"| CFD, 100 steps | 289.56 s | {100 * vof:.3f} s | {100 * foam:.2f} s |"
    yield f"| training data, 900 steps | 2382.48 s | {900 * vof:.2f} s | {900 * foam:.1f} s |"
    yield f"| training | 160.20 s | {training:.2f} s | {training:.2f} s |"
    yield f"| surrogate, 100 steps | 14.51 s | {1e3 * predicted:.3f} ms | {1e3 * predicted:.3f} ms |"
    savings = [100.0 * (1.0 - predicted / (100 * cost)) for cost in (vof, foam)]
    yield f"| savings | 94.98 % | {savings[0]:.3f} % | {savings[1]:.4f} % |"
    paper = (2382.48 + 160.20) / (2.8956 - 0.1451)
    pays = [(900 * cost + training) / (cost - predicted / 100) for cost in (vof, foam)]
    yield f"| steps after which training has paid | {paper:.0f} | {pays[0]:.0f} | {pays[1]:.0f} |"


def draw(motion: Motion, s: Samples, nets: dict[str, Feedback], path: Path) -> None:
    """As the paper's Fig. 14: input, forces on both walls, and the last 100 samples with their errors."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    y, k = s.loads, np.arange(1, SAMPLES + 1)
    found = {mode: predictions(net, s.u, y)[mode] for mode, net in nets.items()}
    figure, axes = plt.subplot_mosaic([["a", "a"], ["b", "b"], ["c", "c"], ["d", "e"]], figsize=(11, 11), layout="constrained")
    axes["a"].plot(motion.times / STEP + 1, np.degrees(motion.motions[:, 3]), "k", lw=0.7)
    axes["a"].set(ylabel="pitch [°]", title="(a) the tank's motion", xlim=(0, SAMPLES))
    styles = {"one step": ("C3", "-"), "free run": ("C1", "--")}
    for whole, zoom, column, wall in (("b", "d", 1, "east"), ("c", "e", 0, "west")):
        for name in (whole, zoom):
            axis = axes[name]
            axis.plot(k, WEIGHT * y[:, column], "C0", lw=1.0 if name == whole else 1.6, label="two-phase solver")
            for mode, (colour, line) in styles.items():
                axis.plot(k, WEIGHT * found[mode][:, column], line, color=colour, lw=0.8 if name == whole else 1.2, label=mode)
            axis.set(ylabel=f"force on {wall} wall [N/m]")
        axes[whole].set(title=f"({whole}) {wall} wall: all samples, trained on the first {TRAINED}", xlim=(0, SAMPLES))
        axes[whole].axvline(TRAINED + 0.5, color="0.4", lw=1, ls=":")
        last, mean_load = y[TRAINED:, column], y[:TRAINED, column].mean()
        known = {mode: found[mode][TRAINED:, column] for mode in styles} | {"mean load": np.full(len(last), mean_load)}
        words = ", ".join(f"{name} {100.0 * np.abs(f / last - 1.0).mean():.2f} %" for name, f in known.items())
        axes[zoom].set(title=f"({zoom}) {wall} wall: {words}", xlim=(TRAINED + 1, SAMPLES), xlabel="sample")
        axes[zoom].title.set_fontsize(10)
        span = last.max() - last.min()
        axes[zoom].set_ylim(WEIGHT * (last.min() - 0.9 * span), WEIGHT * (last.max() + 0.15 * span))
        error = axes[zoom].twinx()
        for mode, (colour, _) in styles.items():
            error.bar(k[TRAINED:], 100.0 * np.abs(known[mode] / last - 1.0), color=colour, alpha=0.45, width=1.0)
        error.set(ylabel="|error / force| [%]", ylim=(0.0, 12.0))
        error.axhline(8.0, color="0.4", lw=1, ls=":")
    axes["b"].legend(ncols=3, fontsize=8)
    for axis in axes.values():
        axis.grid(alpha=0.3)
    figure.savefig(path, dpi=100)
    plt.close(figure)
    print(f"picture: {path}")


def show(progress: Progress) -> None:
    """One line a record."""
    print(f"{progress.done}/{progress.total}  {progress.name}  {progress.cpu:.1f} s CPU", file=sys.stderr, flush=True)


def arguments() -> argparse.ArgumentParser:
    """What the modules of this experiment share."""
    command = argparse.ArgumentParser()
    command.add_argument("--records", type=Path, default=ROOT / "runs" / "rbf_paper")
    command.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    command.add_argument("--csv", type=Path)
    command.add_argument("--picture", type=Path)
    return command


def write(path: Path, rows: Sequence[tuple[object, ...]], header: tuple[str, ...]) -> None:
    """A CSV file, six digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(header)
        table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in rows)


def main() -> None:
    """Records, networks, tables, data, picture."""
    options = arguments().parse_args()
    samples = records(options.records, options.fmus)
    for (variant, seed), s in samples.items():
        last = WEIGHT * s.loads[TRAINED:, WALLS]
        east, west = (f"{last[:, i].mean():.2f} ± {last[:, i].std():.2f} N" for i in (1, 0))
        print(f"{variant}, seed {seed}: D {s.intensity:.2f}, samples 901 to 1000: east {east}, west {west}")
    rows, nets, training = compare(samples)
    print("\n".join(tables(rows)))
    print("\nGaussians and spread by validation, spectral radius of ARX:")
    for key, networks in nets.items():
        sizes = ", ".join(f"{mode} {len(net.centres)}, {net.spread:.1f}" for mode, net in networks.items())
        print(f"{', '.join(map(str, key))}: {sizes}; {train(samples[key]).radius():.5f}")
    first = next(iter(VARIANTS)), SEEDS[0]
    print("\n".join(costs(samples[first], nets[first]["one step"], training)))
    if options.csv:
        write(options.csv, rows, Row._fields)
    if options.picture:
        draw(plan()[0].motion, samples[first], nets[first], options.picture)


if __name__ == "__main__":
    main()
