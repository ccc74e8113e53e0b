"""Acceleration of the two fluids without pressure: advection consistent with mass, viscosity, body force, interface forces.

Momentum is carried by the mass fluxes of the volume-of-fluid step: the density of a face is the mean of its two cells, the mass
through a side of its control volume the mean of the two cells' fluxes, so that a face filled by liquid takes its velocity
(Rudman, Int. J. Numer. Meth. Fluids 28 (1998) 357; Raessi and Pitsch, Comput. Fluids 63 (2012) 70). Where all is liquid the
carried velocity is second order (van Leer's limiter with Lax-Wendroff correction), elsewhere upwind.

Both components use the same kernels: `a` is the distance in the flat arrays along the component (1 for u, s for v), `b` across.
"""

from __future__ import annotations

from typing import Any

from ..kit.compiled import inline, jit

LIQUID = 0.999
"""Cells fuller than this count as liquid for the second-order scheme."""


@inline
def _carried(mass: float, w0: float, w1: float, before: float, after: float, share: float) -> float:
    """Momentum carried by `mass` between w0 and w1, the values one further being before and after; share: 0 for upwind."""
    forward = mass > 0.0
    up = w0 if forward else w1
    inner = w1 - w0
    outer = w0 - before if forward else after - w1
    both = inner * outer
    slope = 2.0 * both / (inner + outer) if both > 0.0 else 0.0
    return mass * (up + (0.5 * share if forward else -0.5 * share) * slope)


@jit
def _along(flux: Any, w: Any, mass: Any, liquid: Any, per_density: float, first: int, n: int, a: int) -> None:
    """Momentum through cell centres."""
    f = flux[first : first + n]
    m0, m1 = mass[first - a : first - a + n], mass[first : first + n]
    before, w0, w1, after = (
        w[first - 2 * a : first - 2 * a + n],
        w[first - a : first - a + n],
        w[first : first + n],
        w[first + a : first + a + n],
    )
    l0, l1, l2 = liquid[first - a : first - a + n], liquid[first : first + n], liquid[first + a : first + a + n]
    for k in range(n):
        m = 0.5 * (m0[k] + m1[k])
        share = l0[k] * l1[k] * l2[k] * (1.0 - abs(m) * per_density)
        f[k] = _carried(m, w0[k], w1[k], before[k], after[k], share)


@jit
def _across(flux: Any, w: Any, mass: Any, liquid: Any, per_density: float, first: int, n: int, a: int, b: int) -> None:
    """Momentum through the nodes on the far side across."""
    f = flux[first : first + n]
    m0, m1 = mass[first : first + n], mass[first + a : first + a + n]
    before, w0, w1, after = (
        w[first - b : first - b + n],
        w[first : first + n],
        w[first + b : first + b + n],
        w[first + 2 * b : first + 2 * b + n],
    )
    l0, l1 = liquid[first : first + n], liquid[first + a : first + a + n]
    l2, l3 = liquid[first + b : first + b + n], liquid[first + a + b : first + a + b + n]
    for k in range(n):
        m = 0.5 * (m0[k] + m1[k])
        share = l0[k] * l1[k] * l2[k] * l3[k] * (1.0 - abs(m) * per_density)
        f[k] = _carried(m, w0[k], w1[k], before[k], after[k], share)


@jit
def _along_ribs(flux: Any, w: Any, mass: Any, liquid: Any, per_density: float, plates: Any, s: int) -> None:
    """`_along` of u again in the cells beside ribs, which see beyond them what they would beyond a wall."""
    for m in range(plates.shape[0]):
        for j in range(plates[m, 1], plates[m, 2]):
            k = (j + 2) * s + plates[m, 0] + 1
            through = 0.5 * (mass[k - 1] + mass[k])
            share = liquid[k - 1] * liquid[k] * (1.0 - abs(through) * per_density)
            flux[k] = _carried(through, w[k - 1], w[k], w[k - 2], 0.0, share)
            through = 0.5 * (mass[k] + mass[k + 1])
            share = liquid[k + 1] * liquid[k + 2] * (1.0 - abs(through) * per_density)
            flux[k + 1] = _carried(through, w[k], w[k + 1], 0.0, w[k + 2], share)


