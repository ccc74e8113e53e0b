"""Slosh in a moving tank, two-phase: cost of a time step, and the same cases by interFoam (OpenFOAM) where it is installed.

Same tank, mesh, motion, simulated time and largest Courant number, one thread each; runs alternate, medians of CPU time.
"""

from __future__ import annotations

import math
import statistics
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion

from . import interfoam
from .interfoam import Array, Case, to_section

TANK = Tank(0.5, 0.15)
REPEAT = 3
STEP = 0.01  # [s] of communication


def motion_of(case: Case) -> Callable[[int], SectionMotion]:
    """The case's motion at communication points, with rates and accelerations of the cubic spline that interFoam follows too."""
    if case.motion is None:
        return lambda k: SectionMotion()
    fine = STEP / 20
    n = math.ceil(case.duration / fine) + 1
    place: Array = to_section(case.motion.at(np.arange(n + 1, dtype=np.float64) * fine))
    rate = np.gradient(place, fine, axis=0, edge_order=2)
    bend = np.gradient(rate, fine, axis=0, edge_order=2)
    return lambda k: SectionMotion(*(float(a[20 * k, c]) for c in range(3) for a in (place, rate, bend)))


def ours(case: Case) -> tuple[float, int, int]:
    """March a case; returns CPU seconds, time steps, pressure iterations."""
    motion = motion_of(case)
    flow = Flow(Grid(TANK, case.cells_x, case.cells_y))
    begin = time.process_time()
    flow.start(motion(0), case.amplitude)
    steps = iterations = 0
    for k in range(round(case.duration / STEP)):
        report = flow.advance(motion(k), motion(k + 1), STEP)
        flow.loads(motion(k + 1))
        steps, iterations = steps + report.steps, iterations + report.iterations
    return time.process_time() - begin, steps, iterations


def run() -> None:
    """Print the table."""
    peer = interfoam.available()
    if not peer:
        print("  interFoam is not installed (Debian: apt-get install openfoam): our side alone")
    cells = ((100, 30), (200, 60))
    cases = {
        "A free wave of 2 mm, 4 s": (interfoam.case_a, 4.0),
        "B pitch 1 deg, 4 s": (interfoam.case_b, 4.0),
        "C06 pitch 4 deg + heave, 3 s, hits the roof": (interfoam.case_c06, 3.0),
    }
    for name, (make, duration) in cases.items():
        for mesh in cells:
            case = make(mesh, duration)
            ours(make(mesh, STEP))  # compiled code is loaded
            mine, theirs = [], []
            for _ in range(REPEAT if mesh[0] == 100 else 1):
                mine.append(ours(case))
                if peer:
                    with tempfile.TemporaryDirectory() as folder:
                        interfoam.write(case, Path(folder))
                        result = interfoam.run(Path(folder))
                    theirs.append((result.cpu_seconds, result.steps))
            cpu = statistics.median(row[0] for row in mine)
            steps, iterations = mine[0][1], mine[0][2]
            text = f"  {name}, {mesh[0]}x{mesh[1]}: {cpu:.2f} s CPU, {1e3 * cpu / steps:.3f} ms a step"
            text += f" of {1e3 * case.duration / steps:.2f} ms, {iterations / steps:.1f} iterations"
            if peer:
                other = statistics.median(row[0] for row in theirs)
                ratio = other / theirs[0][1] / (cpu / steps)
                text += (
                    f"; interFoam {other:6.1f} s: {other / cpu:.0f} times the CPU a simulated second, {ratio:.0f} times a step"
                )
            print(text, flush=True)
