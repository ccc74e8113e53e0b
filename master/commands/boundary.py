"""`aeroslosh boundary`: the neutral V_f of the case's Mach numbers."""

from __future__ import annotations

import argparse
import sys
from typing import Any

from ..api import boundary as api
from ..api import side_by_side
from ..base.errors import ExitCode, show
from ..boundary.search import BoundaryPoint
from ..case import fuel_tank
from ..cosim.progress import Progress
from ..flutter.setup import find_fmus
from ..results import summary as results_summary
from ..results import trust
from ..results.run_folder import RunFolder
from . import HELP, common

GRAVITY = (ExitCode.OK, ExitCode.UNDETERMINED, ExitCode.INPUT, ExitCode.INCOMPLETE, ExitCode.COMPONENT, ExitCode.INTERNAL)


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["boundary"]
    sub = commands.add_parser("boundary", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--mach", type=float, metavar="M", nargs="+", help="instead of boundary.mach")
    sub.add_argument("--vf", type=float, metavar="V", help="where to start, instead of flutter.V_f")
    sub.add_argument("--method", metavar="WORD", help="linear, march or both, instead of boundary.method")
    sub.add_argument("--uncertainty", action="store_true", help="step, amplitude and mesh into the error bars (3 more marches)")
    sub.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes that search Mach numbers side by side, to the same results (default: one for each usable core; "
        "--method march takes one: each Mach number begins where the one before it crossed)",
    )
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Every Mach number's neutral V_f."""
    changes = {
        "boundary.mach": options.mach or None,
        "flutter.V_f": options.vf,
        "boundary.method": options.method,
        "boundary.uncertainty": "true" if options.uncertainty else None,
    }
    workers = side_by_side.wanted(options.workers, f"--workers {options.workers}", "command line")
    case = common.load_case(options, "boundary", changes)
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    api.check_fmus(case, fmus)
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        kept = api.Kept(case, folder, common.tell(options, [case], "boundary", folder.log))
        try:
            points = api.compute(case, fmus, kept, progress, workers)
        except OSError as error:
            raise kept.unwritable(error) from None
        except KeyboardInterrupt as stop:
            stop.add_note(kept.told())
            raise
        data = kept.data()
        summary = results_summary.boundary_summary(data["points"])
        folder.log("\n" + summary)
        spent = f"{data['cost']['wall_seconds']:.1f} s wall, {data['cost']['cpu_seconds']:.1f} s CPU"
        label = fuel_tank.LABEL[case.slosh.model]
        if case.boundary.method == "linear" and case.slosh.model not in ("none", "frozen"):
            label += ", carried frozen by the linear method"
        section = [results_summary.airfoil_line(kept.airfoil)] if kept.airfoil else []
        text = "\n".join([f"Flutter boundary of {case.name}, {label}", summary, *section, f"  cost         {spent}"])
        with common.printed(options, data, text, folder):
            api.draw(case, points, kept, folder)
        return _exit_code(points)


def _exit_code(points: list[BoundaryPoint]) -> int:
    """What scripts learn; failures are shown, the gravest decides."""
    codes = [ExitCode.OK if all(trust.decided(p) for p in points) else ExitCode.UNDETERMINED]
    for p in points:
        if p.failure is not None and p.converged:  # a march failed, the search went round it: its log tells more
            print(f"note: Mach {p.mach:g}: {p.failure.what}", file=sys.stderr)
        elif p.failure is not None:
            show(p.failure)
            codes.append(p.failure.code)
    return max(codes, key=GRAVITY.index)
