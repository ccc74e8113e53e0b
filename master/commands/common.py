"""What commands share: the words of the command line that belong to a case, what is said and printed."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from master import case as cases
from master.case import Case
from master.component import Component
from master.errors import AeroSloshError, ComponentError
from master.progress import Progress
from master.record import RunFolder


def show(error: AeroSloshError) -> None:
    """An error on standard error; a component's with its own traceback."""
    print(f"aeroslosh: {error}", file=sys.stderr)
    if isinstance(error, ComponentError) and error.traceback:
        print(f"  {error.component} says:", file=sys.stderr)
        for line in error.traceback.strip().splitlines():
            print(f"    | {line}", file=sys.stderr)


def add_case(sub: argparse.ArgumentParser) -> None:
    """Arguments of every command that runs a flutter case."""
    sub.add_argument("case", type=Path, metavar="CASE", help="a TOML case, e.g. cases/isogai_a.toml")
    sub.add_argument("--slosh", metavar="MODEL", help="none, frozen, ems, rbf or vof, instead of slosh.model")
    sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the case")
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=default_fmus(), help="folder of the FMUs")
    sub.add_argument("--no-pictures", action="store_true", help="no pictures and no flow fields")
    add_output(sub, "run folder (default runs/<case>_<command>[_<slosh>])")


def add_output(sub: argparse.ArgumentParser, out: str) -> None:
    """Arguments of every command that writes a folder and may be read by a program."""
    sub.add_argument("--out", type=Path, metavar="DIR", help=out)
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.add_argument("--quiet", action="store_true", help="no progress")


def default_fmus() -> Path:
    """AEROSLOSH_FMUS, or dist/fmus beside the checkout."""
    return Path(os.environ.get("AEROSLOSH_FMUS") or Path(__file__).resolve().parents[2] / "dist" / "fmus")


def load_case(options: argparse.Namespace) -> Case:
    """The case with what the command line changes in it."""
    case = cases.load(options.case, options.set)
    if options.slosh is not None:
        cases.apply_override(case, f"slosh.model={options.slosh}")
    if options.no_pictures:
        case.output.pictures = case.output.fields = False
    return case


def run_folder(options: argparse.Namespace, name: str) -> Path:
    """Where the command's results go: --out, or below runs/."""
    liquid = f"_{options.slosh}" if options.slosh is not None else ""
    return options.out or Path("runs") / f"{name}_{options.command}{liquid}"


def say(text: str, folder: RunFolder, progress: Progress) -> None:
    """Into run.log and onto standard error."""
    folder.log(text)
    progress.say(text)


def log_messages(components: Iterable[Component], folder: RunFolder) -> None:
    """The FMUs' log messages into run.log, each once."""
    for component in components:
        for status, text in component.messages:
            folder.log(f"{component.name} (status {status}): {text}")
        component.messages.clear()


def print_result(options: argparse.Namespace, data: dict[str, Any], summary: str, folder: RunFolder) -> None:
    """JSON for programs, the summary for people."""
    if options.json:
        print(json.dumps(data, allow_nan=False))
    else:
        print(f"{summary}\n  run folder   {os.path.relpath(folder.target)}")
