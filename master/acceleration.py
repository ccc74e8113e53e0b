"""Relaxation of a fixed-point iteration x ← H(x): what to try next, given x and the residual r = H(x) − x.

A relaxation is a small class with a `name`, `start()` (a new time step) and `next(x, r)`. Quasi-Newton ones
(IQN-ILS) fit the same face.
"""

from __future__ import annotations

from typing import Protocol

import numpy as np


class Relaxation(Protocol):
    """The face of a relaxation."""

    name: str

    def start(self) -> None:
        """Forget what belongs to the step before."""

    def next(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        """The next iterate. x, r scaled to comparable magnitudes, shape (n_coupled,)."""


class Constant:
    """x + factor r."""

    name = "constant"

    def __init__(self, factor: float = 1.0) -> None:
        self.factor = factor

    def start(self) -> None:
        """Nothing to forget."""

    def next(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        """x + factor r."""
        return x + self.factor * r


class Aitken:
    """Dynamic relaxation after Aitken (Küttler and Wall, Comput. Mech. 43, 2008, doi
    10.1007/s00466-008-0255-5).

    The factor follows from two successive residuals; the first pass of a step takes the full residual,
    since with a good predictor and light added mass it nearly solves the step. The factor is kept within ±`limit`.
    """

    name = "aitken"

    def __init__(self, first: float = 1.0, limit: float = 4.0) -> None:
        self.first, self.limit = first, limit
        self.start()

    def start(self) -> None:
        """Forget the residual of the step before."""
        self._factor = self.first
        self._r: np.ndarray | None = None

    def next(self, x: np.ndarray, r: np.ndarray) -> np.ndarray:
        """x + ω r with ω from the change of the residual."""
        if self._r is not None:
            change = r - self._r
            size = float(change @ change)
            if size > 0.0:
                factor = -self._factor * float(self._r @ change) / size
                self._factor = float(np.clip(factor, -self.limit, self.limit)) or self.first
        self._r = r.copy()
        return x + self._factor * r
