"""Error bars by coarse linear models: on made-up models whose errors are known, and on the thin-airfoil double."""

from __future__ import annotations

import dataclasses
import math
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae
from aeroslosh.master.analysis.crossings import Crossing
from aeroslosh.master.boundary import companion
from aeroslosh.master.linear.model import LinearCrossing


@dataclasses.dataclass
class Line:
    """A linear model of one mode that grows by `slope` (V_f − `neutral`), and diverges at `static`."""

    neutral: float
    slope: float = 0.2
    static: float = 3.0

    def eigenvalues(self, V_f: float) -> np.ndarray:
        return np.array([complex(-0.3, 2.0), complex(self.slope * (V_f - self.neutral), 0.9)])

    def divergence(self) -> float:
        return self.static


def beside(own: Line, coarse: Line, half: Line) -> companion.Companion:
    return companion.Companion(own, coarse, half)  # type: ignore[arg-type]


@pytest.mark.parametrize("slope", [0.2, -0.2])
def test_parts_are_what_the_coarse_models_are_off_by(slope: float) -> None:
    """A first-order error of 0.009 on the own mesh is 0.0135 on the coarse one: half of it is the difference."""
    models = beside(Line(1.009, slope), Line(1.0135, slope), Line(1.0105, slope))
    c = LinearCrossing(1.009, 0.9, "onset" if slope > 0 else "recovery", slope, 0, 0.1)
    parts = models.parts(c)
    assert parts["discretisation"] == pytest.approx(companion.SHARE * (1.009 - 1.0135))
    assert parts["amplitude"] == pytest.approx(1.0105 - 1.0135)
    marched = Crossing(1.01, 0.9, c.direction, slope, True, {"fit": 1e-4})
    wider = models.widened(marched, c)
    assert wider.V_f == 1.01 and wider.uncertainty == pytest.approx(math.hypot(1e-4, *parts.values()))


def test_a_change_that_vanishes_at_one_v_f_leaves_a_bar() -> None:
    """Models that cross at the same V_f by accident, with other slopes: half way to a tenth of V_f aside they differ."""
    parts = beside(Line(1.0, 0.2), Line(1.0, 0.3), Line(1.0, 0.2)).parts(LinearCrossing(1.0, 0.9, "onset", 0.2, 0, 0.1))
    away = math.sqrt((0.1**2 + 0.05**2) / 2.0)  # rms of V_f - 1 over what is looked at
    for name in companion.PARTS:
        assert abs(parts[name]) == pytest.approx(0.1 * away / 0.2)


def test_a_divergence_is_compared_by_its_own_v_f() -> None:
    models = beside(Line(1.0, static=2.0), Line(1.0, static=2.1), Line(1.0, static=2.1))
    parts = models.parts(LinearCrossing(2.0, 0.0, "onset", 0.1, -1, 0.0))
    assert parts == {"discretisation": pytest.approx(companion.SHARE * (2.0 - 2.1)), "amplitude": 0.0}


def test_what_cannot_be_had_is_named() -> None:
    models = beside(Line(1.0), Line(1.1), Line(1.1))
    flat = LinearCrossing(1.0, 0.9, "onset", 0.0, 0, 0.1)
    wider = models.widened(Crossing(1.0, 0.9, "onset", 0.0, True, {"fit": 1e-4}), flat)
    assert wider.missing == companion.PARTS and wider.parts == {"fit": 1e-4}


def test_a_boundary_carries_them_unless_told_not_to(flutter_fmus: Path) -> None:
    case = ae.Case.isogai_a().replace(boundary={"V_f_range": [1.0, 4.0]})
    own = ae.boundary(case, mach=[0.3], method="linear", fmus=flutter_fmus, workers=1)
    bare = ae.boundary(case.changed({"boundary.companion": False}), mach=[0.3], method="linear", fmus=flutter_fmus, workers=1)
    [with_parts], [without] = own.data["points"][0]["crossings"], bare.data["points"][0]["crossings"]
    assert set(with_parts["uncertainty_parts"]) == {"model", *companion.PARTS}
    assert set(without["uncertainty_parts"]) == {"model"}
    assert with_parts["V_f"] == without["V_f"]
    assert abs(with_parts["uncertainty_parts"]["amplitude"]) < 1e-6  # the double is linear


def test_parts_that_were_asked_for_and_not_had_are_named(flutter_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A coarse mesh without a steady flow leaves the fit's error bar, which must not pass for the whole."""
    monkeypatch.setattr(companion, "identify", lambda *words: None)
    case = ae.Case.isogai_a().replace(boundary={"V_f_range": [1.0, 4.0]})
    [crossing] = ae.boundary(case, mach=[0.3], method="linear", fmus=flutter_fmus, workers=1).data["points"][0]["crossings"]
    assert crossing["uncertainty_missing"] == list(companion.PARTS)
