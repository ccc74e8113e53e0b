"""Cheap simulations for tests/rbf/test_dataset.py, and a run of theirs to kill: `python -m support.record_doubles FOLDER`."""

from __future__ import annotations

import os
import sys
import time
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from aeroslosh.fmus.slosh_rbf.training.dataset import Planned, generate
from aeroslosh.fmus.slosh_rbf.training.excitation import aprbs, sine
from aeroslosh.fmus.slosh_rbf.training.signals import instants

Array = np.ndarray
TIMES = instants(0.4, 2e-3)


def plan(count: int = 6, gain: float = 2.0, **settings: Any) -> list[Planned]:
    """`count` short records."""
    return [Planned(aprbs(k, TIMES, 1e-3, 1e-2), {"gain": gain, **settings}, "train") for k in range(1, count + 1)]


def weigh(parameters: Mapping[str, Any], times: Array, motions: Array) -> dict[str, Array]:
    """Loads as a lagged response to the accelerations: the sum of many terms, so that its last bits show any difference."""
    lag = np.exp(-5.0 * np.subtract.outer(times, times)) * (np.subtract.outer(times, times) >= 0.0)
    loads = parameters["gain"] * lag @ motions[:, 2::3]
    return dict(zip(("force_x", "force_y", "moment"), loads.T, strict=True))


def slowly(parameters: Mapping[str, Any], times: Array, motions: Array) -> dict[str, Array]:
    """As `weigh`, in a third of a second; tells its process in a file."""
    Path(parameters["folder"], f"worker-{os.getpid()}").touch()
    time.sleep(0.3 if times.size > 3 else 0.0)
    return weigh(parameters, times, motions)


def fragile(parameters: Mapping[str, Any], times: Array, motions: Array) -> dict[str, Array]:
    """Fails at large plunge, gives no number at larger, dies at the largest."""
    size = np.abs(motions[:, 0]).max()
    if size > 3.5:
        os._exit(9)
    if size > 2.5:
        return {"force_x": np.full(times.size, np.nan)}
    if size > 1.5:
        raise ValueError("the roof is gone")
    return weigh(parameters, times, motions)


def fragile_plan() -> list[Planned]:
    """Plunges of 1 to 4 m."""
    return [Planned(replace(sine(TIMES, 50.0, h=float(h)), name=f"h{h}"), {"gain": 1.0}, "train") for h in range(1, 5)]


if __name__ == "__main__":
    generate(plan(6, folder=sys.argv[1]), Path(sys.argv[1]), slowly, {"is": "slow"}, workers=2)
