"""Read-out of the violent branch: the force up a tank's axis that a broken surface adds to that of the frozen liquid.

    r/Q = sum_j g_j(z) sum_k W_jk b_k,     g_j = exp(−|z − c_j|²/(2 s²)) / sum_i exp(−|z − c_i|²/(2 s²))

r: over m_T g; z: coordinates of the motion (violent_memory.tell) and the fill, b: its phase and slugs. Normalised Gaussians
(Moody and Darken, Neural Comput. 1 (1989) 281, doi:10.1162/neco.1989.1.2.281) are weights between 0 and 1 that sum to one: far
from all centres the nearest one's rule holds. What comes out is the mean of a chaotic flow; the deviation of a single run from
it is of the size Q sum_j g_j N_j, with N_j from records that were not trained on, and lasts `memory`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from ..tank.liquid import Tank
from .memory import Array
from .network import FORMAT, NetworkError, of_kind, write_archive
from .violent_memory import BASIS, ENERGY, SPACE, UNEVEN, Basin, share, tell

KIND = "violent"
WIDTH = SPACE + 1
SAME_ROOM = 0.02
"""Relative difference of height over length up to which a tank is of the trained shape."""
RULES = 0.5
"""Share of the branch from where its distance to the training data counts."""
MARGIN = 0.01
"""How far beyond the trained fills a tank may be filled."""


@argument
class ViolentWeights(NamedTuple):
    """What the kernel needs. shift, scale (WIDTH,): z = (coordinates − shift)/scale; centres (m, WIDTH) in z; sharpness 1/s;
    weights (m, BASIS); noise (m,): rms deviation over Q; low, high (WIDTH,): range of the training data in z; limit: largest
    |r|/Q."""

    shift: Array
    scale: Array
    centres: Array
    sharpness: float
    weights: Array
    noise: Array
    low: Array
    high: Array
    limit: float


@dataclass(frozen=True)
class Violent:
    """A trained branch.

    weights   of the kernel
    fills     least and largest fill trained on
    room      height over length of the tank trained on
    memory    how long a deviation from the mean lasts, over sqrt(l/g)
    about     how it came to be (data, errors, command)"""

    name: str
    weights: ViolentWeights
    fills: tuple[float, float]
    room: float
    memory: float
    about: dict[str, Any] = field(default_factory=dict)

    def knows(self, tank: Tank) -> bool:
        """Whether `tank` has the trained height over length and a fill between those trained on."""
        inside = self.fills[0] - MARGIN <= tank.fill_level <= self.fills[1] + MARGIN
        return inside and abs(tank.height / tank.length / self.room - 1.0) <= SAME_ROOM

    def save(self, path: Path) -> None:
        """Write a numpy archive (no pickles), whole or not at all."""
        text = {n: getattr(self, n) for n in ("name", "fills", "room", "memory", "about")}
        arrays = {name: np.asarray(value) for name, value in self.weights._asdict().items()}
        write_archive(path, {"format": FORMAT, "kind": KIND, **text}, arrays)


def load(path: Path) -> Violent:
    """Read a branch. Raises NetworkError for a file that is none, or whose arrays do not fit or are not finite."""
    try:
        text, arrays = of_kind(path, KIND)
        sharpness, limit = float(arrays.pop("sharpness")), float(arrays.pop("limit"))
        weights = ViolentWeights(**arrays, sharpness=sharpness, limit=limit)
        branch = Violent(weights=weights, **{**text, "fills": tuple(text["fills"])})
    except Exception as error:  # numpy, json and zipfile raise a dozen kinds
        raise NetworkError(f"{path.name} is no violent branch: {error}. Remedy: give a file that `train` wrote") from None
    m = len(weights.noise)
    wanted = {
        "shift": (WIDTH,),
        "scale": (WIDTH,),
        "centres": (m, WIDTH),
        "weights": (m, BASIS),
        "low": (WIDTH,),
        "high": (WIDTH,),
    }
    fits = m > 0 and all(getattr(weights, name).shape == shape for name, shape in wanted.items())
    if not fits or not all(np.isfinite(value).all() for value in weights):
        raise NetworkError(f"{path.name}: arrays do not fit or are not finite. Remedy: train it again")
    sound = (
        np.all(weights.scale > 0.0) and weights.sharpness > 0.0 and weights.limit >= 0.0 and np.all(weights.high > weights.low)
    )
    if not sound or not branch.room > 0.0 or not branch.memory > 0.0 or not 0.0 < branch.fills[0] <= branch.fills[1] < 1.0:
        raise NetworkError(f"{path.name}: scale, limit, range, fills or room make no sense. Remedy: train it again")
    return branch


@jit
def lift(state: Array, p: float, fill: float, basin: Basin, net: ViolentWeights, out: Array) -> None:
    """out (4,): r over m_T g, its deviation over m_T g, distance to the training data (1 at their edge), share of the branch;
    zeros where it has none.

    state: violent_memory; p: g_n/g − 1 at this instant."""
    z, basis = np.empty(WIDTH), np.empty(BASIS)
    Q = tell(state, p, basin, z, basis)
    out[:] = 0.0
    out[3] = share(state[UNEVEN], z[ENERGY])
    if out[3] == 0.0:
        return
    z[SPACE] = fill
    beyond = 0.0
    for k in range(WIDTH):
        z[k] = (z[k] - net.shift[k]) / net.scale[k]
        half = 0.5 * (net.high[k] - net.low[k])
        if out[3] >= RULES:
            beyond = max(beyond, abs(z[k] - 0.5 * (net.high[k] + net.low[k])) / half)
        z[k] = min(max(z[k], net.low[k]), net.high[k])  # beyond the data their edge holds
    sharp = 0.5 * net.sharpness * net.sharpness
    count = net.noise.size
    distance, least = np.empty(count), np.inf
    for j in range(count):
        d = 0.0
        for k in range(WIDTH):
            d += (z[k] - net.centres[j, k]) ** 2
        distance[j] = sharp * d
        least = min(least, distance[j])
    total, value, noise = 0.0, 0.0, 0.0
    for j in range(count):
        far = distance[j] - least
        if far > 20.0:  # a part in 5e8
            continue
        g = math.exp(-far)
        row = 0.0
        for k in range(BASIS):
            row += net.weights[j, k] * basis[k]
        total += g
        value += g * row
        noise += g * net.noise[j]
    out[0] = Q * min(max(value / total, -net.limit), net.limit)
    out[1] = Q * noise / total
    out[2] = beyond
