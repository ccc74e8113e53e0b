"""Steady flow and time marching of the Euler equations around a rigidly moving section.

All in chords, freestream density and freestream sound speed; a time unit is the time sound takes for one chord. Flows are kept in
inertial axes and turned into the body axes of the new time: in these the mesh is at rest, so metrics and linearisation stay
constant and a uniform stream stays uniform to round-off.

Time: BDF2opt, 0.48 BDF3 + 0.52 BDF2 (Vatsa, Carpenter and Lockard, AIAA 2010-0122), each step solved by subiterations with
the approximate inverse of implicit.py from a quadratic prediction.
"""
from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .compiled import jit
from .farfield import Farfield
from .flux import GAMMA, residual
from .implicit import Factors, Recipe
from .loads import Coefficients, WallLoads
from .mesh import Mesh, coarsened
from .wall import wall_state

Array = NDArray[np.float64]

BDF3_SHARE = 0.48
CLIP = 0.15
"""Largest relative change of density or energy a subiteration makes in a cell."""
BLOW_UP = 0.5


class MarchError(RuntimeError):
    """The flow could not be advanced; the message says where, what was tried and the remedy."""


class Motion(NamedTuple):
    """Section motion: plunge (down) and pitch (nose-up) about the elastic axis with rates and accelerations, scaled."""

    h: float = 0.0
    h_dot: float = 0.0
    h_ddot: float = 0.0
    alpha: float = 0.0
    alpha_dot: float = 0.0
    alpha_ddot: float = 0.0


class StepReport(NamedTuple):
    """What a time step took: subiterations, last rms density change over that of the step, whether below tolerance, retries."""

    subiterations: int
    residual: float
    converged: bool
    retries: int


@dataclass(frozen=True)
class Settings:
    """How hard each flow is solved.

    tolerance: rms density change of the last subiteration over that of the whole step; cfl: pseudo-time step of a
    subiteration; steady_tolerance: rms density change an iteration; steady_cfl, steady_step: local and global pseudo-time step.
    """

    tolerance: float = 5e-3
    max_subiterations: int = 25
    cfl: float = 25.0
    steady_tolerance: float = 3e-7
    steady_iterations: int = 3000
    steady_cfl: float = 20.0
    steady_step: float = 0.4


@jit
def _turn(source: Any, target: Any, c: float, s: float, weight: float, add: bool) -> None:
    """target (+)= weight · source with momentum turned from inertial to body axes; shapes (nj, 4, ni)."""
    nj, _, ni = source.shape
    for j in range(nj):
        r, u, v, e = source[j, 0], source[j, 1], source[j, 2], source[j, 3]
        a, b, d, f = target[j, 0], target[j, 1], target[j, 2], target[j, 3]
        if not add:
            target[j] = 0.0
        for i in range(ni):
            x, y = u[i], v[i]
            a[i] += weight * r[i]
            b[i] += weight * (c * x - s * y)
            d[i] += weight * (s * x + c * y)
            f[i] += weight * e[i]


@jit
def _add_time(out: Any, q: Any, past: Any, volume: Any, weight: float) -> None:
    """out += volume · (weight q + past), the time derivative of the conserved variables."""
    nj, _, ni = q.shape
    for j in range(nj):
        for m in range(4):
            o, new, old, v = out[j, m], q[j, m], past[j, m], volume[j]
            for i in range(ni):
                o[i] += v[i] * (weight * new[i] + old[i])


@jit
def _update(q: Any, x: Any) -> float:
    """q += clipped x; returns the rms density change, NaN where anything is not finite or not positive."""
    nj, _, ni = q.shape
    total = 0.0
    worst = 0.0
    for j in range(nj):
        r, u, v, e = q[j, 0], q[j, 1], q[j, 2], q[j, 3]
        a, b, d, f = x[j, 0], x[j, 1], x[j, 2], x[j, 3]
        for i in range(ni):
            change = max(abs(a[i]) / r[i], abs(f[i]) / e[i])
            factor = CLIP / max(CLIP, change)
            worst = max(worst, change)
            total += a[i] * a[i]
            r[i] += factor * a[i]
            u[i] += factor * b[i]
            v[i] += factor * d[i]
            e[i] += factor * f[i]
    if not worst < 1e3:
        return np.nan
    return float(np.sqrt(total / (ni * nj)))


