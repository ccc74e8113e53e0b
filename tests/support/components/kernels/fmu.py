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
        self.y = scaled_sum(np.ones(10))
        self.hits = sum(scaled_sum.stats.cache_hits.values())
        self.misses = sum(scaled_sum.stats.cache_misses.values())

    def step(self, time: float, step_size: float) -> None:
        """Do nothing."""
