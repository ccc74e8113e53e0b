"""Records of a tank for training and tests: planned, simulated side by side, kept as netCDF-3 files with their provenance.

    generate(plan, folder, simulate, model)     what is there already, with the same content, is not computed again
    load(folder)                                the records

simulate(parameters, times, motions) -> {output: (n,)} is passed in (master.tank_records drives an FMU): a component knows no FMU.
A file is there whole or not at all, and tells by a hash of its values when it was damaged later.
"""

from __future__ import annotations

import contextlib
import datetime
import hashlib
import io
import json
import os
import platform
import re
import time as clock
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.io import netcdf_file

from ...kit.interfaces import MOTION, SLOSH, SURGE
from . import processes
from .excitation import Motion
from .signals import Array

FORMAT = "aeroslosh tank record 1"
INPUTS = {name: (unit, text) for name, (unit, _, text) in (MOTION | SURGE).items()}
LOADS = {name: (SLOSH[name][0], SLOSH[name][2]) for name in ("force_x", "force_y", "moment")} | {
    "force_x_tank": ("N/m", "Whole force along the tank, aft"),
    "force_y_tank": ("N/m", "Whole force along the tank's height, up"),
    "force_west": ("N/m", "Force of pressure on the west (fore) wall, along the tank, aft"),
    "force_east": ("N/m", "Force of pressure on the east (aft) wall, along the tank, aft"),
}
"""name: (unit, text) of the outputs that a record holds by default."""
PACKAGES = ("aeroslosh", "numpy", "scipy", "numba", "fmpy", "pythonfmu")

Simulate = Callable[[Mapping[str, Any], Array, Array], Mapping[str, Array]]


class DatasetError(RuntimeError):
    """Records that cannot be made or read; the text says what, where and the remedy."""


@dataclass(frozen=True, eq=False)
class Planned:
    """A record to be: motion (its name is the record's), parameters of the simulation by name, what it is for ("train", …)."""

    motion: Motion
    parameters: Mapping[str, Any]
    split: str


@dataclass(frozen=True, eq=False)
class Record:
    """A record: as planned, with loads {output: (n,)}, the file's attributes and its path."""

    motion: Motion
    parameters: Mapping[str, Any]
    split: str
    loads: Mapping[str, Array]
    attributes: Mapping[str, Any]
    path: Path


class Progress(NamedTuple):
    """Records done of all (those found there included), the last one's name and CPU time [s], and the time left [s]."""

    done: int
    total: int
    name: str
    cpu: float
    left: float


