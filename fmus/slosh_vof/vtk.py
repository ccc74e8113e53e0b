"""Fields in the tank as VTK XML files for ParaView (.vts), where the tank is at the time; see `kit.vtk`."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ..kit.vtk import structured_grid, turned
from ..tank.motion import SectionMotion
from .flow import Flow


def write(folder: Path, number: int, flow: Flow, motion: SectionMotion, time: float) -> Path:
    """Write fields_<number>.vts of the flow at `time` [s] and `motion`; folder is made where missing. Returns the path.

    Cells: volume_fraction of liquid, pressure [Pa] above that in the middle of the roof, velocity [m/s] relative to the tank
    along inertial axes, density [kg/m3]. Whole file: TimeValue [s], baffles [m] (2, 3) each, foot and tip of baffles and of
    closed pieces of ribs, where there are any.
    """
    folder.mkdir(parents=True, exist_ok=True)
    grid = flow.grid
    place = np.array([motion.x, -motion.h, 0.0])
    west = grid.tank.x - 0.5 * grid.tank.length + grid.dx * np.arange(grid.nx + 1)
    floor = grid.tank.y - 0.5 * grid.tank.height + grid.dy * np.arange(grid.ny + 1)
    x, y = np.meshgrid(west, floor)
    points = turned(x, y, motion.alpha) + place
    u, v = flow.velocity
    share = flow.fractions
    cells = {
        "volume_fraction": share,
        "pressure": flow.pressure,
        "velocity": turned(u, v, motion.alpha),
        "density": flow.fluids.gas_density + (grid.tank.density - flow.fluids.gas_density) * share,
    }
    fields = {"TimeValue": np.array([time])}
    if plates := grid.plates + grid.ribs_stand:
        fields["baffles"] = np.concatenate([points[[first, last], column + 1] for column, first, last in plates])
    return structured_grid(folder / f"fields_{number:06d}.vts", points, cells, fields)
