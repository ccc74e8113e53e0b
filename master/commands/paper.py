"""`aeroslosh paper`: the paper's figures and its table computed here, with a verdict on each."""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from ..base import disk
from ..base.errors import AeroSloshError, ExitCode
from ..fmi import installed
from ..paper import run as runs
from ..paper.catalogue import FIGURES
from ..paper.work import Work
from . import HELP, common


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["paper"]
    sub = commands.add_parser("paper", help=text, description=text, epilog=f"figures: {', '.join(FIGURES)}")
    sub.add_argument("figures", nargs="*", metavar="FIGURE", help="figures to compute (--list names them)")
    sub.add_argument("--all", action="store_true", help="all of them")
    sub.add_argument("--list", action="store_true", help="name the figures, compute nothing")
    sub.add_argument("--fresh", action="store_true", help="compute anew what is there")
    sub.add_argument(
        "--coarse", action="store_true", help="coarse meshes, few points: to see that all runs; verdicts mean little"
    )
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=installed.folder(), help="folder of the FMUs")
    sub.add_argument(
        "--workers",
        type=int,
        metavar="N",
        help="processes that search Mach numbers side by side (default: one for each usable core)",
    )
    common.add_output(sub, "folder of the figures (default runs/paper); what is finished there is kept")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Compute, tell, write the table."""
    if options.list:
        wide = max(map(len, FIGURES))
        print(json.dumps(FIGURES) if options.json else "\n".join(f"{name:{wide}}  {text}" for name, text in FIGURES.items()))
        return ExitCode.OK
    names = runs.chosen(options.figures, options.all)
    if options.workers is not None and options.workers < 1:
        raise AeroSloshError(f"--workers {options.workers}", "command line", "a number of processes, at least 1")
    out = options.out or Path("runs") / "paper"
    installed.ensure(options.fmus)
    quiet = options.quiet or options.json

    def say(text: str) -> None:
        if not quiet:
            print(text, file=sys.stderr, flush=True)

    work = Work(out, options.fmus, options.coarse, options.workers, options.fresh, say)
    try:
        out.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise AeroSloshError(f"The folder cannot be made: {error.strerror}", str(out), "give another --out") from None
    try:
        rows = runs.run(work, names)
        runs.write(out, rows, work.key)
    except OSError as error:
        raise disk.explained(error, out, "free space, or give another folder with --out") from None
    print(json.dumps(runs.data(rows)) if options.json else f"{runs.table(rows)}\n  {out / 'paper.md'}")
    return runs.exit_code(rows)
