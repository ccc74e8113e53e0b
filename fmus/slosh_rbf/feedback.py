"""Networks with output feedback, as in the paper: the next load from delayed motions and delayed loads, at one fixed step.

    y(k) = f(u(k) … u(k − m), y(k − 1) … y(k − n))

f is linear (ARX: Billings, Nonlinear System Identification (2013)) or radial basis functions with a constant and no linear part
(Srivastava, Damodaran and Khoo, eq. 21-23: m = 5, n = 3, step 0.02 s). u is the motion itself (h/l, alpha), as in the paper, or
the drive that the liquid feels (memory.drive); y are loads over m_T g, a moment over m_T g l. Errors are fed back, so one step
ahead and free run differ. Gaussians are bounded, so their loads are, with any weights; a linear network whose own feedback grows
is refused (`check`).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..kit.compiled import jit
from .memory import Array
from .network import FORMAT, NetworkError, of_kind, write_archive

KIND = "feedback"
ARRAYS = ("shift", "scale", "output_shift", "output_scale", "linear", "centres", "weights")

INPUTS = {"motion": 2, "drive": 4}
"""Columns of u: (h/l, alpha), or (f_x/g, gamma, (l/2)alpha''/g, (l/2)alpha'²/g)."""


@dataclass(frozen=True)
class Feedback:
    """A network with output feedback.

    inputs       "motion" or "drive"; delays of inputs m and outputs n; step over sqrt(l/g)
    shift, scale of the regressor (INPUTS (m + 1) + outputs n,), and of the outputs (outputs,)
    linear       (regressors + 1, outputs), constant last; nothing of it but the constant is used with Gaussians
    centres      (M, regressors) in scaled units, spread, weights (M, outputs)
    shape, room  depth and height over length of the tank trained on"""

    name: str
    inputs: str
    delays: tuple[int, int]
    step: float
    shift: Array
    scale: Array
    output_shift: Array
    output_scale: Array
    linear: Array
    centres: Array
    spread: float
    weights: Array
    shape: float
    room: float
    about: dict[str, Any] = field(default_factory=dict)

    @property
    def outputs(self) -> int:
        """Loads at an instant."""
        return len(self.output_shift)

    @property
    def width(self) -> int:
        """Numbers in a regressor."""
        return INPUTS[self.inputs] * (self.delays[0] + 1) + self.outputs * self.delays[1]

    def radius(self) -> float:
        """Spectral radius of the linear feedback: below 1 bounded motion gives bounded loads."""
        n, first, outputs = self.delays[1], INPUTS[self.inputs] * (self.delays[0] + 1), self.outputs
        if len(self.centres) or n == 0:
            return 0.0
        companion = np.zeros((outputs * n, outputs * n))
        block = self.linear[first:-1] / self.scale[first:, None] * self.output_scale
        companion[:outputs] = block.T
        companion[outputs:, :-outputs] = np.eye(outputs * (n - 1))
        return float(np.abs(np.linalg.eigvals(companion)).max())

    def check(self) -> None:
        """Raise NetworkError for arrays that do not fit, are not finite, or a linear feedback that grows."""
        wanted = (
            (self.shift, (self.width,)), (self.scale, (self.width,)), (self.output_scale, (self.outputs,)),
            (self.output_shift, (self.outputs,)), (self.linear, (self.width + 1, self.outputs)),
            (self.centres, (len(self.weights), self.width)), (self.weights, (len(self.weights), self.outputs)),
        )  # fmt: skip
        good = all(array.shape == shape and np.isfinite(array).all() for array, shape in wanted)
        if not good or not np.all(self.scale > 0.0) or not 0.0 < self.spread < np.inf:
            raise NetworkError(f"network '{self.name}': arrays do not fit or are not finite. Remedy: train it again")
        if self.radius() >= 1.0:
            raise NetworkError(
                f"network '{self.name}': its feedback grows by {self.radius():.4f} a step: loads would have no bound. Remedy: "
                "train it on more or longer records, or with more ridge"
            )


def save(net: Feedback, path: Path) -> None:
    """Write a numpy archive (no pickles), whole or not at all."""
    text = {n: getattr(net, n) for n in ("name", "inputs", "delays", "step", "spread", "shape", "room", "about")}
    write_archive(path, {"format": FORMAT, "kind": KIND, **text}, {n: getattr(net, n) for n in ARRAYS})


def load(path: Path) -> Feedback:
    """Read a network that `save` wrote. Raises NetworkError for another file, and what `check` raises."""
    try:
        text, arrays = of_kind(path, KIND)
        net = Feedback(**{**text, "delays": tuple(text["delays"])}, **arrays)
    except Exception as error:  # numpy, json and zipfile raise a dozen kinds
        raise NetworkError(f"{path.name} is no network with feedback: {error}. Remedy: give a file that `train` wrote") from None
    net.check()
    return net


def columns(inputs: str, drives: Array, motions: Array, length: float) -> Array:
    """u of many samples: drives (n, 5), motions (n, 9). Shape: (n, INPUTS)."""
    return np.stack([motions[:, 0] / length, motions[:, 3]], axis=1) if inputs == "motion" else drives[:, :4]


def regressors(u: Array, y: Array, delays: tuple[int, int]) -> Array:
    """The regressors of the samples k ≥ max(delays), newest first. u (n, inputs), y (n, outputs). Shape: (n − max, width).

    Raises NetworkError for records of different lengths, or no longer than the delays."""
    m, n = delays
    first, total = max(delays), len(u)
    if u.ndim != 2 or y.ndim != 2 or len(y) != total or total <= first:
        raise NetworkError(
            f"inputs {u.shape}, loads {y.shape}, delays {m} and {n}. Remedy: tables as long as each other, and longer"
        )
    parts = [u[first - j : total - j] for j in range(m + 1)] + [y[first - j : total - j] for j in range(1, n + 1)]
    return np.hstack(parts)


def free_run(net: Feedback, u: Array, start: Array) -> Array:
    """Loads (n, outputs) from the inputs (n, inputs) alone; the sample before the first ones is u[0] with the loads `start`
    (outputs,), for ever. Raises NetworkError for other shapes."""
    if u.ndim != 2 or u.shape[1] != INPUTS[net.inputs] or not len(u) or np.shape(start) != (net.outputs,):
        raise NetworkError(f"network '{net.name}': inputs {u.shape}, start {np.shape(start)}. Remedy: {_wants(net)}")
    m, n = net.delays
    padded = np.vstack([np.repeat(u[:1], m, axis=0), u])
    out = np.tile(start, (len(u) + n, 1))
    _march(padded, out, m, n, net.shift, net.scale, net.output_shift, net.output_scale, net.linear, net.centres,
           1.0 / net.spread, net.weights)  # fmt: skip
    return out[n:]


def one_step(net: Feedback, X: Array) -> Array:
    """Loads (k, outputs) from regressors (k, width) with the true earlier loads. Raises NetworkError for other shapes."""
    if X.ndim != 2 or X.shape[1] != net.width:
        raise NetworkError(f"network '{net.name}': regressors {X.shape}. Remedy: {_wants(net)}")
    z = (X - net.shift) / net.scale
    if len(net.centres):
        scaled = gaussians(z, net.centres, net.spread) @ net.weights + net.linear[-1]
    else:
        scaled = z @ net.linear[:-1] + net.linear[-1]
    return scaled * net.output_scale + net.output_shift


def gaussians(z: Array, centres: Array, spread: float) -> Array:
    """exp(−|z − c|²/(2 spread²)) of scaled regressors (k, width) and centres (M, width). Shape: (k, M)."""
    square = (z**2).sum(axis=1)[:, None] + (centres**2).sum(axis=1) - 2.0 * z @ centres.T
    return np.exp(-0.5 * np.maximum(square, 0.0) / spread**2)


def _wants(net: Feedback) -> str:
    return f"{INPUTS[net.inputs]} inputs '{net.inputs}', {net.outputs} loads, {net.width} regressors"


@jit
def _march(
    u: Array, y: Array, m: int, n: int, shift: Array, scale: Array, output_shift: Array, output_scale: Array, linear: Array,
    centres: Array, sharpness: float, weights: Array,
) -> None:  # fmt: skip
    """Fill y from row n on; u has m rows more in front than samples, y has n."""
    inputs, width, outputs = u.shape[1], shift.size, output_shift.size
    z, scaled = np.empty(width), np.empty(outputs)
    for k in range(len(u) - m):
        at = 0
        for j in range(m + 1):
            for i in range(inputs):
                z[at] = (u[k + m - j, i] - shift[at]) / scale[at]
                at += 1
        for j in range(1, n + 1):
            for i in range(outputs):
                z[at] = (y[k + n - j, i] - shift[at]) / scale[at]
                at += 1
        for i in range(outputs):
            scaled[i] = linear[width, i]
        if len(centres) == 0:
            for at in range(width):
                for i in range(outputs):
                    scaled[i] += linear[at, i] * z[at]
        for c in range(len(centres)):
            distance = 0.0
            for at in range(width):
                distance += (z[at] - centres[c, at]) ** 2
            phi = np.exp(-0.5 * distance * sharpness * sharpness)
            for i in range(outputs):
                scaled[i] += weights[c, i] * phi
        for i in range(outputs):
            y[k + n, i] = scaled[i] * output_scale[i] + output_shift[i]
