"""`aeroslosh overlay`: the boundaries, or the limit cycles, of several runs in one picture."""

from __future__ import annotations

import argparse
import json
import os
from collections import Counter
from pathlib import Path
from typing import Any

from ..base.errors import AeroSloshError, ExitCode
from ..case.fuel_tank import LABEL
from ..results import boundary_table, past_run
from ..results.amplitude_text import said
from . import HELP

KINDS = ("boundary", "amplitude")  # of runs that are laid over each other


def register(commands: Any) -> None:
    """The command line."""
    text = HELP["overlay"]
    sub = commands.add_parser("overlay", help=text, description=text)
    sub.add_argument(
        "runs", type=Path, nargs="+", metavar="RUN", help="run folders of `aeroslosh boundary`, or of `aeroslosh amplitude`"
    )
    sub.add_argument(
        "--names", nargs="+", metavar="NAME", help="what they are called (default: their slosh models, else folders)"
    )
    sub.add_argument("--out", type=Path, metavar="FILE.png", default=Path("runs/overlay.png"), help="(default runs/overlay.png)")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """One picture, and how V_f differs from that of the first run where both have a Mach number."""
    if options.out.suffix.lower() != ".png":
        raise AeroSloshError(f"--out {options.out}", "command line", "a name that ends in .png")
    found = [past_run.load(path) for path in options.runs]
    kinds = {run.kind for run in found}
    for run in found:
        if run.kind not in KINDS or len(kinds) > 1:
            raise AeroSloshError(
                f"The run is {'an' if run.kind[0] in 'aeiou' else 'a'} {run.kind}",
                str(run.path),
                "give run folders of `aeroslosh boundary` alone, or of `aeroslosh amplitude` alone",
            )
    names = options.names or _names([(LABEL.get(r.result.get("slosh", ""), ""), r.path) for r in found])
    if len(names) != len(found) or len(set(names)) != len(names):
        raise AeroSloshError(f"--names {' '.join(names)}", "command line", f"{len(found)} different names, one a run")
    named = dict(zip(names, found, strict=True))
    try:
        return _limit_cycles(options, named) if kinds == {"amplitude"} else _boundaries(options, named)
    except OSError as error:
        raise AeroSloshError(f"The picture cannot be written: {error.strerror}", str(options.out), "give another --out") from None


def _limit_cycles(options: argparse.Namespace, found: dict[str, past_run.PastRun]) -> int:
    """Of runs of `aeroslosh amplitude` at one Mach number."""
    machs = {run.result["mach"] for run in found.values()}
    if len(machs) > 1:
        where = ", ".join(f"{run.path}: {run.result['mach']:g}" for run in found.values())
        raise AeroSloshError("The runs have several Mach numbers", where, "limit cycles over V_f of one Mach number")
    runs = {name: run.result["speeds"] for name, run in found.items()}
    from ..pictures import amplitude_overlay  # matplotlib takes half a second to import

    amplitude_overlay.draw(runs, f"Limit cycles over $V_f$, Mach {machs.pop():g}", options.out)
    if options.json:
        print(json.dumps({"file": str(options.out), "speeds": runs}))
        return ExitCode.OK
    for name, rows in runs.items():
        print("\n".join([f"  {name}", *(f"    {said(row)}" for row in rows)]))
    print(f"  picture      {os.path.relpath(options.out)}")
    return ExitCode.OK


def _boundaries(options: argparse.Namespace, found: dict[str, past_run.PastRun]) -> int:
    """Of runs of `aeroslosh boundary`."""
    names = list(found)
    runs = {name: boundary_table.rows(run.result["points"]) for name, run in found.items()}
    if not any(rows for rows in runs.values()):
        raise AeroSloshError("No run has a finished Mach number", str(options.runs[0]), "finish one of them")
    from ..pictures import overlay  # matplotlib takes half a second to import

    overlay.draw(runs, options.out)
    lowest = {name: _lowest(rows) for name, rows in runs.items()}
    if options.json:
        print(
            json.dumps(
                {"file": str(options.out), "lowest_V_f": {n: {f"{m:g}": v for m, v in low.items()} for n, low in lowest.items()}}
            )
        )
        return ExitCode.OK
    first = lowest[names[0]]
    for mach in sorted({m for low in lowest.values() for m in low}):
        told = []
        for name, low in lowest.items():
            beside = f" ({100.0 * (low[mach] / first[mach] - 1.0):+.1f} %)" if mach in low and mach in first else ""
            told.append(f"{name} {low[mach]:.4f}{'' if name == names[0] else beside}" if mach in low else f"{name} –")
        print(f"  Mach {mach:<6g} lowest neutral V_f: {', '.join(told)}")
    print(f"  picture      {os.path.relpath(options.out)}")
    return ExitCode.OK


def _lowest(rows: list[dict[str, Any]]) -> dict[float, float]:
    """Mach number → lowest neutral V_f."""
    return {row["mach"]: row["V_f"] for row in reversed(rows) if row["V_f"] is not None}


def _names(runs: list[tuple[str, Path]]) -> list[str]:
    """Slosh models where they differ, else the folders."""
    count = Counter(label for label, _ in runs)
    return [label if label and count[label] == 1 else path.absolute().name for label, path in runs]
