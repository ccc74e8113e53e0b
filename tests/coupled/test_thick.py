"""The thick section's linear theory: a plate gives Theodorsen's loads, a steady section the exact map's lift."""

from __future__ import annotations

import numpy as np
import pytest

from aeroslosh.fmus.aero.airfoil import contour
from aeroslosh.fmus.aero.conformal import circle_map
from support import possio, thick


@pytest.mark.parametrize("k", [0.09, 0.36, 0.74])
def test_a_plate_gives_theodorsens_loads(k: float) -> None:
    ours, exact = thick.coefficients(thick.plate(), k, -0.3), possio.coefficients(1e-3, k, -0.3)
    assert np.abs(ours / exact - 1.0).max() < 1e-3


def test_slow_motion_gives_the_steady_lift_of_the_map() -> None:
    """The lag of the wake is gone but for (1 + ik ln k), so that the limit is met by extrapolating two slow motions."""
    slow = [thick.coefficients(thick.section("0012"), k, -0.5)[0, 1].real for k in (1e-3, 2e-3)]
    exact = circle_map(contour("0012")).lift_coefficient(1e-4) / 1e-4
    assert 2.0 * slow[0] - slow[1] == pytest.approx(exact, rel=2e-3)
