"""One FMU alone, driven by a table: `aeroslosh drive FMU --input motion.csv`.

The table is CSV with a header: `time` [s] and names of the FMU's inputs. Each row is a communication point; its values are
those at the end of the step that leads there (the first row's are the initial ones).

An FMU with `write_fields` and `field_folder` can be asked for its fields at every so many rows, the first one included; a
collection beside the folder opens them in ParaView.
"""

from __future__ import annotations

import csv
import io
import math
import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.interpolate import CubicSpline

from ..base import files, pvd, texts
from ..base.errors import AeroSloshError
from .component import Component

FIELD_FILE = re.compile(r"(fields|surface)_\d{6,}\.vt[sp]")


@dataclass(frozen=True)
class Table:
    """times (n,) ascending [s]; names of the other columns; values (n, len(names))."""

    times: np.ndarray
    names: list[str]
    values: np.ndarray

    def resampled(self, step: float) -> Table:
        """At equal steps from the first to the last time, linear in between: of `step` [s], or the nearest of which the table
        holds a whole number. Raises AeroSloshError for a step that is none."""
        if not (isinstance(step, int | float) and 0.0 < step < math.inf):
            raise AeroSloshError(f"step = {step!r}", "the communication step", "a number above 0 [s]")
        count = max(1, round((self.times[-1] - self.times[0]) / step))
        times = np.linspace(self.times[0], self.times[-1], count + 1)
        columns = [np.interp(times, self.times, column) for column in self.values.T]
        return Table(times, self.names, np.array(columns).T.reshape(times.size, len(self.names)))


def read(path: Path) -> Table:
    """Read a table. Raises AeroSloshError naming file, line, column and remedy."""
    try:
        text = io.StringIO(texts.read(path, "table"), newline="")
        lines = [(n, row) for n, row in enumerate(csv.reader(text), start=1) if row and not row[0].lstrip().startswith("#")]
    except (OSError, csv.Error) as error:
        raise AeroSloshError(f"The table cannot be read: {error}", str(path), "give a CSV file with a header") from None
    if len(lines) < 3:
        raise AeroSloshError("The table has fewer than two rows", str(path), "a header, then one row a communication point")
    header = [word.strip() for word in lines[0][1]]
    if "time" not in header or len(set(header)) != len(header):
        raise AeroSloshError(
            f"The columns are {', '.join(header)}", f"{path}, line {lines[0][0]}", "one column 'time' [s], every name once"
        )
    rows = []
    for number, row in lines[1:]:
        where = f"{path}, line {number}"
        if len(row) != len(header):
            raise AeroSloshError(f"{len(row)} values for {len(header)} columns", where, "one value a column")
        for name, word in zip(header, row, strict=True):
            try:
                if not math.isfinite(float(word)):
                    raise ValueError
            except ValueError:
                raise AeroSloshError(f"{name} = '{word}'", where, "a finite number in every place") from None
        rows.append([float(word) for word in row])
    values = np.array(rows)
    column = header.index("time")
    times = values[:, column]
    backwards = np.nonzero(np.diff(times) <= 0.0)[0]
    if backwards.size:
        later = int(backwards[0]) + 1
        where = f"{path}, line {lines[1 + later][0]}"
        raise AeroSloshError(f"time = {times[later]:g} does not grow", where, "times in rising order")
    return Table(times, [n for n in header if n != "time"], np.delete(values, column, axis=1))


def completed(table: Table, inputs: Collection[str]) -> tuple[Table, list[str]]:
    """The table with rates and accelerations that the FMU takes and the table leaves out, and their names.

    For columns q of which the FMU has inputs q, q_dot, q_ddot: derivatives of the cubic spline through the highest one given. An
    FMU feels accelerations; positions alone would tell it of a tank at rest.
    """
    columns = dict(zip(table.names, table.values.T, strict=True))
    derived = []
    for name in table.names:
        lower = name
        for higher in (f"{name}_dot", f"{name}_ddot"):
            if f"{name}_ddot" not in inputs or name not in inputs:
                break
            if higher not in columns:
                columns[higher] = CubicSpline(table.times, columns[lower]).derivative()(table.times)
                derived.append(higher)
            lower = higher
    return Table(table.times, list(columns), np.stack(list(columns.values()), axis=1)), derived


