"""How hard a motion shakes a tank: D, which tells whether the surface stays whole.

    D(t) = max over the time so far of |g_n/g − 1| + (l/2) |alpha''|/g

with g_n the effective gravity at the liquid's centre (tank.motion.body_force), l the tank's length. Below about 1.5 the surface
stays whole at flutter frequencies; above, it breaks, and loads can be told on average alone.
"""

from __future__ import annotations

import numpy as np
from scipy.optimize import brentq

from ...tank.liquid import Tank
from .excitation import ExcitationError, Motion
from .signals import Array


def effective_gravity(motions: Array, tank: Tank) -> Array:
    """g_n [m/s2] at the liquid's centre, shape (n,), of motions (n, 9): minus the second part of tank.motion.body_force."""
    _, _, h_ddot, alpha, alpha_dot, alpha_ddot, _, _, x_ddot = motions.T
    down = (tank.gravity - h_ddot) * np.cos(alpha) + x_ddot * np.sin(alpha)
    return down - tank.x * alpha_ddot - tank.centre_y * alpha_dot**2


def intensity(motions: Array, tank: Tank) -> Array:
    """Running D, shape (n,), of motions (n, 9)."""
    gravity = np.abs(effective_gravity(motions, tank) / tank.gravity - 1.0)
    return np.maximum.accumulate(gravity + 0.5 * tank.length * np.abs(motions[:, 5]) / tank.gravity)


def balanced(motion: Motion, tank: Tank, plunge: float, pitch: float, surge: float = 0.0) -> Motion:
    """Each coordinate scaled so that its largest |h''|/g, (l/2) |alpha''|/g and |x''|/g are these; one at rest stays at rest."""
    largest = np.max(np.abs(motion.motions[:, 2::3]), axis=0) / tank.gravity * [1.0, 0.5 * tank.length, 1.0]
    factors = np.divide([plunge, pitch, surge], largest, out=np.zeros(3), where=largest > 0.0)
    return motion.scaled(*factors.tolist())


def scaled_to(motion: Motion, tank: Tank, target: float) -> Motion:
    """The motion times the factor that brings its D to `target`. Raises ExcitationError for a motion that has none."""
    if not target > 0.0:
        raise ExcitationError(f"D = {target} wanted. Remedy: a value above 0")

    def gap(factor: float) -> float:
        return float(intensity(motion.motions * factor, tank)[-1]) - target

    present = gap(1.0) + target
    if not present > 0.0:
        raise ExcitationError(f"motion {motion.name} has no D to scale. Remedy: one that plunges or pitches")
    # D is nearly linear in the factor: turns of gravity and centrifugal terms bend it
    low = high = target / present
    while gap(high) < 0.0:
        high *= 1.5
    while gap(low) > 0.0:
        low /= 1.5
    return motion.scaled(low if low == high else float(brentq(gap, low, high, xtol=1e-14 * high, rtol=1e-14)))
