"""Aerodynamic coefficients from the wall pressure."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .flux import GAMMA
from .mesh import Mesh

Array = NDArray[np.float64]


class Coefficients(NamedTuple):
    """Lift (normal to the stream, up), drag (along it) and moment (nose-up, about the elastic axis); chord 1."""

    lift: float
    drag: float
    moment: float


def pressure_coefficient(pressure: Array, mach: float) -> Array:
    """C_p of pressures in units of freestream density times sound speed squared, any shape."""
    return np.asarray((pressure - 1.0 / GAMMA) / (0.5 * mach * mach), dtype=float)


class WallLoads:
    """Integration weights of one mesh and axis: coefficients are three dot products a call."""

    def __init__(self, mesh: Mesh, mach: float, axis: float) -> None:
        nx, ny, length, arm = mesh.ring[0]
        self.mach = mach
        # normals point into the flow: pressure pushes against them. arm is x n_y − y n_x about the nose; clockwise is nose-up
        self._weights = np.stack([-nx * length, -ny * length, (arm - axis * ny) * length])

    def __call__(self, pressure: Array, incidence: float) -> Coefficients:
        """Coefficients for wall pressures (ni,) with the stream at incidence [rad] to the section's axis."""
        along, up, moment = (float(v) for v in self._weights @ pressure_coefficient(pressure, self.mach))
        c, s = np.cos(incidence), np.sin(incidence)
        return Coefficients(lift=up * c - along * s, drag=along * c + up * s, moment=moment)
