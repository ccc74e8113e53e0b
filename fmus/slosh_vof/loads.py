"""Loads of the two fluids on the tank: pressure and friction on walls, pressure on baffles and ribs.

Pressure at a wall is that of the cell continued over half a cell by the body force. In cells that the interface crosses the wet
and the dry part each have their own hydrostatic pressure from the interface on: the cell's one value would miss 1/2 ρ g Δy per
metre of surface rise.
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import inline, jit

WEST, EAST, FLOOR, ROOF, SHEAR_X, SHEAR_Y, PLATES, FORCE_X, FORCE_Y, MOMENT, DATUM = range(11)
ROWS = 11


@inline
def _side(surface: Any, q: Any, rho: Any, k: int, g: float, dy: float, edge: float, push: float, p: Any) -> float:
    """Mean pressure on a vertical edge of cell k, at x = edge (0 or 1) in the cell, from the cell's own pressure.

    push [m2/s2]: body force towards the edge times half a cell.
    """
    value = p.liquid_density * q[k]
    m = surface.at[k] - 1
    if m < 0:
        return value + rho[k] * push
    n_x, n_y, d = surface.lines[m, 0], surface.lines[m, 1], surface.lines[m, 2]
    if abs(n_y) < abs(n_x):
        return value + rho[k] * push
    rise = (d - n_x * edge) / n_y
    centre = (d - 0.5 * n_x) / n_y
    # along the interface pressure changes only as far as it does not lie level
    at_interface = value - rho[k] * g * (centre - 0.5) * dy + p.liquid_density * (push + g * (centre - rise) * dy)
    w = min(max(rise, 0.0), 1.0)
    below, above = (p.liquid_density, p.gas_density) if n_y > 0.0 else (p.gas_density, p.liquid_density)
    return at_interface + g * dy * (below * (rise * w - 0.5 * w * w) - above * (0.5 * (1.0 - w * w) - rise * (1.0 - w)))


@inline
def _end(surface: Any, q: Any, rho: Any, k: int, g: float, dy: float, roof: bool, p: Any) -> float:
    """Pressure on the floor or roof side of cell k."""
    value = p.liquid_density * q[k]
    m = surface.at[k] - 1
    if m < 0:
        return value + (-0.5 if roof else 0.5) * rho[k] * g * dy
    n_x, n_y, d = surface.lines[m, 0], surface.lines[m, 1], surface.lines[m, 2]
    if abs(n_y) < abs(n_x):
        return value + (-0.5 if roof else 0.5) * rho[k] * g * dy
    rise = min(max((d - 0.5 * n_x) / n_y, 0.0), 1.0)
    at_interface = value - rho[k] * g * (rise - 0.5) * dy
    liquid_there = (n_y > 0.0) != roof
    near = p.liquid_density if liquid_there else p.gas_density
    return at_interface + near * g * (-(1.0 - rise) if roof else rise) * dy


@jit
def _rib_loads(state: Any, surface: Any, rho: Any, frame: Any, x: Any, y: Any, plates: Any, p: Any, out: Any) -> float:
    """Add the force of the pressures on both sides of ribs to that on plates; returns its moment. Each side is a wall."""
    s, v = p.nx + 2, state[2]
    gx, gy, spin, swirl, rate = frame[0], frame[1], frame[2], frame[3], frame[4]
    moment = 0.0
    for m in range(plates.shape[0]):
        for j in range(plates[m, 1], plates[m, 2]):
            k = (j + 2) * s + plates[m, 0] + 1
            edge = x[k] + 0.5 * p.dx
            g = -(gy + spin * edge + swirl * y[k])
            across = gx - spin * y[k] + swirl * edge
            push = 0.5 * p.dx * (across - rate * (v[k] + v[k - s]))
            left = _side(surface, state[5], rho, k, g, p.dy, 1.0, push, p)
            push = -0.5 * p.dx * (across - rate * (v[k + 1] + v[k + 1 - s]))
            right = _side(surface, state[5], rho, k + 1, g, p.dy, 0.0, push, p)
            force = (left - right) * p.dy
            out[PLATES] += force
            moment += y[k] * force
    return moment


@jit
def wall_loads(state: Any, surface: Any, rho: Any, tau: Any, frame: Any, x: Any, y: Any, plates: Any, p: Any, out: Any,
               ribs: Any = None) -> None:  # fmt: skip
    """Loads per metre of width in tank axes; moment about the elastic axis, nose-up. Pressure is 0 in the middle of the roof.

    out (11,): forces of the west, east, floor and roof walls' pressure (west and east along x, floor and roof along y), friction
    along x and y, force on baffles and ribs along x, whole force along x and y, whole moment, pressure of the datum before the
    shift.
    """
    q = state[5]
    nx, ny, dx, dy = p.nx, p.ny, p.dx, p.dy
    s = nx + 2
    gx, gy, spin, swirl, rate = frame[0], frame[1], frame[2], frame[3], frame[4]
    u, v = state[1], state[2]
    moment = 0.0
    k = (ny + 1) * s + (nx + 1) // 2
    g = -(gy + spin * x[k] + swirl * (y[k] + 0.5 * dy) + 2.0 * rate * u[k])
    datum = _end(surface, q, rho, k, g, dy, True, p)
    if nx % 2 == 0:
        k += 1
        g = -(gy + spin * x[k] + swirl * (y[k] + 0.5 * dy) + 2.0 * rate * u[k - 1])
        datum = 0.5 * (datum + _end(surface, q, rho, k, g, dy, True, p))
    for row in range(ROWS):
        out[row] = 0.0
    for j in range(2, ny + 2):
        for side in range(2):
            k = j * s + (nx if side else 1)
            sign = 1.0 if side else -1.0
            wall_x = x[k] + 0.5 * sign * dx
            # weight and rotation along the wall; at the wall the flow has no acceleration across it
            g = -(gy + spin * wall_x + swirl * y[k])
            across = gx - spin * y[k] + swirl * wall_x - rate * (v[k] + v[k - s])
            push = 0.5 * sign * dx * across
            force = sign * (_side(surface, q, rho, k, g, dy, 1.0 if side else 0.0, push, p) - datum) * dy
            friction = -sign * 0.5 * (tau[k - 1 + side] + tau[k - 1 + side - s]) * dy
            out[EAST if side else WEST] += force
            out[SHEAR_Y] += friction
            moment += y[k] * force - wall_x * friction
    for i in range(1, nx + 1):
        for side in range(2):
            k = ((ny + 1) if side else 2) * s + i
            sign = 1.0 if side else -1.0
            wall_y = y[k] + 0.5 * sign * dy
            g = -(gy + spin * x[k] + swirl * wall_y + rate * (u[k] + u[k - 1]))
            force = sign * (_end(surface, q, rho, k, g, dy, side == 1, p) - datum) * dx
            node = k if side else k - s
            friction = -sign * 0.5 * (tau[node] + tau[node - 1]) * dx
            out[ROOF if side else FLOOR] += force
            out[SHEAR_X] += friction
            moment += wall_y * friction - x[k] * force
    for m in range(plates.shape[0]):
        for j in range(plates[m, 1], plates[m, 2]):
            k = (j + 2) * s + plates[m, 0] + 1
            edge = x[k] + 0.5 * dx
            g = -(gy + spin * edge + swirl * y[k])
            across = gx - spin * y[k] + swirl * edge
            left = _side(surface, q, rho, k, g, dy, 1.0, 0.5 * dx * across, p)
            right = _side(surface, q, rho, k + 1, g, dy, 0.0, -0.5 * dx * across, p)
            force = (left - right) * dy
            out[PLATES] += force
            moment += y[k] * force
    if ribs is not None:
        moment += _rib_loads(state, surface, rho, frame, x, y, ribs.plates, p, out)
    out[FORCE_X] = out[WEST] + out[EAST] + out[SHEAR_X] + out[PLATES]
    out[FORCE_Y] = out[FLOOR] + out[ROOF] + out[SHEAR_Y]
    out[MOMENT] = moment
    out[DATUM] = datum
