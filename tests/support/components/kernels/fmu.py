"""A face over a compiled kernel: tells whether the compiled code came from the cache."""

from __future__ import annotations

import numpy as np

from ..kit.slave import Slave
from ..kit.variables import output
from .sums import scaled_sum


class Kernels(Slave):
    """Sums ten ones in a compiled kernel."""

    variables = (
        output("y", "1", "Twice the sum of ten ones"),
        output("hits", "", "Compiled functions found in the cache", type=int),
        output("misses", "", "Functions compiled", type=int),
    )

    def initialize(self) -> None:
        """Run the kernel."""
        self._sum(np.float64)

    def rehearse(self) -> None:
        """What the second step will call."""
        self._sum(np.float32)

    def _sum(self, kind: type) -> None:
        self.y = scaled_sum(np.ones(10, dtype=kind))
        self.hits = sum(scaled_sum.stats.cache_hits.values())
        self.misses = sum(scaled_sum.stats.cache_misses.values())

    def step(self, time: float, step_size: float) -> None:
        """From the second on: run it in single precision."""
        if time > 0.0:
            self._sum(np.float32)
