"""`aeroslosh init`: a commented case to fill in."""

from __future__ import annotations

import argparse
import json
import shlex
from pathlib import Path
from typing import Any

from ..base import files
from ..base.errors import AeroSloshError, ExitCode
from . import HELP

MODELS = ("none", "frozen", "ems", "rbf", "vof")


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["init"]
    sub = commands.add_parser("init", help=text, description=text)
    sub.add_argument(
        "file", type=Path, nargs="?", default=Path("my_wing.toml"), metavar="FILE.toml", help="(default my_wing.toml)"
    )
    sub.add_argument("--slosh", choices=MODELS, default="none", help="write the keys of a tank out as well")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One file; none is overwritten."""
    from ..case import template

    path: Path = options.file
    if path.suffix != ".toml":
        raise AeroSloshError(f"A case ends in .toml, not as {path.name}", "command line", f"aeroslosh init {path.name}.toml")
    if path.exists():
        raise AeroSloshError("The file is there already", str(path), "give another name; nothing was changed")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        files.write(path, template.text(path.stem, options.slosh).encode("utf-8"))
    except OSError as error:
        raise AeroSloshError(f"The case cannot be written: {error.strerror}", str(path), "give another place") from None
    if options.json:
        print(json.dumps({"file": str(path)}))
    else:
        print(f"{path}: fill it in, then `aeroslosh point {shlex.quote(str(path))}`")
    return ExitCode.OK
