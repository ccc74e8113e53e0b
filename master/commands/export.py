"""`aeroslosh export`: a run's histories and fields in formats of other programs, a coupled system for other co-simulation tools.
Each format has its own arguments."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from ..base import settings
from ..base.errors import AeroSloshError, ExitCode
from ..case import builtin
from ..case import case as cases
from ..cosim import system_file as assemblies
from ..cosim.progress import Progress
from ..flutter.setup import find_fmus
from ..fmi import installed
from ..results import export, history_file
from ..ssp import archive as ssp_archive
from ..ssp import system as ssp_system
from ..ssp.system import Coupled
from . import HELP, common

WRITERS = {"csv": export.to_csv, "parquet": export.to_parquet}


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["export"]
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
    _add_system(formats)


def _add_table(sub: argparse.ArgumentParser) -> None:
    sub.add_argument("path", type=Path, metavar="PATH", help="a run folder, a sweep folder or a history (.nc)")
    sub.add_argument("--out", type=Path, metavar="FILE", help="the file, or a folder for several (default beside each history)")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=_tables)


def _add_system(formats: Any) -> None:
    sub = formats.add_parser(
        "ssp",
        help="a coupled system as an SSP 1.0 archive",
        description="a flutter case at its Mach number and V_f, or a system file, as an SSP 1.0 archive of FMUs, parameters with "
        "units and connections, for FMPy, libcosim, ecos, OMSimulator and others (docs/ssp.md)",
    )
    sub.add_argument(
        "path", type=builtin.case_path, metavar="FILE.toml", help="a case (or the name of a built-in one), or a system file"
    )
    sub.add_argument("--slosh", metavar="MODEL", help="none, frozen, ems, rbf or vof, instead of slosh.model")
    sub.add_argument("--mach", type=float, metavar="M", help="instead of flow.mach")
    sub.add_argument("--vf", type=float, metavar="V", help="instead of flutter.V_f")
    sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the file")
    sub.add_argument(
        "--prediction",
        choices=["none", "linear"],
        help="whether the FMUs extrapolate their inputs over a step, as SSP tools do not "
        "(default: linear where coupling.predictor_order is above 0 and the scheme is not implicit; docs/ssp.md)",
    )
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=installed.folder(), help="folder of the FMUs")
    sub.add_argument("--out", type=Path, metavar="FILE.ssp", help="the archive (default <case>[_<slosh>].ssp)")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=_system)


def _system(options: argparse.Namespace) -> int:
    """A case or a system file as an archive."""
    content, _ = settings.read(options.path, "case or system file", "cases/paper_s.toml")
    coupled = _from_assembly(options) if "components" in content else _from_case(options)
    liquid = f"_{options.slosh}" if options.slosh is not None else ""
    target = options.out or Path(f"{coupled.name}{liquid}.ssp")
    if target.suffix != ".ssp":
        raise AeroSloshError(f"SSP tools know an archive by its ending, not as {target.name}", "--out", "end it in .ssp")
    ssp_archive.write(coupled, target)
    if options.json:
        data = {
            "file": str(target),
            "components": {part.name: {"fmu": part.path.name, "values": part.values} for part in coupled.parts},
            "connections": [str(wire) for wire in coupled.wires],
            "start": coupled.start,
            "stop": coupled.stop,
            "step": coupled.dt,
            "steps": coupled.steps,
            "settings_sha256": coupled.settings_sha256,
            "notes": coupled.notes,
        }
        print(json.dumps(data))
    else:
        names = ", ".join(f"{part.name} ({part.path.name}, {len(part.values)} values)" for part in coupled.parts)
        lines = [f"{os.path.relpath(target)}: {coupled.description}", f"  components   {names}"]
        lines.append(
            f"  step         {coupled.dt!r} s, {coupled.steps} of them from t = {coupled.start!r} s: give it to the tool"
        )
        print("\n".join(lines + [f"  note: {note}" for note in coupled.notes]))
    return ExitCode.OK


def _from_case(options: argparse.Namespace) -> Coupled:
    given = {"slosh.model": options.slosh, "flow.mach": options.mach, "flutter.V_f": options.vf}
    overrides = [f"{key}={value}" for key, value in given.items() if value is not None]
    case = cases.load(options.path, [*options.set, *overrides], "point")
    common.tell(options, [case], "point", lambda text: None)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    return ssp_system.from_case(case, fmus, options.prediction, Progress(options.json).say)


def _from_assembly(options: argparse.Namespace) -> Coupled:
    for name in ("slosh", "mach", "vf"):
        if getattr(options, name) is not None:
            flag = f"--{name}"
            raise AeroSloshError(
                f"{flag} belongs to a flutter case, and this is a system file",
                f"{flag} {getattr(options, name)}, {options.path}",
                "set a component's parameter: --set components.NAME.parameters.VARIABLE=VALUE",
            )
    assembly = assemblies.load(options.path, options.set)
    return ssp_system.from_assembly(assembly, assemblies.find(assembly, options.fmus), options.prediction)


def _tables(options: argparse.Namespace) -> int:
    """Every history of the path as a table."""
    sources = [found for path in history_file.find(options.path) for found in history_file.read(path)]
    if not sources:
        raise AeroSloshError(
            "None of its points has a history: points that failed at once and boundaries of a linear model march nothing",
            str(options.path),
            'its table is sweep.csv; marches come with boundary.method = "both"',
        )
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
