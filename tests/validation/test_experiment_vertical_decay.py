"""Free vertical decay of a tank on a spring: damping over the acceleration and the fill, as the SLOWD project found it.

SLOWD (Horizon 2020, grant 815044) shook tanks some decimetres long at 6 to 8 Hz: hardly any damping below one g, a steep rise
beyond, most near 4 g, a slow fall after; most at half fill (doi:10.3390/app112110401 has a law of it). The rigs' tables are not
public, so shapes are compared. Tank 100 x 60 mm of water, 6.5 Hz, half full the liquid is 0.08 of the structure's mass.
"""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.tank.liquid import Tank
from support.experiments import vertical_decay

pytestmark = pytest.mark.validation
FREQUENCY, RATIO, CYCLES = 6.5, 0.08, 10


def damping(g_start: float, fill: float = 0.5, cells: tuple[int, int] = (60, 36)) -> float:
    """Damping ratio [%] over the first ten cycles."""
    flow = Flow(Grid(Tank(0.1, 0.06, fill_level=fill), *cells))
    t, h = vertical_decay(flow, FREQUENCY, RATIO * fill / 0.5, g_start, CYCLES + 1, 0.01 / FREQUENCY)
    sizes = []
    for first in (0, CYCLES):
        cycle = (t >= first / FREQUENCY) & (t < (first + 1) / FREQUENCY)
        phase = 2.0 * np.pi * FREQUENCY * t[cycle]
        terms = np.stack([np.ones_like(phase), np.cos(phase), np.sin(phase)], axis=1)
        sizes.append(np.hypot(*np.linalg.lstsq(terms, h[cycle], rcond=None)[0][1:]))
    return float(100.0 * np.log(sizes[0] / sizes[1]) / (2.0 * np.pi * CYCLES))


def test_damping_over_the_acceleration() -> None:
    """Nothing while the liquid is held down; a rise to about 4 g; a slow fall."""
    g = (0.5, 2.0, 3.0, 4.0, 6.0, 8.0, 10.0, 12.0)
    zeta = {start: damping(start) for start in g}
    print("damping ratio, %:", {start: round(value, 3) for start, value in zeta.items()})
    assert abs(zeta[0.5]) < 1e-3
    assert 3.0 <= max(zeta, key=lambda start: zeta[start]) <= 6.0
    assert zeta[2.0] < 0.7 * zeta[4.0]
    assert zeta[12.0] < zeta[8.0] < zeta[4.0]
    assert zeta[12.0] > 0.4 * zeta[4.0]


def test_damping_over_the_fill() -> None:
    """On one structure: a tank nearly empty or nearly full damps less than one about half full."""
    fills = (0.1, 0.2, 0.35, 0.5, 0.65, 0.8, 0.9)
    zeta = {fill: damping(4.0, fill) for fill in fills}
    print("damping ratio at 4 g, %:", {fill: round(value, 3) for fill, value in zeta.items()})
    best = max(zeta, key=lambda fill: zeta[fill])
    assert 0.35 <= best <= 0.65
    assert max(zeta[0.1], zeta[0.9]) < 0.5 * zeta[best]
