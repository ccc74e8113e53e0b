"""A thick symmetric section that plunges and pitches by little in incompressible flow, exact to first order in the motion.

What thin-airfoil theory leaves out is kept: the section's own steady flow carries the disturbances and the wake, slowly near
nose and trailing edge. In the plane of the circle |w| = 1 (the product's conformal map, of the geometry alone) the boundary
condition is solved by Fourier series, the wake lies on the real axis and runs with the steady flow there, and the flow leaves
the trailing edge smoothly (Kutta). A plate gives Theodorsen's theory (NACA Report 496): tests/coupled/test_thick.py.
Lengths in half chords where they come out, motion e^{iks}, as in `support.possio`.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from aeroslosh.fmus.aero.airfoil import contour
from aeroslosh.fmus.aero.conformal import circle_map

COUNT = 2048  # points around the circle
NEAR = np.exp(np.linspace(-10.0, 0.0, 800))  # of the wake: distances behind the trailing edge in the circle's plane
TURNS = 60.0  # radians of the motion that the wake remembers before its tail is summed by parts
STEP = 0.03  # radians a panel of the wake, at most


@dataclass(frozen=True)
class Circle:
    """The section as the circle's plane sees it, chord 1: nodes from trailing to leading edge on the upper side.

    radius: z ≈ radius · w far away; circle: the map, None for the plate."""

    x: np.ndarray
    y: np.ndarray
    radius: float
    circle: Any

    def behind(self, xi: np.ndarray) -> np.ndarray:
        """x behind the trailing edge at w = xi > 1."""
        if self.circle is None:
            return 0.5 + self.radius * (xi + 1.0 / xi)
        return np.array(self.circle.points(xi, 1)[:, 0].real)


def plate() -> Circle:
    theta = np.linspace(0.0, np.pi, COUNT // 2 + 1)
    return Circle(0.5 + 0.5 * np.cos(theta), np.zeros_like(theta), 0.25, None)


def section(airfoil: str) -> Circle:
    circle = circle_map(contour(airfoil))
    z = circle.points(np.ones(1), COUNT)[0][: COUNT // 2 + 1]
    z[0] = circle.fixed[0]
    return Circle(z.real, z.imag, circle.radius, circle)


def coefficients(body: Circle, k: float, axis: float) -> np.ndarray:
    """C_L and C_M (rows) of plunge rate (h/b)' and of pitch; moment nose-up about `axis`, half chords aft of mid-chord.

    Shape: (2, 2), complex."""
    omega, at = 2.0 * k, 0.5 * (1.0 + axis)  # speed and chord 1
    n = body.x.size - 1
    theta = np.pi * (np.arange(n) + 0.5) / n
    x, y = 0.5 * (body.x[1:] + body.x[:-1]), 0.5 * (body.y[1:] + body.y[:-1])
    dx, dy, dtheta = np.diff(body.x), np.diff(body.y), np.pi / n
    # stream function of the motions on the wall: upwash of the stream relative to the section, and pitch rate
    walls = body.x, 0.5 * (body.y**2 + (body.x - at) ** 2)
    xi, weight, tau = _wake(body, omega)
    order = np.arange(1, n)
    start = 1.0 + _carried(2.0 / (xi - 1.0), weight, tau, omega)
    potential, slope = [], []
    for wall in walls:
        b = np.fft.rfft(np.concatenate([wall, wall[-2:0:-1]])).real[1:n] / n
        phase = np.outer(theta, order)
        circulation = 2.0 * np.pi * (order @ b) / start
        # the wake of this circulation and its images: what is left of it far behind is the circulation about the circle
        cot = 1.0 / np.tan(0.5 * theta)
        angle = 2.0 * np.arctan((xi - 1.0) / (xi + 1.0) * cot[:, None]) - (np.pi - theta)[:, None]
        ring = (xi**2 - 1.0) / (xi**2 - 2.0 * xi * np.cos(theta)[:, None] + 1.0) - 1.0
        turned = circulation / (2.0 * np.pi)
        potential.append(np.sin(phase) @ b + turned * (np.pi - theta + _carried(angle, weight, tau, omega)))
        slope.append(np.cos(phase) @ (order * b) - turned * (1.0 + _carried(ring, weight, tau, omega)))
    length2 = (dx**2 + dy**2) / dtheta**2
    stream = -2.0 * body.radius * np.sin(theta)  # steady flow along the circle
    u, v = stream * dx / dtheta / length2, stream * dy / dtheta / length2
    columns = []
    for upwash, rate in ((1.0, 0.0), (1.0, 1j * omega)):
        phi, along = upwash * potential[0] + rate * potential[1], upwash * slope[0] + rate * slope[1]
        moving = rate * y * (u - 1.0) - (upwash + rate * (x - at)) * v
        pressure = -(1j * omega * phi + stream * along / length2 - moving)
        # nodes run from the trailing edge forwards: dx is negative
        lift = 2.0 * np.sum(pressure * dx)
        moment = -2.0 * np.sum(pressure * (y * dy + (x - at) * dx))
        columns.append((2.0 * lift, 2.0 * moment))
    return np.array(columns).T


def _wake(body: Circle, omega: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Places of the wake's panels in the circle's plane, i omega ∫ e^{-i omega tau} dtau of each, and tau at its end.

    tau: time since the trailing edge was left."""
    far = np.arange(2.0, 2.0 + TURNS / (omega * body.radius), STEP / (omega * body.radius))
    near = 1.0 + np.concatenate([[0.0], NEAR])
    middle = np.arange(2.0, min(far[1], 50.0), 0.02)[1:]
    nodes = np.unique(np.concatenate([near, middle, far[far > near[-1]]]))
    x = np.concatenate([[1.0], body.behind(nodes[1:])])
    potential = body.radius * np.diff(nodes) * (1.0 - 1.0 / (nodes[1:] * nodes[:-1]))  # of the steady flow, of each panel
    tau = np.concatenate([[0.0], np.cumsum(np.diff(x) ** 2 / potential)])
    turn = np.exp(-1j * omega * tau)
    return 0.5 * (nodes[1:] + nodes[:-1]), -np.diff(turn), float(tau[-1])


def _carried(values: np.ndarray, weight: np.ndarray, tau: float, omega: float) -> np.ndarray:
    """i omega ∫ values e^{-i omega tau} dtau over the wake; values fall as 1/xi, so that parts give what is behind its end."""
    last = values[..., -1]
    slope = -last / tau  # of 1/tau
    end = np.exp(-1j * omega * tau) * (last + slope / (1j * omega))
    return values @ weight + end
