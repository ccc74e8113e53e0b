"""Conformal map of the outside of an airfoil: Kármán–Trefftz, then Theodorsen's iteration to the exact circle.

z (section plane, chords) ↔ ζ (near circle, corner removed) ↔ w (|w| ≥ 1). The map gives an orthogonal smooth mesh, exact
surface slopes and curvature, and the exact incompressible lift.
Sources: Kármán and Trefftz, ZFM 9 (1918) 111; Theodorsen, NACA Report 411 (1931).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]

_MODES = 4096
_TOLERANCE = 1e-13
_ITERATIONS = 400


class MappingError(ValueError):
    """The section cannot be mapped to a circle; the message says why and the remedy."""


@dataclass(frozen=True)
class CircleMap:
    """Map w → z with |w| = 1 on the section.

    coefficients: shape (m,), ln((ζ − centre)/w) = Σ c_k w^-k; trailing_edge: angle θ of the trailing edge [rad];
    power: Kármán–Trefftz exponent; fixed: its two fixed points in z (trailing edge, inside the nose);
    poles: the same two in ζ; iterations: Theodorsen iterations used.
    """

    coefficients: Complex
    centre: complex
    trailing_edge: float
    power: float
    fixed: tuple[complex, complex]
    poles: tuple[complex, complex]
    iterations: int

    @property
    def radius(self) -> float:
        """Radius of the equivalent circle [chords]: z ≈ radius·exp(iβ)·w far away."""
        return float(np.exp(self.coefficients[0].real))

    def lift_coefficient(self, alpha: float) -> float:
        """Exact incompressible C_L at incidence alpha [rad] by the Kutta condition at the trailing edge."""
        zero_lift = self.trailing_edge + self.coefficients[0].imag
        return float(8 * np.pi * self.radius * np.sin(alpha - zero_lift))

    def at(self, rho: Array, angle: Array) -> Complex:
        """z on circles |w| = rho at angles [rad] from the trailing edge's, anticlockwise, shape (len(rho), len(angle))."""
        theta = self.trailing_edge + angle
        order = np.arange(len(self.coefficients))
        series = (self.coefficients * rho[:, None] ** (-order)) @ np.exp(-1j * np.outer(order, theta))
        return self._section_plane(self.centre + rho[:, None] * np.exp(1j * theta + series))

    def points(self, rho: Array, count: int) -> Complex:
        """z on circles |w| = rho, shape (len(rho), count), anticlockwise and evenly from the trailing edge's angle."""
        return self.at(rho, 2 * np.pi * np.arange(count) / count)

    def _section_plane(self, zeta: Complex) -> Complex:
        (z1, z2), (p1, p2) = self.fixed, self.poles
        with np.errstate(divide="ignore", invalid="ignore"):
            ratio = np.exp(self.power * np.log((zeta - p1) / (zeta - p2)))
        ratio = np.where(np.abs(zeta - p1) < 1e-12, 0.0, ratio)
        return np.asarray((z1 - z2 * ratio) / (1 - ratio), dtype=complex)


def circle_map(contour: Array) -> CircleMap:
    """Map of a closed contour of shape (n, 2), Selig order, first point = last point = sharp trailing edge.

    Raises MappingError where the near circle is not star-shaped or the iteration does not converge.
    """
    z = contour[:, 0] + 1j * contour[:, 1]
    z1, nose = z[0], int(np.argmax(np.abs(z - z[0])))
    angle = _trailing_edge_angle(z)
    power = 2 - angle / np.pi
    z2 = _nose_focus(z, nose)
    spread = (z1 - z2) / power
    middle = 0.5 * (z1 + z2)
    p1, p2 = middle + 0.5 * spread, middle - 0.5 * spread

    # arguments are unwrapped along the contour: it may cross the straight line between the fixed points (strong camber)
    inner = z[1:-1]
    log_ratio = np.log(np.abs((inner - z1) / (inner - z2))) + 1j * (
        np.unwrap(np.angle(inner - z1)) - np.unwrap(np.angle(inner - z2))
    )
    at_nose = log_ratio[nose - 1].imag
    log_ratio -= 2j * np.pi * np.round(at_nose / (2 * np.pi))
    ratio = np.exp(log_ratio / power)
    zeta = np.concatenate([[p1], (p1 - p2 * ratio) / (1 - ratio)])

    centre = complex(0.5 * (zeta.real.max() + zeta.real.min()), 0.5 * (zeta.imag.max() + zeta.imag.min()))
    polar = np.unwrap(np.angle(zeta - centre))
    if np.any(np.diff(polar) <= 0) or polar[-1] - polar[0] >= 2 * np.pi:
        raise MappingError(
            "the section does not map to a near circle (its image is not star-shaped). Remedy: smoother coordinates, "
            "less camber or thickness, a trailing edge without hook"
        )
    closed = np.append(polar, polar[0] + 2 * np.pi)
    log_radius = np.log(np.abs(zeta - centre))
    spline = CubicSpline(closed, np.append(log_radius, log_radius[0]), bc_type="periodic")
    coefficients, iterations = _theodorsen(spline)
    start = _trailing_edge_on_circle(coefficients, float(polar[0]))
    return CircleMap(coefficients, centre, start, power, (z1, z2), (p1, p2), iterations)


