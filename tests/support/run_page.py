"""A process that runs a page's blocks in order: JSON in (kind, text, place), JSON out (what each printed).

Python blocks share one namespace, as cells of a notebook; commands run in bash, and the first that fails ends the page."""

from __future__ import annotations

import contextlib
import io
import json
import subprocess
import sys
import traceback
from pathlib import Path
from typing import Any


def run(steps: list[dict[str, str]]) -> list[dict[str, Any]]:
    """What each step printed, and whether it ended well; nothing after one that did not."""
    names: dict[str, Any] = {"__name__": "page"}
    done: list[dict[str, Any]] = []
    for step in steps:
        if step["kind"] == "file":
            Path(step["name"]).write_text(step["text"], encoding="utf-8")
            printed, well = "", True
        elif step["kind"] == "sh":
            words = ["bash", "-e", "-u", "-o", "pipefail", "-c", step["text"]]
            told = subprocess.run(
                words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, encoding="utf-8", timeout=1800
            )
            printed, well = told.stdout, told.returncode == 0
        else:
            out = io.StringIO()
            well = True
            with contextlib.redirect_stdout(out):
                try:
                    exec(compile(step["text"], step["place"], "exec"), names)
                except Exception:
                    out.write(traceback.format_exc())
                    well = False
            printed = out.getvalue()
        done.append({"place": step["place"], "printed": printed, "well": well})
        if not well:
            break
    return done


if __name__ == "__main__":
    results = run(json.loads(Path(sys.argv[1]).read_text(encoding="utf-8")))
    Path(sys.argv[2]).write_text(json.dumps(results), encoding="utf-8")
