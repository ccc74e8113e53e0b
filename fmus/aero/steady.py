"""Steady flow: relaxation with local and global pseudo-time steps from a solution on half the cells each way."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from .control import MarchError, Settings, StepReport
from .field import Field
from .mesh import coarsened

Array = NDArray[np.float64]

RAMP = 30
"""Iterations over which the pseudo-time steps grow from a tenth in a start from the uniform stream."""
RENEW = 50
"""Iterations between linearisations."""
COARSE_TOLERANCE = 2e-5
TREND = 40
"""Iterations over which changes of the lift are compared."""
SLOWEST = 0.9
"""Largest ratio of such changes that is believed: beyond, they do not fall."""
STALL, STALLED, LEAST = 400, 0.8, 0.1
"""Pseudo-time steps are halved, down to LEAST, when over STALL iterations the change of the second half is not below STALLED
of the first's."""
LIFT = 0.01
"""Lift coefficient below which what is left of it counts absolutely, not relatively."""


def solve(field: Field, incidence: float, settings: Settings) -> StepReport:
    """Bring `field` to the steady flow at incidence [rad].

    Raises MarchError when it diverges or stays above tolerance.
    """
    field.start(incidence, _coarse_start(field, incidence, settings))
    # density changes scale with the dynamic pressure
    tolerance = settings.steady_tolerance * field.mach**2
    report = _iterate(field, incidence, settings, tolerance, ramp=0)
    if not report.converged:
        raise MarchError(
            f"steady flow at Mach {field.mach:g}, incidence {np.degrees(incidence):.3f} degrees: rms density change "
            f"{report.residual:.1e} after {report.subiterations} iterations, tolerance {tolerance:.1e}. "
            "Remedy: other cell counts; some flows have no steady state"
        )
    return report


def _coarse_start(field: Field, incidence: float, settings: Settings) -> Array | None:
    mesh = coarsened(field.mesh)
    if mesh is None:
        return None
    coarse = Field(mesh, field.mach, field.axis)
    coarse.start(incidence)
    report = _iterate(coarse, incidence, settings, COARSE_TOLERANCE * field.mach**2, ramp=RAMP)
    return _refined(coarse.q) if np.isfinite(report.residual) else None


def _iterate(field: Field, incidence: float, settings: Settings, tolerance: float, ramp: int) -> StepReport:
    start = field.q.copy()
    change, converged, caution, retries, iteration = np.inf, False, 1.0, 0, 0
    lifts: list[float] = []
    changes: list[float] = []
    eased = 0
    while iteration < settings.steady_iterations:
        if iteration % RENEW == 0 or (iteration < ramp and iteration % 8 == 0):
            share = caution * (min(1.0, 0.1 + iteration / ramp) if ramp else 1.0)
            least = settings.steady_least_cfl * share
            factors = field.linearised(1 / (settings.steady_step * share), settings.steady_cfl * share, least)
        if iteration - eased >= STALL and min(changes[-STALL // 2 :]) > STALLED * min(changes[-STALL : -STALL // 2]):
            # going round in a circle: smaller pseudo-steps from the next linearisation on
            caution, eased = max(0.5 * caution, LEAST), iteration
        field.evaluate()
        change = field.relax(factors)
        if not np.isfinite(change):
            retries += 1
            if retries > 2:
                break
            # smaller pseudo-steps from where it began
            caution, iteration, ramp, field.q[:] = 0.4 * caution, 0, max(ramp, RAMP), start
            field.farfield.set(incidence, 0.0)
            lifts.clear()
            changes.clear()
            eased = 0
            continue
        iteration += 1
        changes.append(change)
        lifts.append(field.coefficients.lift)
        field.farfield.set(incidence, lifts[-1])
        converged = change < tolerance and _left_of_lift(lifts) < settings.steady_lift
        if converged:
            break
    field.find_pressure()
    return StepReport(iteration, float(change), converged, retries)


def _left_of_lift(lifts: list[float]) -> float:
    """What the lift still lacks, relative, if its changes go on falling as they did; infinite while that cannot be said.

    The circulation settles last, as the starting vortex leaves, by changes too small for the tolerance on the density."""
    if len(lifts) <= 2 * TREND:
        return np.inf
    new, old = abs(lifts[-1] - lifts[-1 - TREND]), abs(lifts[-1 - TREND] - lifts[-1 - 2 * TREND])
    ratio = min(new / max(old, 1e-300), SLOWEST)
    return new * ratio / (1.0 - ratio) / max(abs(lifts[-1]), LIFT)


def _refined(q: Array) -> Array:
    """Flow (nj, 4, ni) interpolated bilinearly to twice the cells each way, shape (2 nj, 4, 2 ni)."""
    around = np.empty((q.shape[0], 4, 2 * q.shape[2]))
    around[:, :, 0::2] = 0.75 * q + 0.25 * np.roll(q, 1, axis=2)
    around[:, :, 1::2] = 0.75 * q + 0.25 * np.roll(q, -1, axis=2)
    fine = np.empty((2 * q.shape[0], 4, 2 * q.shape[2]))
    fine[0::2] = 0.75 * around + 0.25 * np.concatenate([around[:1], around[:-1]])
    fine[1::2] = 0.75 * around + 0.25 * np.concatenate([around[1:], around[-1:]])
    return fine
