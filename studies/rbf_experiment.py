"""The paper's surrogate on all its excitations: every load, two grids of the flow, what needs no training.

`python -m studies.rbf_experiment [--records FOLDER] [--csv FILE]`. The experiment, and what the paper leaves open
in it: master/paper/surrogate.py (`aeroslosh paper fig14 table1`). Beside it here: "second grid", the same flow at 200 x 60 cells,
slosh_ems and the untrained bilinear equations, driven through the same motion. Results: docs/slosh_rbf_paper.md.
"""

from __future__ import annotations

import csv
import itertools
import math
import sys
from argparse import ArgumentParser
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from aeroslosh.fmus.slosh_rbf.memory import Array
from aeroslosh.fmus.slosh_rbf.network import untrained
from aeroslosh.fmus.slosh_rbf.surrogate import Surrogate
from aeroslosh.fmus.slosh_rbf.training.dataset import Planned, Progress, Record, generate, read
from aeroslosh.fmus.slosh_rbf.training.intensity import intensity
from aeroslosh.fmus.slosh_rbf.training.plan import FINE as FINE_CELLS
from aeroslosh.fmus.slosh_rbf.training.plan import TANK, settings
from aeroslosh.master.paper.surrogate import (
    FINE,
    LOADS,
    SAMPLES,
    SEEDS,
    STEP,
    TRAINED,
    VARIANTS,
    WALLS,
    WEIGHT,
    WHOLE,
    Feedback,
    Samples,
    both,
    chosen,
    in_tank,
    motion,
    nrmse,
    percent,
    predictions,
    sampled,
    train,
)
from aeroslosh.master.training.tank_records import LINEAR_LOADS, Drive

ROOT = Path(__file__).resolve().parents[1]
VISCOSITY, GAS = 1e-6, 1.2


@dataclass(frozen=True)
class Beside:
    """What is compared with a record: loads (n, 5) of the second grid; whole loads (n, 3) by slosh_ems and by the bilinear
    equations; D of the motion."""

    fine: Array
    linear: Array
    bilinear: Array
    intensity: float


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
    entries = []
    for key in itertools.product(VARIANTS, SEEDS):
        made = motion(*key)
        entries.append(Planned(made, settings(TANK), "paper"))
        entries.append(Planned(replace(made, name=f"{made.name}_fine"), settings(TANK, FINE_CELLS), "paper"))
    return entries


def records(folder: Path, fmus: Path) -> dict[tuple[str, int], tuple[Samples, Beside]]:
    """The samples of each variant and seed; records that `folder` does not hold yet are computed."""
    drive, linear = Drive.of(fmus / "slosh_vof.fmu"), Drive.of(fmus / "slosh_ems.fmu", LINEAR_LOADS)
    found = [read(path) for path in generate(plan(), folder, drive, drive.model, progress=show)]
    pairs = zip(found[::2], found[1::2], strict=True)
    keys = itertools.product(VARIANTS, SEEDS)
    return {key: (sampled(record), beside(record, fine, linear)) for key, (record, fine) in zip(keys, pairs, strict=True)}


def beside(record: Record, fine: Record, linear: Drive) -> Beside:
    """Every 0.02 s: the second grid, and the models that need no training driven through the same motion at its own step."""
    moved, every = record.motion, slice(None, None, round(STEP / FINE))
    surrogate = Surrogate(untrained("bilinear", True), TANK, VISCOSITY, GAS)
    ems = linear(settings(TANK, None), moved.times, moved.motions)
    return Beside(
        both(fine)[every],
        in_tank(np.stack([ems[n] for n in LINEAR_LOADS], axis=1), moved)[every],
        in_tank(surrogate.run(moved.motions, FINE), moved)[every],
        float(intensity(moved.motions, TANK)[-1]),
    )


def judge(variant: str, seed: int, model: str, mode: str, found: Array, true: Array, loads: slice = slice(None)) -> Iterator[Row]:
    """Rows of the samples given, (n, loads) both."""
    apart = percent(found, true)
    small = np.abs(true) < 0.1 * np.sqrt((true**2).mean(axis=0))
    for i, load in enumerate(LOADS[loads]):
        p, low = apart[:, i], small[:, i]
        numbers = (p.mean(), np.median(p), p.max(), nrmse(found, true)[i], 100.0 * low.mean(), p[low].sum() / len(p))
        yield Row(variant, seed, load, model, mode, *(float(x) for x in numbers))


Networks = dict[tuple[str, int], dict[str, Feedback]]


def compare(all_samples: dict[tuple[str, int], tuple[Samples, Beside]]) -> tuple[list[Row], Networks]:
    """All rows, and the networks by variant and seed."""
    rows: list[Row] = []
    nets = {(variant, seed): chosen(s, seed) for (variant, seed), (s, _) in all_samples.items()}
    test = slice(TRAINED, None)
    for (variant, seed), (s, other) in all_samples.items():
        y = s.loads
        found = {("rbf", mode): predictions(net, s.u, y)[mode] for mode, net in nets[variant, seed].items()}
        found |= {("arx", mode): loads for mode, loads in predictions(train(s), s.u, y).items()}
        found["last load", "one step"] = np.vstack([y[:1], y[:-1]])
        found["mean load", "free run"] = np.tile(y[:TRAINED].mean(axis=0), (SAMPLES, 1))
        found["second grid", "free run"] = other.fine
        for (model, mode), loads in found.items():
            rows += judge(variant, seed, model, mode, loads[test], y[test])
        for mode, loads in predictions(train(s, loads=WALLS), s.u, y[:, WALLS]).items():
            rows += judge(variant, seed, "arx, walls alone", mode, loads[test], y[test, WALLS], WALLS)
        for model, loads in (("slosh_ems", other.linear), ("bilinear", other.bilinear)):
            rows += judge(variant, seed, model, "free run", loads[test], y[test, WHOLE], WHOLE)
    return rows, nets


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


def show(progress: Progress) -> None:
    """One line a record."""
    print(f"{progress.done}/{progress.total}  {progress.name}  {progress.cpu:.1f} s CPU", file=sys.stderr, flush=True)


def arguments() -> ArgumentParser:
    """What the modules of this experiment share."""
    command = ArgumentParser()
    command.add_argument("--records", type=Path, default=ROOT / "runs" / "rbf_paper")
    command.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    command.add_argument("--csv", type=Path)
    return command


def write(path: Path, rows: Sequence[tuple[object, ...]], header: tuple[str, ...]) -> None:
    """A CSV file, six digits."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(header)
        table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in rows)


def main() -> None:
    """Records, networks, tables, data."""
    options = arguments().parse_args()
    samples = records(options.records, options.fmus)
    for (variant, seed), (s, other) in samples.items():
        last = WEIGHT * s.loads[TRAINED:, WALLS]
        east, west = (f"{last[:, i].mean():.2f} ± {last[:, i].std():.2f} N" for i in (1, 0))
        print(f"{variant}, seed {seed}: D {other.intensity:.2f}, samples 901 to 1000: east {east}, west {west}")
    rows, nets = compare(samples)
    print("\n".join(tables(rows)))
    print("\nGaussians and spread by validation, spectral radius of ARX:")
    for key, networks in nets.items():
        sizes = ", ".join(f"{mode} {len(net.centres)}, {net.spread:.1f}" for mode, net in networks.items())
        print(f"{', '.join(map(str, key))}: {sizes}; {train(samples[key][0]).radius():.5f}")
    if options.csv:
        write(options.csv, rows, Row._fields)


if __name__ == "__main__":
    main()
