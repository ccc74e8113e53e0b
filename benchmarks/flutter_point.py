"""A flutter point through FMUs and master: Isogai A, Mach 0.825, V_f 0.612, 2 + 5 cycles, 8,064 cells."""

from __future__ import annotations

import resource
import statistics
import time
from pathlib import Path

from aeroslosh.master.case import case as cases
from aeroslosh.master.flutter import march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus

from .exchange import exchange

ROOT = Path(__file__).resolve().parents[1]
SU2_SECONDS_A_STEP = 0.36
"""CPU of an aeroelastic step of SU2 8.0.0 with well-chosen settings (6,532 points, 14 inner iterations), on another machine."""


def run(repeat: int = 5) -> None:
    """Print CPU seconds, shares and memory."""
    case = cases.load(ROOT / "cases" / "isogai_a.toml")
    begin = time.process_time()
    with FlutterSetup(case, find_fmus(ROOT / "dist" / "fmus"), case.flow.mach) as setup:
        opened = time.process_time() - begin
        march.march(setup, case.flutter.V_f)
        marches = [march.march(setup, case.flutter.V_f).cost for _ in range(repeat)]
        steps = marches[0].steps
        total = statistics.median(cost.total_cpu for cost in marches)
        overhead = statistics.median(exchange(setup, case.flutter.V_f) for _ in range(repeat))
        su2 = SU2_SECONDS_A_STEP * steps
        memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
        print(f"  flutter point after the steady start {total:8.2f} s CPU, {steps} steps of {1e3 * total / steps:.2f} ms")
        print(f"  first use at a Mach number           {opened:8.2f} s CPU: load, cached kernels, mesh, steady flow")
        print(
            f"  FMI and master                       {100 * overhead * steps / total:8.1f} % of a step, {1e6 * overhead:.0f} µs"
        )
        print(f"  SU2, as many steps                   {su2:8.0f} s CPU on another machine: {su2 / total:.0f} times as much")
        print(f"  peak memory                          {memory:8.0f} MiB: one process, master and both FMUs")
