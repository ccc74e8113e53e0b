"""`aeroslosh export`: a run's histories and fields in formats of other programs. Each format has its own arguments."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from master import export, history
from master.errors import ExitCode

WRITERS = {"csv": export.to_csv, "parquet": export.to_parquet}


def register(commands: Any) -> None:
    """The command line."""
    text = "write a run's histories or fields for other programs"
    formats = commands.add_parser("export", help=text, description=text).add_subparsers(
        dest="format", required=True, metavar="FORMAT"
    )
    table = formats.add_parser(
        "csv",
        help="histories as CSV",
        description="histories as CSV: a header of names, exact numbers; units and provenance in <file>.csv-metadata.json",
    )
    _add_table(table)
    columns = formats.add_parser(
        "parquet",
        help="histories as Parquet",
        description="histories as Parquet, units and provenance as metadata (needs the extra: pip install 'aeroslosh[parquet]')",
    )
    _add_table(columns)
    film = formats.add_parser(
        "vtk",
        help="fields as a ParaView collection",
        description="the run's field files with their times in one .pvd, which ParaView opens as an animation",
    )
    film.add_argument("path", type=Path, metavar="PATH", help="a run folder, or a folder of fields")
    film.add_argument("--out", type=Path, metavar="PVD", help="default PATH/fields.pvd; names the files relative to itself")
    film.add_argument("--copy", action="store_true", help="copy the field files beside the .pvd, into a folder named like it")
    film.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    film.set_defaults(execute=_fields)


def _add_table(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("path", type=Path, metavar="PATH", help="a run folder, a sweep folder or a history (.nc)")
    sub.add_argument("--out", type=Path, metavar="FILE", help="the file, or a folder for several (default beside each history)")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=_tables)


def _tables(options: argparse.Namespace) -> int:
    """Every history of the path as a table."""
    sources = [found for path in history.find(options.path) for found in history.read(path)]
    targets = export.targets(sources, options.out, f".{options.format}")
    files = [file for s, target in zip(sources, targets, strict=True) for file in WRITERS[options.format](s, target)]
    samples = sum(s.size for s in sources)
    if options.json:
        print(json.dumps({"histories": len(sources), "samples": samples, "files": [str(path) for path in files]}))
    else:
        word = "history" if len(sources) == 1 else "histories"
        print(f"{len(sources)} {word}, {samples} samples\n" + "\n".join(f"  {os.path.relpath(path)}" for path in files))
    return ExitCode.OK


def _fields(options: argparse.Namespace) -> int:
    """The fields of a run as one collection."""
    path, times, files = export.to_vtk(options.path, options.out, options.copy)
    if options.json:
        print(json.dumps({"times": times, "fields": files, "files": [str(path)]}))
    else:
        print(f"{files} field files at {times} times\n  {os.path.relpath(path)}")
    return ExitCode.OK
