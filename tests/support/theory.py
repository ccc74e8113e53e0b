"""Exact answers for the doubles: eigenvalues of section + thin airfoil, and the coupled oscillators."""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales

A, B = np.array([0.165, 0.335]), np.array([0.0455, 0.3])


def matrix(case: Case, mach: float, V_f: float) -> np.ndarray:
    """x' = A x / omega_alpha of section and thin airfoil, x = (h, alpha, h', alpha', two lags). Shape: (6, 6)."""
    s = scales(case, mach, V_f)
    b, U, rho, a = s.half_chord, s.speed, s.density, 2.0 * case.section.elastic_axis - 1.0
    m = np.pi * rho * b**2
    M = np.array([[s.mass, s.static_imbalance], [s.static_imbalance, s.inertia]])
    M = M + m * np.array([[1.0, -b * a], [-b * a, b**2 * (0.125 + a**2)]])
    C = m * np.array([[0.0, U], [0.0, U * b * (0.5 - a)]])
    ratios = np.array([case.section.damping_ratio_h, case.section.damping_ratio_alpha])
    C = C + np.diag(2.0 * ratios * np.array([s.mass * s.omega_h, s.inertia * s.omega_alpha]))
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
    return system / s.omega_alpha


def spectrum(case: Case, mach: float, V_f: float) -> np.ndarray:
    """All eigenvalues / omega_alpha, least stable first. Shape: (6,)."""
    values = np.linalg.eigvals(matrix(case, mach, V_f))
    return values[np.argsort(-values.real)]


def eigenvalues(case: Case, mach: float, V_f: float) -> np.ndarray:
    """Eigenvalues / omega_alpha of the aeroelastic system, those with positive frequency, least damped first."""
    values = spectrum(case, mach, V_f)
    return values[values.imag > 1e-6]


def divergence(case: Case) -> float:
    """The V_f of static divergence; inf where there is none."""
    a = 2.0 * case.section.elastic_axis - 1.0
    return float(np.sqrt(case.section.r2_alpha / (1.0 + 2.0 * a))) if a > -0.5 else np.inf


def crossings(case: Case, mach: float, low: float, high: float) -> list[tuple[float, float, str]]:
    """Every neutral V_f: (V_f, frequency or 0 for divergence, onset or recovery), by the number of unstable oscillations."""
    grid = np.geomspace(low, high, 600)

    def unstable(v: float) -> int:
        return int(np.sum(eigenvalues(case, mach, v).real > 0.0))

    found, counts = [], [unstable(v) for v in grid]
    for i in np.flatnonzero(np.diff(counts)):
        a, b = grid[i], grid[i + 1]
        for _ in range(40):
            middle = 0.5 * (a + b)
            a, b = (middle, b) if unstable(middle) == counts[i] else (a, middle)
        near = eigenvalues(case, mach, b)
        neutral = near[np.argmin(np.abs(near.real))] if near.size else 1.0
        if abs(neutral.real) < 1e-6:  # else two real eigenvalues became a pair, or a pair two real ones
            found.append((b, float(neutral.imag), "onset" if counts[i + 1] > counts[i] else "recovery"))
    static = divergence(case)
    if low < static < high:
        found.append((static, 0.0, "onset"))
    return sorted(found)


def neutral(case: Case, mach: float, low: float, high: float) -> float:
    """The V_f where the least damped eigenvalue is neutral."""
    return float(brentq(lambda v: eigenvalues(case, mach, v)[0].real, low, high, xtol=1e-10))
