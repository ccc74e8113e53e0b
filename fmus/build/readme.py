"""The generated parts of the components' READMEs: `python -m aeroslosh.fmus.build.readme [component ...]` brings them up to date.

<!-- variables -->  ...  <!-- /variables -->      tables made from the declared variables
<!-- reference -->  ...  <!-- /reference -->      an excerpt of reference/output.csv
"""

from __future__ import annotations

import argparse
import csv
import importlib
import json
import re
import sys
from collections.abc import Mapping
from pathlib import Path

from .archive import ROOT, components, face_name
from .page import table, variable_tables

EXCERPT = 5  # rows of the reference result that a README shows


def reference_table(folder: Path) -> str:
    """Return some rows of the reference result in `folder` (output.csv, experiment.json) as a Markdown table."""
    outputs = list(json.loads((folder / "experiment.json").read_text(encoding="utf-8"))["outputs"])
    with (folder / "output.csv").open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    last = len(rows) - 1
    chosen = [rows[round(i * last / (EXCERPT - 1))] for i in range(EXCERPT)]
    cells = [[f"{float(row['time']):.6g}", *(f"{float(row[name]):.6e}" for name in outputs)] for row in chosen]
    return table([["time [s]", *(f"`{name}`" for name in outputs)], *cells])


def filled(text: str, parts: Mapping[str, str]) -> str:
    """Return `text` with what stands between `<!-- name -->` and `<!-- /name -->` replaced by `parts[name]`."""
    for name, part in parts.items():
        pattern = rf"(<!-- {name} -->\n).*?(\n<!-- /{name} -->)"
        text = re.sub(pattern, lambda found, part=part: f"{found[1]}\n{part}\n{found[2]}", text, flags=re.DOTALL)  # type: ignore[misc]
    return text


def current(folder: Path) -> str:
    """Return the README of the component in `folder` (in the source tree) as it should be."""
    module = importlib.import_module(f"..{folder.name}.fmu", __package__)
    face = getattr(module, face_name(folder))(instance_name=folder.name)
    parts = {"variables": variable_tables(face.to_xml())}
    if (folder / "reference" / "output.csv").is_file():
        parts["reference"] = reference_table(folder / "reference")
    return filled((folder / "README.md").read_text(encoding="utf-8"), parts)


def main(arguments: list[str] | None = None) -> int:
    """Rewrite the generated parts of the READMEs; `--check` only tells. Returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m aeroslosh.fmus.build.readme", description="Bring the READMEs of the FMUs up to date."
    )
    parser.add_argument("component", nargs="*", help="names of folders in fmus/; default: all")
    parser.add_argument("--check", action="store_true", help="change nothing, exit with 1 where a README is out of date")
    options = parser.parse_args(arguments)
    known, stale = components(ROOT), 0
    for name in options.component or known:
        if name not in known:
            parser.error(f"no component '{name}'; choose from {', '.join(known)}")
        path, text = known[name] / "README.md", current(known[name])
        if text != path.read_text(encoding="utf-8"):
            stale += 1
            print(f"{path}: out of date" if options.check else f"{path}: written")
            if not options.check:
                path.write_text(text, encoding="utf-8")
    return 1 if options.check and stale else 0


if __name__ == "__main__":
    sys.exit(main())
