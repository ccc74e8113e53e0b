"""Drive the aero FMU alone with small motions and keep what it answers: the data of a linear model.

Time is s = U t / b (half chords travelled). The two inputs of the aerodynamics are the plunge rate over the speed,
w = (dh/dt) / U, and the pitch alpha, both in radians: a steady plunge rate is an angle of attack, and the position h itself
makes no load. A motion gives each of them as a sweep in frequency with its exact derivatives and its integral.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from ..base.errors import AeroSloshError
from ..case.scales import Scales
from ..fmi.component import Component, Saved

NEEDED = {
    "input": ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot"),
    "output": ("lift", "moment"),
}
# Gauss–Legendre nodes and weights on [0, 1]: where the inputs are needed between samples
NODES, QUADRATURE = (0.5 * (np.polynomial.legendre.leggauss(4)[0] + 1.0), 0.5 * np.polynomial.legendre.leggauss(4)[1])
Curve = Callable[[np.ndarray], np.ndarray]  # s, shape (n,) → (integral, value, slope, curvature), shape (4, n)


def still(s: np.ndarray) -> np.ndarray:
    """No motion. Shape: (4, n)."""
    return np.zeros((4, s.size))


def chirp(size: float, start: float, length: float, k: tuple[float, float], phase: float) -> Curve:
    """Sweep from frequency k[0] to k[1], as long in each octave, under a window sin^2, from s = `start` for `length`.

    The integral is exact to 1e-10 by Gauss–Legendre quadrature between samples."""
    x, weight = np.polynomial.legendre.leggauss(8)
    growth = math.log(k[1] / k[0])

    def value(s: np.ndarray, order: int) -> np.ndarray:
        z = np.clip((s - start) / length, 0.0, 1.0)
        rate = k[0] * np.exp(growth * z)
        angle = phase + length / growth * (rate - k[0])
        bend = growth / length * rate
        f, g, e = np.sin(math.pi * z) ** 2, math.pi / length * np.sin(2 * math.pi * z), 2 * (math.pi / length) ** 2
        sin, cos = np.sin(angle), np.cos(angle)
        if order == 0:
            return f * sin
        if order == 1:
            return g * sin + f * rate * cos
        inside = (z > 0.0) & (z < 1.0)
        return inside * (e * np.cos(2 * math.pi * z) * sin + 2 * g * rate * cos + f * (bend * cos - rate**2 * sin))

    def curve(s: np.ndarray) -> np.ndarray:
        h = np.diff(s)[:, None]
        inner = s[:-1, None] + 0.5 * h * (1.0 + x)
        pieces = np.sum(0.5 * h * weight * value(inner, 0), axis=1)
        integral = np.concatenate([[0.0], np.cumsum(pieces)])
        return size * np.stack([integral, value(s, 0), value(s, 1), value(s, 2)])

    return curve


@dataclass(frozen=True)
class Record:
    """The answer to one motion, sampled at the equidistant `s`; loads are changes from the steady ones.

    s        (n,)
    motion   (2, 4, n): of w and alpha, the integral, the value, the first and second derivative by s [rad]
    loads    (2, n): C_L, C_M (nose-up, about the elastic axis)
    between  (2, n_nodes, n - 1): w and alpha at the quadrature nodes between the samples
    """

    s: np.ndarray
    motion: np.ndarray
    loads: np.ndarray
    between: np.ndarray

    @property
    def ds(self) -> float:
        """Step in half chords."""
        return float(self.s[1] - self.s[0])


def check_interface(aero: Component) -> None:
    """Raises AeroSloshError when the FMU lacks a motion input or a load output."""
    for causality, names in NEEDED.items():
        known = aero.input_index if causality == "input" else aero.output_index
        missing = [name for name in names if name not in known]
        if missing:
            raise AeroSloshError(
                f"{aero.name} has no Real {causality} {', '.join(missing)}",
                str(aero.path),
                "a linear model needs the motion as inputs and lift and moment as outputs; use --method march",
            )


def drive(
    aero: Component,
    steady: Saved,
    scales: Scales,
    curves: tuple[Curve, Curve],
    ds: float,
    length: float,
) -> Record:
    """Move `aero` from its saved `steady` state by `curves` (w, alpha) in steps of `ds` half chords.

    The record is `length` half chords long. Raises ComponentError when the FMU fails, AeroSloshError when it answers with a
    number that is none."""
    aero.rewind(steady)
    b, speed = scales.half_chord, scales.speed
    q = 0.5 * scales.density * speed**2
    unit = np.array([q * 2.0 * b, q * (2.0 * b) ** 2])  # of lift and moment
    where = [aero.output_index[name] for name in NEEDED["output"]]
    start = aero.outputs.values[where].copy()
    last = math.ceil(length / ds)
    s = ds * np.arange(last + 1)
    w, alpha = (curve(s) for curve in curves)
    rate = speed / b  # ds/dt
    inputs = {
        "h": w[0] * b, "h_dot": w[1] * speed, "h_ddot": w[2] * speed * rate,
        "alpha": alpha[1], "alpha_dot": alpha[2] * rate, "alpha_ddot": alpha[3] * rate**2,
    }  # fmt: skip
    columns = [(aero.input_index[name], values) for name, values in inputs.items()]
    loads = np.zeros((2, last + 1))
    for i in range(1, last + 1):
        for column, values in columns:
            aero.inputs.values[column] = values[i]
        aero.step(ds / rate)
        loads[:, i] = (aero.outputs.values[where] - start) / unit
        if not np.isfinite(loads[:, i]).all():
            raise AeroSloshError(
                f"{aero.name} gave a load that is not a number in step {i} of a small motion",
                str(aero.path),
                "use --method march, or change the aero settings",
            )
    between = np.stack([[curve(s[:last] + node * ds)[1] for node in NODES] for curve in curves])
    return Record(s, np.stack([w, alpha]), loads, between)
