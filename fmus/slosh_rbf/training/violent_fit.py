"""Training of a violent branch: k-means for the centres, one ridge solve for all weights, noise from records kept apart.

Rows of the least squares are of two kinds. A sample: r over Q + 0.3 g, so that small motions count. A cycle: the work that the
force takes out of it over pi m a X (its loss factor), which is linear in the weights too; without these rows a fit of a chaotic
force gives away work, and work is what decides flutter.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.linalg.blas import dsyrk

from ...kit.compiled import jit
from ...tank.liquid import Tank
from ..body import from_load
from ..memory import GAMMA, Array, Memory, Place, drive
from ..violent_memory import BASIS, ENERGY, SPACE, UNEVEN, Basin, basin, follow, share, still, tell
from ..violent_network import WIDTH, Violent, ViolentWeights
from .basis import k_means

OWN = 0.3
"""Amplitude [g] added to Q in the weight of a sample."""
LEAST = 1.0
"""Least amplitude of acceleration [g] of a cycle whose loss factor counts."""
HEADROOM = 1.2  # loads are clipped at this times the largest |r|/Q of the training data's 99.9 %
SWEEPS, POINTS = 15, 8000  # of k-means
EDGE = 0.05  # share of the range of the training data that counts as their edge
SURE = 0.1  # share from which deviations are counted
KEPT = 20  # samples of a broken surface, of which centres are made: every so many


@dataclass(frozen=True)
class Settings:
    """centres: number of Gaussians; spread: in units of the mean distance of neighbouring centres; ridges: tried on the weights,
    over the mean square of what they multiply; work: weight of a cycle against a sample; thin: every so many samples are used;
    seed: of k-means and sampling."""

    centres: int = 100
    spread: float = 1.4
    ridges: tuple[float, ...] = (1e-3, 1e-2)
    work: float = 3.0
    thin: int = 4
    seed: int = 0


class Cycle(NamedTuple):
    """A cycle of the tank from low to low: samples first to last, amplitudes of acceleration [g] and displacement [m]."""

    first: int
    last: int
    acceleration: float
    displacement: float


@dataclass(frozen=True, eq=False)
class Table:
    """A record as the branch sees it, n samples: coordinates (n, WIDTH), what is read out (n, BASIS), Q, p, share of the branch,
    r over m_T g (n,), the tank's velocity up [m/s], cycles, step [s], tank."""

    name: str
    space: Array
    basis: Array
    Q: Array
    p: Array
    share: Array
    r: Array
    velocity: Array
    cycles: tuple[Cycle, ...]
    step: float
    tank: Tank


def tabulate(name: str, tank: Tank, viscosity: float, gas_density: float, motions: Array, loads: Array, step: float) -> Table:
    """A record with motions (n, 9) and loads (n, 3) in inertial axes, its tank on the axis."""
    memory, n = Memory(tank, viscosity), len(motions)
    space, basis, Q, p, part = np.empty((n, WIDTH)), np.empty((n, BASIS)), np.empty(n), np.empty(n), np.empty(n)
    _tabulate(motions, step, memory.place, basin(memory), still(), space, basis, Q, p, part)
    space[:, SPACE] = tank.fill_level
    whole = from_load(loads[:, 0], loads[:, 1], loads[:, 2], tank, motions[:, 3])
    gas = gas_density * tank.length * (tank.height - tank.depth) * tank.width / tank.mass
    r = whole[:, 1] + (1.0 + p) * (1.0 + gas)
    return Table(name, space, basis, Q, p, part, r, -motions[:, 1], _cycles(-motions[:, 0], -motions[:, 1], p), step, tank)


def loss(table: Table, r: Array) -> Array:
    """Loss factor of each cycle under the force r (n,) over m_T g: work taken out over pi m a X. Shape: (cycles,)."""
    return np.array(
        [
            -np.trapezoid(r[c.first : c.last + 1] * table.velocity[c.first : c.last + 1]) * table.step
            / (math.pi * c.acceleration * c.displacement)
            for c in table.cycles
        ]
    )  # fmt: skip


