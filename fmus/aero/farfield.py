"""State behind the outer boundary: uniform stream plus the compressible point vortex of the section's lift.

Without the vortex a boundary at 25 chords costs 2 % of lift. Source: Thomas and Salas, AIAA J. 24(7), 1986,
doi:10.2514/3.9394. The state is taken at the middles of the outer faces, in body axes.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .flux import GAMMA
from .mesh import Mesh

Array = NDArray[np.float64]

_VORTEX_AT = 0.25
"""Where the vortex stands [chords from the nose]."""


class Farfield:
    """Outer state of one mesh and Mach number; `state` (4, ni) primitive variables is rewritten in place by `set`."""

    def __init__(self, mesh: Mesh, mach: float) -> None:
        middle = 0.5 * (mesh.node[-1, 1:] + mesh.node[-1, :-1])
        x, y = middle[:, 0] - _VORTEX_AT, middle[:, 1]
        self.mach = mach
        self.state = np.zeros((4, mesh.shape[1]))
        self._distance, self._angle = np.hypot(x, y), np.arctan2(y, x)

    def set(self, incidence: float, lift: float) -> None:
        """Stream at incidence [rad] to the section's axis, with the vortex of the lift coefficient `lift` (chord 1).

        Total enthalpy and entropy are the stream's. At supersonic speed there is no upstream influence: no vortex.
        """
        m = self.mach
        beta = np.sqrt(max(1.0 - m * m, 0.0))
        spread = 1.0 - (m * np.sin(self._angle - incidence)) ** 2
        swirl = 0.5 * lift * m * beta / (2 * np.pi * self._distance * np.maximum(spread, 1e-3))
        u = m * np.cos(incidence) + swirl * np.sin(self._angle)
        v = m * np.sin(incidence) - swirl * np.cos(self._angle)
        sound2 = 1.0 + 0.5 * (GAMMA - 1.0) * (m * m - u * u - v * v)
        density = sound2 ** (1.0 / (GAMMA - 1.0))
        self.state[0], self.state[1], self.state[2] = density, u, v
        self.state[3] = density * sound2 / GAMMA
