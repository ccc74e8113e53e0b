"""Training of a network on records of the two-phase solver: k-means, ridge regression, and a search for better centres.

The remainder of the load over the bilinear base is fitted by the linear tail and the Gaussians together, samples weighted by one
over the local size of their record's load: the small motions in which flutter is born count as much as the violent ones. Centres
come from k-means (Moody and Darken, Neural Comput. 1 (1989) 281, doi:10.1162/neco.1989.1.2.281); `tuning` moves centres, spreads
and scales by gradients, the weights being solved anew at each step (variable projection: Golub and Pereyra, SIAM J. Numer. Anal.
10 (1973) 413, doi:10.1137/0710036). Numbers of Gaussians and ridge are chosen by the free-run error on validation records.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..network import Network, Weights
from ..readout import EVEN, MIRROR, ODD, SPACE
from ..surrogate import Table
from .basis import Basis, Samples, at_rest, gaussians, k_means, ridge

FIRST = 50  # samples of a record that are left out: a start from rest is no motion of the kind
HEADROOM = 1.5  # corrections are clipped at this times the largest seen
TAIL = 1e-9  # ridge of the linear tail, in units of its features' mean squares
LOCAL = 200  # samples over which the size of a load is taken


@dataclass(frozen=True)
class Settings:
    """centres: numbers of Gaussians tried; spreads: in units of the coordinates' scales; ridges tried on the Gaussians; tuning:
    steps of the search for better centres (needs torch; 0: none); seed: of k-means and sampling; thin: every so many samples are
    used."""

    centres: tuple[int, ...] = (20, 40, 80)
    spreads: tuple[float, ...] = (3.0, 6.0)
    ridges: tuple[float, ...] = (1e-6, 1e-4, 1e-2)
    tuning: int = 100
    seed: int = 0
    thin: int = 4


def gather(tables: Sequence[Table], thin: int) -> Samples:
    """The samples of `tables`, each weighted by one over the local rms of its load (about its record's mean)."""
    parts = []
    for table in tables:
        keep = slice(FIRST, None, thin)
        load = table.whole - table.whole.mean(axis=0)
        local = np.sqrt(np.stack([np.convolve(load[:, i] ** 2, np.ones(LOCAL) / LOCAL, "same") for i in range(3)], axis=1))
        floor = 0.05 * load.std(axis=0) + 1e-6
        size = np.maximum(local, floor)
        # along and moment in one: they are two sides of the same waves
        parts.append(
            (table.odd[keep], table.even[keep], table.space[keep], table.rest[keep], 1.0 / size[keep, 0], 1.0 / size[keep, 1])
        )
    return Samples(*(np.concatenate(column) for column in zip(*parts, strict=True)))


def solve(samples: Samples, basis: Basis | None, amount: float) -> Weights:
    """Tail and Gaussians for the centres given (none: the tail alone), clipped at what the data show."""
    m = 0 if basis is None else len(basis.sharpness)
    odd, even = samples.odd, samples.even
    if basis is not None:
        phi, image = gaussians(samples.space, basis)
        odd, even = np.hstack([odd, phi - image]), np.hstack([even, phi + image - at_rest(basis)])
    # the tail is free, the Gaussians pay for what they add
    turning = ridge(odd, samples.rest[:, [0, 2]], samples.turning, np.repeat([TAIL, amount], [ODD, m]))
    lifting = ridge(even, samples.rest[:, [1]], samples.lifting, np.repeat([TAIL, amount], [EVEN, m]))[:, 0]
    along, up = odd @ turning, even @ lifting
    limits = HEADROOM * np.array([np.abs(along[:, 0]).max(), np.abs(up).max(), np.abs(along[:, 1]).max()])
    none = Basis(np.zeros((0, SPACE)), np.zeros(0), np.ones(SPACE))
    b = basis or none
    return Weights(
        True, np.ascontiguousarray(turning[:ODD]), lifting[:EVEN].copy(), np.ascontiguousarray(b.centres), b.sharpness.copy(),
        1.0 / b.scales, np.ascontiguousarray(turning[ODD:]), lifting[EVEN : EVEN + m].copy(), at_rest(b), limits,
    )  # fmt: skip


def initial(samples: Samples, count: int, spread: float, random: np.random.Generator) -> Basis:
    """Centres by k-means on the weighted range of the coordinates; one spread for all."""
    points = samples.space[random.choice(len(samples.space), min(20000, len(samples.space)), replace=False)]
    scales = points.std(axis=0) + 1e-12
    # of a pair of mirror images one is enough
    points = np.where(points[:, :1] < 0.0, points * MIRROR, points) / scales
    return Basis(k_means(points, count, random) * scales, np.full(count, 1.0 / spread), scales)


def train(
    training: Sequence[Table],
    error: Callable[[Weights], float],
    settings: Settings,
    say: Callable[[str], None] = lambda text: None,
) -> tuple[Weights, dict[str, Any]]:
    """The weights with the least free-run `error` on validation records, and what was tried.

    Raises ImportError when settings.tuning asks for torch and it is not installed."""
    samples = gather(training, settings.thin)
    random = np.random.default_rng(settings.seed)
    tried: list[dict[str, Any]] = []
    best: tuple[float, Weights, Basis, float] | None = None
    weights = solve(samples, None, 0.0)
    tried.append({"centres": 0, "error": error(weights)})
    say(f"  tail alone: error {tried[-1]['error']:.4%}")
    for count in settings.centres:
        for spread in settings.spreads:
            basis = initial(samples, count, spread, random)
            for amount in settings.ridges:
                weights = solve(samples, basis, amount)
                tried.append({"centres": count, "spread": spread, "ridge": amount, "error": error(weights)})
                say(f"  {count} Gaussians, spread {spread:g}, ridge {amount:g}: error {tried[-1]['error']:.4%}")
                if best is None or tried[-1]["error"] < best[0]:
                    best = (tried[-1]["error"], weights, basis, amount)
    if best is None:  # no Gaussians were asked for
        return weights, {"tried": tried, "validation_error": tried[0]["error"]}
    if settings.tuning:
        from .tuning import tune  # torch, an optional extra

        basis = tune(samples, best[2], best[3], settings.tuning, settings.seed, say)
        weights = solve(samples, basis, best[3])
        tuned = error(weights)
        tried.append({"centres": len(basis.sharpness), "ridge": best[3], "tuned": True, "error": tuned})
        say(f"  tuned: error {tuned:.4%}")
        if tuned < best[0]:
            best = (tuned, weights, basis, best[3])
    return best[1], {"tried": tried, "validation_error": best[0]}


def as_network(
    name: str, weights: Weights, training: Sequence[Table], shape: float, room: float, about: dict[str, Any]
) -> Network:
    """A network with the reach of the data it was trained on; shape, room: depth and height of the tank over its length."""
    reach = np.max([np.abs(table.space).max(axis=0) for table in training], axis=0)
    return Network(name, weights, reach, shape, room, about)
