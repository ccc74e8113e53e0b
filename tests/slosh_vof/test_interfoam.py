"""Signs and conversion of another solver's frame: OpenFOAM's interFoam, theta counter-clockwise, moment counter-clockwise."""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.motion import SectionMotion
from benchmarks.interfoam import case_b, from_section, to_section
from support.motions import march
from support.paths import DATA


def test_frames() -> None:
    """A point of the tank is at the same place in both frames; a force there has opposite moments."""
    surge, heave, theta = 0.3, 0.1, 0.2
    h, alpha, x = to_section(np.array([surge, heave, theta]))
    px, py = 0.25, -0.075
    other = (surge + px * math.cos(theta) - py * math.sin(theta), heave + px * math.sin(theta) + py * math.cos(theta))
    ours = (x + px * math.cos(alpha) + py * math.sin(alpha), -h - px * math.sin(alpha) + py * math.cos(alpha))
    assert ours == pytest.approx(other, abs=1e-15)
    fx, fy = 3.0, -7.0
    nose_up = py * fx - px * fy
    counter_clockwise = px * fy - py * fx
    np.testing.assert_allclose(from_section(np.array([fx, fy, nose_up])), [fx, fy, counter_clockwise], rtol=1e-14)


def test_one_second_of_pitch_against_interfoam() -> None:
    """Wrong signs would show as 200 %. Longer series: tests/validation."""
    theirs = np.genfromtxt(DATA / "interfoam_B_100x30.csv", delimiter=",", names=True, skip_header=2)
    t, step = case_b((50, 16)).motion.t, 0.01  # type: ignore[union-attr]
    table = to_section(case_b((50, 16)).motion.at(np.arange(0, 1.5, 1e-3)))  # type: ignore[union-attr]
    assert t[0] <= 0.0
    rates = np.gradient(table, 1e-3, axis=0, edge_order=2)
    bends = np.gradient(rates, 1e-3, axis=0, edge_order=2)

    def motion(time: float) -> SectionMotion:
        k = round(time / 1e-3)
        return SectionMotion(*(float(a[k, c]) for c in (0, 1, 2) for a in (table, rates, bends)))

    flow = Flow(Grid(Tank(0.5, 0.15), 50, 16))
    flow.start(motion(0.0))
    times, loads = march(flow, motion, 1.4, step)
    mine = from_section(loads[:, :3])
    for column, name in ((0, "fx"), (2, "mz")):
        reference = np.interp(times, theirs["t"], theirs[name])
        assert np.std(mine[:, column] - reference) < 0.03 * np.std(reference), name