def fit(tables: Sequence[Table], settings: Settings) -> list[ViolentWeights]:
    """Centres and weights for each ridge; the noise is nought (`noise`). Raises ValueError where fewer samples than centres are
    of a broken surface."""
    random = np.random.default_rng(settings.seed)
    space = np.concatenate([t.space[t.share > 0.0][::KEPT] for t in tables])
    if len(space) < settings.centres:
        raise ValueError(f"{len(space)} samples for {settings.centres} centres")
    shift, scale = space.mean(axis=0), space.std(axis=0)
    scale[scale < 1e-9] = 1.0  # one fill
    points = (space - shift) / scale
    centres = k_means(
        points[random.choice(len(points), min(POINTS, len(points)), replace=False)], settings.centres, random, SWEEPS
    )
    apart = ((centres[:, None] - centres[None]) ** 2).sum(axis=2)
    np.fill_diagonal(apart, np.inf)
    sharpness = 1.0 / (settings.spread * float(np.sqrt(apart.min(axis=1)).mean()))
    every = np.concatenate([t.space[t.share > 0.0] for t in tables])
    low, high = ((end(every, axis=0) - shift) / scale for end in (np.min, np.max))
    flat = high - low < 1e-9
    low, high = low - EDGE * (high - low), high + EDGE * (high - low)
    net = ViolentWeights(
        shift, scale, centres, sharpness, np.zeros((len(centres), BASIS)), np.zeros(len(centres)), low - flat, high + flat, 0.0
    )  # fmt: skip
    ratio = np.concatenate([(np.abs(t.r) / t.Q)[t.share > 0.0] for t in tables])
    limit = HEADROOM * float(np.quantile(ratio, 0.999))
    normal, right = _equations(tables, net, settings, random)
    return [net._replace(weights=_solve(normal, right, amount, len(centres)), limit=limit) for amount in settings.ridges]


def choose(
    tables: Sequence[Table], checks: Sequence[Table], every: Sequence[Settings], say: Callable[[str], None] = lambda text: None
) -> tuple[ViolentWeights, list[dict[str, Any]]]:
    """The weights whose loss factors are nearest to those of `checks`, and what was tried. Raises ValueError as `fit` does."""
    tried: list[dict[str, Any]] = []
    best: tuple[float, ViolentWeights] | None = None
    for settings in every:
        for amount, net in zip(settings.ridges, fit(tables, settings), strict=True):
            found = measure(checks, [predict(net, t) for t in checks])
            tried.append({"centres": settings.centres, "spread": settings.spread, "ridge": amount, **found})
            say(
                f"  {settings.centres} Gaussians, spread {settings.spread:g}, ridge {amount:g}: loss factor rms "
                f"{found['loss_rms']:.4f}, "
                f"bias {found['loss_bias']:+.4f}, R2 {found['R2']:.3f}"
            )
            if best is None or found["loss_rms"] < best[0]:
                best = (found["loss_rms"], net)
    if best is None:
        raise ValueError("nothing to try")
    return best[1], tried


def predict(net: ViolentWeights, table: Table) -> Array:
    """r (n,) over m_T g, blended in."""
    value = np.einsum("tj,jk,tk->t", gaussians(net, table.space), net.weights, table.basis)
    return table.share * table.Q * np.clip(value, -net.limit, net.limit)


def gaussians(net: ViolentWeights, space: Array) -> Array:
    """Normalised Gaussians (n, m) at coordinates (n, WIDTH)."""
    z = np.clip((space - net.shift) / net.scale, net.low, net.high)
    square = (z**2).sum(axis=1)[:, None] + (net.centres**2).sum(axis=1) - 2.0 * z @ net.centres.T
    square -= square.min(axis=1, keepdims=True)
    g = np.exp(-0.5 * net.sharpness**2 * square)
    return g / g.sum(axis=1, keepdims=True)


def noise(net: ViolentWeights, tables: Sequence[Table]) -> tuple[Array, float]:
    """Rms deviation over Q at each centre (m,) and how long it lasts [s], from records that were not trained on."""
    weight, square = np.full(len(net.centres), 1e-9), np.zeros(len(net.centres))
    before, after = 0.0, 0.0
    for t in tables:
        keep = t.share > SURE
        left = (t.r - predict(net, t))[keep] / (t.share * t.Q)[keep]
        g = gaussians(net, t.space[keep])
        weight += g.sum(axis=0)
        square += g.T @ left**2
        if left.size > 1:
            before += float(left[:-1] @ left[:-1])
            after += float(left[1:] @ left[:-1])
    mean = square.sum() / weight.sum()
    step = tables[0].step
    # a centre that these records hardly visit is told the mean of all
    at = np.sqrt((square + 50.0 * mean) / (weight + 50.0))
    return at, -step / math.log(min(max(after / before, 1e-3), 0.999)) if before > 0.0 else step


