"""NACA sections by their formulas: 4-digit, 5-digit and 6A-series.

A contour is an array of shape (n, 2) in chords, in Selig order: trailing edge, upper side, leading edge, lower side, trailing
edge. Its first and last points are the same sharp trailing edge; the leading edge is at x = 0, the trailing edge at x = 1.
"""

from __future__ import annotations

import csv
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline
from scipy.optimize import brentq

Array = NDArray[np.float64]

_POINTS = 400
"""Stations a side of an analytic contour; the mapping interpolates between them with splines."""


class AirfoilError(ValueError):
    """A name or a file that gives no usable section; the message says what, where and the remedy."""


def naca4(code: str) -> Array:
    """NACA 4-digit section with closed trailing edge (last thickness coefficient −0.1036). NASA TM 4741."""
    m, p, t = int(code[0]) / 100, int(code[1]) / 10, int(code[2:]) / 100
    if t <= 0:
        raise AirfoilError(f"airfoil 'NACA {code}': zero thickness. Remedy: a thickness of 1 to 40 percent, as in 0012")
    if m > 0 and p == 0:
        raise AirfoilError(f"airfoil 'NACA {code}': camber without position. Remedy: a second digit of 1 to 9, as in 2412")
    x = _cosine_stations()
    half = _thickness_4(t, x)
    if m == 0:
        return _assemble(x, half, np.zeros_like(x), np.zeros_like(x))
    fore = x < p
    camber = np.where(fore, m / p**2 * (2 * p * x - x**2), m / (1 - p) ** 2 * (1 - 2 * p + 2 * p * x - x**2))
    slope = np.where(fore, 2 * m / p**2 * (p - x), 2 * m / (1 - p) ** 2 * (p - x))
    return _assemble(x, half, camber, slope)


_MEAN_LINES_5 = {
    "10": (0.0580, 361.400, 0.0),
    "20": (0.1260, 51.640, 0.0),
    "30": (0.2025, 15.957, 0.0),
    "40": (0.2900, 6.643, 0.0),
    "50": (0.3910, 3.230, 0.0),
    "21": (0.1300, 51.990, 0.000764),
    "31": (0.2170, 15.793, 0.00677),
    "41": (0.3180, 6.520, 0.0303),
    "51": (0.4410, 3.191, 0.1355),
}
"""Second and third digit → r, k1 and k2/k1 of the mean line for a design lift coefficient of 0.3 (first digit 2). TM 4741."""


def naca5(code: str) -> Array:
    """NACA 5-digit section (23012; reflexed: 23112) with closed trailing edge. NASA TM 4741; NACA Report 610."""
    t = int(code[3:]) / 100
    if t <= 0 or code[0] == "0" or code[1:3] not in _MEAN_LINES_5:
        raise AirfoilError(
            f"airfoil 'NACA {code}': no NACA 5-digit section. Remedy: first digit 1 to 9, second and third one of "
            f"{', '.join(_MEAN_LINES_5)}, thickness 01 to 99, as in 23012"
        )
    r, k1, ratio = _MEAN_LINES_5[code[1:3]]
    k1 *= int(code[0]) / 2
    x = _cosine_stations()
    fore = x < r
    if ratio == 0.0:
        camber = k1 / 6 * np.where(fore, x**3 - 3 * r * x**2 + r**2 * (3 - r) * x, r**3 * (1 - x))
        slope = k1 / 6 * np.where(fore, 3 * x**2 - 6 * r * x + r**2 * (3 - r), -(r**3))
    else:
        factor = np.where(fore, 1.0, ratio)
        linear = ratio * (1 - r) ** 3 + r**3
        camber = k1 / 6 * (factor * (x - r) ** 3 - linear * x + r**3)
        slope = k1 / 6 * (3 * factor * (x - r) ** 2 - linear)
    return _assemble(x, _thickness_4(t, x), camber, slope)


def naca6a(code: str) -> Array:
    """NACA 6A section, e.g. 64A010: family 63A/64A/65A, design lift in tenths, thickness in percent.

    Thickness form by scaling Theodorsen's epsilon and psi until the thickness fits; straight sides from x = 0.82 to a sharp
    trailing edge, as there; mean line a = 0.8 (modified). Ladson and Brooks, NASA TM X-3069 (1974); NASA TM 4741 (1996).
    """
    family, lift, t = code[:3], int(code[3]) / 10, int(code[4:]) / 100
    if not 0.03 <= t <= 0.21:
        raise AirfoilError(
            f"airfoil 'NACA {code}': thickness {t:.0%} outside 3 to 21 percent, where the 6A forms are defined. "
            "Remedy: e.g. 64A010"
        )
    x = _cosine_stations()
    half = _thickness_6a(family, t, x)
    camber, slope = _mean_line_08_modified(x, lift)
    return _assemble(x, half, camber, slope)


