"""Pitch below resonance: Akyildiz and Unal, Ocean Eng. 33 (2006) 2135, pressure at a wall of a tank 75 % full.

Tank 0.92 x 0.62 m, pitch of 4 degrees at 2 rad/s, sensor P2 170 mm above the floor; digitised. The mean of the record lies
0.33 kPa above the hydrostatic pressure of the depth that is given: the swing alone is compared.
doi:10.1016/j.oceaneng.2005.11.014.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from aeroslosh.fmus.slosh_vof.probes import Probe
from aeroslosh.fmus.tank.liquid import Tank
from support.experiments import record, table
from support.motions import harmonic

pytestmark = pytest.mark.validation
OMEGA = 2.0


def swing(t: np.ndarray, p: np.ndarray) -> tuple[float, float]:
    """Mean and amplitude at OMEGA [Pa]."""
    terms = np.stack([np.ones_like(t), np.cos(OMEGA * t), np.sin(OMEGA * t)], axis=1)
    mean, cos, sin = np.linalg.lstsq(terms, p, rcond=None)[0]
    return float(mean), math.hypot(cos, sin)


def test_the_swing_of_the_pressure() -> None:
    """About the middle of the floor and about the tank's centre: the file does not say which."""
    theirs = table("akyildiz_unal2006_P2.csv")
    mean, real = swing(theirs["t"], 1e3 * theirs["p"])
    hydrostatic = 9810.0 * (0.75 * 0.62 - 0.17)
    print(f"measured: mean {mean:.0f} Pa (hydrostatic {hydrostatic:.0f}), amplitude {real:.0f} Pa")
    for name, y in (("floor", 0.31), ("centre", 0.0)):
        flow = Flow(Grid(Tank(0.92, 0.62, fill_level=0.75, y=y), 92, 62), sensors=(Probe(0.0, 0.17),))
        motion = harmonic(OMEGA, math.pi, pitch=math.radians(4.0))
        flow.start(motion(0.0))
        seen = record(flow, motion, 5 * math.pi, 0.01)
        late = seen.t > math.pi
        found, mine = swing(seen.t[late], seen.pressure[late, 0])
        print(f"about the {name}: mean {found:.0f} Pa, amplitude {mine:.0f} Pa, {mine / real:.2f} of the measured one")
        assert found == pytest.approx(hydrostatic, rel=0.01)
        assert mine == pytest.approx(real, rel=0.05 if name == "floor" else 0.15)
