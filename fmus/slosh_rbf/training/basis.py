"""Radial basis functions and the linear algebra of their weights, in numpy; for training."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..memory import Array
from ..readout import MIRROR


@dataclass(frozen=True)
class Samples:
    """Rows of many records under each other, with weights: turning (n,) of along and moment, lifting (n,) of up."""

    odd: Array
    even: Array
    space: Array
    rest: Array
    turning: Array
    lifting: Array


@dataclass(frozen=True)
class Basis:
    """Gaussians: centres (m, SPACE), sharpness (m,) and scales (SPACE,)."""

    centres: Array
    sharpness: Array
    scales: Array


def k_means(points: Array, count: int, random: np.random.Generator, sweeps: int = 30) -> Array:
    """Centres (count, d) of `points` (n, d), Lloyd's sweeps from random points."""
    centres = points[random.choice(len(points), count, replace=False)]
    for _ in range(sweeps):
        nearest = np.argmin(((points[:, None, :] - centres[None]) ** 2).sum(axis=2), axis=1)
        new = np.array([points[nearest == j].mean(axis=0) if np.any(nearest == j) else centres[j] for j in range(count)])
        if np.allclose(new, centres, atol=1e-12):
            break
        centres = new
    return centres


def gaussians(space: Array, basis: Basis) -> tuple[Array, Array]:
    """phi and its mirror image, each (n, m)."""
    z, c = space / basis.scales, basis.centres / basis.scales
    here = ((z[:, None, :] - c[None]) ** 2).sum(axis=2)
    there = (((z * MIRROR)[:, None, :] - c[None]) ** 2).sum(axis=2)
    sharp = -0.5 * basis.sharpness**2
    return np.exp(sharp * here), np.exp(sharp * there)


def at_rest(basis: Basis) -> Array:
    """phi and its mirror image together, at rest. Shape: (m,)."""
    return 2.0 * np.exp(-0.5 * basis.sharpness**2 * ((basis.centres / basis.scales) ** 2).sum(axis=1))


def ridge(X: Array, Y: Array, weight: Array, amounts: Array) -> Array:
    """Weights (features, outputs) of the ridge regression of Y on X.

    Features count in units of their weighted rms; amounts (features,)."""
    Xw = X * weight[:, None]
    size = np.sqrt((Xw**2).mean(axis=0))
    size[size == 0.0] = 1.0
    Xw = Xw / size
    normal = Xw.T @ Xw / len(X) + np.diag(amounts)
    return np.linalg.solve(normal, Xw.T @ (Y * weight[:, None]) / len(X)) / size[:, None]
