"""CPU time of calls, as medians."""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable


def cpu(call: Callable[[], object], repeat: int = 5, inner: int = 1) -> float:
    """Median CPU seconds of one call over `repeat` samples of `inner` calls, after one that is not counted."""
    call()
    samples = []
    for _ in range(repeat):
        begin = time.process_time()
        for _ in range(inner):
            call()
        samples.append((time.process_time() - begin) / inner)
    return statistics.median(samples)
