"""Flux, wall, linearisation and line solver against identities that can be checked by hand."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.aero.bdf import bdf_weights, combine, turn
from aeroslosh.fmus.aero.factorise import LANES, factorise_across, factorise_around, pack
from aeroslosh.fmus.aero.flux import ALBADA, CALM, GAMMA, SENSOR, half_slopes, limits, residual, roe, shock, tiled_faces
from aeroslosh.fmus.aero.implicit import Blocks, Factors, Recipe
from aeroslosh.fmus.aero.jacobian import assemble, face_blocks
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import Mesh, o_mesh
from aeroslosh.fmus.aero.wall import wall_state


@pytest.fixture(scope="module")
def mesh() -> Mesh:
    return o_mesh("64A010", 100, 30, 20.0)


def conserved(w: np.ndarray) -> np.ndarray:
    r, u, v, p = w
    return np.array([r, r * u, r * v, p / (GAMMA - 1) + 0.5 * r * (u * u + v * v)])


def primitive(q: np.ndarray) -> np.ndarray:
    r, a, b, e = q
    return np.array([r, a / r, b / r, (GAMMA - 1) * (e - 0.5 * (a * a + b * b) / r)])


def exact_flux(w: np.ndarray, n: np.ndarray, vn: float) -> np.ndarray:
    un = w[1] * n[0] + w[2] * n[1]
    return conserved(w) * (un - vn) + w[3] * np.array([0.0, n[0], n[1], un])


def test_roe_flux_is_consistent_and_conservative() -> None:
    n, vn = np.array([0.6, 0.8]), 0.13
    a, b = np.array([1.1, 0.4, -0.2, 0.9]), np.array([0.8, 0.7, 0.1, 0.5])
    np.testing.assert_allclose(roe(*n, vn, 0.0, 0.0, *a, *a), exact_flux(a, n, vn), rtol=1e-14)
    np.testing.assert_allclose(roe(*n, vn, 0.0, 0.0, *a, *b), -np.array(roe(*-n, -vn, 0.0, 0.0, *b, *a)), rtol=1e-13)


def test_roe_flux_is_upwind_in_supersonic_flow() -> None:
    n = np.array([1.0, 0.0])
    a = np.array([1.0, 3.0, 0.2, 1 / GAMMA])
    b = a * 1.02
    # exact to the difference between Roe's and arithmetic averages, of third order in the jump
    np.testing.assert_allclose(roe(*n, 0.0, 0.0, 0.0, *a, *b), exact_flux(a, n, 0.0), rtol=2e-5)


def test_a_contact_and_a_vortex_sheet_that_lie_along_a_face_are_kept() -> None:
    """Jumps of density and of the velocity along the face, none of pressure: nothing but pressure passes."""
    flux = roe(1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.3, 1.0, 0.5, 0.0, -0.2, 1.0)
    np.testing.assert_allclose(flux, [0.0, 1.0, 0.0, 0.0], atol=1e-15)


def test_an_acoustic_wave_at_rest_keeps_the_entropy_floor() -> None:
    """A small jump of the wave u − c alone, at a sonic point: without the floor nothing would damp it."""
    c, jump = np.sqrt(GAMMA), 1e-4  # of density, about rho = p = 1
    push, speed = c * c * jump, -c * jump  # of that wave's pressure and velocity
    left = np.array([1.0 - 0.5 * jump, c - 0.5 * speed, 0.0, 1.0 - 0.5 * push])
    right = np.array([1.0 + 0.5 * jump, c + 0.5 * speed, 0.0, 1.0 + 0.5 * push])
    n = np.array([1.0, 0.0])
    damped = 0.5 * (exact_flux(left, n, 0.0) + exact_flux(right, n, 0.0))[0] - roe(1.0, 0.0, 0.0, 0.0, 0.0, *left, *right)[0]
    assert damped == pytest.approx(0.5 * 0.5 * 0.05 * c * jump, rel=1e-6)


def test_reconstruction_is_third_order_where_smooth_and_limited_at_a_jump() -> None:
    # a parabola's face value from cell averages is met exactly with kappa = 1/3
    def average(x: float) -> float:
        return x * x + 1 / 12

    behind, ahead = half_slopes(average(0) - average(-1), average(1) - average(0), 1.0)
    assert average(0) + ahead == pytest.approx(0.25, abs=1e-14)
    assert average(0) - behind == pytest.approx(0.25, abs=1e-14)
    assert shock(1.0, 1.0, 1.0)[0] == 0.0
    share, whole = shock(1.0, 1.0, 2.0)
    assert share / whole > 0.99
    full = limits(1.0, 1.0, 1.0, -1.0, 1.0, 1.0, 2.0, 1.0, 0.0, 0.5)  # van Albada's own at a strong shock
    assert full == pytest.approx((0.0, 1.0, 0.8, ALBADA / (0.25 + ALBADA)), abs=1e-6)
    assert half_slopes(1.0, -1.0, full[0]) == pytest.approx((0.0, 0.0), abs=1e-9)
    assert limits(0.0, 1.0, 1.0, -1.0, 1.0, 1.0, 2.0, 1.0, 0.0, 0.5) == (1.0, 1.0, 1.0, 1.0)
    half = limits(1.0, 2.0, 1.0, -1.0, 1.0, 1.0, 2.0, 1.0, 0.0, 0.5)
    assert half == pytest.approx(0.5 + 0.5 * np.array(full))


@pytest.mark.parametrize("ni", [64, 100, 168])
def test_moving_mesh_keeps_a_uniform_stream(ni: int) -> None:
    """Plunge, pitch and BDF history together: away from the wall the unsteady residual is round-off."""
    flow = Flow(o_mesh("64A010", ni, 24, 20.0), 0.8, -0.5)
    stream = conserved(np.array([1.0, 0.8, 0.0, 1 / GAMMA]))
    level = np.broadcast_to(stream[None, :, None], flow.q.shape).copy()
    incidence, weights = 0.3, bdf_weights(np.array([0.0, -0.31, -0.57, -0.9]))
    past = np.zeros_like(level)
    combine(level, level, level, weights[1:], np.cos(incidence), np.sin(incidence), past)
    turn(level, flow.q, np.cos(incidence), np.sin(incidence))
    flow.farfield.set(incidence, 0.0)
    flow._motion[:] = 0.11, -0.23, 0.17
    flow.evaluate()
    unsteady = flow.out + flow.mesh.volume[:, None] * (weights[0] * flow.q + past)
    assert np.abs(unsteady[2:]).max() < 1e-12
    assert np.abs(unsteady[0]).max() > 1e-4  # the body is felt


def test_residual_is_galilean_invariant(mesh: Mesh) -> None:
    """Stream and mesh moving together change no mass flux; momentum gains V times mass."""
    nj, ni = mesh.shape
    rng = np.random.default_rng(1)
    w = np.array([1.0, 0.5, 0.1, 0.7])[None, :, None] * (1 + 0.05 * rng.standard_normal((nj, 4, ni)))
    drift = np.array([0.21, -0.13])

    def outflow(speed: np.ndarray) -> np.ndarray:
        shifted = w.copy()
        shifted[:, 1] += speed[0]
        shifted[:, 2] += speed[1]
        q = np.stack([conserved(shifted[j]) for j in range(nj)])
        ghost, pressure, out = np.zeros((4, ni)), np.zeros(ni), np.zeros_like(q)
        wall = np.zeros((5, ni))
        wall[0], wall[1] = mesh.curvature, mesh.gap
        motion = np.array([*speed, 0.0])
        wall_state(q, mesh.ring, wall, motion, ghost, pressure)
        far = np.ascontiguousarray(shifted[-1])
        residual(
            q.reshape(-1), out.reshape(-1), *tiled_faces(mesh.side, mesh.ring, np.float64), ghost.reshape(-1),
            pressure, far.reshape(-1), motion, ni, nj,
        )  # fmt: skip
        return out

    still, moving = outflow(np.zeros(2)), outflow(drift)
    np.testing.assert_allclose(moving[:, 0], still[:, 0], atol=1e-13)
    np.testing.assert_allclose(moving[:, 1], still[:, 1] + drift[0] * still[:, 0], atol=1e-13)
    np.testing.assert_allclose(moving[:, 2], still[:, 2] + drift[1] * still[:, 0], atol=1e-13)


def test_residual_conserves(mesh: Mesh) -> None:
    """Summed over the mesh only the two boundaries remain: mass leaves through the outer one alone."""
    flow = Flow(mesh, 0.7, 0.25)
    flow.start(0.05)
    rng = np.random.default_rng(2)
    flow.q[:] *= 1 + 0.02 * rng.standard_normal(flow.q.shape)
    flow.evaluate()
    inside = flow.out[:, 0].sum()
    flow.q[: mesh.shape[0] - 3] *= 1 + 0.05 * rng.standard_normal(flow.q[: mesh.shape[0] - 3].shape)
    flow.evaluate()
    assert flow.out[:, 0].sum() == pytest.approx(inside, abs=1e-12)


@pytest.mark.parametrize("ni", [64, 100, 168])
@pytest.mark.parametrize("rough", [1e-5, 0.02, 0.08], ids=["calm", "limited", "shocks"])
def test_single_precision_loses_rounding_alone(ni: int, rough: float) -> None:
    """Fluxes of one precision and the other from the same flow differ by a few roundings of what passes a face."""
    mesh = o_mesh("64A010", ni, 24, 20.0)
    flow = Flow(mesh, 0.8, -0.5)
    flow.start(0.05)
    flow._motion[:] = 0.11, -0.23, 0.17
    flow.q[:] *= 1 + rough * np.random.default_rng(3).standard_normal(flow.q.shape).clip(-2, 2)
    flow.evaluate()
    double = flow.out.copy()
    flow.evaluate(np.float32)
    reach = mesh.side[:, 2] + np.roll(mesh.side[:, 2], -1, axis=1) + mesh.ring[:-1, 2] + mesh.ring[1:, 2]
    lost = np.abs(flow.out - double) / reach[:, None]
    # the flux of energy is 2.5 and more, a rounding 6e-8 of it, in ten terms; a limiter is steep in the jumps it looks at
    assert lost.max() < (2e-6 if rough < 0.01 else 6e-6)
    assert lost.max() > 1e-9


def test_calm_flow_is_not_limited_at_all() -> None:
    """Below a tenth of the sensor's threshold the limiter's share is zero, above it grows from there without a jump."""
    step = CALM * SENSOR * 2.0  # second difference of pressures about 1 that is just calm: v = CALM w, w = 4 SENSOR
    assert shock(1.0, 1.0, 1.0 + 1.99 * step)[0] == 0.0
    share, whole = shock(1.0, 1.0, 1.0 + 2.05 * step)
    assert 0.0 < share / whole < 2e-5


def rotating_gas_error(cells: tuple[int, int], accelerated: bool) -> float:
    """rms error of the wall pressure in gas that turns with the section, isentropic: enthalpy = constant + rate² r²/2."""
    mesh = o_mesh("0012", *cells, 20.0)
    (nj, ni), rate = mesh.shape, 0.4

    def sound2(r2: np.ndarray) -> np.ndarray:
        return 1 + (GAMMA - 1) * 0.5 * rate**2 * r2

    x, y = mesh.centre[..., 0], mesh.centre[..., 1]
    c2 = sound2(x * x + y * y)
    density = c2 ** (1 / (GAMMA - 1))
    w = np.stack([density, rate * y, -rate * x, density * c2 / GAMMA], axis=1)
    q = np.stack([conserved(w[j]) for j in range(nj)])
    middle = 0.5 * (mesh.node[0, 1:] + mesh.node[0, :-1])
    wall = np.zeros((5, ni))
    wall[0], wall[1], wall[3], wall[4] = mesh.curvature, mesh.gap, middle[:, 0], middle[:, 1]
    if accelerated:
        wall[2] = -(rate**2) * np.sum(middle.T * mesh.ring[0, :2], axis=0)
    ghost, pressure = np.zeros((4, ni)), np.zeros(ni)
    wall_state(q, mesh.ring, wall, np.array([0.0, 0.0, rate]), ghost, pressure)
    exact = sound2(np.sum(middle**2, axis=1)) ** (GAMMA / (GAMMA - 1)) / GAMMA
    return float(np.sqrt(np.mean((pressure - exact) ** 2)))


def test_wall_pressure_on_a_rotating_section_is_second_order() -> None:
    """dp/dn = −rho a_n, a_n = −rate² r·n; without that term the error falls with the first order only."""
    coarse, fine = (rotating_gas_error(cells, True) for cells in ((100, 30), (200, 60)))
    assert np.log2(coarse / fine) > 1.9
    coarse, fine = (rotating_gas_error(cells, False) for cells in ((100, 30), (200, 60)))
    assert np.log2(coarse / fine) < 1.2


def test_face_blocks_are_the_derivative_of_the_flux() -> None:
    n, length = np.array([0.6, 0.8]), 1.3
    # faster than sound: below, Roe's dissipation of the normal velocity is less than the linearisation's
    a, b = np.array([1.0, 0.9, -0.6, 0.7]), np.array([1.001, 0.9009, -0.6, 0.7004])
    plus, minus = np.zeros((4, 4)), np.zeros((4, 4))
    face_blocks(*n, length, a, b, plus.ravel(), minus.ravel(), np.zeros(16))

    def flux(qa: np.ndarray, qb: np.ndarray) -> np.ndarray:
        return length * np.array(roe(*n, 0.0, 0.0, 0.0, *primitive(qa), *primitive(qb)))

    qa, qb = conserved(a), conserved(b)
    for k in range(4):
        e = np.zeros(4)
        e[k] = 1e-6
        # |A| is frozen: the difference is of the order of the jump
        np.testing.assert_allclose(plus[:, k], (flux(qa + e, qb) - flux(qa - e, qb)) / 2e-6, atol=2e-3)
        np.testing.assert_allclose(minus[:, k], (flux(qa, qb + e) - flux(qa, qb - e)) / 2e-6, atol=2e-3)


def lines_solved(around: np.ndarray, spikes: np.ndarray, across: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The line solver in numpy, lines side by side: −r (nj, 4, ni) by float32 factors, (groups, cells, matrices, 16, LANES)."""
    nj, _, ni = r.shape
    b = np.moveaxis(-r, 1, 2).copy()
    m = around.reshape(around.shape[0], ni, 3, 4, 4, LANES)
    f = np.moveaxis(m, 5, 1).reshape(-1, ni, 3, 4, 4)[:nj]  # (line, cell, matrix, 4, 4)
    m = spikes.reshape(spikes.shape[0], ni, 4, 4, LANES)
    response = np.moveaxis(m, 4, 1).reshape(-1, ni, 4, 4)[:nj]
    for i in range(ni - 1):
        b[:, i] = np.einsum("lab,lb->la", f[:, i, 0], b[:, i]) - np.einsum("lab,lb->la", f[:, i, 1], b[:, i - 1]) * (i > 0)
    for i in range(ni - 3, -1, -1):
        b[:, i] -= np.einsum("lab,lb->la", f[:, i, 2], b[:, i + 1])
    end = ni - 1
    b[:, end] = np.einsum("lab,lb->la", f[:, end, 0], b[:, end]) - np.einsum("lab,lb->la", f[:, end, 1], b[:, end - 1])
    b[:, end] -= np.einsum("lab,lb->la", f[:, end, 2], b[:, 0])
    b[:, :end] -= np.einsum("liab,lb->lia", response[:, :end], b[:, end])
    m = across.reshape(across.shape[0], nj, 3, 4, 4, LANES)
    f = np.moveaxis(m, 5, 1).reshape(-1, nj, 3, 4, 4)[:ni]
    for j in range(nj):
        b[j] = np.einsum("lab,lb->la", f[:, j, 0], b[j]) - np.einsum("lab,lb->la", f[:, j, 1], b[j - 1]) * (j > 0)
    for j in range(nj - 2, -1, -1):
        b[j] -= np.einsum("lab,lb->la", f[:, j, 2], b[j + 1])
    return b


