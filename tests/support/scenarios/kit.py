"""Scenarios of any FMU: failures, states, many instances, versions, predicted inputs, its reference result."""

from __future__ import annotations

import gc
import math
from pathlib import Path
from typing import Any

from fmpy.fmi1 import FMICallException

from aeroslosh.master.hosts import reference as references

from ..instance import LOG, Instance


def fault(path: str, kind: int) -> Any:
    """Fail in a step, collect garbage, be told, recover by a state, step again."""
    one = Instance(path).start()
    one["u"] = 1.0
    statuses = [one.step(0.0, 0.1)]
    good = one.fmu.getFMUstate()
    bad = Instance(path, folder=one.folder).start(fault=kind)  # a state belongs to the library that gave it
    after_start = bad["failed"]
    bad_statuses = [bad.step(0.0, 0.1), bad.step(0.1, 0.1)]
    gc.collect()
    seen = {"failed": bad["failed"], "error": bad["error"], "y": bad["y"], "after_start": after_start}
    bad.take(good)
    recovered = {"failed": bad["failed"], "error": bad["error"], "y": bad["y"]}
    bad["u"] = 1.0
    bad_statuses.append(bad.step(0.1, 0.1))
    recovered["next"] = bad["y"]
    for _ in range(3):
        gc.collect()
    one.fmu.freeInstance()
    bad.fmu.freeInstance()
    gc.collect()
    return {"good": statuses, "bad": bad_statuses, "seen": seen, "recovered": recovered, "log": LOG}


def state_faults(path: str, kind: int) -> Any:
    """Take, restore and serialise a state with a face that fails in it."""
    one = Instance(path).start(fault=kind)
    one.step(0.0, 0.1)
    status = 0
    try:
        status = one.take(one.fmu.deSerializeFMUstate(one.fmu.serializeFMUstate(one.fmu.getFMUstate())))
    except FMICallException as error:
        status = int(error.status)
    return {"failed": one["failed"], "error": one["error"], "status": status, "next": one.step(0.1, 0.1)}


def refused(path: str) -> Any:
    """Set values that must be refused, before and after the start."""
    result: dict[str, Any] = {}
    for name, value in (
        ("gain", 9.0),
        ("gain", float("nan")),
        ("count", 7),
        ("fault", 99),
        ("u", float("inf")),
        ("y", 1.0),
    ):
        one = Instance(path)
        one[name] = value
        before = one["error"]
        one.start()
        result[f"{name}={value}"] = [before, one["failed"], one["error"], one.step(0.0, 0.1), str(one["y"])]
    one = Instance(path).start()
    one["u"] = float("nan")
    result["input"] = [one["u"], one.step(0.0, 0.1), one["error"]]
    one["u"] = 1.0
    result["input again"] = [one.step(0.0, 0.1), one["failed"], one["y"]]
    one["gain"] = 3.0
    result["late"] = [one.step(0.1, 0.1), one["error"]]
    result["numbers"] = [one["gain"], one["count"], one["label"]]
    return result


def many(path: str, count: int) -> Any:
    """Instantiate, run and free many times."""
    folder = None
    for i in range(count):
        one = Instance(path, f"i{i}", folder).start()
        folder = one.folder
        assert one.step(0.0, 0.1) == 0
        one.fmu.terminate()
        one.fmu.freeInstance()
    gc.collect()
    return count


def two_versions(first: str, second: str) -> Any:
    """Run two versions of one FMU in one process."""
    one, two = Instance(first, "one").start(), Instance(second, "two").start()
    for instance in (one, two, one, two):
        instance["u"] = 1.0
    one.step(0.0, 0.1)
    two.step(0.0, 0.1)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)
    two.take(two.fmu.deSerializeFMUstate(data))
    return {"y": [one["y"]], "failed": two["failed"], "error": two["error"]}


def reset(path: str) -> Any:
    """Fail, reset, run again."""
    one = Instance(path).start(fault=1)
    statuses = [one.step(0.0, 0.1)]
    one.fmu.reset()
    one.start()
    one["u"] = 1.0
    statuses.append(one.step(0.0, 0.1))
    return {"statuses": statuses, "y": one["y"], "failed": one["failed"]}


def kernels(path: str) -> Any:
    """Run a compiled kernel from a fresh unzip folder."""
    one = Instance(path).start()
    return {"y": one["y"], "hits": one["hits"], "misses": one["misses"], "error": one["error"]}


def bad_start(path: str, values: dict[str, Any]) -> Any:
    """Start with values that must be refused."""
    one = Instance(path).start(**values)
    return {"failed": one["failed"], "error": one["error"], "status": one.step(0.0, 1e-3), "log": LOG}


def predicted(path: str, switch: str, values: dict[str, Any], names: list[str], keep: str) -> Any:
    """One instance that predicts its inputs, one that is told them, one that goes on from the first's bytes."""
    ahead, told = Instance(path, "ahead").start(**values, **{switch: 1}), Instance(path, "told").start(**values)
    outputs = [v.name for v in ahead.variables.values() if v.causality == "output" and v.type == "Real"]
    rows: dict[str, list[Any]] = {"ahead": [], "told": [], "resumed": []}
    old, time, past, resumed = [0.0] * len(names), 0.0, math.inf, None
    for i in range(12):
        step_size = 1e-3 * (1.0 + 0.5 * (i % 3))
        new = [1e-3 * math.sin((3.0 + place) * 40.0 * time) for place in range(len(names))]
        for one in [ahead, told] + ([resumed] if resumed else []):
            for name, a, b in zip(names, new, old, strict=True):
                share = step_size / past
                one[name] = (1.0 + share) * a - share * b if one is told else a
            assert one.step(time, step_size) == 0, one["error"]
        assert [ahead[name] for name in names] == new  # a host reads back what it set
        rows["ahead"].append([ahead[name].hex() for name in outputs])
        rows["told"].append([told[name].hex() for name in outputs])
        if resumed:
            rows["resumed"].append([resumed[name].hex() for name in outputs])
        old, past, time = new, step_size, time + step_size
        if i == 5:
            with open(keep, "wb") as file:
                file.write(ahead.fmu.serializeFMUstate(ahead.fmu.getFMUstate()))
            resumed = Instance(path, "resumed").start(**values)
            with open(keep, "rb") as file:
                resumed.take(resumed.fmu.deSerializeFMUstate(file.read()))
    return rows


def reference(path: str) -> Any:
    """The FMU against its own reference result: name, difference, allowed."""
    return [[one.name, one.found, one.allowed] for one in references.check(Path(path))]
