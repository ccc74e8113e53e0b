"""What the body force and surface tension do at the interface, so that liquid at rest stays at rest.

Plain body force with the mean density of a face leaves a mixed row of cells with a wrong lateral pressure force, −1/2 ρ g Δy
per surface slope. Here the force follows from the potential at the interface: −∇p + ρ b = −∇(p + ρΦ) + Φ_I ∇ρ with b = −∇Φ, so a
flat surface on an equipotential is balanced exactly at any tilt (the idea of reduced gravity: Wroniszewski, Verschaeve and
Pedersen, Coastal Eng. 87 (2014) 139, doi:10.1016/j.coastaleng.2013.12.008).
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import inline, jit


@inline
def _weight(c: float) -> float:
    """How much a cell's line says about a face it shares: nothing where it is full or empty but for round-off."""
    return min(max(c * (1.0 - c), 0.0), 1.0)


@inline
def _point(nx: float, ny: float, d: float, fx: float, fy: float, dx: float, dy: float, vertical: bool) -> tuple[float, float]:
    """Vector [m] from a face centre (fx, fy in cell units) to the interface.

    Along the way between the two cells where the line crosses it well, so that heights of columns count exactly; to the nearest
    point otherwise.
    """
    gap = d - nx * fx - ny * fy
    if vertical and abs(ny) >= abs(nx):
        return 0.0, gap / ny * dy
    if not vertical and abs(nx) >= abs(ny):
        return gap / nx * dx, 0.0
    a, b = nx / dx, ny / dy
    t = gap / (a * a + b * b)
    return t * a, t * b


@jit
def interface_forces(ax: Any, ay: Any, c: Any, rho: Any, open_x: Any, open_y: Any, surface: Any,
                     x: Any, y: Any, frame: Any, jump: float, sigma: float, dx: float, dy: float, s: int) -> None:  # fmt: skip
    """Add to face accelerations ax, ay what the mean-density body force misses, and surface tension.

    frame (4,): body force at the elastic axis along x and y [m/s²], angular acceleration [rad/s²], angular rate squared; jump:
    density of liquid less gas; sigma [N/m] with curvatures kappa (n,) [1/m], positive where the liquid bulges.
    """
    gx, gy, spin, swirl = frame[0], frame[1], frame[2], frame[3]
    cells, lines, kappa = surface.cells, surface.lines, surface.kappa
    for m in range(surface.found[0]):
        k = cells[m]
        nx, ny, d = lines[m, 0], lines[m, 1], lines[m, 2]
        own = _weight(c[k])
        for side in range(4):
            vertical = side >= 2
            step = s if vertical else 1
            far = side % 2 == 1
            face = k if far else k - step
            gate = open_y[face] if vertical else open_x[face]
            if gate == 0.0:
                continue
            other = k + step if far else k - step
            step_c = c[face + step] - c[face]
            if step_c * (ny if vertical else nx) > 0.0:  # the neighbour belongs to another piece of surface
                continue
            share = own / (own + _weight(c[other]))
            fx = 0.5 if vertical else (1.0 if far else 0.0)
            fy = (1.0 if far else 0.0) if vertical else 0.5
            px, py = _point(nx, ny, d, fx, fy, dx, dy, vertical)
            # the potential part of the Euler force −α̈·x·y goes with gravity; halfway between face and interface
            hx = x[k] + (fx - 0.5) * dx + 0.5 * px
            hy = y[k] + (fy - 0.5) * dy + 0.5 * py
            rise = -(gx + spin * hy + swirl * hx) * px - (gy + spin * hx + swirl * hy) * py
            mean = 0.5 * (rho[face] + rho[face + step])
            push = share * (jump * rise + sigma * kappa[m]) * step_c / mean
            if vertical:
                ay[face] += push / dy
            else:
                ax[face] += push / dx
