"""Friction on walls from the laminar layer that cells are too thick to hold.

A wall that the liquid slides along with U(t) at distance y drags it with τ/ρ = ∫ K(t − s) U'(s) ds. For a layer between the
wall and a cell's centre, driven by the same pressure as the flow outside, K(t) = ν/y (1 + 2 Σ exp(−n² π² ν t/y²)) (heat
conduction in a slab: Carslaw and Jaeger, Conduction of Heat in Solids, 2nd ed. 1959, section 3.5): sqrt(ν/(π t)) at first,
which gives Stokes' oscillating layer, ν/y in the end. The sum is replaced by an integral over decay rates and that by one over
rates spaced by a factor of four, each with a memory that is advanced exactly. For layers thinner than half a cell; thicker ones
the grid holds itself.

Gas has no memory: its friction does not count. Rows of `memory`: u faces along the floor, v faces along the west wall, u faces
along the roof, v faces along the east wall, nx + ny + nx + ny in all; columns: the memories and the last velocity.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..kit.compiled import jit

RATES = 12
COLUMNS = RATES + 1
_SPACING = math.log(4.0)


def rows(nx: int, ny: int) -> int:
    """Rows of a memory."""
    return 2 * (nx + ny)


@jit
def _drag(memory: Any, row: int, velocity: float, nu: float, y: float, dt: float) -> float:
    """τ/ρ at a wall at distance y from where the liquid moves with `velocity`, dt after the last time; updates the memory."""
    slowest = 0.25 * math.pi**2 * nu / (y * y)
    change = velocity - memory[row, RATES]
    memory[row, RATES] = velocity
    total = nu / y * velocity
    rate = slowest * math.exp(0.5 * _SPACING)
    factor = math.exp(_SPACING)
    for m in range(RATES):
        x = rate * dt
        decay = math.exp(-x)
        gain = (1.0 - decay) / x if x > 1e-6 else 1.0 - 0.5 * x
        memory[row, m] = memory[row, m] * decay + change * gain
        total += math.sqrt(nu * rate) / math.pi * _SPACING * memory[row, m]
        rate *= factor
    return total


@jit
def wall_shear(tau: Any, u: Any, v: Any, c: Any, memory: Any, density: float, nu: float, dx: float, dy: float, nx: int, ny: int,
               dt: float) -> None:  # fmt: skip
    """Replace the shear stress at the nodes of wetted walls; dt [s] since the last time."""
    s = nx + 2
    for side in range(2):
        sign = -1.0 if side else 1.0
        line = (ny + 1) * s if side else 2 * s
        for i in range(1, nx):  # u faces between cells i and i + 1
            k = line + i
            row = side * (nx + ny) + i
            if 0.5 * (c[k] + c[k + 1]) > 0.5:
                node = k if side else k - s
                tau[node] = sign * density * _drag(memory, row, u[k], nu, 0.5 * dy, dt)
            else:
                for m in range(COLUMNS):
                    memory[row, m] = 0.0
        column = nx if side else 1
        for j in range(ny - 1):
            k = (j + 2) * s + column
            row = side * (nx + ny) + nx + j
            if 0.5 * (c[k] + c[k + s]) > 0.5:
                node = k if side else k - 1
                tau[node] = sign * density * _drag(memory, row, v[k], nu, 0.5 * dx, dt)
            else:
                for m in range(COLUMNS):
                    memory[row, m] = 0.0


def memory(nx: int, ny: int) -> Any:
    """An empty one, shape (rows, columns)."""
    return np.zeros((rows(nx, ny), COLUMNS))
