"""64 points of a sweep on one local worker and on two: seconds of wall time, worker start included.

Real FMUs on a small mesh (64 x 16 cells), 4 fill levels x 16 V_f; the numbers of both runs are compared bit by bit elsewhere
(tests/master/sweeps/test_same_numbers.py). Needs two idle cores."""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SET = ("aero.cells_around=64", "aero.cells_normal=16", "flutter.free_cycles=8.0")
SWEPT = ("slosh.fill_level=0.2:0.8:4", "flutter.V_f=0.4:0.8:16")


def seconds(workers: int) -> float:
    """Wall time of the whole command."""
    with tempfile.TemporaryDirectory() as folder:
        command = [sys.executable, "-m", "aeroslosh", "sweep", str(ROOT / "cases" / "fill_sweep.toml"), "--out", f"{folder}/s"]
        command += [word for text in SET for word in ("--set", text)] + [word for text in SWEPT for word in ("--grid", text)]
        begin = time.perf_counter()
        subprocess.run(
            [*command, "--workers", str(workers), "--quiet", "--no-pictures"], check=True, capture_output=True, cwd=ROOT
        )
        return time.perf_counter() - begin


def run(repeat: int = 3) -> None:
    """Print medians and the ratio; one worker and two take turns, so that other load hits both."""
    seconds(2)  # kernels into the cache
    pairs = [(seconds(1), seconds(2)) for _ in range(repeat)]
    one, two = (statistics.median(column) for column in zip(*pairs, strict=True))
    print(f"  64 points on 1 worker  {one:7.1f} s")
    print(f"  64 points on 2 workers {two:7.1f} s: {one / two:.2f} times faster")
