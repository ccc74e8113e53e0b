"""`aeroslosh point`: march one Mach number and V_f."""

from __future__ import annotations

import argparse
from typing import Any

from ..analysis.verdict import Verdict
from ..api import point as api
from ..base.errors import ExitCode, show
from ..case import case as cases
from ..cosim import checkpoint
from ..cosim.progress import Progress
from ..flutter.setup import find_fmus
from ..fmi import unpack
from ..results import summary as results_summary
from ..results import trust
from ..results.run_folder import RunFolder
from . import HELP, common

# what may differ from the checkpoint's: a march may grow
FREE = ("flutter.free_cycles", "flutter.max_free_cycles", "output.pictures", "output.fields")


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["point"]
    sub = commands.add_parser("point", help=text, description=text)
    common.add_case(sub)
    sub.add_argument("--mach", type=float, metavar="M", help="instead of flow.mach")
    sub.add_argument("--vf", type=float, metavar="V", help="instead of flutter.V_f")
    common.add_checkpoint(sub)
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One march."""
    case = common.load_case(options, "point", {"flow.mach": options.mach, "flutter.V_f": options.vf})
    progress = Progress(options.quiet or options.json)
    fmus = find_fmus(options.fmus, case.slosh.model, case.slosh.predictor)
    api.check_fmus(case, fmus)
    files, settings = api.files(case, fmus), cases.flat(case)
    hashes = {name: unpack.sha256(path) for name, path in files.items()}
    # all this before the steady flow, which may take minutes
    keeper, start = common.keeper(options, settings, hashes), common.restart(options, settings, hashes, FREE)
    if keeper is not None:
        checkpoint.check_files({name: path for name, path in files.items() if (name, case.slosh.model) != ("slosh", "frozen")})
    with RunFolder(common.run_folder(options, case.name)) as folder:
        folder.write_case(case)
        told = common.tell(options, [case], "point", folder.log)
        no_fields = start is not None and not start.about["case"]["output.fields"]
        if no_fields and case.output.fields:
            common.say("no flow fields: the march to go on with began without a folder for them", folder, progress)
        computed = api.compute(case, fmus, progress, folder, keeper, start, not no_fields)
        computed.data |= told
        march = computed.march
        folder.keep()  # a failed march's history is worth keeping
        summary = results_summary.march_summary(computed.data)
        folder.log(summary)
        if march.failure is not None:
            folder.log(f"{march.failure}\n{march.failure.traceback}")
        with common.printed(options, computed.data, summary, folder):
            api.write(case, computed, folder)
        if march.failure is not None:
            show(march.failure)
            return ExitCode.COMPONENT
        return ExitCode.UNDETERMINED if trust.verdict(march) is Verdict.UNDETERMINED else ExitCode.OK
