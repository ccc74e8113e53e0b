"""`aeroslosh run`: any system of FMUs, from a system file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from ..api import simulate as api
from ..base.errors import ExitCode, show
from ..case import builtin
from ..cosim import system_file as assemblies
from ..cosim.checkpoint import Checkpoint, Keeper
from ..cosim.progress import Progress
from ..cosim.system_file import Assembly
from ..fmi import installed
from ..results.run_folder import RunFolder
from . import HELP, common


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["run"]
    sub = commands.add_parser("run", help=text, description=text)
    sub.add_argument(
        "system", type=builtin.case_path, metavar="SYSTEM", help="a TOML system file, or the built-in tank_on_springs"
    )
    sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the file")
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=installed.folder(), help="folder of the FMUs")
    sub.add_argument("--no-pictures", action="store_true", help="no picture")
    common.add_output(sub, "run folder (default runs/<system>_run)")
    common.add_checkpoint(sub)
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One run."""
    assembly = assemblies.load(options.system, options.set)
    assembly.run.pictures = assembly.run.pictures and not options.no_pictures
    progress = Progress(options.quiet or options.json)
    files = assemblies.find(assembly, options.fmus)
    with RunFolder(options.out or Path("runs") / f"{assembly.name}_run") as folder:
        folder.write_settings(assemblies.dump(assembly))

        def keep(hashes: dict[str, str]) -> tuple[Keeper | None, Checkpoint | None]:
            settings = assemblies.flat(assembly)
            return common.keeper(options, settings, hashes), common.restart(
                options, settings, hashes, ("run.end", "run.pictures")
            )

        ran = api.compute(assembly, files, progress, folder, keep)
        folder.keep()
        text = _summary(assembly, ran.data)
        folder.log(text)
        with common.printed(options, ran.data, text, folder):
            api.write(assembly, ran, folder)
        if ran.result.failure is not None:
            show(ran.result.failure)
            return ExitCode.COMPONENT
        return ExitCode.OK if ran.result.converged else ExitCode.UNDETERMINED


def _summary(assembly: Assembly, data: dict[str, Any]) -> str:
    """What a person wants to know of a run."""
    scheme, cost = data["scheme"], data["cost"]
    shares = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in cost["cpu_seconds_by_component"].items())
    lines = [f"{assembly.name}: {data['outcome']}", f"  end          t = {data['end_time']:g} s, {scheme['steps']} steps"]
    if scheme["passes_mean"] is not None and scheme["passes_max"] > 1:
        lines.append(f"  coupling     {scheme['passes_mean']:.2f} passes a step, {scheme['passes_max']} at most")
    for name, value in data["last"].items():
        edge = data["last"].get(f"{name}_edge") or 1.0
        if name.endswith(".validity") and (value is not None and value > edge):
            lines.append(
                f"  note: {name.removesuffix('.validity')} says that it does not hold (validity {value:.3g}, edge {edge:g})"
            )
    if assembly.dt != assembly.run.step:
        lines.append(f"  note: steps of {assembly.dt:.6g} s: the run holds no whole number of run.step = {assembly.run.step:g} s")
    lines.append(f"  cost         {cost['wall_seconds']:.1f} s wall, {cost['cpu_seconds']:.1f} s CPU ({shares})")
    return "\n".join(lines)
