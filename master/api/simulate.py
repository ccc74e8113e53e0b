"""One FMU driven by a table, and any system of FMUs."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from ..base import notices
from ..base.errors import AeroSloshError
from ..case import builtin
from ..cosim import system_file, system_run
from ..cosim.checkpoint import Checkpoint, Keeper
from ..cosim.system_file import Assembly
from ..cosim.system_run import Simulation
from ..fmi import installed, table_drive
from ..fmi.component import Component
from ..fmi.table_drive import Table
from ..results.history_writer import write_simulation
from ..results.provenance import provenance
from ..results.run_folder import RunFolder
from . import datasets
from .case import plain
from .point import fmu_folder
from .progress import Callback, Reporter, interruptible, reporter

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr


def simulate(
    fmu: str | os.PathLike[str],
    table: Mapping[str, Any] | pd.DataFrame | xr.Dataset | str | os.PathLike[str],
    *,
    parameters: Mapping[str, Any] | None = None,
    step: float | None = None,
    fmus: str | os.PathLike[str] | None = None,
) -> xr.Dataset:
    """Drive one FMU with a table of its inputs; returns every numeric output over `time` [s], with units.

    fmu         a file, or the name of one of this package's FMUs: "slosh_vof"
    table       columns `time` [s], strictly rising, and inputs of the FMU, each (n,): a dictionary, a DataFrame, a Dataset, or
                the path of a CSV file. Rates and accelerations left out are taken from splines. Each row is a communication point
    parameters  variable → value, set before it starts; `step` [s]: resample the table to equal steps

    Raises AeroSloshError for a column that is no input and a value that fits no parameter, ComponentError when the FMU fails."""
    path = installed.named(Path(fmu), None if fmus is None else Path(fmus))
    driven = table_drive.read(Path(table)) if isinstance(table, str | os.PathLike) else _table(table)
    if step is not None:
        driven = driven.resampled(step)
    with interruptible():
        component = Component(path, path.stem)
        try:
            for name, value in plain(parameters or {}).items():
                component.check_and_set(name, value, f"ae.simulate, parameters, {name}")
            if driven.names:
                driven, _ = table_drive.completed(driven, component.input_index)
            columns = table_drive.run(component, driven)
            known = component.variables
            units = {n: (known[n].unit or "1", known[n].description or n) if n in known else ("s", "time") for n in columns}
            attributes = {"fmu": path.name, "fmu_sha256": component.sha256}
        finally:
            component.close()
    return datasets.history({n: (v, *units[n]) for n, v in columns.items()}, attributes)


class System:
    """Any FMUs, wired: as in a system file.

    >>> system = System(
    ...     {"table": {"fmu": "shaker.fmu"}, "tank": {"fmu": "slosh_ems", "parameters": {"tank_length": 0.9}}},
    ...     ["table.x -> tank.x", "table.x_ddot -> tank.x_ddot"],
    ...     end=2.0, step=1e-3,
    ... )
    >>> system.run()["tank.force_x"]
    """

    def __init__(
        self,
        components: Mapping[str, Mapping[str, Any] | str | os.PathLike[str]],
        wires: Sequence[str] = (),
        *,
        end: float,
        step: float,
        start: float = 0.0,
        record_every: int = 1,
        coupling: Mapping[str, Any] | None = None,
    ) -> None:
        """components: name → fmu (a file or a name of this package's), parameters, predicts; or the fmu alone;
        wires: "a.output -> b.input";
        start, end, step [s]; coupling: keys of the table [coupling]. Raises AeroSloshError naming the key."""
        run = {"start": start, "end": end, "step": step, "record_every": record_every}
        parts = {n: {"fmu": os.fspath(c)} if isinstance(c, str | os.PathLike) else dict(c) for n, c in components.items()}
        data = plain({"components": parts, "system": {"wires": list(wires)}, "run": run, "coupling": dict(coupling or {})})
        self._assembly = system_file.of_data(data, {}, Path("ae.System"), Path.cwd())

    @classmethod
    def load(cls, path: str | os.PathLike[str], overrides: Sequence[str] = ()) -> System:
        """The system of a TOML file (or the built-in "tank_on_springs"). Raises AeroSloshError (file, line, key, remedy)."""
        made = cls.__new__(cls)
        made._assembly = system_file.load(builtin.resolve(Path(path)), overrides)
        return made

    @property
    def settings(self) -> dict[str, Any]:
        """Every key with its value."""
        return system_file.flat(self._assembly)

    def run(
        self,
        *,
        folder: str | os.PathLike[str] | None = None,
        fmus: str | os.PathLike[str] | None = None,
        progress: bool | Callback = False,
    ) -> xr.Dataset:
        """Run it; every output over `time` [s], and `passes`; attributes say how it ended (`outcome`, `converged`).

        folder: a run folder to write. Raises AeroSloshError for a system that cannot be built, ComponentError when an FMU fails
        (a folder keeps what came before), Cancelled."""
        assembly, report = self._assembly, reporter(progress)
        files = system_file.find(assembly, fmu_folder(fmus))
        with interruptible(), notices.to(report.say):
            if folder is None:
                result = compute(assembly, files, report).result
            else:
                with RunFolder(Path(folder)) as kept:
                    kept.write_settings(system_file.dump(assembly))
                    ran = compute(assembly, files, report, kept)
                    write(assembly, ran, kept)
                    result = ran.result
        if result.failure is not None:
            raise result.failure
        columns = {n: (v, result.units[n], n) for n, v in result.outputs.items()}
        columns |= {"time": (result.time, "s", "time"), "passes": (result.passes, "1", "passes over the components in the step")}
        return datasets.history(columns, {"outcome": result.outcome, "converged": int(result.converged)})

    def __repr__(self) -> str:
        run = self._assembly.run
        return f"System({', '.join(self._assembly.components)}: {run.start:g} to {run.end:g} s in steps of {run.step:g} s)"


@dataclass(frozen=True)
class Ran:
    """A run with its numbers, as in result.json, and its provenance."""

    result: Simulation
    data: dict[str, Any]
    about: dict[str, Any]


def compute(
    assembly: Assembly,
    files: dict[str, Path],
    report: Reporter,
    folder: RunFolder | None = None,
    keep: Callable[[dict[str, str]], tuple[Keeper | None, Checkpoint | None]] = lambda hashes: (None, None),
) -> Ran:
    """Run the system of `assembly`. `keep(hashes)`: what writes its checkpoints and the one to go on from; with a `folder` its
    log is kept. Raises AeroSloshError."""
    system = system_file.build(assembly, files)
    try:
        hashes = {c.name: c.sha256 for c in system.everyone}
        keeper, start = keep(hashes)
        if folder is not None:
            for loop in system.loops:
                folder.log(f"algebraic loop, closed by the coupling scheme {assembly.coupling.scheme}: {' '.join(loop)}")
        if assembly.dt != assembly.run.step:
            text = f"steps of {assembly.dt!r} s: the run holds no whole number of run.step"
            report.say(text)
            if folder is not None:
                folder.log(text)
        report.start(assembly.name)
        result = system_run.simulate(assembly, system, report.watch, keeper, start)
        if folder is not None:
            folder.log_messages(system.everyone)
    finally:
        system.close()
    return Ran(result, system_run.data(result), provenance(hashes))


def write(assembly: Assembly, ran: Ran, folder: RunFolder) -> None:
    """The files of a run: history, result, picture. Raises OSError."""
    write_simulation(folder.path / "history.nc", ran.result, ran.about)
    folder.write_result(ran.data | {"provenance": ran.about})
    if assembly.run.pictures:
        from ..pictures import table as picture  # matplotlib takes half a second to import

        nothing = Table(ran.result.time, [], np.zeros((ran.result.time.size, 0)))
        picture.draw(folder.path / "histories.png", nothing, {"time": ran.result.time, **ran.result.outputs}, ran.result.units)


def _table(given: Mapping[str, Any] | Any) -> Table:
    """A table from columns. Raises AeroSloshError."""
    where = "ae.simulate, table"
    if hasattr(given, "reset_index") and getattr(getattr(given, "index", None), "name", None) == "time":  # a DataFrame over time
        given = given.reset_index()
    if not hasattr(given, "keys"):
        raise AeroSloshError(f"A {type(given).__name__} is no table", where, "a dictionary, a DataFrame, a Dataset or a CSV file")
    names = [str(name) for name in [*given.keys(), *getattr(given, "coords", ())]]
    columns: dict[str, np.ndarray] = {}
    for name in dict.fromkeys(names):
        column = np.asarray(given[name])
        if column.ndim == 0 and name in getattr(given, "coords", ()):
            continue  # a Dataset's scalar coordinate says of what it is, and is no column
        if column.ndim != 1 or column.dtype.kind not in "biuf":
            raise AeroSloshError(
                f"'{name}' has shape {column.shape} and holds {column.dtype}", where, "numbers, one a row; time in seconds"
            )
        columns[name] = column.astype(float)
    if "time" not in columns:
        raise AeroSloshError(f"The columns are {', '.join(columns) or 'none'}", where, "one column 'time' [s]")
    time = columns.pop("time")
    if any(v.size != time.size for v in columns.values()) or time.size < 2 or not (np.diff(time) > 0.0).all():
        raise AeroSloshError("Columns of one length and times that rise are needed", where, "two rows or more")
    values = np.column_stack(list(columns.values())) if columns else np.zeros((time.size, 0))
    for name, column in {"time": time, **columns}.items():
        if not np.isfinite(column).all():
            raise AeroSloshError(f"'{name}' holds a number that is not finite", where, "a finite number in every place")
    return Table(time, list(columns), values)
