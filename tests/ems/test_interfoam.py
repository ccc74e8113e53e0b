"""Against a two-phase Navier-Stokes solution (interfoam.csv): signs, size, and what the parametric equations add.

Case B: pitch of 1 degree at 3.14 rad/s, smooth start, 3 s. Case C06: pitch of 4 degrees and plunge of 7.5 mm at 6.28 rad/s, first
second, before the surface breaks. Their wave heights are 0.6 and 1.2 of the edge of linear slosh: some per cent may differ.
"""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.slosh_ems.linear import LinearSlosh
from aeroslosh.fmus.slosh_ems.parametric import ParametricSlosh
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes, stokes_damping
from aeroslosh.fmus.tank.motion import SectionMotion, course

DATA = Path(__file__).with_name("interfoam.csv")


def gaps(kind: type[LinearSlosh], case: str) -> np.ndarray:
    """Root mean square difference of (force_x, force_y, moment) over the standard deviation of interFoam's."""
    with DATA.open(encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(line for line in file if not line.startswith("#")) if row["case"] == case]
    tank = Tank(length=0.5, height=0.15)
    parameters = modes(tank, 20)
    model = kind(tank, parameters, stokes_damping(tank, parameters.omega, 1e-6))
    motion, time, loads = SectionMotion(), 0.0, []
    w = model.start(motion)
    for row in rows:
        end = SectionMotion(*(float(row[name]) for name in SectionMotion._fields[:6]))
        step = float(row["t"]) - time
        w = model.advance(w, course(motion, end, step), step)
        motion, time = end, float(row["t"])
        loads.append(model.load(w, motion))
    exact = np.array([[float(row[name]) for name in ("force_x", "force_y", "moment")] for row in rows])
    return np.asarray((np.array(loads) - exact).std(axis=0) / exact.std(axis=0))


@pytest.mark.parametrize(
    ("kind", "case", "edges"),
    [
        (LinearSlosh, "B", (0.035, 1.01, 0.015)),  # the linear vertical force does not change
        (ParametricSlosh, "B", (0.035, 0.20, 0.015)),
        (LinearSlosh, "C06", (0.055, 0.30, 0.04)),
        (ParametricSlosh, "C06", (0.025, 0.035, 0.02)),
    ],
    ids=["linear B", "parametric B", "linear C06", "parametric C06"],
)
def test_loads_before_the_surface_breaks(kind: type[LinearSlosh], case: str, edges: tuple[float, ...]) -> None:
    seen = gaps(kind, case)
    print(kind.__name__, case, *(f"{100 * value:.1f} %" for value in seen))
    np.testing.assert_array_less(seen, edges)
