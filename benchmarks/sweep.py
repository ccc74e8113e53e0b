"""64 points of a sweep on one local worker and on two: seconds of wall time, worker start included.

Real FMUs on a small mesh (64 x 16 cells), 4 fill levels x 16 V_f; the numbers of both runs are compared bit by bit elsewhere
(tests/master/sweeps/test_same_numbers.py). Needs two idle cores."""

from __future__ import annotations

import statistics
import time

import aeroslosh as ae


def seconds(workers: int) -> float:
    """Wall time of the sweep."""
    case = ae.Case.load("fill_sweep").replace(
        aero={"cells_around": 64, "cells_normal": 16}, flutter={"free_cycles": 8.0}, output={"pictures": False}
    )
    swept = {
        "slosh.fill_level": {"from": 0.2, "to": 0.8, "count": 4},
        "flutter.V_f": {"from": 0.4, "to": 0.8, "count": 16},
    }
    begin = time.perf_counter()
    ae.sweep(case, swept, workers=workers)
    return time.perf_counter() - begin


def run(repeat: int = 3) -> None:
    """Print medians and the ratio; one worker and two take turns, so that other load hits both."""
    seconds(2)  # kernels into the cache
    pairs = [(seconds(1), seconds(2)) for _ in range(repeat)]
    one, two = (statistics.median(column) for column in zip(*pairs, strict=True))
    print(f"  64 points on 1 worker  {one:7.1f} s")
    print(f"  64 points on 2 workers {two:7.1f} s: {one / two:.2f} times faster")
