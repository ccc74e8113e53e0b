"""What commands share: the words of the command line that belong to a case, what is said and printed."""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from ..api.point import DOUBTS, noted
from ..base.errors import AeroSloshError
from ..case import builtin, checks
from ..case import case as cases
from ..case.case import Case
from ..cosim import checkpoint
from ..cosim.checkpoint import Checkpoint, Keeper
from ..cosim.progress import Progress
from ..fmi import installed
from ..results.run_folder import RunFolder

EVERY = 500  # steps between two checkpoints


def add_case(sub: argparse.ArgumentParser) -> None:
    """Arguments of every command that runs a flutter case."""
    sub.add_argument(
        "case", type=builtin.case_path, metavar="CASE", help=f"a TOML case, or a built-in one: {', '.join(builtin.names())}"
    )
    sub.add_argument("--slosh", metavar="MODEL", help="none, frozen, ems, rbf or vof, instead of slosh.model")
    sub.add_argument("--set", action="append", default=[], metavar="TABLE.KEY=VALUE", help="change any key of the case")
    sub.add_argument("--fmus", type=Path, metavar="DIR", default=installed.folder(), help="folder of the FMUs")
    sub.add_argument("--no-pictures", action="store_true", help="no pictures and no flow fields")
    add_output(sub, "run folder (default runs/<case>_<command>[_<slosh>])")


def add_output(sub: argparse.ArgumentParser, out: str) -> None:
    """Arguments of every command that writes a folder and may be read by a program."""
    sub.add_argument("--out", type=Path, metavar="DIR", help=out)
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.add_argument("--quiet", action="store_true", help="no progress")


def add_checkpoint(sub: argparse.ArgumentParser) -> None:
    """Arguments of commands that make one long march."""
    sub.add_argument("--checkpoint", type=Path, metavar="FILE", help="write the march to FILE as it goes (see --every)")
    sub.add_argument("--every", type=int, metavar="N", help=f"steps between two checkpoints (default {EVERY})")
    sub.add_argument("--restart", type=Path, metavar="FILE", help="go on from a checkpoint, as if there had been no interruption")


def keeper(options: argparse.Namespace, settings: dict[str, Any], hashes: dict[str, str]) -> Keeper | None:
    """What writes the checkpoints asked for. Raises AeroSloshError."""
    file, every = options.checkpoint, EVERY if options.every is None else options.every
    if every < 1:
        raise AeroSloshError(f"--every {every}", "command line", "a number of steps, at least 1")
    if file is None:
        if options.every is not None:
            raise AeroSloshError("--every without --checkpoint", "command line", "name the file too: --checkpoint FILE")
        return None
    folder = file.absolute().parent
    if not folder.is_dir():
        raise AeroSloshError("There is no folder for the checkpoint", str(file), "create it, or name another file")
    if file.is_dir():
        raise AeroSloshError("The checkpoint is a folder", str(file), "name a file")
    try:
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise AeroSloshError(f"The checkpoint cannot be written: {error.strerror}", str(file), "name another file") from None
    return Keeper(file, every, {"case": settings, "fmu_sha256": hashes})


def restart(
    options: argparse.Namespace, settings: dict[str, Any], hashes: dict[str, str], free: tuple[str, ...]
) -> Checkpoint | None:
    """The checkpoint to go on from, if one is asked for; settings but for those in `free` must be those it was written with.

    Raises AeroSloshError."""
    if options.restart is None:
        return None
    found = checkpoint.read(options.restart)
    checkpoint.check(found, settings, hashes, free)
    return found


def load_case(options: argparse.Namespace, command: str = "", changes: Mapping[str, Any] = {}) -> Case:
    """The case with what the command line changes in it; `changes`: key → TOML value of the command's own options, None for
    one not given; `command` as in `case.load`. Raises AeroSloshError."""
    liquid = {"slosh.model": options.slosh}
    own = [f"{name}={value}" for name, value in (liquid | dict(changes)).items() if value is not None]
    case = cases.load(options.case, [*options.set, *own], command)
    if options.no_pictures:
        case.output.pictures = case.output.fields = False
    return case


def tell(options: argparse.Namespace, asked: Sequence[Case], command: str, log: Callable[[str], None]) -> dict[str, Any]:
    """Say what nobody gave in the cases `asked` (the points of a sweep, or one) and what is unusual in any of them: into the
    log, and on standard error but with --json; as data."""
    silent, found = checks.told(asked[0], command), noted(asked, command)
    doubts = found["warnings"]
    more = [f"warning: {len(doubts) - DOUBTS} more of the kind"] if len(doubts) > DOUBTS else []
    for text in [*([silent] if silent else []), *(f"warning: {doubt}" for doubt in doubts[:DOUBTS]), *more]:
        log(text)
        if not options.json:
            print(text, file=sys.stderr, flush=True)
    return found


def run_folder(options: argparse.Namespace, name: str) -> Path:
    """Where the command's results go: --out, or below runs/."""
    liquid = f"_{options.slosh}" if options.slosh is not None else ""
    return options.out or Path("runs") / f"{name}_{options.command}{liquid}"


def say(text: str, folder: RunFolder, progress: Progress) -> None:
    """Into run.log and onto standard error."""
    folder.log(text)
    progress.say(text)


@contextmanager
def printed(options: argparse.Namespace, data: dict[str, Any], summary: str, folder: RunFolder) -> Iterator[None]:
    """JSON for programs, the summary for people, after the block that writes the files; also where that fails."""
    try:
        yield
    except Exception:
        _print(options, data, summary)
        raise
    _print(options, data, f"{summary}\n  run folder   {os.path.relpath(folder.target)}")


def _print(options: argparse.Namespace, data: dict[str, Any], text: str) -> None:
    print(json.dumps(data, allow_nan=False) if options.json else text)
