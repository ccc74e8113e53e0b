"""The conformal map against exact airfoils, the mesh against identities."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.aero.airfoil import contour
from aeroslosh.fmus.aero.conformal import circle_map
from aeroslosh.fmus.aero.mesh import MeshError, check, o_mesh


def karman_trefftz(power: float, centre: complex, count: int = 801) -> tuple[np.ndarray, float, float]:
    """Exact section: contour (unit chord), circle radius over chord, angle of zero lift [rad]."""
    radius = abs(1 - centre)
    start = np.angle(1 - centre)
    w = centre + radius * np.exp(1j * (start + np.linspace(0, 2 * np.pi, count)))
    ratio = ((w - 1) / (w + 1)) ** power
    z = power * (1 + ratio) / (1 - ratio)
    chord = z.real.max() - z.real.min()
    z = (z - z.real.min()) / chord
    z[0] = z[-1] = 0.5 * (z[0] + z[-1])
    return np.column_stack([z.real, z.imag]), radius / chord, start


@pytest.mark.parametrize("camber", [0.0, 0.06])
def test_map_of_a_karman_trefftz_section_is_its_circle(camber: float) -> None:
    points, radius, zero_lift = karman_trefftz(1.93, -0.08 + 1j * camber)
    circle = circle_map(points)
    assert circle.radius == pytest.approx(radius, rel=2e-6)
    alpha = 0.03
    assert circle.lift_coefficient(alpha) == pytest.approx(8 * np.pi * radius * np.sin(alpha - zero_lift), rel=1e-4)


def test_map_reproduces_the_contour() -> None:
    points = contour("64A415")
    z = circle_map(points).points(np.ones(1), 400)[0]
    distance = np.abs(z[:, None] - (points[:, 0] + 1j * points[:, 1])[None]).min(axis=1)
    assert distance.max() < 0.005  # between the contour's points
    nose = int(np.argmin(points[:, 0]))
    middle = z[(z.real > 0.2) & (z.real < 0.8) & (z.imag > 0)]
    exact = np.interp(middle.real, points[nose::-1, 0], points[nose::-1, 1])
    np.testing.assert_allclose(middle.imag, exact, atol=2e-6)


@pytest.mark.parametrize("airfoil", ["64A010", "0012", "2412", "6412", "4424", "63A415"])
def test_cells_close_and_fill_the_ring(airfoil: str) -> None:
    mesh = o_mesh(airfoil, 96, 32, 20.0)
    side = mesh.side[:, :2] * mesh.side[:, 2:3]
    ring = mesh.ring[:, :2] * mesh.ring[:, 2:3]
    closure = np.roll(side, -1, axis=2) - side + ring[1:] - ring[:-1]
    assert np.abs(closure).max() < 1e-13
    # moment arms close too: a rotating mesh makes no flux of a uniform stream
    arms = mesh.side[:, 3] * mesh.side[:, 2], mesh.ring[:, 3] * mesh.ring[:, 2]
    assert np.abs(np.roll(arms[0], -1, axis=1) - arms[0] + arms[1][1:] - arms[1][:-1]).max() < 1e-12
    outer, inner = mesh.node[-1], mesh.node[0]

    def area(p: np.ndarray) -> float:
        return 0.5 * float(np.sum(p[:-1, 0] * p[1:, 1] - p[1:, 0] * p[:-1, 1]))

    assert mesh.volume.sum() == pytest.approx(area(outer) - area(inner), rel=1e-12)


def test_mesh_is_nested_orthogonal_and_square_at_the_wall() -> None:
    fine, coarse = o_mesh("64A010", 128, 48, 25.0), o_mesh("64A010", 64, 24, 25.0)
    np.testing.assert_allclose(fine.node[::2, ::2], coarse.node, atol=1e-9)
    along = fine.node[:-1, 1:] - fine.node[:-1, :-1]
    out = fine.node[1:, :-1] - fine.node[:-1, :-1]
    cosine = np.sum(along * out, axis=-1) / (np.linalg.norm(along, axis=-1) * np.linalg.norm(out, axis=-1))
    assert np.median(np.abs(cosine)) < 0.05
    ratio = np.linalg.norm(out[0], axis=-1) / np.linalg.norm(along[0], axis=-1)
    assert np.median(ratio) == pytest.approx(1.0, abs=0.1)


def test_wall_curvature_is_that_of_the_section() -> None:
    mesh = o_mesh("0012", 168, 48, 25.0)
    # NACA 0012: nose radius 1.1019 t² (NASA TM 4741)
    assert mesh.curvature.max() == pytest.approx(1 / (1.1019 * 0.12**2), rel=0.02)
    assert np.abs(mesh.curvature[:3]).max() < 2.0


@pytest.mark.parametrize(("around", "normal"), [(60, 48), (168, 8)])
def test_too_few_cells_are_refused(around: int, normal: int) -> None:
    with pytest.raises(MeshError, match="Remedy"):
        o_mesh("64A010", around, normal, 25.0)


def test_folded_mesh_is_refused_with_its_cell() -> None:
    mesh = o_mesh("64A010", 64, 16, 25.0)
    mesh.volume[3, 5] = -1.0
    with pytest.raises(MeshError, match=r"folds over.*i = 5, j = 3"):
        check(mesh)