@jit
def _distance(a: Any, b: Any) -> float:
    """rms difference of the densities of two flows (nj, 4, ni)."""
    nj, _, ni = a.shape
    total = 0.0
    for j in range(nj):
        p, q = a[j, 0], b[j, 0]
        for i in range(ni):
            total += (p[i] - q[i]) * (p[i] - q[i])
    return float(np.sqrt(total / (ni * nj)))


def bdf_weights(times: Array) -> Array:
    """Weights of BDF2opt for the derivative at times[0] from values at the four descending times, shape (4,).

    Any step lengths: derivative of the interpolating polynomials through four and three points.
    """

    def derivative(t: Array) -> Array:
        n = len(t)
        result = np.zeros(n)
        for k in range(1, n):
            others = [m for m in range(n) if m not in (0, k)]
            result[k] = np.prod([(t[0] - t[m]) / (t[k] - t[m]) for m in others]) / (t[k] - t[0])
        result[0] = -np.sum(result[1:])
        return result

    return BDF3_SHARE * derivative(times) + (1 - BDF3_SHARE) * np.append(derivative(times[:3]), 0.0)


def extrapolation_weights(times: Array) -> Array:
    """Weights that predict the value at times[0] from the three earlier ones (quadratic), shape (3,)."""
    old = times[1:]
    return np.array(
        [np.prod([(times[0] - old[m]) / (old[k] - old[m]) for m in range(3) if m != k]) for k in range(3)]
    )


