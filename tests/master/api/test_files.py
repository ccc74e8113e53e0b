"""Histories are netCDF-3 and open in xarray as they are; nothing is lost on the way through it, also into other formats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import xarray as xr

import aeroslosh as ae


@pytest.fixture(scope="module")
def run(flutter_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> ae.Point:
    case = ae.Case.isogai_a().replace(
        flow={"mach": 0.3}, flutter={"steps_per_cycle": 72, "free_cycles": 3.0}, output={"pictures": False, "fields": False}
    )
    return ae.point(case, V_f=1.0, fmus=flutter_fmus, folder=tmp_path_factory.mktemp("files") / "run")


def test_open_dataset_gives_units_and_coordinates(run: ae.Point) -> None:
    assert run.folder is not None
    with xr.open_dataset(run.folder / "history.nc") as found:
        assert set(found.coords) == {"time", "tau"} and found.alpha.dims == ("time",)
        assert found.alpha.attrs["units"] == "rad" and found.time.dtype == float  # seconds are not made dates
        assert found.attrs["verdict"] == "damped" and found.attrs["Conventions"] == "CF-1.8"
        for name in run.history.variables:
            np.testing.assert_array_equal(found[name].values, run.history[name].values)


def test_a_history_survives_xarray_s_own_file(run: ae.Point, tmp_path: Path) -> None:
    run.history.to_netcdf(tmp_path / "again.nc", engine="scipy")
    with xr.open_dataset(tmp_path / "again.nc") as found:
        assert found.equals(run.history) and found.alpha.attrs == run.history.alpha.attrs
