"""Exact answers for the doubles: eigenvalues of section + thin airfoil, and the coupled oscillators."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from master.case import Case
from master.similarity import scales

A, B = np.array([0.165, 0.335]), np.array([0.0455, 0.3])


def eigenvalues(case: Case, mach: float, V_f: float) -> np.ndarray:
    """Eigenvalues / omega_alpha of the aeroelastic system, those with positive frequency, least damped first."""
    s = scales(case, mach, V_f)
    b, U, rho, a = s.half_chord, s.speed, s.density, 2.0 * case.section.elastic_axis - 1.0
    m = np.pi * rho * b**2
    M = np.array([[s.mass, s.static_imbalance], [s.static_imbalance, s.inertia]])
    M = M + m * np.array([[1.0, -b * a], [-b * a, b**2 * (0.125 + a**2)]])
    C = m * np.array([[0.0, U], [0.0, U * b * (0.5 - a)]])
    K = np.diag([s.mass * s.omega_h**2, s.inertia * s.omega_alpha**2])
    load = 2.0 * np.pi * rho * U * b * np.array([-1.0, b * (a + 0.5)])  # per effective downwash
    w = np.array([0.0, U, 1.0, b * (0.5 - a)])  # downwash from (h, alpha, h_dot, alpha_dot)
    rate = B * U / b
    system = np.zeros((6, 6))
    system[:2, 2:4] = np.eye(2)
    right = np.hstack([-K, -C, np.zeros((2, 2))])
    right[:, :4] += np.outer(load, (1.0 - A.sum()) * w)
    right[:, 4:] += np.outer(load, A)
    system[2:4] = np.linalg.solve(M, right)
    system[4:, :4] = np.outer(rate, w)
    system[4:, 4:] = -np.diag(rate)
    values = np.linalg.eigvals(system) / s.omega_alpha
    values = values[values.imag > 0.05]
    return values[np.argsort(-values.real)]


def neutral(case: Case, mach: float, low: float, high: float) -> float:
    """The V_f where the least damped eigenvalue is neutral."""
    return float(brentq(lambda v: eigenvalues(case, mach, v)[0].real, low, high, xtol=1e-10))
