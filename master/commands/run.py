"""`aeroslosh run`: any system of FMUs, from a system file."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import ExitCode, show
from ..case import builtin
from ..cosim import system_file as assemblies
from ..cosim import system_run
from ..cosim.progress import Progress
from ..cosim.system_file import Assembly
from ..cosim.system_run import Simulation
from ..fmi import installed, table_drive
from ..results.history_writer import write_simulation
from ..results.provenance import provenance
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
    progress = Progress(options.quiet or options.json)
    files = assemblies.find(assembly, options.fmus)
    with RunFolder(options.out or Path("runs") / f"{assembly.name}_run") as folder:
        folder.write_settings(assemblies.dump(assembly))
        system = assemblies.build(assembly, files)
        try:
            hashes = {c.name: c.sha256 for c in system.everyone}
            settings = assemblies.flat(assembly)
            keeper = common.keeper(options, settings, hashes)
            start = common.restart(options, settings, hashes, ("run.end", "run.pictures"))
            for loop in system.loops:
                folder.log(f"algebraic loop, closed by the coupling scheme {assembly.coupling.scheme}: {' '.join(loop)}")
            if assembly.dt != assembly.run.step:
                common.say(f"steps of {assembly.dt!r} s: the run holds no whole number of run.step", folder, progress)
            progress.start(assembly.name)
            result = system_run.simulate(assembly, system, progress.watch, keeper, start)
            folder.log_messages(system.everyone)
        finally:
            system.close()
        folder.keep()
        about, data = provenance(hashes), system_run.data(result)
        text = _summary(assembly, data)
        folder.log(text)
        with common.printed(options, data, text, folder):
            write_simulation(folder.path / "history.nc", result, about)
            folder.write_result(data | {"provenance": about})
            if assembly.run.pictures and not options.no_pictures:
                _draw(folder.path / "histories.png", result)
        if result.failure is not None:
            show(result.failure)
            return ExitCode.COMPONENT
        return ExitCode.OK if result.converged else ExitCode.UNDETERMINED


def _draw(path: Path, result: Simulation) -> None:
    nothing = table_drive.Table(result.time, [], np.zeros((result.time.size, 0)))
    from ..pictures import table as table_picture  # matplotlib takes half a second to import

    table_picture.draw(path, nothing, {"time": result.time, **result.outputs}, result.units)


def _summary(assembly: Assembly, data: dict[str, Any]) -> str:
    """What a person wants to know of a run."""
    scheme, cost = data["scheme"], data["cost"]
    shares = ", ".join(f"{name} {seconds:.2f} s" for name, seconds in cost["cpu_seconds_by_component"].items())
    lines = [f"{assembly.name}: {data['outcome']}", f"  end          t = {data['end_time']:g} s, {scheme['steps']} steps"]
    if scheme["passes_mean"] is not None and scheme["passes_max"] > 1:
        lines.append(f"  coupling     {scheme['passes_mean']:.2f} passes a step, {scheme['passes_max']} at most")
    for name, value in data["last"].items():
        if name.endswith(".validity") and (value is not None and value > 1.0):
            lines.append(f"  note: {name.removesuffix('.validity')} says that it does not hold (validity {value:.3g}, edge 1)")
    if assembly.dt != assembly.run.step:
        lines.append(f"  note: steps of {assembly.dt:.6g} s: the run holds no whole number of run.step = {assembly.run.step:g} s")
    lines.append(f"  cost         {cost['wall_seconds']:.1f} s wall, {cost['cpu_seconds']:.1f} s CPU ({shares})")
    return "\n".join(lines)