def generate(
    plan: Sequence[Planned], folder: Path, simulate: Simulate, model: Mapping[str, str], workers: int = 1,
    progress: Callable[[Progress], None] | None = None, say: Callable[[str], None] | None = None,
) -> list[Path]:  # fmt: skip
    """Make the records of a plan that `folder` does not hold yet; returns the files in the plan's order.

    simulate    picklable; called in spawned processes of one thread
    model       what names the simulation (an FMU's SHA-256): part of each record's key, and kept with it
    say         hears what is computed again and why, and of files that are not of the plan
    Raises DatasetError for names that occur twice, a folder that cannot be written, and, after all others are done, for records
    that failed. Killed at any moment it leaves whole records, and goes on from them when called again.
    """
    told = say or (lambda _: None)
    names = [entry.motion.name for entry in plan]
    twice = sorted({name for name in names if names.count(name) > 1})
    if twice:
        raise DatasetError(f"The plan names {', '.join(twice)} twice\n  remedy: give each motion a name of its own")
    odd = [name for name in names if not re.fullmatch(r"\w[\w.+-]*", name)]
    if odd:
        raise DatasetError(f"'{odd[0]}' names no file\n  remedy: name motions with letters, digits, '_', '.', '+' and '-'")
    keys = {entry.motion.name: content_key(entry, model) for entry in plan}
    paths = [folder / f"{name}.nc" for name in names]
    try:
        folder.mkdir(parents=True, exist_ok=True)
        strangers = sorted({path.name for path in folder.glob("*.nc")} - {path.name for path in paths})
    except OSError as error:
        raise DatasetError(f"The folder cannot be made: {error.strerror}\n  where:  {folder}\n  remedy: give another") from None
    if strangers:
        told(f"not of this plan, but `load` reads them too: {', '.join(strangers)} (remedy: remove them)")
    todo = []
    for entry, path in zip(plan, paths, strict=True):
        why = _why_compute(path, keys[entry.motion.name])
        if why is None:
            continue
        if why:
            told(f"{path.name} is computed again: {why}")
        for part in folder.glob(f".{path.name}.part-*"):  # left by a run that was killed
            part.unlink(missing_ok=True)
        todo.append(entry)
    todo.sort(key=_weight, reverse=True)  # the long ones first: no worker is left alone with one at the end
    _compile(todo, simulate)
    failed, done, weights, begin = [], 0.0, sum(map(_weight, todo)), clock.perf_counter()
    jobs = [(entry.parameters, entry.motion.times, entry.motion.motions) for entry in todo]
    with contextlib.closing(processes.run(simulate, jobs, max(1, workers))) as answers:
        for count, answer in enumerate(answers, start=len(plan) - len(todo) + 1):
            entry = todo[answer.number]
            name = entry.motion.name
            trouble = answer.error or _trouble(answer.result, entry.motion.times.size)
            if trouble:
                failed.append(f"{name}: {trouble}")
            else:
                _write(
                    folder / f"{name}.nc", entry, answer.result, {"key": keys[name], "model": dict(model), "cpu_s": answer.cpu}
                )
            done += _weight(entry)
            if progress:
                left = (clock.perf_counter() - begin) * (weights / done - 1.0)
                progress(Progress(count, len(plan), name, answer.cpu, left))
    if failed:
        what = f"{len(failed)} of {len(plan)} records failed\n  " + "\n  ".join(failed)
        raise DatasetError(
            f"{what}\n  where:  {folder}\n  remedy: gentler motions or other settings for these; the others are kept"
        )
    return paths


def load(folder: Path, split: str | None = None) -> list[Record]:
    """All records in a folder, or those of one split, by name. Raises DatasetError for a damaged file and where there is none."""
    records = [read(path) for path in sorted(folder.glob("*.nc"))]
    if not records:
        raise DatasetError(f"There are no records (.nc)\n  where:  {folder}\n  remedy: give the folder that `generate` wrote")
    return [record for record in records if split in (None, record.split)]


def read(path: Path) -> Record:
    """One record. Raises DatasetError where the file is none, or damaged."""
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            about = {name: _attribute(value) for name, value in file._attributes.items()}
            values = {name: np.array(variable[:], dtype=float) for name, variable in file.variables.items()}
        if about["format"] != FORMAT or about["data_sha256"] != _hash_of(values):
            raise ValueError("its values are not those that were written")
        times, motions = values.pop("time"), np.stack([values.pop(name) for name in INPUTS], axis=1)
        motion = Motion(about["name"], about["kind"], int(about["seed"]), about["motion_parameters"], times, motions)
        return Record(motion, about["parameters"], about["split"], values, about, path)
    except Exception as error:  # scipy raises whatever a broken file makes of it
        what = f"The record cannot be read: {type(error).__name__}: {error}"
        raise DatasetError(f"{what}\n  where:  {path}\n  remedy: remove it, or generate the records again") from None


def content_key(entry: Planned, model: Mapping[str, str]) -> str:
    """SHA-256 of what decides a record: motion, parameters, model.

    The motion enters to 1e-8 of its peaks: sines and sums differ in the last bits between machines and numbers of threads, and
    that makes no other record."""
    digest = hashlib.sha256(json.dumps([FORMAT, dict(entry.parameters), dict(model)], sort_keys=True).encode())
    for column in (entry.motion.times, *entry.motion.motions.T):
        peak = float(np.max(np.abs(column)))
        digest.update(f"{peak:.8e}".encode())
        if peak > 0.0:
            digest.update(np.round(column / peak * 1e8).astype("<i8").tobytes())
    return digest.hexdigest()


