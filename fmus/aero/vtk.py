"""Flow fields as VTK XML files for ParaView: mesh and Mach field (.vts), surface pressure (.vtp).

Points are in metres in inertial axes, origin at the elastic axis at rest; arrays are inline base64 (Float32, UInt64 headers).
Format: VTK File Formats, https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html
"""

from __future__ import annotations

import base64
import os
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .flux import GAMMA
from .loads import pressure_coefficient
from .march import Flow

Array = NDArray[np.float64]


def write(folder: Path, number: int, flow: Flow, chord: float, plunge: float) -> list[Path]:
    """Write fields_<number>.vts and surface_<number>.vtp of the present flow; folder is made where missing.

    chord [m]; plunge [m], positive down. Returns the two paths. Each file appears whole or not at all.
    """
    folder.mkdir(parents=True, exist_ok=True)
    nj, ni = flow.mesh.shape
    c, s = np.cos(flow.incidence), np.sin(flow.incidence)
    # nodes relative to the elastic axis, turned nose-up (clockwise) by the incidence
    x, y = flow.mesh.node[..., 0] - flow.axis, flow.mesh.node[..., 1]
    points = np.stack([chord * (x * c + y * s), chord * (y * c - x * s) - plunge, np.zeros_like(x)], axis=-1)
    density, along, up, energy = (flow.q[:, m] for m in range(4))
    u, v = along / density, up / density
    pressure = (GAMMA - 1) * (energy - 0.5 * density * (u * u + v * v))
    mach = np.sqrt((u * u + v * v) * density / (GAMMA * pressure))
    velocity = np.stack([c * u + s * v, c * v - s * u, np.zeros_like(u)], axis=-1)
    cells = {
        "mach": mach,
        "pressure_coefficient": pressure_coefficient(pressure, flow.mach),
        "density": density,
        "velocity": velocity,
    }
    extent = f"0 {ni} 0 {nj} 0 0"
    volume = (
        f'<StructuredGrid WholeExtent="{extent}"><Piece Extent="{extent}">'
        f"<Points>{_array('points', points.reshape(-1, 3))}</Points>"
        f"<CellData>{''.join(_array(name, values) for name, values in cells.items())}</CellData>"
        "</Piece></StructuredGrid>"
    )
    surface = (
        f'<PolyData><Piece NumberOfPoints="{ni + 1}" NumberOfLines="{ni}" NumberOfVerts="0" NumberOfStrips="0" '
        f'NumberOfPolys="0"><Points>{_array("points", points[0])}</Points>'
        f"<Lines>{_array('connectivity', np.stack([np.arange(ni), np.arange(1, ni + 1)], axis=1).ravel())}"
        f"{_array('offsets', 2 * np.arange(1, ni + 1))}</Lines>"
        f"<CellData>{_array('pressure_coefficient', pressure_coefficient(flow.pressure, flow.mach))}</CellData>"
        "</Piece></PolyData>"
    )
    return [
        _save(folder / f"fields_{number:06d}.vts", "StructuredGrid", volume),
        _save(folder / f"surface_{number:06d}.vtp", "PolyData", surface),
    ]


def _array(name: str, values: NDArray[np.generic]) -> str:
    """One DataArray element; a last axis of length 3 is a vector."""
    integer = np.issubdtype(values.dtype, np.integer)
    data = np.ascontiguousarray(values, dtype="<i8" if integer else "<f4")
    parts = 3 if data.ndim > 1 and data.shape[-1] == 3 else 1
    raw = np.uint64(data.nbytes).tobytes() + data.tobytes()
    return (
        f'<DataArray type="{"Int64" if integer else "Float32"}" Name="{name}" NumberOfComponents="{parts}" format="binary">'
        f"{base64.b64encode(raw).decode()}</DataArray>"
    )


def _save(path: Path, kind: str, body: str) -> Path:
    temporary = path.with_suffix(path.suffix + ".part")
    temporary.write_text(
        f'<?xml version="1.0"?>\n<VTKFile type="{kind}" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
        f"{body}</VTKFile>\n",
        encoding="ascii",
    )
    os.replace(temporary, path)
    return path
