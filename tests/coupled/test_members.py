"""Ensembles of two-phase marches: any member can be repeated alone, the point carries their mean."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae

SMALL: dict[str, object] = {
    "aero.cells_around": 64, "aero.cells_normal": 16, "slosh.cells_x": 20, "slosh.cells_y": 16, "flutter.free_cycles": 1.5,
    "flutter.max_free_cycles": 1.5, "flutter.steps_per_cycle": 72, "slosh.members": 3, "output.pictures": False,
    "output.fields": False, "flutter.forced_cycles": 1.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def fmus(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("fmus")
    for name in ("structure", "aero", "slosh_vof"):
        (folder / f"{name}.fmu").symlink_to(fmu(name))
    return folder


def test_a_point_is_the_mean_of_its_members(fmus: Path) -> None:
    case = ae.Case.load("paper_s").changed(SMALL)
    found = ae.point(case, mach=0.8, V_f=0.75, slosh="vof", fmus=fmus)
    told = found.data["ensemble"]
    assert told["seeds"] == [0, 1, 2] and len(set(told["growth_rates"])) == 3
    assert found.growth_rate == pytest.approx(np.mean(told["growth_rates"]))
    assert found.data["uncertainty_parts"]["members"] == pytest.approx(told["standard_error"])
    alone = ae.point(case.changed({"slosh.members": 1, "slosh.seed": 2}), mach=0.8, V_f=0.75, slosh="vof", fmus=fmus)
    assert alone.growth_rate == told["growth_rates"][2] and alone.data["ensemble"] is None


def test_a_liquid_without_scatter_has_one_member(fmus: Path) -> None:
    """As other keys of slosh_vof it is not read with another model: one case draws all curves."""
    found = ae.point(ae.Case.load("paper_s").changed(SMALL), mach=0.8, V_f=0.75, slosh="none", fmus=fmus)
    assert found.data["ensemble"] is None
