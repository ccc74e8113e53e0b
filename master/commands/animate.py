"""`aeroslosh animate`: the liquid in a tank, from the fields that a slosh FMU wrote."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from ..base.errors import ExitCode
from . import HELP


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["animate"]
    film = commands.add_parser("animate", help=text, description=text)
    film.add_argument("folder", type=Path, metavar="FOLDER", help="with files fields_<number>.vts (`drive --fields` writes them)")
    film.add_argument("--out", type=Path, metavar="GIF", help="the animation (default FOLDER/animation.gif)")
    film.add_argument("--fps", type=int, default=20, metavar="N", help="pictures a second, 1 to 50 (default 20)")
    film.add_argument("--pictures", action="store_true", help="each picture as PNG too, in a folder named like the animation")
    film.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    film.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """Pictures and an animation of the liquid in a tank."""
    from ..pictures import tank_film  # matplotlib takes half a second to import

    fields = tank_film.find(options.folder)
    out = options.out or options.folder / "animation.gif"
    files = tank_film.animate(fields, out, options.fps, out.with_suffix("") if options.pictures else None)
    if options.json:
        print(json.dumps({"frames": len(fields), "files": [str(path) for path in files]}))
    else:
        print(
            f"{len(fields)} frames\n  {files[0]}" + (f"\n  {len(files) - 1} pictures in {files[1].parent}" if files[1:] else "")
        )
    return ExitCode.OK
