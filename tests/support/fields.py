"""Field files as the FMUs write them: a tank with liquid, and a flow around a section."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from aeroslosh.fmus.kit.vtk import structured_grid, turned


def tank(
    folder: Path, number: int, angle: float = 0.0, aft: float = 0.0, time: float | None = None, cells: str = "volume_fraction"
) -> Path:
    """A tank of 0.4 x 0.2 m, liquid in its lower half, turned nose-up about its centre and moved aft."""
    folder.mkdir(exist_ok=True)
    x, y = np.meshgrid(np.linspace(-0.2, 0.2, 21), np.linspace(-0.1, 0.1, 11))
    share = np.where(np.arange(10)[:, None] < 5, 1.0, 0.0) * np.ones(20)
    place = np.array([aft, 0.0, 0.0])
    fields = {"baffles": turned(np.array([0.05, 0.05]), np.array([-0.1, 0.04]), angle) + place}
    if time is not None:
        fields["TimeValue"] = np.array([time])
    return structured_grid(folder / f"fields_{number:06d}.vts", turned(x, y, angle) + place, {cells: share}, fields)


def flow(
    folder: Path, number: int, time: float, sonic: float = 0.8, around: int = 96, normal: int = 30, half: float = 0.5
) -> Path:
    """A ring of cells around a circle of half a chord; Mach number 1 + 0.5 (sonic - r), r [chords] from the middle, which stands
    half a chord aft of the elastic axis, chord 1 m."""
    folder.mkdir(exist_ok=True)
    angle = np.linspace(0.0, -2.0 * np.pi, around + 1)
    r = half * np.geomspace(1.0, 40.0, normal + 1)[:, None]
    points = np.stack([0.5 + r * np.cos(angle), r * np.sin(angle), np.zeros((normal + 1, around + 1))], axis=-1)
    middle = 0.25 * (points[1:, 1:] + points[:-1, 1:] + points[1:, :-1] + points[:-1, :-1])
    mach = 1.0 + 0.5 * (sonic - np.hypot(middle[..., 0] - 0.5, middle[..., 1]))
    return structured_grid(
        folder / f"fields_{number:06d}.vts", points, {"mach": np.maximum(mach, 0.3)}, {"TimeValue": np.array([time])}
    )
