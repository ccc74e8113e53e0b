"""The corrected equations against an independent finite-element solution, and what those printed in the paper give.

The solution: Laplace's equation for the potential in the liquid at rest, biquadratic elements; unit velocity of the walls in
surge or pitch (anticlockwise, about the liquid's centre); omega² phi = g dphi/dy on the surface. Pressure is −density dphi/dt.
Printed equations: S. Srivastava, M. Damodaran, B. C. Khoo, "Models for Predicting Transonic Flutter of a Wing-Section with
Sloshing in an Embedded Fuel Tank", equations 18 to 20.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable

import numpy as np
import pytest
from scipy import sparse
from scipy.sparse.linalg import spsolve

from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import lid_inertia, modes
from aeroslosh.fmus.tank.potential import pitch_force, pitch_inertia, surge_mass
from support.paths import ROOT

G = 9.81
PAPER = Tank(length=0.5, height=0.15)
TANKS = {
    "paper": PAPER,
    "square": Tank(length=0.5, height=1.0),
    "shallow": Tank(length=1.0, height=0.1),
    "tall": Tank(length=0.3, height=0.72),
}
PAGE = ROOT / "docs" / "ems.md"


def line(size: float, elements: int) -> tuple[np.ndarray, sparse.csr_array, sparse.csr_array]:
    """Nodes, mass and stiffness matrix of quadratic elements on −size/2 … size/2."""
    n, h = 2 * elements + 1, size / elements
    mass, stiffness = sparse.lil_array((n, n)), sparse.lil_array((n, n))
    m = h / 30 * np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]])
    k = 1 / (3 * h) * np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]])
    for e in range(elements):
        part = slice(2 * e, 2 * e + 3)
        mass[part, part] += m
        stiffness[part, part] += k
    return np.linspace(-size / 2, size / 2, n), mass.tocsr(), stiffness.tocsr()


def solve(tank: Tank, omega: float, lid: bool = False, elements: int = 40) -> tuple[float, float, float]:
    """Apparent mass in surge, force of pitch, apparent inertia in pitch, as in potential.py; with a lid: of a closed box."""
    x, mass_x, stiff_x = line(tank.length, elements)
    y, mass_y, stiff_y = line(tank.depth, elements)
    top, bottom = (sparse.csr_array(([1.0], ([i], [i])), shape=(len(y), len(y))) for i in (len(y) - 1, 0))
    matrix = sparse.kron(stiff_x, mass_y) + sparse.kron(mass_x, stiff_y)
    if not lid:
        matrix = matrix - omega**2 / G * sparse.kron(mass_x, top)
    ends = np.zeros(len(x))
    ends[0], ends[-1] = -1.0, 1.0  # n_x
    one = np.ones(len(y))
    surge = np.kron(ends, mass_y @ one)
    pitch = np.kron(mass_x @ x, -bottom @ one + (top @ one if lid else 0.0)) - np.kron(ends, mass_y @ y)  # x n_y − y n_x
    if lid:  # the potential is known but for a constant
        matrix = matrix.tolil()
        matrix[0, 0] += 1.0
    phi = spsolve(matrix.tocsc(), np.stack([surge, pitch], axis=1))
    A = tank.density * tank.width * np.array([surge @ phi, pitch @ phi])
    weight = 0.0 if lid else tank.mass * G * tank.length**2 / (12 * tank.depth) / omega**2
    return float(A[0, 0]), float(-A[0, 1]), float(A[1, 1]) + weight


@pytest.mark.parametrize("ratio", [0.1, 0.6, 0.8, 1.2, 1.4])
@pytest.mark.parametrize("tank", TANKS.values(), ids=TANKS)
def test_corrected_closed_forms_agree_with_finite_elements(tank: Tank, ratio: float) -> None:
    """At frequencies below and above the first mode's."""
    omega = ratio * float(modes(tank, 1).omega[0])
    fem = solve(tank, omega)
    assert surge_mass(tank, omega) == pytest.approx(fem[0], rel=1e-5)
    assert pitch_force(tank, omega) == pytest.approx(fem[1], rel=1e-5)
    assert pitch_inertia(tank, omega) == pytest.approx(fem[2], rel=1e-5)


@pytest.mark.parametrize("tank", TANKS.values(), ids=TANKS)
def test_inertia_under_a_lid_agrees_with_finite_elements(tank: Tank) -> None:
    assert lid_inertia(tank) == pytest.approx(solve(tank, 1.0, lid=True)[2], rel=2e-6)


def test_frequencies_agree_with_finite_elements() -> None:
    """The apparent mass changes its sign through infinity there."""
    for n, wave in enumerate(modes(PAPER, 3).omega):
        below, above = (solve(PAPER, float(wave) * (1.0 + gap))[0] for gap in (-1e-5, 1e-5))
        assert below > 0.0 > above, n


# -- as printed --


def printed_terms() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """F(n), 1/2 − G(n) and omega_n² [1/s2] of equations 17 and 18, which are right. Shapes: (200,)."""
    l, h_f, q = PAPER.length, PAPER.depth, 2 * np.arange(1, 201) - 1
    F = 8 * l * np.tanh(q * np.pi * h_f / l) / (np.pi**3 * q**3.0 * h_f)
    K = 2 * l * np.tanh(q * np.pi * h_f / (2 * l)) / (np.pi * q * h_f)
    return F, 0.5 - K, G * q * np.pi / l * np.tanh(q * np.pi * h_f / l)


