"""ParaView collections (.pvd): which field file belongs to which time, so that one file opens the whole animation.

A field file is named <kind>_<number>.vts (or .vtp, …); each kind of a folder is one part of the collection. Files are named
relative to the collection, so that the run folder can move.
Format: https://www.paraview.org/Wiki/ParaView/Data_formats#PVD_File_Format
"""

from __future__ import annotations

import os
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from xml.etree import ElementTree

from . import files as base_files
from .errors import AeroSloshError

FIELD_FILE = re.compile(r"(?P<kind>.+)_(?P<number>\d{3,})\.vt[spuir]")
Frame = tuple[float, Path]  # time [s], file


def number(path: Path) -> int:
    """The number in a field file's name. Raises ValueError for another file."""
    match = FIELD_FILE.fullmatch(path.name)
    if match is None:
        raise ValueError(f"{path.name} has no number")
    return int(match["number"])


def field_files(folder: Path) -> list[Path]:
    """The field files in a folder, by kind and number."""
    found = [
        (match["kind"], int(match["number"]), path) for path in folder.glob("*") if (match := FIELD_FILE.fullmatch(path.name))
    ]
    return [path for _, _, path in sorted(found)]


def write(path: Path, frames: Iterable[Frame]) -> Path:
    """Write a collection of files with their times [s]; whole or not at all. Returns its path."""
    kinds: dict[tuple[Path, str], int] = {}
    rows = []
    for time, file in frames:
        kind = FIELD_FILE.sub(r"\g<kind>", file.name)
        part = kinds.setdefault((file.parent, kind), len(kinds))
        rows.append((time, part, kind, Path(os.path.relpath(file, path.parent)).as_posix()))
    root = ElementTree.Element("VTKFile", type="Collection", version="1.0", byte_order="LittleEndian")
    collection = ElementTree.SubElement(root, "Collection")
    for time, part, kind, name in sorted(rows):
        entry = {"timestep": repr(float(time)), "part": str(part), "name": kind, "file": name}
        ElementTree.SubElement(collection, "DataSet", entry)
    ElementTree.indent(root)
    path.parent.mkdir(parents=True, exist_ok=True)
    text = f'<?xml version="1.0"?>\n{ElementTree.tostring(root, encoding="unicode")}\n'
    base_files.write(path, text.encode())
    return path


def write_beside(folder: Path, times: Mapping[int, float]) -> Path:
    """Write <folder>.pvd beside a folder of fields. times: number in a file's name → time [s]; other files are left out."""
    return write(
        folder.with_name(f"{folder.name}.pvd"), [(times[n], f) for f in field_files(folder) if (n := number(f)) in times]
    )


def read(path: Path) -> list[Frame]:
    """Times [s] and files of a collection. Raises AeroSloshError when it is none."""
    try:
        root = ElementTree.parse(path).getroot()
        return [(float(e.attrib["timestep"]), path.parent / e.attrib["file"]) for e in root.iter("DataSet")]
    except (ElementTree.ParseError, KeyError, ValueError, OSError) as error:
        raise AeroSloshError(f"The collection cannot be read: {error}", str(path), "remove it and export again") from None
