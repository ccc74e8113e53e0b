"""Flow fields as VTK XML files for ParaView: mesh and Mach field (.vts), surface pressure (.vtp); see `kit.vtk`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..kit.vtk import line, structured_grid, turned
from .flux import GAMMA
from .loads import pressure_coefficient
from .march import Flow


def write(folder: Path, number: int, flow: Flow, chord: float, plunge: float) -> list[Path]:
    """Write fields_<number>.vts and surface_<number>.vtp of the present flow; folder is made where missing.

    chord [m]; plunge [m], positive down. Returns the two paths. Each file appears whole or not at all.
    """
    folder.mkdir(parents=True, exist_ok=True)
    # nodes relative to the elastic axis
    x, y = flow.mesh.node[..., 0] - flow.axis, flow.mesh.node[..., 1]
    points = chord * turned(x, y, flow.incidence) - [0.0, plunge, 0.0]
    density, along, up, energy = (flow.q[:, m] for m in range(4))
    u, v = along / density, up / density
    pressure = (GAMMA - 1) * (energy - 0.5 * density * (u * u + v * v))
    cells = {
        "mach": np.sqrt((u * u + v * v) * density / (GAMMA * pressure)),
        "pressure_coefficient": pressure_coefficient(pressure, flow.mach),
        "density": density,
        "velocity": turned(u, v, flow.incidence),
    }
    surface = {"pressure_coefficient": pressure_coefficient(flow.pressure, flow.mach)}
    return [
        structured_grid(folder / f"fields_{number:06d}.vts", points, cells),
        line(folder / f"surface_{number:06d}.vtp", points[0], surface),
    ]
