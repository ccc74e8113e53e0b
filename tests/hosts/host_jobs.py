"""What the five FMUs are asked to do in other tools: small grids, a motion that moves everything, a step that no tool rounds."""

from __future__ import annotations

import math
import os
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
LAUNCH = [
    "env",
    f"PYTHONPATH={ROOT}",
    sys.executable,
    "-m",
    "aeroslosh.master.hosts.launcher",
]  # from any folder

STEP = 2.0**-9  # s: a whole number of nanoseconds, in which libcosim counts, and exact in binary: times are the same in all tools
POINTS = 13


def _wave(amplitude: float, phase: float) -> list[float]:
    """Samples of a smooth signal that is 0 at the start."""
    return [amplitude * math.sin(0.4 * i) * math.cos(phase * i) for i in range(POINTS)]


MOTION = {"h_dot": _wave(0.2, 0.1), "h_ddot": _wave(3.0, 0.2), "alpha": _wave(0.03, 0.0), "alpha_dot": _wave(0.5, 0.3)}
LOADS = ["force_x", "force_y", "moment"]
TANK = {"tank_length": 0.4, "fill_level": 0.4}
SHAKEN = {**MOTION, "x_ddot": _wave(2.0, 0.15)}
# FMU → parameters, inputs, outputs
JOBS: dict[str, tuple[dict[str, Any], dict[str, list[float]], list[str]]] = {
    "structure": (
        {"forced_cycles": 0.1, "load_prediction": 1, "damping_ratio_h": 0.01},
        {"lift": _wave(5e3, 0.1), "moment": _wave(800.0, 0.2)},
        ["h", "h_dot", "alpha", "alpha_ddot", "energy"],
    ),
    "aero": ({"mach": 0.6, "cells_around": 64, "cells_normal": 16}, MOTION, ["lift", "moment", "C_L", "C_M", "C_D"]),
    "slosh_ems": ({**TANK, "modes": 20, "damping_ratio": 0.01, "parametric": True}, SHAKEN, [*LOADS, "wave_height_west"]),
    "slosh_rbf": ({**TANK, "gravity": 9.0}, SHAKEN, [*LOADS, "wave_height_west", "validity"]),
    "slosh_vof": ({**TANK, "cells_x": 16, "cells_y": 16}, SHAKEN, [*LOADS, "wave_height_west", "liquid_volume"]),
}


def job(name: str, fmu: str) -> dict[str, Any]:
    """The job of the FMU `name`, which lies at `fmu`, for tools.py."""
    parameters, inputs, outputs = JOBS[name]
    return {"fmu": fmu, "parameters": parameters, "inputs": inputs, "step": STEP, "outputs": outputs}


def table(name: str, points: int = POINTS) -> str:
    """The job's inputs as the table that the C host reads."""
    inputs = JOBS[name][1]
    rows = [",".join([repr(i * STEP), *(repr(values[i]) for values in inputs.values())]) for i in range(points)]
    return "\n".join([",".join(["time", *inputs]), *rows, ""])


def settings(name: str) -> list[str]:
    """The job's parameters as words for the C host."""
    return [f"{key}={str(value).lower() if isinstance(value, bool) else repr(value)}" for key, value in JOBS[name][0].items()]


def clean(**more: str) -> dict[str, str]:
    """This environment without what a test runner may have put there for Python, and with `more`."""
    return {key: value for key, value in os.environ.items() if key not in ("PYTHONPATH", "PYTHONHOME", "LD_PRELOAD")} | more
