"""Polynomial extrapolation of values from step to step."""

from __future__ import annotations

import numpy as np

WEIGHTS = {0: (1.0,), 1: (2.0, -1.0), 2: (3.0, -3.0, 1.0)}  # of y_n, y_{n-1}, y_{n-2}


class Extrapolation:
    """Of `order` 0, 1 or 2 through the last values, at equal steps. `past`: the values, newest first. Shape: (order + 1, n)."""

    def __init__(self, order: int, now: np.ndarray) -> None:
        self._weights = np.array(WEIGHTS[order])
        self.past = np.tile(now, (order + 1, 1))  # the march starts at rest

    def next(self) -> np.ndarray:
        """A step further. Shape: (n,)."""
        return self._weights @ self.past

    def push(self, now: np.ndarray) -> None:
        """The values a step further are these."""
        self.past[1:] = self.past[:-1].copy()
        self.past[0] = now
