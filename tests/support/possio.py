"""A flat plate in unsteady subsonic flow: Possio's integral equation, its neutral V_f, and a rational model for the test double.

Kernel: Bisplinghoff, Ashley and Halfman, Aeroelasticity (1955), chapter 6; checked in
tests/coupled/test_preset.py against steady flow and Theodorsen's function. Collocation at the quadrature points that integrate
the Cauchy singularity exactly; the logarithm's error of these points is taken off. Lengths in half chords, time in half chords
travelled, motion e^{iks}.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from scipy.optimize import root
from scipy.special import hankel2

from aeroslosh.master.case.case import Case
from aeroslosh.master.case.scales import scales

Liquid = Callable[[float], np.ndarray]
POINTS = 40
POLES = np.geomspace(0.03, 3.0, 10)
_T, _W = np.polynomial.legendre.leggauss(40)
_T, _W = 0.5 * (1.0 + _T), 0.5 * _W


def coefficients(mach: float, k: float, axis: float, n: int = POINTS) -> np.ndarray:
    """C_L and C_M (rows) of plunge rate (h/b)' and of pitch; moment nose-up about `axis`, half chords aft of mid-chord.

    Shape: (2, 2), complex."""
    step = 2.0 * np.pi / (2 * n + 1)
    nodes, places = -np.cos(step * (np.arange(n) + 0.5)), -np.cos(step * np.arange(1, n + 1))
    A = k * kernel(mach, k, places[:, None] - nodes) * step * (1.0 - nodes)
    # the sum of a logarithm at points half a step off is too large by step ln 2: with its coefficient i/(2 pi beta) in the kernel
    excess = k * 1j / (2.0 * np.pi * math.sqrt(1.0 - mach**2)) * step * math.log(2.0) * (1.0 - places)
    i = np.arange(n)
    A[i, i] -= 0.5 * excess
    A[i, np.minimum(i + 1, n - 1)] -= 0.5 * excess
    downwash = -np.column_stack([np.ones(n), 1.0 + 1j * k * (places - axis)])
    pressure = np.linalg.solve(A, downwash) * (step * (1.0 - nodes))[:, None]
    return np.stack([pressure.sum(axis=0), -0.5 * (nodes - axis) @ pressure])


def kernel(mach: float, k: float, x: np.ndarray) -> np.ndarray:
    """K(M, k x): upwash over the speed is k times its integral with pressure difference over rho U²."""
    beta2 = 1.0 - mach**2
    beta, z = math.sqrt(beta2), mach * k * np.abs(x) / beta2
    near = np.exp(1j * mach**2 * k * x / beta2) * (1j * mach * np.sign(x) * hankel2(1, z) - hankel2(0, z))
    end = (k * x / beta2)[..., None]
    u = end * _T**2  # the square takes the logarithm at the lower end
    integral = np.sum(np.exp(1j * u) * hankel2(0, mach * np.abs(u)) * end * 2.0 * _T * _W, axis=-1)
    wake = 2.0 / (np.pi * beta) * math.log((1.0 + beta) / mach) + integral
    return (near + 1j * beta2 * np.exp(-1j * k * x) * wake) / (4.0 * beta)


def neutral(case: Case, mach: float, liquid: Liquid, guess: float, ratios: tuple[float, ...] = (1.4, 1.6, 1.2)) -> float:
    """The V_f at which section, air and liquid oscillate without decay. liquid(omega [rad/s]): dynamic stiffness of the liquid
    in (h, alpha), shape (2, 2) [N/m …]; guess: of the V_f; ratios of flutter frequency and omega_alpha to start from."""
    s, section = scales(case, mach, case.flutter.V_f), case.section
    unit = s.mass * (s.speed / s.half_chord) ** 2 * np.outer([1.0, s.half_chord], [1.0, s.half_chord])
    axis = 2.0 * section.elastic_axis - 1.0

    def determinant(unknown: np.ndarray) -> list[float]:
        V_f, k = np.exp(unknown)
        k_alpha2 = 1.0 / (V_f**2 * section.mass_ratio)
        D = -(k**2) * np.array([[1.0, section.x_alpha], [section.x_alpha, section.r2_alpha]])
        D = D + k_alpha2 * np.diag([section.frequency_ratio**2, section.r2_alpha]) + liquid(k * s.speed / s.half_chord) / unit
        Q = coefficients(mach, k, axis)
        load = np.column_stack([1j * k * Q[:, 0], Q[:, 1]]) * np.array([[-1.0], [2.0]]) / (np.pi * section.mass_ratio)
        value = np.linalg.det((D - load) / k**2)
        return [value.real, value.imag]

    for ratio in ratios:
        found = root(determinant, np.log([guess, ratio / (guess * math.sqrt(section.mass_ratio))]), tol=1e-8)
        if found.success and abs(found.x[0] - math.log(guess)) < 0.2:
            return float(np.exp(found.x[0]))
    raise AssertionError(found.message)


def rational(mach: float, axis: float) -> dict[str, list]:
    """C(ik) = D0 + D1 ik + sum R_j ik/(ik + p_j) for plunge rate and pitch by least squares, k from 0.03 to 1.

    Returns poles p (n), D0, D1 (2 loads, 2 motions; D1 of plunge rate is 0), R (n, 2, 2) and the largest relative error for k
    from 0.1 to 0.6."""
    k = np.geomspace(0.03, 1.0, 60)
    data = np.array([coefficients(mach, value, axis) for value in k])
    basis = np.column_stack([np.ones_like(k), 1j * k, *(1j * k / (1j * k + p) for p in POLES)])
    D0, D1, R = np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((POLES.size, 2, 2))
    error, inner = 0.0, (k > 0.1) & (k < 0.6)
    for motion in (0, 1):
        used = [0, 1, *range(2, 2 + POLES.size)] if motion else [0, *range(2, 2 + POLES.size)]
        B = basis[:, used]
        for load in (0, 1):
            y = data[:, load, motion]
            c = np.linalg.lstsq(np.vstack([B.real, B.imag]), np.concatenate([y.real, y.imag]), rcond=None)[0]
            full = np.zeros(basis.shape[1])
            full[used] = c
            D0[load, motion], D1[load, motion], R[:, load, motion] = full[0], full[1], full[2:]
            error = max(error, float(np.max((np.abs(B @ c - y) / np.abs(y))[inner])))
    return {"poles": POLES.tolist(), "D0": D0.tolist(), "D1": D1.tolist(), "R": R.tolist(), "error": error}
