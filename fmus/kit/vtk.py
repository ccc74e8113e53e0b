"""VTK XML files for ParaView: fields on structured grids (.vts), lines with values (.vtp).

Points are in metres in inertial axes, origin at the elastic axis at rest; arrays are inline base64 with UInt64 headers.
Format: VTK File Formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
"""

from __future__ import annotations

import base64
import os
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Arrays = Mapping[str, NDArray[np.generic]]


def turned(x: Array, y: Array, angle: float) -> Array:
    """Vectors (x aft, y up) of the section in inertial axes, shape (..., 3): turned nose-up (clockwise) by angle [rad]."""
    c, s = np.cos(angle), np.sin(angle)
    return np.stack([x * c + y * s, y * c - x * s, np.zeros_like(x)], axis=-1)


def structured_grid(path: Path, points: Array, cells: Arrays, fields: Arrays | None = None) -> Path:
    """Write a .vts file. points [m], shape (nj + 1, ni + 1, 3); cells: name to (nj, ni) or, a vector, (nj, ni, 3).

    fields: values of the whole file by name, in full precision; ParaView takes `TimeValue` as its time [s].
    Returns the path; the file appears whole or not at all.
    """
    nj, ni = points.shape[0] - 1, points.shape[1] - 1
    extent = f"0 {ni} 0 {nj} 0 0"
    whole = "".join(array(name, values, exact=True) for name, values in (fields or {}).items())
    body = (
        f'<StructuredGrid WholeExtent="{extent}">{f"<FieldData>{whole}</FieldData>" if whole else ""}<Piece Extent="{extent}">'
        f"<Points>{array('points', points.reshape(-1, 3))}</Points>"
        f"<CellData>{''.join(array(name, values) for name, values in cells.items())}</CellData>"
        "</Piece></StructuredGrid>"
    )
    return _save(path, "StructuredGrid", body)


def line(path: Path, points: Array, cells: Arrays) -> Path:
    """Write a .vtp file of one line of segments. points [m], shape (n + 1, 3); cells: name to (n,). Returns the path."""
    n = len(points) - 1
    body = (
        f'<PolyData><Piece NumberOfPoints="{n + 1}" NumberOfLines="{n}" NumberOfVerts="0" NumberOfStrips="0" '
        f'NumberOfPolys="0"><Points>{array("points", points)}</Points>'
        f"<Lines>{array('connectivity', np.stack([np.arange(n), np.arange(1, n + 1)], axis=1).ravel())}"
        f"{array('offsets', 2 * np.arange(1, n + 1))}</Lines>"
        f"<CellData>{''.join(array(name, values) for name, values in cells.items())}</CellData>"
        "</Piece></PolyData>"
    )
    return _save(path, "PolyData", body)


def array(name: str, values: NDArray[np.generic], exact: bool = False) -> str:
    """One DataArray element; a last axis of length 3 is a vector. exact: Float64 instead of Float32, and its number of tuples."""
    integer = np.issubdtype(values.dtype, np.integer)
    data = np.ascontiguousarray(values, dtype="<i8" if integer else "<f8" if exact else "<f4")
    parts = 3 if data.ndim > 1 and data.shape[-1] == 3 else 1
    raw = np.uint64(data.nbytes).tobytes() + data.tobytes()
    kind = "Int64" if integer else "Float64" if exact else "Float32"
    tuples = f' NumberOfTuples="{data.size // parts}"' if exact else ""
    return (
        f'<DataArray type="{kind}" Name="{name}" NumberOfComponents="{parts}"{tuples} format="binary">'
        f"{base64.b64encode(raw).decode()}</DataArray>"
    )


def _save(path: Path, kind: str, body: str) -> Path:
    hidden = path.with_name(f".{path.name}.part-{os.getpid()}")
    try:
        hidden.write_text(
            f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
            f"{body}</VTKFile>\n",
            encoding="ascii",
        )
        os.replace(hidden, path)
    except BaseException:
        hidden.unlink(missing_ok=True)
        raise
    return path
