"""A run's histories and fields in formats of other programs: CSV, Parquet, a ParaView collection.

CSV: first line the names, then plain numbers (shortest text that reads back exactly), no comment lines: what pandas, Excel and
numpy.genfromtxt(names=True) read as it is. Units, meanings and provenance stand in <file>.csv-metadata.json beside it, after the
W3C's "Metadata Vocabulary for Tabular Data" (CSV on the Web), https://www.w3.org/TR/tabular-metadata/."""

from __future__ import annotations

import csv
import json
import os
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ..base import files as base_files
from ..base import pvd, texts, vtk
from ..base.errors import AeroSloshError
from . import history_file
from .history_file import History


def targets(sources: Sequence[History], out: Path | None, suffix: str) -> list[Path]:
    """Where each history goes: beside itself, to the file `out` (with an ending), to the folder `out`. Raises AeroSloshError."""
    if out is None:
        return [source.path.with_name(source.name + suffix) for source in sources]
    if len(sources) == 1 and out.suffix and not out.is_dir():
        return [out]
    if out.is_file() or out.suffix == suffix:
        raise AeroSloshError(f"There are {len(sources)} histories for one file", f"--out {out}", "give a folder, or one history")
    return [out / (source.name + suffix) for source in sources]


def to_csv(source: History, target: Path) -> list[Path]:
    """Write a history as CSV and its metadata beside it; returns both paths."""

    def table(path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.writer(file)
            writer.writerow(source.values)
            writer.writerows(zip(*([repr(v) for v in column.tolist()] for column in source.values.values()), strict=True))

    columns = [
        {
            "name": name,
            "titles": name,
            "datatype": "double",
            "dc:description": source.long_names[name],
            "schema:unitText": source.units[name],
        }
        for name in source.values
    ]
    about = {
        "@context": "http://www.w3.org/ns/csvw",
        "url": target.name,
        "tableSchema": {"columns": columns},
        "notes": [_about(source)],
    }
    text = json.dumps(about, indent=2, ensure_ascii=False) + "\n"
    metadata = target.with_name(f"{target.name}-metadata.json")
    return [_publish(target, table), _publish(metadata, lambda path: path.write_text(text, encoding="utf-8"))]


def to_parquet(source: History, target: Path) -> list[Path]:
    """Write a history as Parquet: doubles; `unit` and `long_name` of each field; the key `aeroslosh` of the schema is JSON.

    Raises AeroSloshError where pyarrow is not installed.
    """
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError:
        raise AeroSloshError("Parquet needs pyarrow", "aeroslosh export parquet", "pip install 'aeroslosh[parquet]'") from None
    fields = [
        pyarrow.field(name, pyarrow.float64(), metadata={"unit": source.units[name], "long_name": source.long_names[name]})
        for name in source.values
    ]
    schema = pyarrow.schema(fields, metadata={"aeroslosh": json.dumps(_about(source), ensure_ascii=False)})
    table = pyarrow.table(list(source.values.values()), schema=schema)
    return [_publish(target, lambda path: pyarrow.parquet.write_table(table, path))]


def to_vtk(run: Path, out: Path | None = None, copy: bool = False) -> tuple[Path, int, int]:
    """Collect the fields of a run into a .pvd, `out` or fields.pvd in the run folder; returns its path, times and files.

    copy: the field files go into a folder beside it, named like it; else they stay and are named relative to it.
    Raises AeroSloshError for a run without fields and for files of which nothing tells the time.
    """
    frames = fields(run)
    target = out or (run if run.is_dir() else run.parent) / "fields.pvd"
    if target.suffix != ".pvd":
        raise AeroSloshError(f"ParaView knows a collection by its ending, not as {target.name}", "--out", "end it in .pvd")
    base = run if run.is_dir() else run.parent

    def copied(file: Path) -> Path:
        inside = Path(os.path.relpath(file.resolve(), base.resolve()))
        place = target.with_suffix("") / (inside if ".." not in inside.parts else inside.name)
        if place.resolve() != file.resolve():
            place.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, place)
        return place

    try:
        if copy:
            frames = [(time, copied(file)) for time, file in frames]
        pvd.write(target, frames)
    except OSError as error:
        raise _unwritable(target, error) from None
    return target, len({time for time, _ in frames}), len(frames)


def fields(run: Path) -> list[pvd.Frame]:
    """Field files in a run folder and below (or named by a .pvd), each with its time [s]. Raises AeroSloshError for none.

    The time is what a collection there says, else what the file says, else that of the sample of the history which the number
    in its name counts.
    """
    if run.is_file() and run.suffix == ".pvd":
        return pvd.read(run)
    if not run.is_dir():
        raise AeroSloshError("There is no such run folder", str(run), "give the folder that a run wrote, with its fields")
    folders = [run, *sorted(path for path in run.rglob("*") if path.is_dir())]
    files = [file for folder in folders for file in pvd.field_files(folder)]
    if not files:
        remedy = "run again with output.fields = true and without --no-pictures; for one FMU, `aeroslosh drive --fields N`"
        raise AeroSloshError("The run wrote no fields", str(run), remedy)
    collections = [*run.glob("*.pvd"), *run.parent.glob(f"{run.name}.pvd")]
    told = {file.resolve(): time for path in collections for time, file in pvd.read(path)}
    samples = _samples(run)
    own = {file: told.get(file.resolve(), vtk.time_of(file)) for file in files}
    by_number = {(file.parent, pvd.number(file)): time for file, time in own.items() if time is not None}
    frames = []
    for file in files:
        count = pvd.number(file)
        time = own[file] if own[file] is not None else by_number.get((file.parent, count))
        if time is None and count < len(samples):
            time = samples[count]
        if time is None:
            remedy = "write the fields again: runs now leave a .pvd with their times"
            raise AeroSloshError("Nothing tells the time of a field file", str(file), remedy)
        frames.append((time, file))
    return frames


def _samples(run: Path) -> list[float]:
    """Times [s] of the run's history, where it has exactly one: the aero FMU numbers its fields by steps."""
    found = [*run.glob("*.nc")] or [*run.parent.glob("history.nc")]
    read = history_file.read(found[0]) if len(found) == 1 else []
    return read[0].values["time"].tolist() if len(read) == 1 and "time" in read[0].values else []


def _about(source: History) -> dict[str, Any]:
    """What the history says of itself, and the resolved case beside it."""
    case = source.path.with_name("case.toml")
    return source.attributes | ({"case": texts.read(case, "resolved case")} if case.is_file() else {})


def _publish(target: Path, write: Callable[[Path], Any]) -> Path:
    """Let `write` fill a temporary file and rename it. Raises AeroSloshError where the file cannot be written."""
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        with base_files.part(target) as hidden:
            write(hidden)
    except OSError as error:
        raise _unwritable(target, error) from None
    return target


def _unwritable(target: Path, error: OSError) -> AeroSloshError:
    return AeroSloshError(f"The file cannot be written: {error.strerror or error}", str(target), "give another with --out")