@jit
def _across_ribs(flux: Any, w: Any, mass: Any, liquid: Any, per_density: float, plates: Any, ny: int, s: int) -> None:
    """`_across` of v again through the nodes next to ribs: beyond a rib v is the same (slip)."""
    for m in range(plates.shape[0]):
        for j in range(max(plates[m, 1] - 1, 0), min(plates[m, 2], ny - 1)):
            k = (j + 2) * s + plates[m, 0]
            through = 0.5 * (mass[k] + mass[k + s])
            share = liquid[k] * liquid[k + s] * liquid[k + 1] * liquid[k + s + 1] * (1.0 - abs(through) * per_density)
            flux[k] = _carried(through, w[k], w[k + 1], w[k - 1], w[k + 1], share)
            k += 2
            through = 0.5 * (mass[k] + mass[k + s])
            share = liquid[k] * liquid[k + s] * liquid[k + 1] * liquid[k + s + 1] * (1.0 - abs(through) * per_density)
            flux[k] = _carried(through, w[k], w[k + 1], w[k], w[k + 2], share)


@jit
def _carry(acc: Any, w: Any, old: Any, new: Any, along: Any, across: Any, dt: float, first: int, n: int, a: int, b: int) -> None:
    """acc = gain of momentum by advection per time, less that of the mass at the old velocity."""
    out, wc = acc[first : first + n], w[first : first + n]
    old0, old1 = old[first : first + n], old[first + a : first + a + n]
    new0, new1 = new[first : first + n], new[first + a : first + a + n]
    al0, al1 = along[first : first + n], along[first + a : first + a + n]
    ac0, ac1 = across[first - b : first - b + n], across[first : first + n]
    per_dt = 1.0 / dt
    for k in range(n):
        change = 0.5 * (old0[k] + old1[k] - new0[k] - new1[k])
        out[k] = (change * wc[k] - (al1[k] - al0[k]) - (ac1[k] - ac0[k])) * per_dt


@jit
def _rub(acc: Any, w: Any, mu: Any, tau: Any, ha: float, hb: float, first: int, n: int, a: int, b: int) -> None:
    """acc += viscous force per volume."""
    out = acc[first : first + n]
    wb, wc, wf = w[first - a : first - a + n], w[first : first + n], w[first + a : first + a + n]
    mu0, mu1 = mu[first : first + n], mu[first + a : first + a + n]
    t0, t1 = tau[first - b : first - b + n], tau[first : first + n]
    per_a, per_b = 2.0 / (ha * ha), 1.0 / hb
    for k in range(n):
        out[k] += per_a * (mu1[k] * (wf[k] - wc[k]) - mu0[k] * (wc[k] - wb[k])) + per_b * (t1[k] - t0[k])


@jit
def _push(acc: Any, other: Any, open_face: Any, new: Any, x: Any, y: Any, force: Any, first: int, n: int, a: int, b: int) -> None:
    """acc = acc / density + body force on open faces, 0 on others.

    force (4,): constant, per x, per y, and per velocity of the other component (Coriolis).
    """
    out, gate = acc[first : first + n], open_face[first : first + n]
    o0, o1 = other[first - b : first - b + n], other[first : first + n]
    o2, o3 = other[first + a - b : first + a - b + n], other[first + a : first + a + n]
    new0, new1 = new[first : first + n], new[first + a : first + a + n]
    xx, yy = x[first : first + n], y[first : first + n]
    f0, fx, fy, turn = force[0], force[1], force[2], 0.25 * force[3]
    for k in range(n):
        body = f0 + fx * xx[k] + fy * yy[k] + turn * (o0[k] + o1[k] + o2[k] + o3[k])
        out[k] = gate[k] * (2.0 * out[k] / (new0[k] + new1[k]) + body)


