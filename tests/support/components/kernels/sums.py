"""Two kernels, one calling the other."""

import numpy as np

from ..kit.cache import jit

SCALE = 2.0


@jit
def scaled(x: float) -> float:
    """Return SCALE x."""
    return SCALE * x


@jit(fastmath=True)
def scaled_sum(values: np.ndarray, start: float = 0.0) -> float:
    """Return SCALE times the sum of `values`, and `start`."""
    total = start
    for i in range(values.size):
        total += scaled(values[i])
    return total
