"""Reference of every variable of every FMU, read from the model descriptions inside the built FMUs."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

from aeroslosh.fmus.build.page import variable_tables


def pages(fmus: Path) -> dict[str, str]:
    """Name → Markdown; `fmus` is a folder of FMUs. Raises FileNotFoundError where it holds none."""
    found = sorted(fmus.glob("*.fmu"))
    if not found:
        raise FileNotFoundError(f"no FMU in {fmus}; remedy: make fmus")
    parts = [
        "# Variables of the FMUs\n\nRead from the model descriptions. What they mean in the equations: the page of each FMU.\n"
    ]
    for path in found:
        with zipfile.ZipFile(path) as archive:
            description = ElementTree.fromstring(archive.read("modelDescription.xml"))
        about = description.get("description", "")
        parts.append(f"## {path.stem}\n\n{about}. Page: [fmus/{path.stem}](../fmus/{path.stem}/README.md)\n")
        parts.append(variable_tables(description) + "\n")
    return {"fmu-variables": "\n".join(parts)}
