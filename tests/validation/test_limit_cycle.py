"""Strong shocks: the paper's third case, Mach 0.875, V_f 1.420, marches on to its limit cycle and stays there."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

pytestmark = pytest.mark.validation
Run = Callable[..., dict[str, Any]]
FINE = 7.023  # degrees: `point … --set aero.cells_around=240 --set aero.cells_normal=72 --set flutter.forced_amplitude_deg=6`


def amplitudes(result: dict[str, Any]) -> np.ndarray:
    """Largest |alpha| [deg] of each whole cycle of omega_alpha."""
    with netcdf_file(next(result["folder"].glob("history*.nc")), mmap=False) as history:
        alpha = np.degrees(np.abs(np.array(history.variables["alpha"][:])))
    steps = result["steps_per_cycle"]
    return np.array([alpha[k : k + steps].max() for k in range(0, len(alpha) - steps, steps)])


def test_limit_cycle_is_reached_from_below_and_from_above_and_kept(aeroslosh: Run) -> None:
    case = ["--mach", "0.875", "--vf", "1.42"]
    below = aeroslosh("point", *case, "--set", "flutter.free_cycles=33")
    above = aeroslosh(
        "point", *case,
        *("--set", "flutter.free_cycles=14", "--set", "flutter.forced_amplitude_deg=18", "--set", "flutter.max_alpha_deg=30"),
    )  # fmt: skip
    rising, falling = amplitudes(below), amplitudes(above)
    print("\nfrom below", np.round(rising, 2), "\nfrom above", np.round(falling, 2))
    for result in (below, above):
        cost = result["cost"]["cpu_seconds"] / (result["steps"] / result["steps_per_cycle"])
        print(f"verdict {result['verdict']}, {cost:.2f} s CPU a cycle, steps not converged {result['unconverged_steps']}")
        assert result["failure"] is None
    assert rising[2] < 2.0  # starts small
    assert falling[2:4].max() > 7.5  # released above
    # twenty cycles on it; 240 x 72 cells have 7.023 degrees
    assert np.all(np.abs(rising[-20:] - FINE) < 0.05)
    assert falling[-3:].mean() == pytest.approx(rising[-20:].mean(), abs=0.02)
    assert below["verdict"] == "limit cycle"
