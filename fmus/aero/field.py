"""One flow on one mesh at one instant: conserved variables in body axes, boundary states, residual, relaxation, loads.

All in chords, freestream density and freestream sound speed; a time unit is the time sound takes for one chord.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..kit.compiled import jit
from .farfield import Farfield
from .flux import GAMMA, residual, tiled_faces
from .implicit import Blocks, Factors, Recipe
from .loads import Coefficients, WallLoads
from .mesh import Mesh
from .wall import wall_state

Array = NDArray[np.float64]

CLIP = 0.15
"""Largest relative change of density or energy a relaxation makes in a cell."""


class Motion(NamedTuple):
    """Section motion: plunge (down) and pitch (nose-up) about the elastic axis with rates and accelerations, scaled."""

    h: float = 0.0
    h_dot: float = 0.0
    h_ddot: float = 0.0
    alpha: float = 0.0
    alpha_dot: float = 0.0
    alpha_ddot: float = 0.0


@jit
def update(q: Any, x: Any) -> float:
    """q += clipped x; returns the rms density change, NaN where anything is not finite or not positive."""
    nj, _, ni = q.shape
    total = 0.0
    heavy = 0.0
    for j in range(nj):
        r, u, v, e = q[j, 0], q[j, 1], q[j, 2], q[j, 3]
        a, b, d, f = x[j, 0], x[j, 1], x[j, 2], x[j, 3]
        for i in range(ni):
            change = max(abs(a[i] * e[i]), abs(f[i] * r[i])) / (r[i] * e[i])
            factor = CLIP / max(CLIP, change)
            heavy += change * change  # a sum, not the largest: it takes NaN along and is SIMD code
            total += a[i] * a[i]
            r[i] += factor * a[i]
            u[i] += factor * b[i]
            v[i] += factor * d[i]
            e[i] += factor * f[i]
    if not heavy < 1e6:  # a thousandfold change of a cell, or NaN
        return np.nan
    return float(np.sqrt(total / (ni * nj)))


@jit
def density_distance(a: Any, b: Any) -> float:
    """rms difference of the densities of two flows (nj, 4, ni)."""
    nj, _, ni = a.shape
    total = 0.0
    for j in range(nj):
        p, q = a[j, 0], b[j, 0]
        for i in range(ni):
            total += (p[i] - q[i]) * (p[i] - q[i])
    return float(np.sqrt(total / (ni * nj)))


class Field:
    """Flow around a section whose elastic axis is `axis` chords behind the nose. `q` has shape (nj, 4, ni)."""

    def __init__(self, mesh: Mesh, mach: float, axis: float) -> None:
        nj, ni = mesh.shape
        self.mesh, self.mach, self.axis = mesh, mach, axis
        self.q = np.zeros((nj, 4, ni))
        self.out = np.zeros_like(self.q)
        self.blocks = Blocks(mesh)
        self.pressure = np.full(ni, 1.0 / GAMMA)
        self.incidence = 0.0
        self.loads = WallLoads(mesh, mach, axis)
        self.farfield = Farfield(mesh, mach)
        self._x = np.zeros_like(self.q)
        self._ghost = np.zeros((4, ni))
        self._motion = np.zeros(3)
        self._arithmetic: dict[type, tuple[NDArray[Any], NDArray[Any]]] = {}
        self._wall = np.zeros((5, ni))
        middle = 0.5 * (mesh.node[0, 1:] + mesh.node[0, :-1])
        self._wall[0], self._wall[1], self._wall[3:] = mesh.curvature, mesh.gap, middle.T

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients at the present time."""
        return self.loads(self.pressure, self.incidence)

    def start(self, incidence: float, flow: Array | None = None) -> None:
        """Section at rest at incidence [rad] in `flow` (body axes), or in the uniform stream."""
        self.move(Motion(), incidence, 0.0)
        if flow is None:
            m = self.mach
            self.q[:, 0], self.q[:, 1], self.q[:, 2] = 1.0, m * np.cos(incidence), m * np.sin(incidence)
            self.q[:, 3] = 1.0 / (GAMMA * (GAMMA - 1.0)) + 0.5 * m * m
        else:
            self.q[:] = flow
            self.find_pressure()
            self.farfield.set(incidence, self.coefficients.lift)

    def move(self, motion: Motion, incidence: float, lift: float) -> None:
        """Set mesh velocity, wall acceleration and outer state, all in body axes.

        incidence: of the stream to the section's axis [rad]; lift: coefficient of the vortex in the outer state.
        """
        c, s = np.cos(incidence), np.sin(incidence)
        rate, spin = motion.alpha_dot, motion.alpha_ddot
        self._motion[:] = motion.h_dot * s, -motion.h_dot * c + rate * self.axis, rate
        x, y = self._wall[3] - self.axis, self._wall[4]
        nx, ny = self.mesh.ring[0, 0], self.mesh.ring[0, 1]
        along = motion.h_ddot * s + y * spin - x * rate**2
        up = -motion.h_ddot * c - x * spin - y * rate**2
        self._wall[2] = along * nx + up * ny
        self.incidence = incidence
        self.farfield.set(incidence, lift)

    def find_pressure(self) -> None:
        """Wall pressure and the state behind the wall from `q`."""
        wall_state(self.q, self.mesh.ring, self._wall, self._motion, self._ghost, self.pressure)

    def evaluate(self, kind: type = np.float64) -> None:
        """Net outward flux of every cell into `out`, and the wall pressure.

        kind: number type of the arithmetic. float32 takes half the time; the fluxes of a cell are then wrong by some 1e-6 of
        the pressure times its faces' length.
        """
        self.find_pressure()
        if kind not in self._arithmetic:
            self._arithmetic[kind] = tiled_faces(self.mesh.side, self.mesh.ring, kind)
        nj, ni = self.mesh.shape
        residual(
            self.q.reshape(-1), self.out.reshape(-1), *self._arithmetic[kind], self._ghost.reshape(-1), self.pressure,
            self.farfield.state.reshape(-1), self._motion, ni, nj,
        )  # fmt: skip

    def linearised(self, weight: float, cfl: float, least_cfl: float = np.inf) -> Factors:
        """Factors of the present flow with time weight [1/time] and pseudo-time step `cfl`; least_cfl: see Recipe."""
        recipe = Recipe(self.q.copy(), self.farfield.state.copy(), weight, cfl, least_cfl)
        return Factors(recipe, self.mesh, self.blocks)

    def relax(self, factors: Factors) -> float:
        """One correction of `q` against `out`; returns the rms density change, NaN when it blew up."""
        factors.solve(self.out, self._x)
        return float(update(self.q, self._x))