class Flow:
    """Euler flow around one section at one Mach number, elastic axis at `axis` chords behind the nose."""

    def __init__(self, mesh: Mesh, mach: float, axis: float, settings: Settings | None = None) -> None:
        self.mesh, self.mach, self.axis = mesh, mach, axis
        self.settings = settings or Settings()
        nj, ni = mesh.shape
        self.q = np.zeros((nj, 4, ni))
        self.pressure = np.full(ni, 1.0 / GAMMA)
        self.incidence = 0.0
        self.loads = WallLoads(mesh, mach, axis)
        self.farfield = Farfield(mesh, mach)
        self.refactorings = 0
        self._factors: Factors | None = None
        self._former: Factors | None = None
        self._refresh = True
        self._age = 0
        self._out, self._x, self._past = np.zeros_like(self.q), np.zeros_like(self.q), np.zeros_like(self.q)
        self._motion = np.zeros(3)
        self._wall = np.zeros((5, ni))
        middle = 0.5 * (mesh.node[0, 1:] + mesh.node[0, :-1])
        self._wall[0], self._wall[1], self._wall[3:] = mesh.curvature, mesh.gap, middle.T
        self._levels: tuple[Array, Array, Array] = (self.q, self.q, self.q)
        self._times: tuple[float, ...] = (0.0, 0.0, 0.0)
        self._ghost = np.zeros((4, ni))
        self._lift = 0.0

    @property
    def coefficients(self) -> Coefficients:
        """Coefficients at the present time."""
        return self.loads(self.pressure, self.incidence)

    # ---- steady flow -------------------------------------------------------------------------------------------------

    def solve_steady(self, incidence: float) -> StepReport:
        """Steady flow at incidence [rad], all of the past set to it. Starts on a mesh of half the cells each way.

        Raises MarchError when it diverges or stays above tolerance.
        """
        self._begin(incidence, self._coarse_start(incidence))
        # density changes scale with the dynamic pressure
        report = self._iterate_steady(incidence, self.settings.steady_tolerance * self.mach**2, ramp=0)
        if not report.converged:
            raise MarchError(
                f"steady flow at Mach {self.mach:g}, incidence {np.degrees(incidence):.3f} degrees: rms density change "
                f"{report.residual:.1e} after {report.subiterations} iterations, tolerance {self.settings.steady_tolerance:.1e}. "
                "Remedy: a larger tolerance, other cell counts; some flows have no steady state"
            )
        flow = np.empty_like(self.q)
        _turn(self.q, flow, float(np.cos(incidence)), -float(np.sin(incidence)), 1.0, False)
        self._levels = (flow, flow, flow)
        self._times = (0.0, 0.0, 0.0)
        self._lift = self.coefficients.lift
        self._refresh = True
        return report

    def _begin(self, incidence: float, start: Array | None) -> None:
        self.incidence = incidence
        self._motion[:] = 0.0
        self._wall[2] = 0.0
        if start is None:
            m = self.mach
            self.q[:, 0], self.q[:, 1], self.q[:, 2] = 1.0, m * np.cos(incidence), m * np.sin(incidence)
            self.q[:, 3] = 1.0 / (GAMMA * (GAMMA - 1.0)) + 0.5 * m * m
            self.farfield.set(incidence, 0.0)
        else:
            self.q[:] = start
            self._wall_pressure()
            self.farfield.set(incidence, self.coefficients.lift)

    def _coarse_start(self, incidence: float) -> Array | None:
        coarse = coarsened(self.mesh)
        if coarse is None:
            return None
        flow = Flow(coarse, self.mach, self.axis, self.settings)
        flow._begin(incidence, None)
        report = flow._iterate_steady(incidence, 2e-5 * self.mach**2, ramp=30)
        return _refined(flow.q) if np.isfinite(report.residual) else None

    def _iterate_steady(self, incidence: float, tolerance: float, ramp: int) -> StepReport:
        s = self.settings
        change = np.inf
        cautious = 1.0
        start = self.q.copy()
        retries = 0
        iteration = 0
        while iteration < s.steady_iterations:
            share = min(1.0, 0.1 + iteration / ramp) if ramp else 1.0
            if iteration % 50 == 0 or (iteration < ramp and iteration % 8 == 0):
                scale = cautious * share
                factors = self._linearised(1 / (s.steady_step * scale), s.steady_cfl * scale)
            self._evaluate()
            factors.solve(self._out, self._x)
            change = _update(self.q, self._x)
            if not np.isfinite(change):
                retries += 1
                if retries > 2:
                    break
                # smaller pseudo-steps from where it began
                cautious, iteration, self.q[:] = 0.4 * cautious, 0, start
                self.farfield.set(incidence, 0.0)
                ramp = max(ramp, 30)
                continue
            iteration += 1
            self.farfield.set(incidence, self.coefficients.lift)
            if change < tolerance:
                break
        self._wall_pressure()
        return StepReport(iteration, float(change), bool(change < tolerance), retries)

    # ---- time marching -----------------------------------------------------------------------------------------------

    def step(self, motion: Motion, incidence: float, dt: float) -> StepReport:
        """Advance by dt to the given motion at its end, with the stream at incidence [rad] to the section's axis.

        When the subiterations blow up the step is repeated from a constant prediction with fresh factors and smaller
        pseudo-steps. Raises MarchError when that fails too.
        """
        s = self.settings
        if self._times[1] == self._times[0]:
            # before the first step the flow stood still: place its past one step apart
            self._times = (self._times[0], self._times[0] - dt, self._times[0] - 2 * dt)
        times = np.array([self._times[0] + dt, *self._times])
        weights = bdf_weights(times)
        guess = extrapolation_weights(times)
        c, sine = float(np.cos(incidence)), float(np.sin(incidence))
        for k, level in enumerate(self._levels):
            _turn(level, self._past, c, sine, float(weights[k + 1]), k > 0)
        self._move(motion, incidence)
        factors = self._factors
        stale = self._refresh or factors is None or abs(weights[0] / factors.recipe.weight - 1) > 0.05
        for retry, cfl in enumerate((s.cfl, 0.25 * s.cfl, 0.1 * s.cfl)):
            prediction = guess if retry == 0 else np.array([1.0, 0.0, 0.0])
            for k, level in enumerate(self._levels):
                if k == 0 or prediction[k]:
                    _turn(level, self.q, c, sine, float(prediction[k]), k > 0)
            if factors is None or stale or retry:
                factors = self._linearised(weights[0], cfl)
                self._set_factors(factors)
                self._refresh, self._age = False, 0
                self.refactorings += 1
            limit = s.max_subiterations * (1 if retry == 0 else 3)
            count, change, moved = self._subiterate(factors, weights[0], limit)
            if np.isfinite(change):
                break
        else:
            raise MarchError(
                f"time step to t = {times[0]:.4f} chords/a diverged at Mach {self.mach:g}, incidence "
                f"{np.degrees(incidence):.2f} degrees, with three sizes of pseudo-step. "
                "Remedy: a smaller communication step or amplitude"
            )
        flow = np.empty_like(self.q)
        _turn(self.q, flow, c, -sine, 1.0, False)
        self._levels = (flow, self._levels[0], self._levels[1])
        self._times = (float(times[0]), float(times[1]), float(times[2]))
        relative = change / max(moved, 1e-12)
        converged = relative <= s.tolerance or change < 1e-10
        self._age += 1
        # slow subiterations: the flow has left the one that was linearised
        self._refresh = retry > 0 or (count > 0.6 * s.max_subiterations and self._age >= 4)
        return StepReport(count, float(relative), bool(converged), retry)

    def _subiterate(self, factors: Factors, weight: float, limit: int) -> tuple[int, float, float]:
        """Subiterations used, last rms density change and that of the whole step; NaN when it blew up."""
        change = moved = np.inf
        for count in range(1, limit + 1):
            self._evaluate()
            _add_time(self._out, self.q, self._past, self.mesh.volume, weight)
            factors.solve(self._out, self._x)
            change = _update(self.q, self._x)
            if not np.isfinite(change) or change > BLOW_UP:
                return count, np.nan, np.nan
            if count == 2:
                # densities do not turn: no need to rotate
                moved = _distance(self.q, self._levels[0])
            if count >= 3 and change <= max(self.settings.tolerance * moved, 1e-10):
                break
        self._wall_pressure()
        return count, change, moved

    def _linearised(self, weight: float, cfl: float) -> Factors:
        return Factors(Recipe(self.q.copy(), self.farfield.state.copy(), weight, cfl), self.mesh)

    def _move(self, motion: Motion, incidence: float) -> None:
        """Mesh velocity, wall acceleration and outer state of a motion, in body axes."""
        c, s = np.cos(incidence), np.sin(incidence)
        rate, spin = motion.alpha_dot, motion.alpha_ddot
        self._motion[:] = motion.h_dot * s, -motion.h_dot * c + rate * self.axis, rate
        x, y = self._wall[3] - self.axis, self._wall[4]
        nx, ny = self.mesh.ring[0, 0], self.mesh.ring[0, 1]
        along = motion.h_ddot * s + y * spin - x * rate**2
        up = -motion.h_ddot * c - x * spin - y * rate**2
        self._wall[2] = along * nx + up * ny
        self.incidence = incidence
        self.farfield.set(incidence, self._lift)

    def _wall_pressure(self) -> None:
        wall_state(self.q, self.mesh.ring, self._wall, self._motion, self._ghost, self.pressure)

    def _evaluate(self) -> None:
        self._wall_pressure()
        nj, ni = self.mesh.shape
        residual(
            self.q.reshape(-1), self._out.reshape(-1), self.mesh.side.reshape(-1), self.mesh.ring.reshape(-1),
            self._ghost.reshape(-1), self.pressure, self.farfield.state.reshape(-1), self._motion, ni, nj,
        )  # fmt: skip

    # ---- state -------------------------------------------------------------------------------------------------------

    def save(self) -> dict[str, Any]:
        """All that the next step reads, arrays by reference: none of them is ever written again."""
        state: dict[str, Any] = {
            "levels": self._levels,
            "times": self._times,
            "lift": self._lift,
            "pressure": self.pressure.copy(),
            "incidence": self.incidence,
            "refresh": self._refresh,
            "age": self._age,
        }
        if self._factors is not None:
            state["recipe"] = dict(vars(self._factors.recipe))
        return state

    def restore(self, state: dict[str, Any]) -> None:
        """Back to a saved state, of this flow or of one like it in another process; the next step repeats to the last bit."""
        first, second, third = state["levels"]
        self._levels = (first, second, third)
        self._times = tuple(state["times"])
        self._lift, self.incidence = state["lift"], state["incidence"]
        self._refresh, self._age = state["refresh"], state["age"]
        self.pressure[:] = state["pressure"]
        if "recipe" not in state:
            self._factors = None
            return
        recipe = Recipe(**state["recipe"])
        # the factors in hand, or those before them, nearly always are the ones; else the recipe makes them again
        known = [f for f in (self._factors, self._former) if f is not None and f.recipe.flow is recipe.flow]
        self._set_factors(known[0] if known else Factors(recipe, self.mesh))

    def _set_factors(self, factors: Factors) -> None:
        if factors is not self._factors:
            self._factors, self._former = factors, self._factors

def _refined(q: Array) -> Array:
    """Flow (nj, 4, ni) interpolated bilinearly to twice the cells each way, shape (2 nj, 4, 2 ni)."""
    around = np.empty((q.shape[0], 4, 2 * q.shape[2]))
    around[:, :, 0::2] = 0.75 * q + 0.25 * np.roll(q, 1, axis=2)
    around[:, :, 1::2] = 0.75 * q + 0.25 * np.roll(q, -1, axis=2)
    fine = np.empty((2 * q.shape[0], 4, 2 * q.shape[2]))
    fine[0::2] = 0.75 * around + 0.25 * np.concatenate([around[:1], around[:-1]])
    fine[1::2] = 0.75 * around + 0.25 * np.concatenate([around[1:], around[-1:]])
    return fine
