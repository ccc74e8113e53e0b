"""One FMU and systems of FMUs through the Python interface."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import aeroslosh as ae

TIME = np.linspace(0.0, 1.0, 101)
TABLE = {"time": TIME, "x": 0.002 * np.sin(5.0 * TIME)}


def test_one_fmu_answers_a_table_however_it_is_given(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    path = fmu("slosh_ems")
    found = ae.simulate(path, TABLE, parameters={"tank_length": 0.4})
    assert found.force_x.dims == ("time",) and found.force_x.units == "N/m" and float(abs(found.force_x).max()) > 0.0
    pd.DataFrame(TABLE).to_csv(tmp_path / "motion.csv", index=False)
    for table in (pd.DataFrame(TABLE), xr.Dataset({"x": ("time", TABLE["x"])}, coords={"time": TIME}), tmp_path / "motion.csv"):
        assert ae.simulate(path, table, parameters={"tank_length": 0.4}).equals(found)
    other = ae.simulate(path, TABLE, parameters={"tank_length": 0.5})
    assert not np.allclose(other.force_x, found.force_x)


@pytest.mark.parametrize(
    ("table", "parameters", "said"),
    [
        ({"x": [0.0, 1.0]}, {}, "one column 'time'"),
        ({"time": [0.0, 0.0], "x": [0.0, 1.0]}, {}, "times that rise"),
        ({"time": [0.0, 1.0], "x": [0.0, np.nan]}, {}, "'x' holds a number that is not finite"),
        ({"time": [0.0, 1.0], "xx": [0.0, 1.0]}, {}, "'xx' is no Real input"),
        (TABLE, {"tank_lenght": 0.4}, "tank_length"),
        (TABLE, {"tank_length": "long"}, "tank_length has the wrong type"),
    ],
)
def test_what_does_not_fit_is_refused(table: dict, parameters: dict, said: str, fmu: Callable[[str], Path]) -> None:
    with pytest.raises(ae.AeroSloshError, match=said):
        ae.simulate(fmu("slosh_ems"), table, parameters=parameters)


def test_an_fmu_that_does_not_exist_names_those_that_do(fmu: Callable[[str], Path]) -> None:
    with pytest.raises(ae.AeroSloshError, match="slosh_ems"):
        ae.simulate("slosh_xyz", TABLE, fmus=fmu("slosh_ems").parent)


def test_a_system_from_dictionaries_is_the_one_of_a_file(doubles: Path, tmp_path: Path) -> None:
    """Two oscillators and a spring between them."""
    masses = {"a": 0.1, "b": 0.0}
    components = {n: {"fmu": str(doubles / "oscillator.fmu"), "parameters": {"initial_x": x}} for n, x in masses.items()}
    components["link"] = {"fmu": str(doubles / "link.fmu")}
    wires = ["a.x -> link.x_a", "b.x -> link.x_b", "link.force_a -> a.force", "link.force_b -> b.force"]
    found = ae.System(components, wires, end=0.5, step=0.01).run(folder=tmp_path / "run")
    start = {name: f"initial_x = {x}" for name, x in masses.items()}
    text = "".join(
        f'[components.{name}]\nfmu = "{part["fmu"]}"\nparameters = {{ {start.get(name, "")} }}\n'
        for name, part in components.items()
    )
    file = tmp_path / "system.toml"
    file.write_text(f"{text}[system]\nwires = {json.dumps(wires)}\n[run]\nend = 0.5\nstep = 0.01\n")
    assert ae.System.load(file).run().equals(found)
    assert found.attrs["outcome"] == "completed" and found.sizes["time"] == 51 and float(found["b.x"][-1]) != 0.0
    opened = ae.open(tmp_path / "run")
    np.testing.assert_array_equal(opened["a.x"].values, found["a.x"].values)
    with pytest.raises(ae.AeroSloshError, match="'c'"):
        ae.System(components, [*wires, "c.x -> a.force"], end=0.5, step=0.01).run()
