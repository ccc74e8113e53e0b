"""Acceleration of a fixed-point iteration x ← H(x): what to try next, given x and the residual r = H(x) − x.

An acceleration is a small class with a `name`, `reset()` (a new march), `start()` (a new time step), `next(x, r, size)`, `end()`
(the step is done) and `state()`, `restore()` for checkpoints. `size` holds the magnitudes in which the entries are compared.
All arrays have shape (n_coupled,).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from .quasi_newton import least_squares


class Acceleration(Protocol):
    """The interface of an acceleration."""

    name: str

    def reset(self) -> None:
        """Forget everything."""

    def start(self) -> None:
        """A new time step, or the same again."""

    def next(self, x: np.ndarray, r: np.ndarray, size: np.ndarray) -> np.ndarray:
        """The next iterate."""

    def end(self) -> None:
        """The step is done: keep of it what helps the next ones."""

    def state(self) -> dict[str, np.ndarray]:
        """What `restore` needs between two steps."""

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""


class _Memoryless:
    """What accelerations share that carry nothing from step to step."""

    def reset(self) -> None:
        """Nothing to forget."""

    def start(self) -> None:
        """Nothing to forget."""

    def end(self) -> None:
        """Nothing to keep."""

    def state(self) -> dict[str, np.ndarray]:
        """Nothing."""
        return {}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Nothing."""


class Constant(_Memoryless):
    """x + factor r; the plain fixed point with factor 1."""

    name = "constant"

    def __init__(self, factor: float = 1.0) -> None:
        self.factor = factor

    def next(self, x: np.ndarray, r: np.ndarray, size: np.ndarray) -> np.ndarray:
        """x + factor r."""
        return x + self.factor * r


class Aitken(_Memoryless):
    """Dynamic relaxation after Aitken (Küttler and Wall, Comput. Mech. 43, 2008, doi 10.1007/s00466-008-0255-5).

    The factor follows from two successive residuals; the first pass of a step takes `first` times the residual: all of it by
    default, since with a good predictor and light added mass it nearly solves the step. The factor stays within ±`limit`.
    """

    name = "aitken"

    def __init__(self, first: float = 1.0, limit: float = 4.0) -> None:
        self.first, self.limit = first, limit
        self.start()

    def start(self) -> None:
        """Forget the residual of the step before."""
        self._factor = self.first
        self._r: np.ndarray | None = None

    def next(self, x: np.ndarray, r: np.ndarray, size: np.ndarray) -> np.ndarray:
        """x + ω r with ω from the change of the residual."""
        scaled = r / size
        if self._r is not None:
            change = scaled - self._r
            length = float(change @ change)
            if length > 0.0:
                factor = -self._factor * float(self._r @ change) / length
                self._factor = float(np.clip(factor, -self.limit, self.limit)) or self.first
        self._r = scaled
        return x + self._factor * r


class QuasiNewton:
    """IQN-ILS: the inverse Jacobian by least squares over the differences of earlier passes (Degroote, Bathe and Vierendeels,
    Comput. Struct. 87, 2009, doi 10.1016/j.compstruc.2008.11.013).

    Differences of the last `reuse` steps are used too, newest first. A column that depends on newer ones (what is left of it
    after orthogonalisation is below `filter` of its length) is left out (Haelterman et al., Comput. Struct. 171, 2016, doi
    10.1016/j.compstruc.2016.04.001). A linear loop in n quantities is solved in n + 2 passes or fewer. While there are no
    columns, the residual is taken `first` times.
    """

    name = "iqn-ils"

    def __init__(self, first: float = 1.0, reuse: int = 8, filter: float = 1e-6) -> None:
        self.first, self.reuse, self.filter = first, reuse, filter
        self.dropped = 0
        self.reset()

    def reset(self) -> None:
        """Forget all columns."""
        self._steps: list[list[tuple[np.ndarray, np.ndarray]]] = []  # newest step first, each newest column first
        self.start()

    def start(self) -> None:
        """A new step: no differences in it yet."""
        self._x: np.ndarray | None = None
        self._r: np.ndarray | None = None
        self._now: list[tuple[np.ndarray, np.ndarray]] = []

    def next(self, x: np.ndarray, r: np.ndarray, size: np.ndarray) -> np.ndarray:
        """x + r + W c, with c from V c ≈ −r; V, W are the changes of r and of H(x) = x + r."""
        if self._x is not None and self._r is not None:
            change = r - self._r
            if change.any():
                self._now.insert(0, (change, x + r - self._x - self._r))
        self._x, self._r = x.copy(), r.copy()
        columns = [column for step in (self._now, *self._steps) for column in step]
        if not columns:
            return x + self.first * r
        update, dropped = least_squares(columns, r, size, self.filter)
        self.dropped += dropped
        return x + r + update

    def end(self) -> None:
        """Keep this step's columns, forget those of the oldest."""
        self._steps = [step for step in [self._now, *self._steps] if step][: self.reuse]
        self.start()

    def state(self) -> dict[str, np.ndarray]:
        """The columns of the last steps. `counts`: columns a step; V, W with shape (n_columns, n_coupled)."""
        columns = [column for step in self._steps for column in step]
        V, W = (np.array([column[i] for column in columns]) for i in (0, 1))
        return {"counts": np.array([len(step) for step in self._steps], dtype=np.int64), "V": V, "W": W}

    def restore(self, state: Mapping[str, np.ndarray]) -> None:
        """Return to a `state`."""
        self.reset()
        columns = iter(zip(state["V"], state["W"], strict=True))
        self._steps = [[next(columns) for _ in range(count)] for count in state["counts"]]


def make(name: str, first: float, reuse: int, filter: float) -> Acceleration:
    """The acceleration called `name`: constant, aitken or iqn-ils."""
    if name == QuasiNewton.name:
        return QuasiNewton(first, reuse, filter)
    return Constant(first) if name == Constant.name else Aitken(first)
