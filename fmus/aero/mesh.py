"""O-mesh around an airfoil from its conformal map, with the metrics the solver reads.

Index i runs anticlockwise from the trailing edge (upper side first), j outward from the wall. Nodes have shape
(cells_normal + 1, cells_around + 1), the last column repeating the first. Nested: halving both cell counts keeps every second
node. The uniform angle in the circle plane clusters cells at nose and trailing edge (Vassberg and Jameson,
J. Aircraft 47(4), 2010, doi:10.2514/1.46737 use the same idea).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

from .airfoil import Section, section
from .conformal import CircleMap, MappingError, circle_map

Array = NDArray[np.float64]

_MIN_ANGLE = np.radians(30.0)
"""Smallest angle between mesh lines: below it the flux formulas lose their order."""


class MeshError(ValueError):
    """A mesh that would give wrong answers; the message names the cell, the measure and the remedy."""


@dataclass(frozen=True)
class Mesh:
    """Nodes and metrics of an O-mesh, lengths in chords, leading edge of the section at x = 0.

    node: (nj+1, ni+1, 2); centre: (nj, ni, 2); volume: (nj, ni);
    side: (nj, 4, ni) face between cells i−1 and i: unit normal x, y (towards i), length, moment arm x n_y − y n_x about origin;
    ring: (nj+1, 4, ni) face between cells j−1 and j: the same, normal outward;
    curvature: (ni,) of the wall at the face middles, positive where the section is convex; gap: (ni,) distance between
    first cell centre and its mirror image behind the wall.
    """

    node: Array
    centre: Array
    volume: Array
    side: Array
    ring: Array
    curvature: Array
    gap: Array
    circle: CircleMap
    farfield: float

    @property
    def shape(self) -> tuple[int, int]:
        """(cells normal, cells around)."""
        return self.volume.shape[0], self.volume.shape[1]


def o_mesh(airfoil: str | Section, cells_around: int, cells_normal: int, farfield_chords: float) -> Mesh:
    """Mesh of a section, of a NACA name or of a coordinate file with its outer boundary about farfield_chords away.

    Raises AirfoilError, MappingError or MeshError (all ValueError) with what, where and remedy.
    """
    if cells_around < 64 or cells_normal < 16:
        raise MeshError(
            f"cells_around = {cells_around}, cells_normal = {cells_normal}: at least 64 and 16 are needed. "
            "Remedy: e.g. 168 and 48"
        )
    found = section(airfoil) if isinstance(airfoil, str) else airfoil
    try:
        circle = circle_map(found.contour)
    except MappingError as error:
        raise MappingError(f"airfoil '{found.name}': {error}") from None
    rho = _radii(cells_around, cells_normal, farfield_chords / circle.radius)
    z = circle.points(rho, cells_around)
    z[0, 0] = circle.fixed[0]
    z = np.concatenate([z, z[:, :1]], axis=1)
    node = np.stack([z.real, z.imag], axis=-1)
    curvature = _curvature(circle, cells_around)
    mesh = _metrics(node, curvature, circle, farfield_chords)
    check(mesh)
    return mesh


def coarsened(mesh: Mesh) -> Mesh | None:
    """The mesh of every second node, or None where a cell count would be too small or odd."""
    nj, ni = mesh.shape
    if nj % 2 or ni % 2 or nj < 32 or ni < 128:
        return None
    node = np.ascontiguousarray(mesh.node[::2, ::2])
    return _metrics(node, _curvature(mesh.circle, ni // 2), mesh.circle, mesh.farfield)


def _radii(ni: int, nj: int, outer: float) -> Array:
    """Circle radii, shape (nj+1,): ln ρ = L sinh(b j/nj)/sinh b with b such that wall cells are square."""
    length = np.log(outer)
    first = 2 * np.pi / ni * nj / length
    b = brentq(lambda s: s / np.sinh(s) - first, 1e-6, 40.0) if first < 1 else 1e-6
    return np.exp(length * np.sinh(b * np.arange(nj + 1) / nj) / np.sinh(b))


def _curvature(circle: CircleMap, ni: int) -> Array:
    """Wall curvature [1/chord] at the middle angle of each wall face, from the map on shifted angles."""
    step, half = 1e-3, np.pi / ni
    middle = half + 2 * np.pi * np.arange(ni) / ni
    behind, here, ahead = (circle.at(np.ones(1), middle + shift)[0] for shift in (-step, 0.0, step))
    first, second = (ahead - behind) / (2 * step), (ahead - 2 * here + behind) / step**2
    # anticlockwise around the body: positive where convex
    return np.asarray((np.conj(first) * second).imag / np.abs(first) ** 3, dtype=float)


def _metrics(node: Array, curvature: Array, circle: CircleMap, farfield: float) -> Mesh:
    side = _faces(node[:-1, :-1], node[1:, :-1], turn=1.0)
    ring = _faces(node[:, :-1], node[:, 1:], turn=-1.0)
    a, b, c, d = node[:-1, :-1], node[:-1, 1:], node[1:, 1:], node[1:, :-1]
    # clockwise in space (i anticlockwise, j outward): the cross product of the diagonals is negative
    volume = -0.5 * _cross(c - a, d - b)
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = -0.5 * _cross(b - a, c - a)[..., None], -0.5 * _cross(c - a, d - a)[..., None]
        centre = (first * (a + b + c) + second * (a + c + d)) / (3 * (first + second))
    wall = 0.5 * (node[0, :-1] + node[0, 1:])
    gap = 2 * np.abs(np.sum((centre[0] - wall) * ring[0, :2].T, axis=-1))
    return Mesh(node, centre, volume, side, ring, curvature, gap, circle, farfield)


def _faces(start: Array, end: Array, turn: float) -> Array:
    """Normals of the faces from start to end, shape (rows, 4, columns): n_x, n_y, length, x n_y − y n_x."""
    edge, middle = end - start, 0.5 * (start + end)
    length = np.hypot(edge[..., 0], edge[..., 1])
    with np.errstate(divide="ignore", invalid="ignore"):
        nx, ny = -turn * edge[..., 1] / length, turn * edge[..., 0] / length
    return np.ascontiguousarray(np.stack([nx, ny, length, middle[..., 0] * ny - middle[..., 1] * nx], axis=1))


def _cross(a: Array, b: Array) -> Array:
    return np.asarray(a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0], dtype=float)


def check(mesh: Mesh) -> None:
    """Refuse a folded, degenerate or too skew mesh.

    Raises MeshError naming the worst cell, its place and the measure.
    """
    nj, ni = mesh.shape

    def where(j: int, i: int) -> str:
        x, y = mesh.node[j, i]
        return f"at cell i = {i}, j = {j} (x/c = {x:.3f}, y/c = {y:.3f})"

    remedy = "Remedy: smoother or denser coordinates, or more cells_around"
    if not np.all(np.isfinite(mesh.node)):
        raise MeshError(f"mesh nodes are not finite. {remedy}")
    j, i = np.unravel_index(int(np.argmin(mesh.volume)), (nj, ni))
    if mesh.volume[j, i] <= 0:
        raise MeshError(f"mesh folds over: volume {mesh.volume[j, i]:.2e} {where(int(j), int(i))}. {remedy}")
    along = mesh.node[:-1, 1:] - mesh.node[:-1, :-1]
    out = mesh.node[1:, :-1] - mesh.node[:-1, :-1]
    sine = np.abs(_cross(along, out)) / (np.linalg.norm(along, axis=-1) * np.linalg.norm(out, axis=-1))
    sine[0, 0] = 1.0  # the trailing edge itself: the corner angle is the section's
    j, i = np.unravel_index(int(np.argmin(sine)), (nj, ni))
    if sine[j, i] < np.sin(_MIN_ANGLE):
        raise MeshError(f"mesh angle {np.degrees(np.arcsin(sine[j, i])):.0f} degrees {where(int(j), int(i))}. {remedy}")
    ratio = mesh.volume[:, np.arange(ni) - 1] / mesh.volume
    worst = np.maximum(ratio, 1 / ratio)
    j, i = np.unravel_index(int(np.argmax(worst)), (nj, ni))
    if worst[j, i] > 20:
        raise MeshError(f"neighbouring cells differ {worst[j, i]:.0f} times in size {where(int(j), int(i))}. {remedy}")
