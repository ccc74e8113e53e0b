"""Training of networks with output feedback: regressors of records, least squares, k-means."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ..feedback import INPUTS, Feedback, gaussians, regressors
from ..memory import Array
from ..network import NetworkError
from .basis import k_means

SAMPLED = 2000
"""Regressors among which k-means looks for centres; more records, the same cost."""


def fit(
    name: str,
    inputs: str,
    delays: tuple[int, int],
    step: float,
    records: Sequence[tuple[Array, Array]],
    shape: float,
    room: float,
    centres: int = 0,
    spread: float = 0.0,
    ridge: float = 1e-8,
    seed: int = 0,
    about: dict[str, Any] | None = None,
) -> Feedback:
    """A linear network (centres = 0) or one of Gaussians, fitted one step ahead on `records` of u (n, inputs), y (n, outputs).

    spread: of all Gaussians, in scaled units; 0: twice the root of the number of regressors, so that neighbours overlap. ridge:
    on the weights, not the constant, per sample. Raises NetworkError for records that do not fit."""
    if not records or any(u.ndim != 2 or u.shape[1] != INPUTS[inputs] for u, _ in records):
        raise NetworkError(f"network '{name}': {INPUTS[inputs]} inputs '{inputs}' in each record. Remedy: see `feedback.columns`")
    X = np.vstack([regressors(u, y, delays) for u, y in records])
    Y = np.vstack([y[max(delays) :] for _, y in records])
    shift, scale = _normal(X)
    output_shift, output_scale = _normal(Y)
    z, target = (X - shift) / scale, (Y - output_shift) / output_scale
    width, outputs = X.shape[1], Y.shape[1]
    spread = spread or 2.0 * np.sqrt(width)
    linear, points, weights = np.zeros((width + 1, outputs)), np.zeros((0, width)), np.zeros((0, outputs))
    if centres:
        random = np.random.default_rng(seed)
        some = z[random.choice(len(z), SAMPLED, replace=False)] if len(z) > SAMPLED else z
        points = k_means(some, min(centres, len(some)), random)
        weights, linear[-1] = _solve(gaussians(z, points, spread), target, ridge)
    else:
        linear[:-1], linear[-1] = _solve(z, target, ridge)
    return Feedback(
        name, inputs, delays, step, shift, scale, output_shift, output_scale, linear, points, spread, weights, shape, room,
        about or {},
    )  # fmt: skip


def _normal(values: Array) -> tuple[Array, Array]:
    """Mean and std of columns; a column that hardly changes (plunge, in pure pitch) keeps its own unit."""
    mean, std = values.mean(axis=0), values.std(axis=0)
    return mean, np.where(std > 1e-9 * (1.0 + np.abs(mean)), std, 1.0)


def _solve(features: Array, target: Array, ridge: float) -> tuple[Array, Array]:
    """Weights (features, outputs) and constant (outputs,) of least squares.

    By orthogonal factors, not normal equations: wide Gaussians look alike, and a linear system is to be found exactly."""
    count = features.shape[1]
    mean, middle = features.mean(axis=0), target.mean(axis=0)
    rows = np.vstack([(features - mean) / np.sqrt(len(features)), np.sqrt(ridge) * np.eye(count)])
    right = np.vstack([(target - middle) / np.sqrt(len(features)), np.zeros((count, target.shape[1]))])
    weights = np.linalg.lstsq(rows, right, rcond=None)[0]
    return weights, middle - mean @ weights