def _why_compute(path: Path, key: str) -> str | None:
    """None where the record is there; else "" for a new one, or what is wrong with the one there."""
    if not path.exists():
        return ""
    try:
        found = read(path).attributes.get("key")
    except DatasetError as error:
        return str(error).splitlines()[0]
    return None if found == key else "its motion, its parameters or the model are others now"


def _compile(todo: Iterable[Planned], simulate: Simulate) -> None:
    """The first steps of each kind of simulation, in a process that is thrown away.

    So that kernels are compiled once, not by all workers together, and that every record comes from code read back from the
    cache: its last bits may differ from those of code just compiled."""
    kinds = {json.dumps(dict(entry.parameters), sort_keys=True): entry for entry in todo}
    jobs = [(e.parameters, e.motion.times[:3], e.motion.motions[:3]) for e in kinds.values()]
    for _ in processes.run(simulate, jobs, 1):
        pass  # an error will come again with the record itself


def _weight(entry: Planned) -> float:
    """Relative cost of a record: instants times cells, where the parameters tell of cells."""
    return float(entry.motion.times.size * entry.parameters.get("cells_x", 1) * entry.parameters.get("cells_y", 1))


def _trouble(loads: Mapping[str, Array], count: int) -> str:
    """What is wrong with what a simulation returned; "" for nothing."""
    for name, values in loads.items():
        if np.shape(values) != (count,):
            return f"{name} has shape {np.shape(values)}, not ({count},)"
        if not np.all(np.isfinite(values)):
            return f"{name} is not finite from instant {int(np.argmin(np.isfinite(values)))} on"
    return "" if loads else "the simulation returned no output"


def _write(path: Path, entry: Planned, loads: Mapping[str, Array], about: Mapping[str, Any]) -> None:
    """One file, under a hidden name first."""
    motion = entry.motion
    columns = {"time": motion.times, **dict(zip(INPUTS, motion.motions.T, strict=True)), **loads}
    values = {name: np.array(column, dtype=float) for name, column in columns.items()}
    texts = {"time": ("s", "time"), **INPUTS, **LOADS}
    attributes = {
        "Conventions": "CF-1.8",
        "title": f"aeroslosh tank record {motion.name}",
        "format": FORMAT,
        "name": motion.name,
        "split": entry.split,
        "kind": motion.kind,
        "seed": motion.seed,
        "motion_parameters": dict(motion.parameters),
        "parameters": dict(entry.parameters),
        **about,
        "versions": _versions(),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "host": platform.node(),
        "data_sha256": _hash_of(values),
    }
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w")
    file.createDimension("time", motion.times.size)
    for name, column in values.items():
        variable = file.createVariable(name, "f8", ("time",))
        variable[:] = column
        variable.units, variable.long_name = texts.get(name, ("", ""))
    for name, value in attributes.items():
        setattr(file, name, json.dumps(value) if isinstance(value, dict) else value)
    file.flush()
    part = path.with_name(f".{path.name}.part-{os.getpid()}")
    try:
        with part.open("wb") as stream:
            stream.write(buffer.getvalue())
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(part, path)
    except OSError as error:
        part.unlink(missing_ok=True)
        raise DatasetError(f"A record cannot be written: {error.strerror}\n  where:  {path}\n  remedy: make room") from None


def _hash_of(values: Mapping[str, Array]) -> str:
    digest = hashlib.sha256()
    for name, column in values.items():
        digest.update(name.encode() + column.astype("<f8").tobytes())
    return digest.hexdigest()


def _versions() -> dict[str, str]:
    found = {"python": platform.python_version()}
    for package in PACKAGES:
        try:
            found[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            found[package] = "unknown"
    return found


def _attribute(value: Any) -> Any:
    """An attribute as Python has it: number, text, or the table that a text is JSON of."""
    if isinstance(value, bytes):
        text = value.decode("utf-8")
        return json.loads(text) if text.startswith("{") else text
    return np.asarray(value).item()
