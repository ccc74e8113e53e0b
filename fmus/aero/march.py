"""Time marching of the flow around a rigidly moving section.

Past flows are kept in inertial axes and turned into the body axes of the new time: in these the mesh is at rest, so metrics and
linearisation stay constant and a uniform stream stays uniform to round-off. Each step is solved by subiterations with the
approximate inverse of implicit.py from a quadratic prediction.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import steady
from .bdf import add_time_derivative, bdf_weights, combine, extrapolation_weights, predict, turn
from .control import MarchError, Settings, StepReport
from .field import Field, Motion, density_distance
from .implicit import Factors, Recipe
from .mesh import Mesh

Array = NDArray[np.float64]

BLOW_UP = 0.5
"""rms density change of a subiteration that is taken for divergence."""
RETRIES = (1.0, 0.25, 0.1)
"""Pseudo-time steps of a step and of its repetitions, over the normal one."""
PREDICTED = 0.1
"""Largest relative change of density or energy that is predicted in a cell."""
SINGLE = 5e-7
"""rms density change at which a step ends beyond which fluxes are found in single precision, which rounds by 1e-7."""
NEAR_SHARE = 0.4
"""Part of the quadratic prediction that cells near the trailing edge take."""
CAUTION = 0.25
"""Least factor on the pseudo-time step, and on the bend of the prediction, after steps that did not converge."""
MEMORY = 0.95
"""What is left, a step later, of the density change of a step as the measure of the tolerance."""
STALE = 0.05
"""Relative change of the step length that asks for new factors."""
SLOW = 15
"""Subiterations of a step beyond which the next one linearises afresh."""
HALVED = 8
"""Subiterations over which the density change must halve, from twice as many on, else the step linearises afresh: a shock has
moved off the factors."""


class Flow(Field):
    """Flow that is marched in time; Field's attributes are those of the present time."""

    def __init__(self, mesh: Mesh, mach: float, axis: float, settings: Settings | None = None) -> None:
        super().__init__(mesh, mach, axis)
        self.settings = settings or Settings()
        self.refactorings = 0
        self._past = np.zeros_like(self.q)
        self._share = _bend_share(mesh.shape[1])
        self._levels: tuple[Array, Array, Array] = (self.q, self.q, self.q)
        self._times: tuple[float, ...] = (0.0, 0.0, 0.0)
        self._lift = 0.0
        self._moved = 0.0
        self._caution = 1.0
        self._factors: Factors | None = None
        self._former: Factors | None = None
        self._refresh = True
        self._age = 0

    def solve_steady(self, incidence: float) -> StepReport:
        """Steady flow at incidence [rad], all of the past set to it.

        Raises MarchError when it diverges or stays above tolerance.
        """
        report = steady.solve(self, incidence, self.settings)
        flow = np.empty_like(self.q)
        turn(self.q, flow, float(np.cos(incidence)), -float(np.sin(incidence)))
        self._levels = (flow, flow, flow)
        self._times = (0.0, 0.0, 0.0)
        self._lift = self.coefficients.lift
        self._moved, self._caution, self._refresh, self.refactorings = 0.0, 1.0, True, 0
        return report

    def step(self, motion: Motion, incidence: float, dt: float) -> StepReport:
        """Advance by dt to the given motion at its end, with the stream at incidence [rad] to the section's axis.

        When the subiterations blow up the step is repeated from a constant prediction with fresh factors and smaller
        pseudo-steps. Raises MarchError when that fails too.
        """
        if self._times[1] == self._times[0]:
            # before the first step the flow stood still: place its past one step apart
            self._times = (self._times[0], self._times[0] - dt, self._times[0] - 2 * dt)
        times = (self._times[0] + dt, *self._times)
        weights, guess = bdf_weights(times), extrapolation_weights(times)
        c, s = float(np.cos(incidence)), float(np.sin(incidence))
        combine(*self._levels, weights[1:], c, s, self._past)
        self.move(motion, incidence, self._lift)
        factors = self._factors
        stale = self._refresh or factors is None or abs(weights[0] / factors.recipe.weight - 1) > STALE
        for retry, share in enumerate(RETRIES):
            if retry == 0:
                predict(*self._levels, *guess, self._caution * self._share, PREDICTED, c, s, self.q)
            else:
                turn(self._levels[0], self.q, c, s)
            if factors is None or stale or retry:
                factors = self.linearised(float(weights[0]), share * self._caution * self.settings.cfl)
                self._set_factors(factors)
                self._refresh, self._age = False, 0
                self.refactorings += 1
            limit = self.settings.max_subiterations * (1 if retry == 0 else 3)
            count, change, moved = self._subiterate(factors, float(weights[0]), limit, share)
            if np.isfinite(change):
                break
        else:
            raise MarchError(
                f"time step to t = {times[0]:.4f} chords/a diverged at Mach {self.mach:g}, incidence "
                f"{np.degrees(incidence):.2f} degrees, with three sizes of pseudo-step. "
                "Remedy: a smaller communication step or amplitude"
            )
        flow = np.empty_like(self.q)
        turn(self.q, flow, c, -s)
        self._levels = (flow, self._levels[0], self._levels[1])
        self._times = times[:3]
        self._moved = moved
        relative = change / max(moved, 1e-12)
        self._age += 1
        # slow subiterations: the flow has left the one that was linearised
        self._refresh = retry > 0 or (count > SLOW and self._age >= 4)
        # strong moving shocks want smaller pseudo-steps; what is taken off is given back slowly
        self._caution = max(CAUTION, 0.5 * self._caution) if retry or count == limit else min(1.0, 1.02 * self._caution)
        return StepReport(count, float(relative), bool(relative <= self.settings.tolerance or change < 1e-10), retry)

    def _subiterate(self, factors: Factors, weight: float, limit: int, share: float) -> tuple[int, float, float]:
        """Subiterations used, last rms density change and that of the whole step; NaN when it blew up.

        Where the change does not halve within HALVED subiterations the flow is linearised afresh, from the second time in the
        step on with shorter pseudo-time steps (`share` of which the step takes anyway)."""
        changes: list[float] = []
        moved, afresh = np.inf, False
        kind = np.float32 if self.settings.tolerance * self._moved > SINGLE else np.float64
        for count in range(1, limit + 1):
            self.evaluate(kind)
            add_time_derivative(self.out, self.q, self._past, self.mesh.volume, weight)
            changes.append(self.relax(factors))
            if not np.isfinite(changes[-1]) or changes[-1] > BLOW_UP:
                return count, np.nan, np.nan
            if count == 2:
                # densities do not turn: no need to rotate. At a turning point of the motion the steps before set the scale
                moved = max(density_distance(self.q, self._levels[0]), MEMORY * self._moved)
            if count >= 3 and changes[-1] <= max(self.settings.tolerance * moved, 1e-10):
                break
            if count % HALVED == 0 and HALVED < count < limit and changes[-1] > 0.5 * changes[-HALVED]:
                if afresh:
                    self._caution = max(CAUTION, 0.5 * self._caution)
                factors = self.linearised(weight, share * self._caution * self.settings.cfl)
                self._set_factors(factors)
                self.refactorings += 1
                self._age, afresh = 0, True
        self.find_pressure()
        return count, changes[-1], moved

    def save(self) -> dict[str, Any]:
        """All that the next step reads, arrays by reference: none of them is ever written again."""
        state: dict[str, Any] = {
            "levels": self._levels,
            "times": self._times,
            "lift": self._lift,
            "moved": self._moved,
            "caution": self._caution,
            "refactorings": self.refactorings,
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
        self._lift, self._moved, self.incidence = state["lift"], state["moved"], state["incidence"]
        self._caution, self.refactorings = state["caution"], state["refactorings"]
        self._refresh, self._age = state["refresh"], state["age"]
        self.pressure[:] = state["pressure"]
        if "recipe" not in state:
            self._factors = None
            return
        recipe = Recipe(**state["recipe"])
        # the factors in hand, or those before them, nearly always are the ones; else the recipe makes them again
        known = [f for f in (self._factors, self._former) if f is not None and f.recipe.flow is recipe.flow]
        self._set_factors(known[0] if known else Factors(recipe, self.mesh, self.blocks))

    def _set_factors(self, factors: Factors) -> None:
        if factors is not self._factors:
            self._factors, self._former = factors, self._factors


def _bend_share(ni: int) -> Array:
    """How much of the quadratic part of the prediction each column of cells takes, shape (ni,).

    Near the trailing edge, where cells are smallest, subiterations converge slowest; a quadratic prediction amplifies what they
    left over (seven times where it alternates, a linear one three times) and so makes the next step start worse.
    """
    column = np.arange(ni) + 0.5
    away = np.minimum(column, ni - column) / ni  # share of the circle between the column and the trailing edge
    return NEAR_SHARE + (1 - NEAR_SHARE) * np.clip((away - 0.15) / 0.05, 0.0, 1.0)
