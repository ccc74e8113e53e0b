"""SPHERIC benchmark 10, lateral impact of oil (990 kg/m3, 5e-5 m2/s, 1.5353 s): what the front and the back wall take.

Souto-Iglesias and Botia-Vera (SPHERIC test 10, 2011), 102 runs. The roll of the oil's runs is not published in numbers: it is
that of the water's, its time scaled to the oil's period. The tank is 62 mm wide, Stokes' layer of the oil 5 mm.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids, Numerics
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.tank.liquid import Tank
from support.experiments import Record, arrivals, record, roll, table

pytestmark = pytest.mark.validation
TANK = Tank(0.9, 0.508, width=0.062, fill_level=93 / 508, y=0.254, density=990.0)
PERIOD, OF_WATER = 1.5353, 1.6295
IMPACT = 100.0  # [Pa]


def run(side_walls: bool) -> Record:
    numerics = Numerics(side_wall_omega=2.0 * math.pi / PERIOD if side_walls else 0.0)
    flow = Flow(Grid(TANK, 90, 51), Fluids(liquid_viscosity=5e-5), numerics, sensors=(Probe(0.0, 0.093),))
    motion = roll(PERIOD / OF_WATER)
    flow.start(motion(0.0))
    return record(flow, motion, 5.9, 1e-3)


def impacts(seen: Record) -> list[float]:
    """Times of the first three impacts on the wall; the rise at 0.4 s, before the first of them, is the start."""
    return [at for at in arrivals(seen.t, seen.pressure[:, 0], IMPACT) if at > 1.0]


def test_side_walls_take_most_of_the_peaks_excess() -> None:
    rows = table("spheric10_oil_lateral_pressure_1kHz.csv")
    t, p = rows["t"], rows["p"]
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (p[1:] + p[:-1]))])
    theirs = Record(t, p[:, None], integral[:, None], np.zeros((len(t), 0)), np.zeros((len(t), 0)))
    runs = table("spheric10_oil_4first_peak_lateral_impact_tto_0_8_h93_b1x.csv")
    real = np.array([100 * runs[name].mean() for name in ("p1", "p2", "p3")])
    found = {}
    for name, seen in (("measured", theirs), ("without", run(False)), ("with", run(True))):
        starts = impacts(seen)[:3]
        peaks = [float(seen.pressure[(seen.t >= at) & (seen.t < at + 0.5), 0].max()) for at in starts]
        found[name] = (starts, peaks, seen.mean(starts[0], 0.3))
        print(f"{name}: arrival {np.round(starts, 3)} s, peaks {np.round(peaks)} Pa, first 300 ms {found[name][2]:.0f} Pa")
    excess = 1.0 - (np.array(found["with"][1]) - real) / (np.array(found["without"][1]) - real)
    print(f"peaks of 102 runs {np.round(real)} Pa; part of the excess that the side walls take: {np.round(excess, 2)}")
    assert excess.min() > 0.75
    assert found["with"][1][0] < 1.6 * real[0]
    # what stays: peaks 1.4 to 2.8 times too high, the mean by a third to a half, the wave early by 0.1 s
    assert abs(found["with"][2] / found["measured"][2] - 1.0) < abs(found["without"][2] / found["measured"][2] - 1.0)
    np.testing.assert_allclose(found["with"][0], found["measured"][0], rtol=0.03)