def set_parameters(component: Component, settings: list[str]) -> None:
    """Set `name=value` parameters by their type. Raises AeroSloshError for unknown names and values that do not read."""
    for setting in settings:
        name, equals, text = setting.partition("=")
        variable = component.variables.get(name.strip())
        if not equals or variable is None or variable.causality != "parameter":
            names = sorted(n for n, v in component.variables.items() if v.causality == "parameter")
            raise AeroSloshError(f"'{setting}' sets no parameter of {component.name}", "--set", f"one of {', '.join(names)}")
        text = text.strip()
        try:
            if variable.type == "Boolean":
                value: float | bool | str = {"true": True, "false": False, "1": True, "0": False}[text.lower()]
            else:
                value = text if variable.type == "String" else float(text) if variable.type == "Real" else int(text)
        except (KeyError, ValueError):
            raise AeroSloshError(f"'{text}' is no {variable.type} for {name}", "--set", "a value of that type") from None
        component.set(variable.name, value)


def prepare_fields(component: Component, default: Path) -> Path:
    """Make the folder of an FMU's fields ready: its field_folder, or `default` where that is empty; returns it.

    An earlier run's fields in it go: mixed with the new ones they would tell a wrong story. Raises AeroSloshError for an FMU
    without fields.
    """
    if any(name not in component.variables for name in ("write_fields", "field_folder")):
        raise AeroSloshError(f"{component.name} writes no fields", "--fields", "leave it out, or take an FMU with write_fields")
    folder = Path(component.get("field_folder") or default).resolve()
    component.set("field_folder", str(folder))
    for path in folder.glob("*.vt[sp]"):
        if FIELD_FILE.fullmatch(path.name):
            path.unlink()
    return folder


def collect_fields(folder: Path, table: Table, every: int) -> Path:
    """Write <folder>.pvd, the fields of a run with their times. every: as in `run`. Returns its path."""
    numbers = sorted({pvd.number(path) for path in folder.glob("*.vt[sp]") if FIELD_FILE.fullmatch(path.name)})
    asked = table.times[::every]
    # an FMU whose fields begin with its first step has none of the first row
    return pvd.write_beside(folder, dict(zip(numbers, asked[-len(numbers) :], strict=False)))


def run(component: Component, table: Table, every: int = 0) -> dict[str, np.ndarray]:
    """Drive an FMU whose parameters are set; returns `time` and every numeric output, each (n,).

    every: rows between fields (`prepare_fields` first), 0 for none. Raises AeroSloshError for a column that is no Real input,
    ComponentError when the FMU fails.
    """
    unknown = [name for name in table.names if name not in component.input_index]
    if unknown:
        known = ", ".join(component.input_index)
        raise AeroSloshError(f"'{unknown[0]}' is no Real input of {component.name}", "--input", f"the inputs are {known}")
    where = [component.input_index[name] for name in table.names]
    for name, value in zip(table.names, table.values[0], strict=True):
        component.set(name, float(value))
    if every:
        component.set("write_fields", True)
    component.initialize(float(table.times[0]))
    groups = [component.outputs, component.whole, component.truth]
    names = [name for group in groups for name in group.names if name != "failed"]
    rows = []

    def note() -> None:
        component.whole.get()
        component.truth.get()
        rows.append([float(v) for group in groups for n, v in zip(group.names, group.values, strict=True) if n != "failed"])

    note()
    for k in range(1, table.times.size):
        component.inputs.values[where] = table.values[k]
        if every:
            component.set("write_fields", k % every == 0)
        # from where the FMU stands: sums of steps would drift from the table's times
        component.step(float(table.times[k]) - component.time)
        note()
    return {"time": table.times, **dict(zip(names, np.array(rows).T, strict=True))}


def write(path: Path, columns: dict[str, np.ndarray]) -> None:
    """Write columns as CSV, whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with files.part(path) as hidden, hidden.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(columns)
        writer.writerows(zip(*([repr(float(v)) for v in column] for column in columns.values()), strict=True))
