"""Networks and baselines trained on one set of records, and how each does on records that none of them has seen."""

from __future__ import annotations

import math
import re
import time as clock
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ...tank.liquid import Tank
from ..feedback import Feedback, columns, free_run
from ..memory import Array
from ..network import Network, Weights, untrained
from ..surrogate import Record, Surrogate, Table, inputs, tabulate
from . import dataset, measures
from . import fit as training_fit
from .feedback_fit import fit
from .fit import Settings
from .intensity import intensity

WHOLE = 1.0  # D up to which a surface counts as whole
DELAYS = (5, 3)  # of the network with output feedback that stands beside the others

Model = Callable[[Record], Array]


@dataclass(frozen=True)
class Data:
    """Records of one tank by name, in splits ("train", "validation", "test", "breakup"), with their running D; `fine`: the same
    motions on the second grid."""

    tank: Tank
    viscosity: float
    gas_density: float
    records: Mapping[str, Mapping[str, Record]]
    fine: Mapping[str, Record]
    unevenness: Mapping[str, float]


def arrange(found: Sequence[dataset.Record]) -> Data:
    """The records of a folder. Raises DatasetError when they are not of one tank."""
    names = ("tank_length", "tank_height", "tank_width", "fill_level", "tank_x", "tank_y", "liquid_density", "gravity")
    keys = {tuple(float(r.parameters[n]) for n in names) for r in found}
    if len(keys) != 1:
        raise dataset.DatasetError(f"The records are of {len(keys)} tanks\n  remedy: one folder a tank")
    tank = Tank(*next(iter(keys)))
    records: dict[str, dict[str, Record]] = {}
    fine: dict[str, Record] = {}
    for r in found:
        loads = np.stack([r.loads[n] for n in ("force_x", "force_y", "moment")], axis=1)
        record = Record(float(r.motion.times[1] - r.motion.times[0]), np.ascontiguousarray(r.motion.motions), loads)
        if r.motion.name.endswith("_fine"):
            fine[r.motion.name.removesuffix("_fine")] = record
        else:
            records.setdefault(r.split, {})[r.motion.name] = record
    every = {name: record for split in records.values() for name, record in split.items()}
    uneven = {name: float(intensity(record.motions, tank)[-1]) for name, record in every.items()}
    first = found[0].parameters
    return Data(tank, float(first["liquid_viscosity"]), float(first["gas_density"]), records, fine, uneven)


def tables(data: Data, split: str, most: float) -> dict[str, Table]:
    """Features of the records of a split with D up to `most`, under the bilinear base."""
    base = Surrogate(untrained("bilinear", True), data.tank, data.viscosity, data.gas_density)
    return {n: tabulate(base, r) for n, r in data.records[split].items() if data.unevenness[n] <= most}


def train(
    data: Data, settings: Settings, most: float, say: Callable[[str], None], about: Mapping[str, Any] | None = None
) -> tuple[Network, Network, dict[str, Any]]:
    """The network with Gaussians, the tail alone ("quadratic"), and what was tried; records with D above `most` are left out."""
    shape, room = data.tank.depth / data.tank.length, data.tank.height / data.tank.length
    seen, begin = list(tables(data, "train", most).values()), clock.process_time()
    checks = [r for n, r in data.records["validation"].items() if data.unevenness[n] <= most]
    if not seen or not checks:
        raise dataset.DatasetError(
            f"{len(seen)} records to train on and {len(checks)} to choose by have D up to {most:g}\n  remedy: a larger largest_D"
        )

    def network(weights: Weights, name: str, more: Mapping[str, Any]) -> Network:
        return training_fit.as_network(name, weights, seen, shape, room, {**(about or {}), **more})

    def error(weights: Weights) -> float:
        model = modal(network(weights, "candidate", {}), data)
        return float(np.mean([measures.errors(model(r), r.loads, data.tank) for r in checks]))

    weights, report = training_fit.train(seen, error, settings, say)
    report |= {"training_cpu_s": clock.process_time() - begin, "records": len(seen), "seed": settings.seed, "largest_D": most}
    plain = training_fit.solve(training_fit.gather(seen, settings.thin), None, 0.0)
    kept = {k: v for k, v in report.items() if k != "tried"}
    return network(weights, "rbf", kept), network(plain, "quadratic", kept), report