def _trailing_edge_angle(z: Complex) -> float:
    """Included angle [rad] between the sides at the trailing edge, from the chord of the last percents."""

    def direction(points: Complex) -> float:
        distance = np.abs(points - points[0])
        reach = max(int(np.searchsorted(distance, 0.02)), 1)
        return float(np.angle(points[reach] - points[0]))

    angle = (direction(z[::-1]) - direction(z)) % (2 * np.pi)
    if not 0 <= angle < 0.6:
        raise MappingError(
            f"trailing-edge angle {np.degrees(angle):.1f} degrees is outside 0 to 34. Remedy: upper side above the lower one, "
            "sharp trailing edge"
        )
    return angle


def _nose_focus(z: Complex, nose: int) -> complex:
    """The second fixed point: half a nose radius inside the point farthest from the trailing edge."""
    near = np.abs(z - z[nose]) < 0.01
    near[max(nose - 2, 0) : nose + 3] = True
    points = z[near]
    # algebraic circle fit: |z|² = 2 Re(conj(c) z) + const
    system = np.column_stack([2 * points.real, 2 * points.imag, np.ones(len(points))])
    (x, y, constant), *_ = np.linalg.lstsq(system, np.abs(points) ** 2, rcond=None)
    centre = complex(x, y)
    radius = float(np.sqrt(max(constant + abs(centre) ** 2, 1e-8)))
    inward = (centre - z[nose]) / abs(centre - z[nose])
    return complex(z[nose] + 0.5 * radius * inward)


def _theodorsen(log_radius: CubicSpline) -> tuple[Complex, int]:
    """Coefficients c_k of ln((ζ − centre)/w) from ln|ζ − centre| over its polar angle, and the iterations used."""
    theta = 2 * np.pi * np.arange(_MODES) / _MODES
    start = log_radius.x[0]
    phi = theta.copy()
    half = _MODES // 2
    for iteration in range(1, _ITERATIONS + 1):
        spectrum = np.fft.fft(log_radius(start + np.mod(phi - start, 2 * np.pi))) / _MODES
        # analytic outside the circle: only e^{-ikθ} terms, c_0 real, c_k = 2·conj of the e^{+ikθ} coefficient
        coefficients = np.zeros(half, dtype=complex)
        coefficients[0] = spectrum[0].real
        coefficients[1:] = 2 * np.conj(spectrum[1:half])
        full = np.zeros(_MODES, dtype=complex)
        full[:half] = coefficients
        target = theta + np.fft.fft(full).imag
        change = float(np.max(np.abs(target - phi)))
        phi = 0.5 * phi + 0.5 * target
        if change < _TOLERANCE:
            return coefficients, iteration
        if not np.isfinite(change):
            break
    raise MappingError(
        f"Theodorsen's iteration did not converge in {_ITERATIONS} steps. Remedy: smoother coordinates or less camber"
    )


def _trailing_edge_on_circle(coefficients: Complex, polar: float) -> float:
    """Angle θ with polar angle φ(θ) = polar, by Newton's method."""
    order = np.arange(len(coefficients))
    theta = polar
    for _ in range(60):
        terms = coefficients * np.exp(-1j * order * theta)
        residual = theta + float(np.sum(terms).imag) - polar
        slope = 1 - float(np.sum(order * terms).real)
        theta -= residual / slope
        if abs(residual) < 1e-14:
            break
    return theta