@jit
def component(acc: Any, w: Any, other: Any, open_face: Any, old: Any, new: Any, mass_a: Any, mass_b: Any, liquid: Any, mu: Any,
              tau: Any, x: Any, y: Any, force: Any, dt: float, ha: float, hb: float, per_density: float, along: Any, across: Any,
              first: int, n: int, a: int, b: int, ribs: Any = None) -> None:  # fmt: skip
    """Acceleration of one component without pressure.

    w, other: velocities; old, new: densities of cells before and after the step dt; mass_a, mass_b: mass through far faces in
    the step per cell volume; liquid: 1 in liquid cells; mu, tau: dynamic viscosity of cells, shear stress at nodes; ha, hb: cell
    sizes along and across; per_density: 1/ρ_l; along, across: scratch; ribs: `partition.Partition`, or None.
    """
    _along(along, w, mass_a, liquid, per_density, first, n + a, a)
    _across(across, w, mass_b, liquid, per_density, first - b, n + b, a, b)
    if ribs is not None:
        if a == 1:
            _along_ribs(along, w, mass_a, liquid, per_density, ribs.plates, b)
        else:
            _across_ribs(across, w, mass_b, liquid, per_density, ribs.plates, n // a, a)
    _carry(acc, w, old, new, along, across, dt, first, n, a, b)
    _rub(acc, w, mu, tau, ha, hb, first, n, a, b)
    _push(acc, other, open_face, new, x, y, force, first, n, a, b)


@jit
def shear(tau: Any, u: Any, v: Any, mu: Any, dx: float, dy: float, nx: int, ny: int, slip: bool) -> None:
    """Shear stress at the north-east node of each cell, walls included; velocities need their ghosts (`wall_ghosts`).

    Viscosities of the four cells in series (harmonic mean): gas beside thick liquid must not feel the liquid's viscosity.
    """
    s = nx + 2
    first, n = s, (ny + 1) * s
    per_dx, per_dy = 1.0 / dx, 1.0 / dy
    t = tau[first : first + n]
    u0, u1 = u[first : first + n], u[first + s : first + s + n]
    v0, v1 = v[first : first + n], v[first + 1 : first + 1 + n]
    m0, m1 = mu[first : first + n], mu[first + 1 : first + 1 + n]
    m2, m3 = mu[first + s : first + s + n], mu[first + s + 1 : first + s + 1 + n]
    for k in range(n):
        series = 1.0 / m0[k] + 1.0 / m1[k] + 1.0 / m2[k] + 1.0 / m3[k]
        t[k] = 4.0 / series * ((u1[k] - u0[k]) * per_dy + (v1[k] - v0[k]) * per_dx)
    if slip:
        for i in range(s):
            tau[s + i] = 0.0
            tau[(ny + 1) * s + i] = 0.0
    for j in range(1, ny + 2):
        if slip:
            tau[j * s] = 0.0
            tau[j * s + nx] = 0.0
        tau[j * s + nx + 1] = 0.0


@jit
def wall_ghosts(u: Any, v: Any, nx: int, ny: int, slip: bool) -> None:
    """Set the tangential velocities beyond the walls: equal for slip, opposite for no slip."""
    s = nx + 2
    sign = 1.0 if slip else -1.0
    top = (ny + 1) * s
    for i in range(s):
        u[s + i] = sign * u[2 * s + i]
        u[top + s + i] = sign * u[top + i]
    for j in range(2, ny + 2):
        v[j * s] = sign * v[j * s + 1]
        v[j * s + nx + 1] = sign * v[j * s + nx]


@jit
def mirror(field: Any, nx: int, ny: int) -> None:
    """Continue a cell field beyond the walls with the value inside."""
    s = nx + 2
    for j in range(2, ny + 2):
        field[j * s] = field[j * s + 1]
        field[j * s + nx + 1] = field[j * s + nx]
    floor, top = 2 * s, (ny + 1) * s
    for i in range(s):
        field[floor - s + i] = field[floor + i]
        field[top + s + i] = field[top + i]