def _cosine_stations() -> Array:
    """Stations from leading (0) to trailing edge (1), shape (_POINTS,), dense at both ends."""
    return 0.5 * (1 - np.cos(np.linspace(0, np.pi, _POINTS)))


def _thickness_4(t: float, x: Array) -> Array:
    """Half thickness of the 4- and 5-digit series at stations x, shape like x, of thickness ratio t."""
    half = 5 * t * (0.2969 * np.sqrt(x) - 0.1260 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    half[-1] = 0.0
    return np.asarray(half)


def _assemble(x: Array, half: Array, camber: Array, slope: Array) -> Array:
    """Contour from half thickness laid off normal to a mean line, all of shape (n,), leading edge first."""
    angle = np.arctan(slope)
    upper = np.column_stack([x - half * np.sin(angle), camber + half * np.cos(angle)])
    lower = np.column_stack([x + half * np.sin(angle), camber - half * np.cos(angle)])
    upper[-1] = lower[-1] = (1.0, 0.0)
    return np.vstack([upper[::-1], lower[1:]])


@cache
def _forms_6a() -> dict[str, tuple[CubicSpline, CubicSpline]]:
    """Splines of epsilon(phi) and psi(phi) a family, from naca6a.csv."""
    text = (Path(__file__).parent / "naca6a.csv").read_text(encoding="utf-8").splitlines()
    table = list(csv.DictReader(line for line in text if not line.startswith("#")))
    forms = {}
    for family in sorted({row["family"] for row in table}):
        rows = [row for row in table if row["family"] == family]
        phi, epsilon, psi = (np.array([float(row[key]) for row in rows]) for key in ("phi", "epsilon", "psi"))
        # epsilon is odd and psi even about both ends by the symmetry of the section
        forms[family] = (
            CubicSpline(phi, epsilon, bc_type=((2, 0.0), (2, 0.0))),
            CubicSpline(phi, psi, bc_type=((1, 0.0), (1, 0.0))),
        )
    return forms


def _thickness_6a(family: str, t: float, x: Array) -> Array:
    """Half thickness at stations x, shape like x, of a 6A basic form of thickness ratio t."""
    epsilon, psi = _forms_6a()[family]
    phi = np.linspace(0, np.pi, 2001)

    def shape(scale: float) -> tuple[Array, Array]:
        angle = phi - epsilon(phi) * scale
        along = -2 * np.cosh(psi(phi) * scale) * np.cos(angle)
        up = 2 * np.sinh(psi(phi) * scale) * np.sin(angle)
        length = along[-1] - along[0]
        return (along - along[0]) / length, up / length

    scale = brentq(lambda s: 2 * shape(s)[1].max() - t, 0.05, 3.0, xtol=1e-12)
    station, half = shape(scale)
    # in sqrt(x) the round nose is a straight line, so that a spline holds there
    spline = CubicSpline(np.sqrt(station), half)
    joint = 0.82
    result = np.where(x < joint, spline(np.sqrt(x)), spline(np.sqrt(joint)) * (1 - x) / (1 - joint))
    result[0] = result[-1] = 0.0
    return np.asarray(result, dtype=float)


def _mean_line_08_modified(x: Array, lift: float) -> tuple[Array, Array]:
    """Ordinate and slope of the mean line a = 0.8 (modified) for a design lift coefficient. NASA TM 4741, p. 8."""
    if lift == 0:
        return np.zeros_like(x), np.zeros_like(x)
    a = 0.8
    g = -(a**2 * (0.5 * np.log(a) - 0.25) + 0.25) / (1 - a)
    h = (0.5 * (1 - a) ** 2 * np.log(1 - a) - 0.25 * (1 - a) ** 2) / (1 - a) + g

    def xlog(y: Array) -> Array:
        return np.where(np.abs(y) > 1e-14, y * np.log(np.maximum(np.abs(y), 1e-300)), 0.0)

    # slope at the very nose is infinite: TM 4741 keeps the one at x = 0.005
    steep = np.maximum(x, 0.005)

    def ordinate(s: Array) -> Array:
        z = 0.5 * (a - s) * xlog(a - s) - 0.5 * (1 - s) * xlog(1 - s) + 0.25 * (1 - s) ** 2 - 0.25 * (a - s) ** 2
        return lift / (2 * np.pi * (a + 1)) * (z / (1 - a) - xlog(s) + g - h * s)

    camber = 0.97948 * ordinate(x)
    derivative = -xlog(a - steep) + xlog(1 - steep)
    slope = 0.97948 * lift / (2 * np.pi * (a + 1)) * (derivative / (1 - a) - 1 - np.log(steep) - h)
    straight = (slope <= -0.24521 * lift) | (x > 0.87)
    return np.where(straight, 0.24521 * lift * (1 - x), camber), np.where(straight, -0.24521 * lift, slope)
