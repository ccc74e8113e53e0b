"""Results as labelled arrays: histories, swept grids, tables. xarray and pandas are loaded when the first is asked for."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..case import case as cases
from ..flutter.march import March
from ..results import history_file
from ..results.history_writer import channels, march_attributes

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

Columns = Mapping[str, tuple[np.ndarray, str, str]]  # name → values (n,), unit, long name
UNITS = {  # of what a sweep's points give
    "growth_rate": "omega_alpha", "growth_rate_uncertainty": "omega_alpha", "frequency": "omega_alpha",
    "frequency_uncertainty": "omega_alpha", "limit_cycle_amplitude_deg": "degree", "cpu_seconds": "s", "wall_seconds": "s",
    "mach": "1", "V_f": "1", "V_f_uncertainty": "1", "own_V_f": "1", "margin": "1", "damping_ratio": "1", "steps": "1",
    "airspeed": "m/s", "equivalent_airspeed": "m/s", "dynamic_pressure": "Pa", "pressure_altitude": "m", "density": "kg/m3",
    "static_pressure": "Pa", "static_temperature": "K", "mass": "kg/m", "static_imbalance": "kg", "inertia": "kg m",
    "plunge_frequency": "Hz", "pitch_frequency": "Hz", "neutral_pitch_frequency": "Hz",
}  # fmt: skip


def history(columns: Columns, attributes: Mapping[str, Any]) -> xr.Dataset:
    """Channels over `time` [s], with `tau` (omega_alpha t) as a second coordinate where it is known; units as attributes."""
    import xarray as xr

    variables = {
        name: ("time", np.asarray(values, dtype=float), {"units": unit, "long_name": long_name})
        for name, (values, unit, long_name) in columns.items()
    }
    return xr.Dataset(variables, attrs=dict(attributes)).set_coords([name for name in ("time", "tau") if name in variables])


def of_march(march: March) -> xr.Dataset:
    """The history of a march."""
    return history(channels(march), {k: v for k, v in march_attributes(march).items() if v != ""})


def of_file(path: Path) -> list[xr.Dataset]:
    """The histories in a netCDF-3 file that a run wrote. Raises AeroSloshError."""
    found = []
    for h in history_file.read(path):
        columns = {name: (values, h.units[name], h.long_names[name]) for name, values in h.values.items()}
        found.append(history(columns, {k: v for k, v in h.attributes.items() if isinstance(v, str | int | float)}))
    return found


def grid(rows: Sequence[Mapping[str, Any]], names: Sequence[str], keys: Iterable[str], whole: bool) -> xr.Dataset:
    """Rows (one a point) as a Dataset: over the swept `names` where they form a grid (`whole`), else over `point`.

    rows    each with its swept keys and the results `keys`; numbers that are missing are nan, texts that are missing empty"""
    import xarray as xr

    dims = list(names) if whole else ["point"]
    axes = {name: list(dict.fromkeys(row[name] for row in rows)) for name in names} if whole else {}
    for name, values in axes.items():
        if all(isinstance(v, int | float) and not isinstance(v, bool) for v in values):
            axes[name] = sorted(values)
    shape = [len(axes[name]) for name in names] if whole else [len(rows)]
    data = {}
    for key in keys:
        values = [row.get(key) for row in rows]
        text = any(isinstance(v, str) for v in values)
        array = np.full(shape, "", dtype=object) if text else np.full(shape, math.nan)
        for n, (row, value) in enumerate(zip(rows, values, strict=True)):
            place = tuple(axes[name].index(row[name]) for name in names) if whole else (n,)
            array[place] = ("" if text else math.nan) if value is None else value if text else float(value)
        array = array.astype(str) if text else array
        data[key] = (dims, array, {"units": UNITS[key]} if key in UNITS else {})
    coords = {
        name: (name if whole else "point", _values(axes[name] if whole else [row[name] for row in rows]), _unit(name))
        for name in names
    }
    return xr.Dataset(data, coords=coords)


def _values(values: Sequence[Any]) -> np.ndarray:
    """A coordinate: numbers, truths or texts; of several kinds as they are."""
    kinds = {bool if isinstance(v, bool) else float if isinstance(v, int | float) else type(v) for v in values}
    return np.array(values) if len(kinds) == 1 else np.array(list(values), dtype=object)


def _unit(key: str) -> dict[str, str]:
    """The unit of a case's key."""
    table, _, name = key.partition(".")
    fields = {f.name: f for f in dataclasses.fields(cases.TABLES[table])} if table in cases.TABLES else {}
    return {"units": fields[name].metadata["unit"]} if name in fields and "unit" in fields[name].metadata else {}


def table(rows: Sequence[Mapping[str, Any]], columns: Sequence[str]) -> pd.DataFrame:
    """Rows as a DataFrame with exactly these columns."""
    import pandas as pd

    return pd.DataFrame([{name: row.get(name) for name in columns} for row in rows], columns=list(columns))
