"""`aeroslosh report`: a run as one HTML page that can be sent."""

from __future__ import annotations

import argparse
import json
import os
from pathlib import Path
from typing import Any

from ..api import report as api
from ..base.errors import ExitCode
from . import HELP


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["report"]
    sub = commands.add_parser("report", help=text, description=text)
    sub.add_argument(
        "path", type=Path, metavar="RUN", help="a run folder of point, boundary, amplitude or run, or a sweep folder"
    )
    sub.add_argument("--out", type=Path, metavar="FILE.html", help="the page (default RUN/report.html)")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One page."""
    written = api.report(options.path, options.out)
    size = written.stat().st_size
    if options.json:
        print(json.dumps({"file": str(written), "bytes": size}))
    else:
        print(f"{os.path.relpath(written)}: {size / 1024:.0f} KiB, opens in any browser, needs no network")
    return ExitCode.OK
