"""`aeroslosh amplitude`: limit cycles and damping over amplitude at several V_f of a Mach number."""

from __future__ import annotations

import argparse
import dataclasses
from typing import Any

from ..api import amplitude as api
from ..api.point import check_fmus
from ..base.errors import ExitCode
from ..cosim.progress import Progress
from ..flutter.setup import find_fmus
from ..results.amplitude_text import said
from ..results.run_folder import RunFolder
from . import HELP, common


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["amplitude"]
    sub = commands.add_parser("amplitude", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--mach", type=float, metavar="M", help="instead of flow.mach")
    sub.add_argument("--vf", type=float, metavar="V", nargs="+", help="V_f to look at, instead of flutter.V_f")
    sub.add_argument(
        "--from", type=float, metavar="DEG", nargs="+", dest="starts", default=list(api.START_DEG),
        help="amplitudes of the forced pitch from which marches begin (default: %(default)s)",
    )  # fmt: skip
    sub.add_argument(
        "--cycles", type=float, metavar="N", default=api.FREE_CYCLES, help="free cycles a march (default: %(default)s)"
    )
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """March, read envelopes, confirm."""
    starts = api.checked_starts(options.starts, f"--from {options.starts}", "command line")
    changes = {"flow.mach": options.mach, "flutter.free_cycles": options.cycles, "flutter.max_free_cycles": options.cycles}
    if options.vf:
        changes["flutter.V_f"] = options.vf[0]
    case = common.load_case(options, "point", changes)
    case = dataclasses.replace(case, output=dataclasses.replace(case.output, fields=False))
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    check_fmus(case, fmus)
    progress = Progress(options.quiet or options.json)
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        told = common.tell(options, [case], "point", folder.log)
        speeds = options.vf or [case.flutter.V_f]
        data = api.compute(case, fmus, speeds, starts, progress, folder) | told
        summary = "\n".join([f"{case.name}, Mach {case.flow.mach:g}: limit cycles", *("  " + said(r) for r in data["speeds"])])
        folder.log(summary)
        with common.printed(options, data, summary, folder):
            api.write(case, data, folder, fmus)
    return ExitCode.OK if any(row["curve"] for row in data["speeds"]) else ExitCode.UNDETERMINED