def measure(tables: Sequence[Table], forces: Sequence[Array]) -> dict[str, Any]:
    """How well forces (n,) over m_T g tell those of the records: R2 of r/(Q + OWN), loss factors of cycles (rms, bias, count)."""
    left, whole = 0.0, 0.0
    gaps: list[Array] = []
    for t, force in zip(tables, forces, strict=True):
        keep = t.share > 0.0
        weight = 1.0 / (t.Q[keep] + OWN)
        left += float((((force - t.r)[keep] * weight) ** 2).sum())
        whole += float(((t.r[keep] * weight) ** 2).sum())
        gaps.append(loss(t, force) - loss(t, t.r))
    gap = np.concatenate(gaps)
    return {
        "R2": 1.0 - left / whole,
        "loss_rms": float(np.sqrt((gap**2).mean())),
        "loss_bias": float(gap.mean()),
        "cycles": gap.size,
    }


def _equations(
    tables: Sequence[Table], net: ViolentWeights, settings: Settings, random: np.random.Generator
) -> tuple[Array, Array]:
    """Normal matrix and right side, summed record by record."""
    size = len(net.centres) * BASIS
    normal, right = np.zeros((size, size), order="F"), np.zeros(size)
    for t in tables:
        keep = np.flatnonzero(t.share > 0.0)
        if not keep.size:
            continue
        g, b = gaussians(net, t.space), t.basis * (t.share * t.Q)[:, None]
        picked = keep[random.integers(settings.thin) :: settings.thin]
        weight = 1.0 / (t.Q[picked] + OWN)
        rows = [(g[picked][:, :, None] * (b[picked] * weight[:, None])[:, None, :]).reshape(len(picked), size)]
        values = [t.r[picked] * weight]
        for c, true in zip(t.cycles, loss(t, t.r), strict=True):
            if not np.any(t.share[c.first : c.last + 1]):
                continue
            part = slice(c.first, c.last + 1)
            rate = -t.velocity[part] * t.step / (math.pi * c.acceleration * c.displacement)
            rate[[0, -1]] *= 0.5
            rows.append(settings.work * ((g[part] * rate[:, None]).T @ b[part]).reshape(1, size))
            values.append(np.array([settings.work * true]))
        X = np.concatenate(rows)
        normal = dsyrk(1.0, X.T, beta=1.0, c=normal, overwrite_c=1)
        right += X.T @ np.concatenate(values)
    return np.triu(normal) + np.triu(normal, 1).T, right


def _solve(normal: Array, right: Array, ridge: float, centres: int) -> Array:
    """Weights (m, BASIS) of a ridge regression."""
    damped = normal.copy()
    damped[np.diag_indices(len(right))] += ridge * np.trace(normal) / len(right) + 1e-12
    return cho_solve(cho_factor(damped, overwrite_a=True, check_finite=False), right).reshape(centres, -1)


def _cycles(place: Array, velocity: Array, p: Array) -> tuple[Cycle, ...]:
    """From each lowest place of the tank to the next, those of LEAST amplitude or more."""
    lows = np.flatnonzero((velocity[:-1] < 0.0) & (velocity[1:] >= 0.0)).tolist()
    found = [
        Cycle(a, b, 0.5 * float(np.ptp(p[a : b + 1])), 0.5 * float(np.ptp(place[a : b + 1]))) for a, b in itertools.pairwise(lows)
    ]
    return tuple(c for c in found if c.acceleration >= LEAST and c.displacement > 0.0)


@jit
def _tabulate(
    motions: Array,
    step: float,
    place: Place,
    basin: Basin,
    state: Array,
    space: Array,
    basis: Array,
    Q: Array,
    p: Array,
    part: Array,
) -> None:
    rows = np.empty(5)
    for k in range(len(motions)):
        if k > 0:
            follow(state, motions[k - 1], motions[k], step, place, basin)
        drive(motions[k], place, rows)
        p[k] = rows[GAMMA]
        Q[k] = tell(state, p[k], basin, space[k], basis[k])
        part[k] = share(state[UNEVEN], space[k, ENERGY])


def branch(name: str, net: ViolentWeights, checks: Sequence[Table], fills: tuple[float, float], about: dict[str, Any]) -> Violent:
    """A branch with its noise, from records that were not trained on."""
    at, lasts = noise(net, checks)
    tank = checks[0].tank
    memory = lasts / math.sqrt(tank.length / tank.gravity)
    return Violent(name, net._replace(noise=at), fills, tank.height / tank.length, memory, about)