def modal(network: Network, data: Data) -> Model:
    """A network on the modal memory, in free run."""
    surrogate = Surrogate(network, data.tank, data.viscosity, data.gas_density)
    return lambda record: surrogate.run(record.motions, record.step)


def with_feedback(data: Data, most: float, centres: int = 0, seed: int = 0) -> tuple[Feedback, Model]:
    """A linear network (or one of Gaussians) with output feedback on the drive that the liquid feels, in free run.

    Raises NetworkError where its feedback grows."""
    base = Surrogate(untrained("ems", False), data.tank, data.viscosity, data.gas_density)

    def pair(record: Record) -> tuple[Array, Array]:
        return columns("drive", inputs(base, record.motions), record.motions, data.tank.length), tabulate(base, record).whole

    seen = [pair(r) for n, r in data.records["train"].items() if data.unevenness[n] <= most]
    step = next(iter(data.records["train"].values())).step / math.sqrt(data.tank.length / data.tank.gravity)
    shape, room = data.tank.depth / data.tank.length, data.tank.height / data.tank.length
    name = "rbf_feedback" if centres else "arx"
    net = fit(name, "drive", DELAYS, step, seen, shape, room, centres, seed=seed)
    net.check()

    def model(record: Record) -> Array:
        u, y = pair(record)
        return base.inertial(free_run(net, u, y[0]), record.motions)

    return net, model


def evaluate(models: Mapping[str, Model], data: Data, split: str) -> list[dict[str, Any]]:
    """A row a model and record: D, errors (3,), errors of the second grid, work and its error, harmonics of sinusoids."""
    rows = []
    for name, record in data.records[split].items():
        times = record.step * np.arange(len(record.motions))
        found = re.search(r"sine(\d+)", name)
        true_work = measures.work(record.loads, record.motions)
        grid = data.fine.get(name)
        for label, model in [*models.items(), *([("second grid", None)] if grid is not None else [])]:
            loads = model(record) if model is not None else grid.loads  # type: ignore[union-attr]
            row: dict[str, Any] = {
                "model": label,
                "record": name,
                "D": data.unevenness[name],
                "errors": measures.errors(loads, record.loads, data.tank).tolist(),
                "work": true_work,
                "work_error": measures.work(loads, record.motions) - true_work,
                "rms_ratio": (loads.std(axis=0) / measures.size(record.loads, data.tank)).tolist(),
            }
            if found:
                pairs = measures.harmonics(loads, record.loads, times, float(found[1]), data.tank)
                row["harmonics"] = [None if h is None else [h.amplitude, h.phase] for h in pairs]
            rows.append(row)
    return rows


def summary(rows: Sequence[Mapping[str, Any]], most: float = WHOLE) -> dict[str, dict[str, float]]:
    """Of each model over records with D up to `most`: mean and largest errors, largest errors of harmonics and work."""
    out: dict[str, dict[str, float]] = {}
    for label in dict.fromkeys(row["model"] for row in rows):
        mine = [row for row in rows if row["model"] == label and row["D"] <= most]
        if not mine:
            continue
        e = np.array([row["errors"] for row in mine])
        pairs = [h for row in mine for h in row.get("harmonics", []) if h is not None]
        out[label] = {f"mean_{n}": float(v) for n, v in zip(("fx", "fy", "mz"), e.mean(axis=0), strict=True)}
        out[label] |= {f"most_{n}": float(v) for n, v in zip(("fx", "fy", "mz"), e.max(axis=0), strict=True)}
        out[label]["work_error"] = max(abs(row["work_error"]) for row in mine)
        if pairs:
            out[label]["amplitude"] = max(abs(h[0]) for h in pairs)
            out[label]["phase_deg"] = math.degrees(max(abs(h[1]) for h in pairs))
    return out
