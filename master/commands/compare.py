"""`aeroslosh compare`: do two runs tell the same?"""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ..base.errors import ExitCode
from ..results import compare, compare_text, past_run
from . import HELP

EPILOG = (
    "exit codes: 0 the same (within the tolerance), 1 different, 2 bad input; cost, settings and provenance alone never make it 1"
)


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["compare"]
    sub = commands.add_parser("compare", help=f"{text} (exit code 1 when results differ)", description=text, epilog=EPILOG)
    where = "a run folder or sweep folder, a result.json, or a history (.nc)"
    sub.add_argument("a", type=Path, metavar="A", help=where)
    sub.add_argument("b", type=Path, metavar="B", help="another of the same command")
    sub.add_argument(
        "--tolerance",
        type=float,
        default=0.0,
        metavar="X",
        help="relative to a number's value (a growth rate: to the frequency) and a channel's range; judges the headline numbers "
        "and the channels of the physics (default 0: every bit)",
    )
    sub.add_argument("--all", action="store_true", help="everything that differs, cost, and channels that do not")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Summary and details of two runs."""
    found = compare.compare(past_run.load(options.a), past_run.load(options.b), options.tolerance)
    if options.json:
        print(json.dumps(compare_text.data(found), allow_nan=False))
    else:
        print(compare_text.summary(found))
        if more := compare_text.details(found, options.all):
            print(more)
    return ExitCode.DIFFERENT if found.different else ExitCode.OK
