"""The histories as netCDF-3 files: of a march, of a system's run."""

from __future__ import annotations

import contextlib
import io
import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from ..base import files
from ..cosim.system_run import Simulation
from ..flutter.march import March
from ..flutter.recorder import REALS
from . import trust

UNITS = {  # history variables that are no FMU outputs
    "time": ("s", "time since the start of the march"),
    "tau": ("1", "dimensionless time omega_alpha t"),
    "h_over_b": ("1", "plunge over half chord, positive down"),
    "subiterations": ("1", "subiterations of the aero step"),
    "passes": ("1", "passes over the components in the step"),
}


def write_history(path: Path, march: March, about: dict[str, Any]) -> None:
    """netCDF-3 history of `march` with the provenance `about` as global attributes."""
    with written(path) as file:
        put_march(file, march)
        put_attributes(file, march_attributes(march) | about)


@contextlib.contextmanager
def written(path: Path) -> Iterator[netcdf_file]:
    """A netCDF-3 file to fill; it lies at `path` whole or not at all. Raises OSError."""
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w")
    yield file
    file.flush()
    files.write(path, buffer.getvalue())


def channels(march: March) -> dict[str, tuple[np.ndarray, str, str]]:
    """Channel → values (n,), unit, long name."""
    return {name: (values, *(UNITS[name] if name in UNITS else REALS[name][2:])) for name, values in march.history.items()}


def put_march(file: netcdf_file, march: March, prefix: str = "") -> None:
    """The channels of `march` as variables over the dimension `time`, the names of all with `prefix`."""
    file.createDimension(f"{prefix}time", march.tau.size)
    for name, (values, unit, long_name) in channels(march).items():
        variable = file.createVariable(prefix + name, "f8", (f"{prefix}time",))
        variable[:] = values
        variable.units = unit
        variable.long_name = long_name
        if name not in ("time", "tau"):
            variable.coordinates = f"{prefix}tau"  # CF: a second name of each instant


def march_attributes(march: March) -> dict[str, Any]:
    """What a history says of its march."""
    s = march.scales
    return {
        "title": f"aeroslosh march, Mach {s.mach:g}, V_f {s.V_f:g}",
        "Conventions": "CF-1.8",
        "mach": s.mach,
        "V_f": s.V_f,
        "omega_alpha": s.omega_alpha,
        "half_chord": s.half_chord,
        "speed": s.speed,
        "density": s.density,
        "mass": s.mass,
        "steps_per_cycle": s.steps_per_cycle,
        "release_index": march.release,
        "verdict": str(trust.verdict(march)),
        "reason": march.reason,
        "failure": march.failure.what if march.failure else "",
        "stopped": march.stopped,
        "slosh": march.slosh,
    }


def put_attributes(file: netcdf_file, attributes: dict[str, Any]) -> None:
    """Global attributes: numbers and texts as they are, tables as JSON; empty texts are left out."""
    for name, value in attributes.items():
        if isinstance(value, dict):
            value = json.dumps(value)
        if value != "":
            setattr(file, name, np.float64(value) if isinstance(value, float) else _ascii(value))


def _ascii(value: Any) -> Any:
    """Attributes as netCDF-3 holds them: numbers, or bytes of UTF-8."""
    return value if isinstance(value, (int, float)) else str(value).encode("utf-8")


def write_simulation(path: Path, simulation: Simulation, about: dict[str, Any]) -> None:
    """netCDF-3: `time`, every output by its full name, `passes`; the provenance `about` as global attributes."""
    with written(path) as file:
        file.createDimension("time", simulation.time.size)
        columns = {"time": (simulation.time, "s"), "passes": (simulation.passes, "1")}
        columns |= {name: (column, simulation.units[name]) for name, column in simulation.outputs.items()}
        for name, (column, unit) in columns.items():
            variable = file.createVariable(name, "f8", ("time",))
            variable[:] = column
            variable.units, variable.long_name = unit, name
        put_attributes(file, {"title": "aeroslosh run", "outcome": simulation.outcome} | about)
