"""A violent branch from the records of a folder: trained, chosen, and measured on records that it has not seen."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from ...tank.liquid import Tank
from ..memory import Array
from ..violent_network import Violent, ViolentWeights
from . import dataset
from .violent_fit import Settings, Table, branch, choose, loss, measure, predict, tabulate

TWIN = "_twin"
BANDS = (1.0, 2.0, 4.0, 8.0, 40.0)
"""Amplitudes [g] between which loss factors are told apart."""
NAMES = ("tank_length", "tank_height", "tank_width", "fill_level", "tank_x", "tank_y", "liquid_density", "gravity")


def tables(found: Sequence[dataset.Record]) -> dict[str, list[Table]]:
    """Records by split; twins of test records under "twin". Raises DatasetError where heights over lengths differ."""
    out: dict[str, list[Table]] = {}
    for r in found:
        tank = Tank(*(float(r.parameters[n]) for n in NAMES))
        loads = np.stack([r.loads[n] for n in ("force_x", "force_y", "moment")], axis=1)
        split = "twin" if r.motion.name.endswith(TWIN) else r.split
        viscosity, gas = float(r.parameters["liquid_viscosity"]), float(r.parameters["gas_density"])
        step = float(r.motion.times[1] - r.motion.times[0])
        table = tabulate(r.motion.name, tank, viscosity, gas, np.ascontiguousarray(r.motion.motions), loads, step)
        out.setdefault(split, []).append(table)
    rooms = {round(t.tank.height / t.tank.length, 6) for split in out.values() for t in split}
    if len(rooms) != 1:
        raise dataset.DatasetError(f"The records are of {len(rooms)} shapes of tanks\n  remedy: one folder a shape")
    return out


def train(
    data: Mapping[str, Sequence[Table]],
    name: str,
    every: Sequence[Settings],
    say: Callable[[str], None],
    about: Mapping[str, Any],
) -> tuple[Violent, dict[str, Any]]:
    """The branch and a report: what was tried, how it does on each split. Raises DatasetError for a split without records."""
    for split in ("train", "validation", "test"):
        if not data.get(split):
            raise dataset.DatasetError(f"There are no records of the split {split}\n  remedy: ask for some in [violent]")
    seen, checks = data["train"], data["validation"]
    try:
        net, tried = choose(seen, checks, every, say)
    except ValueError as error:
        raise dataset.DatasetError(f"Too little breaks: {error}\n  remedy: more records, or fewer centres") from None
    fills = [t.tank.fill_level for t in seen]
    made = branch(name, net, checks, (min(fills), max(fills)), dict(about))
    return made, {"tried": tried, "splits": evaluate(made.weights, data)}


def evaluate(net: ViolentWeights, data: Mapping[str, Sequence[Table]]) -> dict[str, Any]:
    """Of each split: `measure`, the same by amplitude and by fill; of the tests also what their twins are worth."""
    out: dict[str, Any] = {}
    for split in ("train", "validation", "test"):
        forces = [predict(net, t) for t in data[split]]
        out[split] = {**measure(data[split], forces), "bands": _bands(data[split], forces), "fills": _fills(data[split], forces)}
    twins = {t.name.removesuffix(TWIN): t for t in data.get("twin", ())}
    pairs = [(t, twins[t.name].r) for t in data["test"] if t.name in twins]
    if pairs:
        both, forces = [t for t, _ in pairs], [r for _, r in pairs]
        out["twins"] = {**measure(both, forces), "bands": _bands(both, forces)}
    return out


def _bands(tables: Sequence[Table], forces: Sequence[Array]) -> list[dict[str, float]]:
    """Loss factors by amplitude of acceleration."""
    size = np.array([c.acceleration for t in tables for c in t.cycles])
    true = np.concatenate([loss(t, t.r) for t in tables])
    gap = np.concatenate([loss(t, f) for t, f in zip(tables, forces, strict=True)]) - true
    rows = []
    for low, high in itertools.pairwise(BANDS):
        mine = (size >= low) & (size < high)
        if np.any(mine):
            rows.append(
                {"from": low, "to": high, "cycles": int(mine.sum()), "loss": float(true[mine].mean()),
                 "loss_rms": float(np.sqrt((gap[mine] ** 2).mean())), "loss_bias": float(gap[mine].mean())}
            )  # fmt: skip
    return rows


def _fills(tables: Sequence[Table], forces: Sequence[Array]) -> list[dict[str, float]]:
    """`measure` by fill, to a tenth."""
    rows = []
    for fill in sorted({round(t.tank.fill_level, 1) for t in tables}):
        mine = [(t, f) for t, f in zip(tables, forces, strict=True) if round(t.tank.fill_level, 1) == fill]
        if any(t.cycles and np.any(t.share) for t, _ in mine):
            rows.append({"fill": fill, **measure([t for t, _ in mine], [f for _, f in mine])})
    return rows