def test_line_solver_inverts_the_product_of_its_factors(mesh: Mesh) -> None:
    nj, ni = mesh.shape
    flow = Flow(mesh, 0.7, 0.25)
    flow.start(0.05)
    recipe = Recipe(flow.q.copy(), flow.farfield.state.copy(), 0.7, 12.0)
    r = np.random.default_rng(0).standard_normal(flow.q.shape)
    diagonal, near, radius = np.empty((nj, ni, 4, 4)), np.empty((4, nj, ni, 4, 4)), np.empty((nj, ni))
    flat = [block.ravel() for block in (diagonal, *near)]
    assemble(flow.q, mesh.side, mesh.ring, flow.farfield.state, *flat, radius.ravel())
    shift = mesh.volume * 0.7 + radius / 12.0

    def times(blocks: np.ndarray, v: np.ndarray) -> np.ndarray:
        return np.einsum("jiab,jib->jia", blocks, v)

    def missed(v: np.ndarray) -> float:
        edge, whole = np.zeros_like(v[:1]), diagonal + shift[..., None, None] * np.eye(4)
        across = times(near[2], np.concatenate([edge, v[:-1]])) + times(near[3], np.concatenate([v[1:], edge]))
        y = v + times(np.linalg.inv(whole), across)
        product = times(whole, y) + times(near[0], np.roll(y, 1, axis=1)) + times(near[1], np.roll(y, -1, axis=1))
        return float(np.abs(product + np.moveaxis(r, 1, 2)).max() / np.abs(r).max())

    # the factors themselves, in float32
    around = np.zeros((-(-nj // LANES), ni, 3, 16, LANES), dtype=np.float32)
    spikes = np.zeros((-(-nj // LANES), ni, 16, LANES), dtype=np.float32)
    across = np.zeros((-(-ni // LANES), nj, 3, 16, LANES), dtype=np.float32)
    factorise_around(flat[0], flat[1], flat[2], shift.ravel(), ni, nj, around.ravel(), spikes.ravel())
    factorise_across(flat[0], flat[3], flat[4], shift.ravel(), ni, nj, across.ravel())
    assert missed(lines_solved(around, spikes, across, r)) < 5e-6
    # the solver's are packed: it solves exactly with what was kept
    x = np.zeros_like(r)
    Factors(recipe, mesh, Blocks(mesh)).solve(r, x)
    kept = lines_solved(*(unpacked(f) for f in (around, spikes, across)), r)
    np.testing.assert_allclose(np.moveaxis(x, 1, 2), kept, rtol=0.0, atol=2e-6 * np.abs(kept).max())
    assert missed(np.moveaxis(x, 1, 2)) < 2e-2  # 2^-8 of each entry, where the approximation itself leaves 0.7


def unpacked(factors: np.ndarray) -> np.ndarray:
    """What is left of float32 `factors` (…, 16, LANES) after packing."""
    words = pack(factors.view(np.uint32).ravel()).reshape(*factors.shape[:-2], 8, LANES)
    both = np.stack([words << np.uint32(16), words], axis=-2)  # (…, 8, 2, LANES)
    return both.reshape(factors.shape).view(np.float32)


def test_packed_entries_come_nearest() -> None:
    rng = np.random.default_rng(3)
    factors = (rng.standard_normal((500, 16, LANES)) * 10.0 ** rng.uniform(-6, 3, (500, 16, LANES))).astype(np.float32)
    factors[0] = 0.0
    error = np.abs(unpacked(factors) - factors)
    assert np.max(error / np.maximum(np.abs(factors), 1e-30)) <= 2.0**-8
    beside = np.stack([factors[1:, ::2], factors[1:, 1::2]])  # entries with few digits stay as they are, but for the bits behind
    exact = np.round(np.ldexp(np.frexp(beside)[0], 8)) * np.ldexp(1.0, np.frexp(beside)[1] - 8)
    assert np.array_equal(unpacked(factors)[1:, ::2], exact[0].astype(np.float32))
    assert not unpacked(factors)[0].any()


def test_time_weights_are_exact_for_parabolas_at_uneven_steps() -> None:
    times = np.array([2.0, 1.7, 1.1, 0.9])
    weights = bdf_weights(times)
    assert weights.sum() == pytest.approx(0.0, abs=1e-13)
    assert weights @ times == pytest.approx(1.0, rel=1e-13)
    assert weights @ times**2 == pytest.approx(4.0, rel=1e-12)
