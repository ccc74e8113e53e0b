"""Error bars by coarse marches on the thin-airfoil double, whose eigenvalues are the truth."""

from __future__ import annotations

import dataclasses
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter import coarse_marches
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.march import March
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.results import summary
from support import theory

MACH = 0.3


@pytest.fixture(scope="module")
def fmus(flutter_fmus: Path) -> dict[str, Path]:
    return find_fmus(flutter_fmus)


@pytest.fixture(scope="module")
def marched(fmus: dict[str, Path]) -> Iterator[tuple[Case, March]]:
    case = Case()
    case.flow.mach = MACH
    with FlutterSetup(case, fmus, MACH) as setup:
        yield case, flutter_march.march(setup, 0.6)


def change(case: Case, march: March, fmus: dict[str, Path], pole: complex | None = None) -> coarse_marches.Change:
    assert march.fit is not None
    own = pole or complex(march.fit.growth_rate, march.fit.frequency)
    return coarse_marches.change(lambda of, mach: FlutterSetup(of, fmus, mach), case, march, own)


def wet(model: str, **keys: object) -> Case:
    """A case with a liquid."""
    case = Case()
    case.flow.mach = MACH
    return dataclasses.replace(case, slosh=dataclasses.replace(case.slosh, model=model, **keys))


@pytest.mark.parametrize("order", [1, 2])
@pytest.mark.parametrize("V_f", [0.4, 0.9, 1.5, 2.4])
def test_the_truth_is_inside(fmus: dict[str, Path], V_f: float, order: int) -> None:
    """The double's only error is the coupling's, of second order in the step or better: two standard deviations cover it."""
    case = Case()
    case.flow.mach, case.coupling.predictor_order = MACH, order
    expected = theory.eigenvalues(case, MACH, V_f)
    with FlutterSetup(case, fmus, MACH) as setup:
        march = flutter_march.march(setup, V_f)
    assert march.fit is not None
    own = complex(march.fit.growth_rate, march.fit.frequency)
    truth = expected[np.argmin(np.abs(expected - own))]
    bar = coarse_marches.widened(march, change(case, march, fmus)).fit
    assert bar is not None
    assert abs(own.real - truth.real) < 2.0 * bar.growth_rate_uncertainty
    # no excuse: at most twice the error, beside the fits' own scatter
    assert bar.growth_rate_uncertainty < 2.0 * abs(own.real - truth.real) + 1e-4


def test_a_linear_flow_does_not_depend_on_amplitude(marched: tuple[Case, March], fmus: dict[str, Path]) -> None:
    told = change(*marched, fmus)
    assert abs(told.growth_rate["amplitude"]) < 1e-6 and abs(told.frequency["amplitude"]) < 1e-6
    assert len(told.marches) == 2 and not told.missing
    own, coarse = marched[1].scales.steps_per_cycle, told.marches[0].scales.steps_per_cycle
    assert coarse == round(own / coarse_marches.COARSER)


def test_another_mode_is_no_comparison(marched: tuple[Case, March], fmus: dict[str, Path]) -> None:
    told = change(*marched, fmus, complex(0.0, 30.0))
    assert told.missing == coarse_marches.PARTS and not told.growth_rate


def test_a_two_phase_liquid_is_frozen_for_what_the_air_changes(fmus: dict[str, Path]) -> None:
    """The part of mesh and step is that of the frozen liquid, to the bit; the others are named as missing, no two-phase march is
    made and the tank's own parameters are left out."""
    vof = wet("vof", parameters={"cells_x": 24}, members=3)
    still = coarse_marches.frozen(vof)
    with FlutterSetup(still, fmus, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    told, as_frozen = change(vof, march, fmus), change(still, march, fmus)
    assert told.growth_rate == {"discretisation": as_frozen.growth_rate["discretisation"]}
    assert 0.0 < abs(told.growth_rate["discretisation"]) < 1e-2
    assert told.missing == coarse_marches.TWO_PHASE
    assert [m.slosh for m in told.marches] == ["frozen", "frozen"]


def test_without_the_fmu_of_the_frozen_liquid_the_parts_are_missing(flutter_fmus: Path, tmp_path: Path) -> None:
    for name in ("structure", "aero"):
        shutil.copy(flutter_fmus / f"{name}.fmu", tmp_path)
    few = {name: tmp_path / f"{name}.fmu" for name in ("structure", "aero")}
    dry = wet("none")
    with FlutterSetup(dry, few, MACH) as setup:
        march = flutter_march.march(setup, 0.6)
    told = change(wet("vof"), march, few)
    assert told == coarse_marches.Change(missing=("discretisation", *coarse_marches.TWO_PHASE))


def test_a_point_carries_them_unless_told_not_to(flutter_fmus: Path) -> None:
    case = ae.Case.isogai_a()
    own = ae.point(case, mach=MACH, V_f=0.6, fmus=flutter_fmus)
    bare = ae.point(case.changed({"flutter.companion": False}), mach=MACH, V_f=0.6, fmus=flutter_fmus)
    assert set(coarse_marches.PARTS) <= set(own.data["uncertainty_parts"])
    assert not set(coarse_marches.PARTS) & set(bare.data["uncertainty_parts"])
    assert own.growth_rate == bare.growth_rate and own.growth_rate_uncertainty > bare.growth_rate_uncertainty
    assert own.march is not None and own.march.fit is not None  # what pictures and histories are made of
    assert own.march.fit.growth_rate_uncertainty == own.growth_rate_uncertainty
    assert "error bar    fit" in summary.march_summary(own.data) and "error bar" not in summary.march_summary(bare.data)


def test_a_sign_within_the_error_bar_is_said(marched: tuple[Case, March]) -> None:
    _, march = marched
    wide = coarse_marches.Change({"discretisation": 1.0}, {}, ("amplitude",))
    said = summary.march_summary(summary.march_data(coarse_marches.widened(march, wide), None, wide))
    assert "within its error bar of 0" in said and "not in it: amplitude" in said


def test_a_boundary_by_marches_alone_carries_them(flutter_fmus: Path) -> None:
    case = ae.Case.isogai_a().replace(boundary={"V_f_range": [1.0, 4.0]})
    found = ae.boundary(case, mach=[MACH], method="march", fmus=flutter_fmus, workers=1)
    [point] = found.data["points"]
    parts = point["crossings"][0]["uncertainty_parts"]
    assert {"fit", "interpolation", *coarse_marches.PARTS} == set(parts)
    truth = theory.neutral(Case(), MACH, 1.0, 4.0)
    assert abs(point["crossings"][0]["V_f"] - truth) < 2.0 * point["crossings"][0]["V_f_uncertainty"]
    assert point["cost"]["uncertainty_marches"] == 2
