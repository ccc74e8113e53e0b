"""Reads the fields that the FMUs write: VTK XML structured grids (.vts), inline base64, no compression."""

from __future__ import annotations

import base64
from dataclasses import dataclass, field
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from .errors import AeroSloshError

TYPES = {"Float32": "f4", "Float64": "f8", "Int32": "i4", "Int64": "i8"}


@dataclass(frozen=True)
class Field:
    """x, y: nodes, shape (nj + 1, ni + 1). cells: name → (nj, ni[, 3]). whole: values of the file, name → (n[, 3]).

    Around an airfoil i goes around it and j = 0 is on it; in a tank i goes aft and j up.
    """

    x: np.ndarray
    y: np.ndarray
    cells: dict[str, np.ndarray]
    whole: dict[str, np.ndarray] = field(default_factory=dict)

    def scaled(self, chord: float, elastic_axis: float) -> Field:
        """Lengths in chords from the leading edge at rest, where the file has metres from the elastic axis."""
        return Field(self.x / chord + elastic_axis, self.y / chord, self.cells, self.whole)


def read(path: Path) -> Field:
    """The field of one file. Raises AeroSloshError when it is not such a file."""
    try:
        root = ElementTree.parse(path).getroot()
        extent = [int(v) for v in root.find("StructuredGrid").attrib["WholeExtent"].split()]  # type: ignore[union-attr]
        ni, nj = extent[1] - extent[0], extent[3] - extent[2]
        header = {"UInt64": 8, "UInt32": 4}[root.attrib.get("header_type", "UInt32")]
        order = "<" if root.attrib.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
        points = _array(root.find(".//Points/DataArray"), header, order).reshape(nj + 1, ni + 1, 3)
        cells = {}
        for element in root.findall(".//CellData/DataArray"):
            values = _array(element, header, order)
            shape = (nj, ni) if values.size == ni * nj else (nj, ni, -1)
            cells[element.attrib["Name"]] = values.reshape(shape)
        whole = {}
        for element in root.findall(".//FieldData/DataArray"):
            parts = int(element.attrib.get("NumberOfComponents", "1"))
            values = _array(element, header, order)
            whole[element.attrib["Name"]] = values.reshape(-1, parts) if parts > 1 else values
    except (ElementTree.ParseError, AttributeError, KeyError, ValueError, OSError) as error:
        raise AeroSloshError(f"The field file cannot be read: {error}", str(path), "rebuild the FMUs: make fmus") from None
    return Field(points[..., 0], points[..., 1], cells, whole)


def time_of(path: Path) -> float | None:
    """The time [s] that a file tells of itself (`TimeValue`, which precedes the grid), else None. Raises AeroSloshError."""
    try:
        header, order = 4, "<"
        for event, element in ElementTree.iterparse(path, ("start", "end")):
            if event == "start" and element.tag == "VTKFile":
                header = {"UInt64": 8, "UInt32": 4}[element.attrib.get("header_type", "UInt32")]
                order = "<" if element.attrib.get("byte_order", "LittleEndian") == "LittleEndian" else ">"
            elif event == "start" and element.tag == "Piece":
                return None
            elif event == "end" and element.attrib.get("Name") == "TimeValue":
                return float(_array(element, header, order)[0])
    except (ElementTree.ParseError, KeyError, ValueError, IndexError, OSError) as error:
        raise AeroSloshError(
            f"The field file cannot be read: {error}", str(path), "remove it, or write the fields again"
        ) from None
    return None


def _array(element: ElementTree.Element | None, header: int, order: str) -> np.ndarray:
    """A DataArray's values: base64 of a byte count and the raw numbers."""
    if element is None or element.attrib.get("format") != "binary":
        raise ValueError('a DataArray with format="binary" is missing')
    raw = base64.b64decode("".join((element.text or "").split()))
    return np.frombuffer(raw[header:], dtype=order + TYPES[element.attrib["type"]]).astype(float)
