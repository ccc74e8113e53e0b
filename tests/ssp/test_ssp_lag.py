"""What docs/ssp.md says of the lag of tools that exchange once a step, on a coarse mesh."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from studies import ssp_lag

sys.path.insert(0, str(Path(__file__).parent))
from ssp_marches import Fmu, files


def test_lag_is_of_first_order_and_prediction_takes_it_away(fmu: Fmu) -> None:
    """Late by a step, the error of the growth rate halves with the step; with prediction a hundredth of it is left."""
    name = "dry, Mach 0.825, V_f 0.612"
    found = []
    for refined in (1, 2):
        case = ssp_lag.load(name, refined, ssp_lag.COARSE)
        fmus = files(fmu, case)
        rates = {word: ssp_lag.exported(case, fmus, word) for word in ("none", "linear")}
        found.append(rates | {"own": ssp_lag.own(case, fmus)})
    coarse, fine = found
    error = coarse["none"] - coarse["own"]
    assert error > 0.01
    assert (fine["none"] - fine["own"]) / error == pytest.approx(0.5, abs=0.02)
    assert abs(coarse["linear"] - coarse["own"]) < 0.01 * error
