"""SPHERIC benchmark 10, lateral impact of water: roll of 4 degrees, 900 x 508 mm, 93 mm of water, a sensor at the still level.

Souto-Iglesias and Botia-Vera (SPHERIC test 10, 2011), 102 runs; the files name where the figures come from. The motion is a
sinusoid fitted to some of its knots, amplitude ± 3 %. Prints what agrees and what does not.
"""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow, Fluids
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.tank.liquid import Tank
from support.experiments import Record, arrivals, record, roll, table

pytestmark = pytest.mark.validation
TANK = Tank(0.9, 0.508, width=0.062, fill_level=93 / 508, y=0.254, density=998.0)  # the axis is the middle of the floor
IMPACT = 500.0  # [Pa] that tells an impact
WINDOW = 0.02  # [s]


def run(cells: tuple[int, int], duration: float, gas_pressure: float = 0.0) -> Record:
    fluids = Fluids(liquid_viscosity=1e-6, gas_pressure=gas_pressure)
    flow = Flow(Grid(TANK, *cells), fluids, sensors=(Probe(0.0, 0.093),))
    motion = roll()
    flow.start(motion(0.0))
    return record(flow, motion, duration, 1e-3)


def measured() -> Record:
    rows = table("spheric10_water_lateral_pressure_1kHz.csv")
    t, p = rows["t"], rows["p"]
    integral = np.concatenate([[0.0], np.cumsum(0.5 * np.diff(t) * (p[1:] + p[:-1]))])
    none = np.zeros((len(t), 0))
    return Record(t, p[:, None], integral[:, None], none, none)


def largest_mean(seen: Record, start: float, window: float) -> float:
    """Largest mean [Pa] over `window` that begins within 0.2 s about an impact."""
    return max(seen.mean(at, window) for at in np.arange(start - 0.05, start + 0.15, 1e-3))


def test_arrivals_and_means_over_time_agree() -> None:
    theirs, ours = measured(), run((180, 102), 6.0)
    real, mine = (arrivals(seen.t, seen.pressure[:, 0], IMPACT) for seen in (theirs, ours))
    print("arrival of impacts, s: measured", np.round(real[:3], 3), "here", np.round(mine, 3))
    assert len(mine) == 3
    assert mine[0] == pytest.approx(real[0], abs=0.02)
    # later ones come early, the third by 0.06 s
    np.testing.assert_allclose(mine, real[:3], rtol=0.012)
    for window, most in ((0.1, 0.15), (0.3, 0.12)):
        pair = [seen.mean(start, window) for seen, start in ((theirs, real[0]), (ours, mine[0]))]
        print(f"impact 1, mean over {1e3 * window:.0f} ms from arrival: measured {pair[0]:.0f} Pa, here {pair[1]:.0f} Pa")
        assert pair[1] == pytest.approx(pair[0], rel=most)


def test_a_peak_grows_with_the_mesh_and_a_mean_over_20_ms_settles() -> None:
    """The peak of impact 1 is two to four times the measured one; the largest 20 ms mean is right within an eighth on the two
    finer of three meshes."""
    theirs = measured()
    start = arrivals(theirs.t, theirs.pressure[:, 0], IMPACT)[0]
    peaks = table("spheric10_water_4first_peak_lateral_impact_tto_0_85_h93_b1x.csv")["p1"]
    wanted = largest_mean(theirs, start, WINDOW)
    print(f"measured: peak {100 * peaks.mean():.0f} ± {100 * peaks.std():.0f} Pa, 20 ms mean {wanted:.0f} Pa")
    tops, means, short = [], [], []
    for cells in ((90, 51), (180, 102), (360, 204)):
        seen = run(cells, 2.6)
        at = arrivals(seen.t, seen.pressure[:, 0], IMPACT)[0]
        tops.append(float(seen.pressure[:, 0].max()))
        means.append(largest_mean(seen, at, WINDOW))
        short.append(largest_mean(seen, at, 0.005))
        print(
            f"{cells[0]}x{cells[1]}: arrival {at:.3f} s, peak {tops[-1]:.0f}, 5 ms mean {short[-1]:.0f}, "
            f"20 ms mean {means[-1]:.0f} Pa"
        )
    assert min(tops) > 1.5 * 100 * peaks.mean()
    assert tops[2] > 1.5 * tops[0]
    np.testing.assert_allclose(means[1:], wanted, rtol=0.125)
    assert abs(means[0] / wanted - 1.0) < 0.5 * (tops[0] / (100 * peaks.mean()) - 1.0)


def test_a_cushion_of_gas_stops_the_peaks_growth_and_leaves_the_20_ms_mean() -> None:
    """With air at sea level a finer mesh has no higher peak; it is still more than one and a half times the measured one."""
    theirs = measured()
    start = arrivals(theirs.t, theirs.pressure[:, 0], IMPACT)[0]
    peaks = table("spheric10_water_4first_peak_lateral_impact_tto_0_85_h93_b1x.csv")["p1"]
    wanted = largest_mean(theirs, start, WINDOW)
    tops, means = [], []
    for cells in ((90, 51), (180, 102), (360, 204)):
        seen = run(cells, 2.6, 101325.0)
        at = arrivals(seen.t, seen.pressure[:, 0], IMPACT)[0]
        tops.append(float(seen.pressure[:, 0].max()))
        means.append(largest_mean(seen, at, WINDOW))
        print(
            f"{cells[0]}x{cells[1]}, air at sea level: arrival {at:.3f} s, peak {tops[-1]:.0f}, lowest "
            f"{seen.pressure[:, 0].min():.0f}, 5 ms mean {largest_mean(seen, at, 0.005):.0f}, 20 ms mean {means[-1]:.0f} Pa"
        )
    assert tops[2] < 1.2 * tops[0]
    assert min(tops) > 1.5 * 100 * peaks.mean()
    np.testing.assert_allclose(means[1:], wanted, rtol=0.3)
