"""`aeroslosh drive`: one FMU alone, driven by a table."""

from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

from ..base import disk
from ..base.errors import AeroSloshError, ExitCode
from ..case import fuel_tank
from ..fmi import installed, table_drive
from ..fmi.component import Component
from . import HELP


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["drive"]
    alone = commands.add_parser("drive", help=text, description=text)
    alone.add_argument("fmu", type=Path, metavar="FMU", help="a file, or the name of one of this package's FMUs: slosh_vof")
    alone.add_argument("--input", type=Path, required=True, metavar="CSV", help="column time [s], and inputs of the FMU by name")
    alone.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="a parameter of the FMU")
    alone.add_argument("--step", type=float, metavar="S", help="communication step [s] (default: the table's rows)")
    alone.add_argument(
        "--fields",
        type=int,
        metavar="N",
        help="write fields for ParaView and `animate` at the first row and every N-th, to the FMU's field_folder or "
        "fields beside --out, and the collection <folder>.pvd for ParaView; an earlier run's fields there are removed",
    )
    alone.add_argument("--out", type=Path, metavar="CSV", help="outputs (default <input>_<fmu>.csv, picture beside it)")
    alone.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    alone.add_argument("--no-pictures", action="store_true", help="no picture")
    alone.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One FMU alone, driven by a table; CSV and picture of what comes out."""
    table = table_drive.read(options.input)
    if options.step is not None:
        if not options.step > 0.0:
            raise AeroSloshError(f"--step {options.step:g}", "command line", "a step above 0 [s]")
        table = table.resampled(options.step)
    fmu = installed.named(options.fmu)
    target = options.out or options.input.with_name(f"{options.input.stem}_{fmu.stem}.csv")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise AeroSloshError(f"The folder cannot be made: {error.strerror}", str(target.parent), "give another --out") from None
    component = Component(fmu, fmu.stem)
    table_drive.set_parameters(component, options.set)
    table, derived = table_drive.completed(table, component.input_index)
    if derived:
        print(f"note: {', '.join(derived)} not in the table, taken from splines", file=sys.stderr)
    if options.fields is not None and options.fields < 1:
        raise AeroSloshError(f"--fields {options.fields}", "command line", "a number of rows, at least 1")
    folder = table_drive.prepare_fields(component, target.parent / "fields") if options.fields else None
    columns = table_drive.run(component, table, options.fields or 0)
    try:
        table_drive.write(target, columns)
    except OSError as error:
        raise disk.explained(error, target, "free space, or give another --out") from None
    files = [str(target)]
    if folder is not None:
        files += [os.path.relpath(folder), os.path.relpath(table_drive.collect_fields(folder, table, options.fields))]
    if not options.no_pictures:
        picture = target.with_suffix(".png")
        from ..pictures import table as table_picture  # matplotlib takes half a second to import

        table_picture.draw(picture, table, columns, {name: v.unit or "" for name, v in component.variables.items()})
        files.append(str(picture))
    steps = table.times.size - 1
    worst = float(columns["validity"].max()) if "validity" in columns else None
    if options.json:
        print(json.dumps({"steps": steps, "cpu_seconds": component.cpu, "files": files, "validity": worst}))
    else:
        print(f"{fmu.stem}: {steps} steps, {component.cpu:.2f} s CPU\n  " + "\n  ".join(files))
        edge = float(columns["validity_edge"].max()) if "validity_edge" in columns else fuel_tank.EDGE
        if worst is not None and not fuel_tank.holds(worst, edge):
            print(f"  note: {fuel_tank.broken(worst, edge)}")
    return ExitCode.OK
