"""Surge near resonance: Faltinsen, Rognebakke, Lukovsky and Timokha, J. Fluid Mech. 407 (2000) 201, figure 7.

Tank 1.73 m long and 1.05 m high, 0.6 m of water, surge of 32 mm with a period of 1.3 s, wave 50 mm from the left wall. How the
motion began is not published: here it rises over one period, and the record is moved in time for the best correlation.
doi:10.1017/S0022112099007569.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.liquid import Tank
from support.experiments import record, table
from support.motions import harmonic

pytestmark = pytest.mark.validation
PERIOD = 1.3


def crests(t: np.ndarray, wave: np.ndarray) -> np.ndarray:
    """Times [s] of the largest crest above 20 mm in each 0.6 s and more."""
    found: list[int] = []
    for k in np.flatnonzero((wave[1:-1] > wave[:-2]) & (wave[1:-1] >= wave[2:]) & (wave[1:-1] > 0.02)) + 1:
        if not found or t[k] - t[found[-1]] > 0.6:
            found.append(int(k))
        elif wave[k] > wave[found[-1]]:
            found[-1] = int(k)
    return np.asarray(t[found])


def largest(t: np.ndarray, wave: np.ndarray, at: np.ndarray) -> np.ndarray:
    """Largest height [m] within 0.35 s of each of the times `at`."""
    return np.array([wave[np.abs(t - middle) < 0.35].max() for middle in at])


def test_the_beating_wave() -> None:
    theirs = table("faltinsen2000_fig7.csv")
    flow = Flow(Grid(Tank(1.73, 1.05, fill_level=0.6 / 1.05), 80, 48))
    motion = harmonic(2.0 * math.pi / PERIOD, PERIOD, surge=0.032)
    flow.start(motion(0.0))
    seen = record(flow, motion, 10.0, 0.01, (0.05,))
    wave = seen.height[:, 0]
    shifts = np.arange(-0.65, 0.65, 0.01)
    likeness = [np.corrcoef(np.interp(theirs["t"] - shift, seen.t, wave), theirs["H"])[0, 1] for shift in shifts]
    shift = float(shifts[int(np.argmax(likeness))])
    at = crests(theirs["t"], theirs["H"])
    real, mine = largest(theirs["t"], theirs["H"], at), largest(seen.t, wave, at - shift)
    print(f"correlation {max(likeness):.3f} at a shift of {shift:.2f} s")
    print("crests, mm: measured", np.round(1e3 * real), "here", np.round(1e3 * mine), "at", np.round(at, 2), "s")
    assert len(at) == 6
    assert max(likeness) > 0.94
    np.testing.assert_allclose(mine, real, atol=0.025)
    np.testing.assert_allclose(mine[1:3], real[1:3], rtol=0.05)
    assert int(np.argmin(mine)) == int(np.argmin(real)) == 3  # the beat
