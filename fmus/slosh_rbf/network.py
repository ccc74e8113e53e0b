"""The surrogate: modal memory, bilinear base, a linear tail on odd and even features, and radial basis functions.

    load = base + tail · features + sum_j W_j [phi_j(z) ∓ phi_j(M z)]
    phi_j(z) = exp(−sum_k ((z_k − c_jk) / (q_k sigma_j))² / 2)

The Gaussians are the network of Srivastava, Damodaran and Khoo (their eq. 22-23; Moody and Darken, Neural Comput. 1 (1989) 281,
doi:10.1162/neco.1989.1.2.281), one spread a centre and one scale a coordinate; M is the mirror, minus for force along and moment,
plus for force up. Nothing is fed back: one step ahead and free run are the same, and bounded motion gives bounded loads with any
weights: the memory is bounded (slosh_rbf.memory), the base and the features are polynomials in it, and the correction is clipped.

Baselines are the same model with less: without corrections ("bilinear"), without products of gamma ("ems"), without Gaussians
("quadratic").
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ..kit.cache import argument
from ..kit.compiled import jit
from .body import Body, base_load
from .memory import Array, Complex
from .readout import EVEN, MIRROR, ODD, SPACE, features

FORMAT = 1


class NetworkError(ValueError):
    """A network that cannot be used; the text says why and the remedy."""


@argument
class Weights(NamedTuple):
    """What the kernels need of a network.

    odd (ODD, 2): along, moment; even (EVEN,): up; centres (m, SPACE), sharpness (m,): inverse spreads, inverse_scales (SPACE,);
    turning (m, 2), lifting (m,): weights of the Gaussians, still (m,): their pairs' values at rest; limits (3,): largest
    corrections."""

    bilinear: bool
    odd: Array
    even: Array
    centres: Array
    sharpness: Array
    inverse_scales: Array
    turning: Array
    lifting: Array
    still: Array
    limits: Array


@dataclass(frozen=True)
class Network:
    """A trained surrogate. All arrays are dimensionless; `about` tells how it came to be (tank, data, errors, command).

    reach (SPACE,): largest |z| of the training data; shape, room: depth and height over length of the tank trained on."""

    name: str
    weights: Weights
    reach: Array
    shape: float
    room: float
    about: dict[str, Any] = field(default_factory=dict)

    def save(self, path: Path) -> None:
        """Write a numpy archive (no pickles), whole or not at all."""
        about = {"format": FORMAT, "name": self.name, "shape": self.shape, "room": self.room, "about": self.about}
        arrays = {name: np.asarray(value) for name, value in self.weights._asdict().items()}
        write_archive(path, about, {"reach": self.reach, **arrays})


def write_archive(path: Path, about: Mapping[str, Any], arrays: Mapping[str, Array]) -> None:
    """A numpy archive (no pickles) of `arrays` and the JSON text `about`, whole or not at all."""
    text = json.dumps(about, sort_keys=True).encode()
    part = path.with_name(f".{path.name}.part-{os.getpid()}")
    try:
        with part.open("wb") as file:
            np.savez_compressed(file, text=np.frombuffer(text, np.uint8), **arrays)  # type: ignore[arg-type]
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def read_archive(path: Path) -> tuple[Any, dict[str, Array]]:
    """What `write_archive` wrote: the text and the arrays. Raises what numpy, json and zipfile raise."""
    with np.load(path, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    return json.loads(arrays.pop("text").tobytes()), arrays


def of_kind(path: Path, kind: str) -> tuple[dict[str, Any], dict[str, Any]]:
    """The same of an archive of this kind, without format and kind. Raises ValueError for another one, and like
    `read_archive`."""
    text, arrays = read_archive(path)
    if (text.pop("format"), text.pop("kind")) != (FORMAT, kind):
        raise ValueError("another kind or format")
    return text, arrays


def untrained(name: str, bilinear: bool) -> Network:
    """The base alone: "ems" (linear) or "bilinear"; it may be used anywhere."""
    weights = Weights(
        bilinear, np.zeros((ODD, 2)), np.zeros(EVEN), np.zeros((0, SPACE)), np.zeros(0), np.ones(SPACE), np.zeros((0, 2)),
        np.zeros(0), np.zeros(0), np.zeros(3),
    )  # fmt: skip
    return Network(name, weights, np.full(SPACE, np.inf), 0.0, 0.0, {"kind": "equations alone"})


def load(path: Path) -> Network:
    """Read a network. Raises NetworkError for a file that is none, or whose arrays do not fit or are not finite."""
    try:
        text, arrays = read_archive(path)
        reach = arrays.pop("reach")
        weights = Weights(bool(arrays.pop("bilinear")), **arrays)
        m = len(weights.sharpness)
        if not isinstance(text, dict):
            raise ValueError("its text is no table")
    except OSError as error:
        raise NetworkError(f"the network {path.name} cannot be read: {error}. Remedy: give a file that `train` wrote") from None
    except Exception as error:  # numpy and zipfile raise a dozen kinds
        raise NetworkError(f"{path.name} is no network: {error}. Remedy: give a file that `train` wrote") from None
    if text.get("format") != FORMAT:
        raise NetworkError(f"{path.name} has format {text.get('format')}, not {FORMAT}. Remedy: train it again")
    wanted = ((ODD, 2), (EVEN,), (m, SPACE), (m,), (SPACE,), (m, 2), (m,), (m,), (3,))
    for name, array, shape in zip(weights._fields[1:], weights[1:], wanted, strict=True):
        if array.shape != shape or not np.isfinite(array).all():
            raise NetworkError(f"{path.name}: {name} has shape {array.shape} or is not finite. Remedy: train it again")
    depth, room = (float(v) if isinstance(v := text.get(n), float) else 0.0 for n in ("shape", "room"))
    sound = reach.shape == (SPACE,) and bool(np.all(reach > 0.0)) and bool(np.all(weights.limits >= 0.0))
    if not sound or not 0.0 < depth < np.inf or not 0.0 < room < np.inf:
        raise NetworkError(f"{path.name}: reach, limits, shape or room make no sense. Remedy: train it again")
    return Network(str(text.get("name", path.stem)), weights, reach, depth, room, dict(text.get("about", {})))


@jit
def correction(odd: Array, even: Array, space: Array, net: Weights, out: Array) -> None:
    """The trained part of the load (3,), clipped."""
    along, up, moment = 0.0, 0.0, 0.0
    for i in range(ODD):
        along += net.odd[i, 0] * odd[i]
        moment += net.odd[i, 1] * odd[i]
    for i in range(EVEN):
        up += net.even[i] * even[i]
    for j in range(net.sharpness.size):
        here, there = 0.0, 0.0
        for k in range(SPACE):
            z, c = space[k] * net.inverse_scales[k], net.centres[j, k] * net.inverse_scales[k]
            here += (z - c) ** 2
            there += (z * MIRROR[k] - c) ** 2
        sharp = -0.5 * net.sharpness[j] ** 2
        here, there = np.exp(sharp * here), np.exp(sharp * there)
        along += net.turning[j, 0] * (here - there)
        moment += net.turning[j, 1] * (here - there)
        up += net.lifting[j] * (here + there - net.still[j])  # nothing at rest
    out[0] = min(max(along, -net.limits[0]), net.limits[0])
    out[1] = min(max(up, -net.limits[1]), net.limits[1])
    out[2] = min(max(moment, -net.limits[2]), net.limits[2])


@jit
def read_out(w: Complex, rows: Array, body: Body, net: Weights, space: Array, out: Array) -> None:
    """Load (3,) in tank axes over m_T g and m_T g l; `space` (SPACE,) receives the coordinates."""
    odd, even, more = np.empty(ODD), np.empty(EVEN), np.empty(3)
    features(w, rows, body, odd, even, space)
    base_load(w, rows, body, net.bilinear, out)
    correction(odd, even, space, net, more)
    for i in range(3):
        out[i] += more[i]
