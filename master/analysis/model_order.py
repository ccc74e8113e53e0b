"""How many exponentials a signal holds, and from where on: the fit that an information criterion prefers, with what would imitate
modes kept out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .exponentials import Poles, Solution, refine
from .pencil import pencil

MOST = 10  # dimensions of the signal's space: two an oscillation, one a real pole
PATIENCE = 3  # orders tried without a better fit before the search ends
PAIR_PAYS = 30.0  # by which a close pair of oscillations must lower the residual's variance
CLEAN = 1e-3  # of the rms: a residual that leaves nothing to be gained from a later window
SLOW = 3.0  # 1/span: a real pole slower than this is nearly a constant
LONG = 12.0 * np.pi  # a window from which slow poles are looked for with a coarse pencil too


def choose(tau: np.ndarray, z: np.ndarray) -> tuple[Solution | None, int]:
    """The fit, and the first sample of its window."""
    best, start = best_order(tau, z), 0
    if best is None or not len(best.poles.oscillations):
        return best, 0
    if best.variance < CLEAN**2:
        return best, 0
    omega = best.poles.oscillations[int(np.argmax(best.shares)), 1]
    cycle = 2.0 * np.pi / (omega * (tau[1] - tau[0]))
    for skip in (0.25, 0.5, 0.75):
        first = round(skip * cycle)
        if tau.size - first < max(2.5 * cycle, 24):
            break
        for reals in {best.poles.reals.size: best.poles.reals, 0: best.poles.reals[:0]}.values():
            trial = refine(tau[first:], z[:, first:], replace(best.poles, reals=reals))
            # a later window must pay for the samples it leaves out: half the residual variance
            if trial is not None and trial.variance < 0.5 * best.variance:
                best, start = trial, first
    return best, start


def best_order(tau: np.ndarray, z: np.ndarray) -> Solution | None:
    """The fit with the lowest information criterion, of all orders that matrix pencils suggest, without or with a constant.

    One with two oscillations that the window cannot tell apart must explain far more than those without: a growth rate that
    changes with the amplitude looks the same."""
    dt = float(tau[1] - tau[0])
    best: dict[bool, Solution] = {}  # by whether two oscillations are close

    def consider(new: Solution | None) -> bool:
        if new is None or ((old := best.get(close := has_close_pair(new))) is not None and old.score <= new.score):
            return False
        best[close] = new
        return True

    for coarse in (False, True):
        if coarse and z.shape[1] * dt < LONG:
            break
        idle = 0
        for first in pencil(dt, z, MOST, coarse):
            idle = 0 if consider(refine(tau, z, first)) or not best else idle + 1
            if idle >= PATIENCE:
                break
    if not best:
        consider(refine(tau, z, Poles(np.empty((0, 2)), np.array([0.1]), False)))  # nothing but a drift
    for found in list(best.values()):
        poles = found.poles
        consider(refine(tau, z, replace(poles, constant=True)))
        if poles.size > 1 and poles.reals.size:  # a constant in place of the slowest real pole
            fewer = np.delete(poles.reals, int(np.argmin(np.abs(poles.reals))))
            consider(refine(tau, z, replace(poles, constant=True, reals=fewer)))
    apart, close = best.get(False), best.get(True)
    if apart is None or close is None:
        return apart or close
    return close if close.variance < apart.variance / PAIR_PAYS else apart


def has_close_pair(solution: Solution) -> bool:
    """Whether two oscillations beat less than once within the window and decay alike, or cannot be told from each other; or a
    slow real pole goes with a constant."""
    poles, std, span = solution.poles.oscillations, solution.std, solution.span
    for i in range(len(poles)):
        for j in range(i):
            apart = float(np.hypot(*(poles[i] - poles[j])))
            if apart * span < 2.0 * np.pi:
                return True
            if apart < 2.0 * float(np.hypot(np.max(std[i]), np.max(std[j]))):
                return True
    return solution.poles.constant and bool(np.any(np.abs(solution.poles.reals) * span < SLOW))