def printed_18a(omega: float, h: float = PAPER.height) -> float:
    """F / (omega² psi) of equation 18a, per kilogram; h is the tank's height in the paper."""
    l, h_f, (F, place, w2) = PAPER.length, PAPER.depth, printed_terms()
    return float(h_f * (l**2 / (12 * h_f**2) + np.sum(F * omega**2 / (w2 - omega**2) * (place + G / (h * w2)))))


def printed_18b(omega: float, h: float = PAPER.height, first_sum: float = 1.0) -> float:
    """M / (omega² psi) of equation 18b, per kilogram; the factor of its first sum is printed as 1."""
    l, h_f, (F, place, w2) = PAPER.length, PAPER.depth, printed_terms()
    total = lid_inertia(PAPER) / PAPER.mass / h_f**2 + G * l**2 / (12 * h_f**3 * omega**2)
    total += first_sum * np.sum(F * (place + G / (2 * h_f * w2)) * G / (h_f * w2))
    return float(h_f**2 * (total + np.sum(F * (place + G / (h * w2)) ** 2 * omega**2 / (w2 - omega**2))))


def printed_lid(l: float, h_f: float) -> float:
    """I_fz / I_sz as printed, with pi^3 in place of pi^5."""
    q = 2 * np.arange(1, 200) - 1
    series = float(np.sum(np.tanh(q * np.pi * h_f / (2 * l)) / q**5.0))
    return 1 - 4 * l**2 / (l**2 + h_f**2) + 768 * l**3 / (math.pi**3 * h_f * (l**2 + h_f**2)) * series


def printed_19a(omega: float) -> float:
    """F / (omega² psi) of equation 19a, per kilogram, with the right parameters."""
    m = modes(PAPER, 200)
    lever = m.height * omega**2 + G
    total = m.fixed_mass * m.fixed_height + np.sum(m.mass * lever * m.omega**2 / (m.omega**2 - omega**2))
    return float(total) / PAPER.mass


def printed_19b(omega: float) -> float:
    """M / (omega² psi) of equation 19b, per kilogram, with the right parameters."""
    m = modes(PAPER, 200)
    lever = m.height * omega**2 + G
    total = m.fixed_inertia + m.fixed_mass * m.fixed_height**2 + np.sum(m.mass * lever**2 * m.omega**2 / (m.omega**2 - omega**2))
    return float(total) / PAPER.mass


def printed_20(h: float = PAPER.height) -> tuple[float, float, float]:
    """m_1/m, K_1/m [1/s2], h_1 [m] of equations 20a to c: 2n + 1 at n = 1, tank height h where h stands."""
    l, h_f, q = PAPER.length, PAPER.depth, 3
    wave = q * math.pi * h_f / l
    mass = 8 / math.pi**3 * math.tanh(wave) / (q**3 * h / l)
    spring = G / h_f * 8 * math.tanh(wave) / q**2
    place = h * (0.5 - math.tanh(wave / 2) / (q * math.pi * h / (2 * l)))
    return mass, spring, place


def cells(row: str) -> list[float]:
    """Numbers of the cells of a row of the page's table, one a cell."""
    text = next(line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {row} |"))
    found = [re.search(r"−?\d+\.?\d*(e−?\d+)?", cell) for cell in text.split("|")[3:5]]
    return [float(match.group().replace("−", "-")) for match in found if match]


ROWS: dict[str, tuple[Callable[[], float], Callable[[], float]]] = {
    "18a": (lambda: printed_18a(4.0), lambda: pitch_force(PAPER, 4.0) / PAPER.mass),
    "18b": (lambda: printed_18b(4.0), lambda: pitch_inertia(PAPER, 4.0) / PAPER.mass),
    "I_f": (lambda: printed_lid(PAPER.length, PAPER.depth), lambda: lid_inertia(PAPER) / frozen_inertia()),
    "19a": (lambda: printed_19a(4.0), lambda: pitch_force(PAPER, 4.0) / PAPER.mass),
    "19b": (lambda: printed_19b(4.0), lambda: pitch_inertia(PAPER, 4.0) / PAPER.mass),
    "20a": (lambda: printed_20()[0], lambda: float(modes(PAPER, 1).mass[0]) / PAPER.mass),
    "20b": (lambda: printed_20()[1], lambda: float(modes(PAPER, 1).stiffness[0]) / PAPER.mass),
    "20c": (lambda: printed_20()[2], lambda: float(modes(PAPER, 1).height[0])),
}


def frozen_inertia() -> float:
    return PAPER.mass * (PAPER.length**2 + PAPER.depth**2) / 12


@pytest.mark.parametrize("row", ROWS)
def test_table_of_the_page_is_what_the_equations_give(row: str) -> None:
    printed, corrected = (value() for value in ROWS[row])
    assert cells(row) == pytest.approx([printed, corrected], rel=6e-4)
    assert abs(printed / corrected - 1.0) > 0.01


def test_printed_18_becomes_right_by_the_depth_and_a_factor_two() -> None:
    """The tank's height replaced by the depth, the first sum of the moment doubled: the finite-element values."""
    _, force, inertia = solve(PAPER, 4.0)
    assert printed_18a(4.0, PAPER.depth) == pytest.approx(force / PAPER.mass, rel=1e-5)
    assert printed_18b(4.0, PAPER.depth, 2.0) == pytest.approx(inertia / PAPER.mass, rel=1e-5)


def test_the_thin_layer_tells_the_power_of_pi_in_the_lid_inertia() -> None:
    """A thin layer under a lid turns as if frozen; with the printed power it would turn many times as hard."""
    assert printed_lid(1.0, 1e-3) > 30.0
    thin = Tank(length=1.0, height=2e-3)
    assert lid_inertia(thin) / (thin.mass * (1 + 1e-6) / 12) == pytest.approx(1.0, abs=1e-5)
