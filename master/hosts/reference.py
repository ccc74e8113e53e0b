"""The reference result that an FMU carries, and the FMU run against it through FMPy's own `simulate_fmu`.

In the FMU, documentation/reference/:
    experiment.json   title, start_values, step_size [s], stop_time [s], inputs (how input.csv was made), outputs: the largest
                      difference allowed for each, over the largest magnitude of its column
    input.csv         `time` and the inputs that a host sets before the step that starts at that time
    output.csv        `time` and the outputs at that time
Values are set before a step and mean its end: a row of input.csv holds the motion one step later. So any tool that sets a row
and steps reproduces output.csv, with nothing lagging.
`python -m aeroslosh.master.hosts.make_reference` makes them.
"""

from __future__ import annotations

import csv
import io
import json
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..base.errors import AeroSloshError
from ..fmi import unpack

INSIDE = "documentation/reference/"
Columns = dict[str, np.ndarray]


@dataclass(frozen=True)
class Reference:
    """What output.csv should be. Columns have shape (n_rows,)."""

    experiment: dict[str, Any]
    inputs: Columns
    outputs: Columns


@dataclass(frozen=True)
class Difference:
    """How far one output is from its reference: both relative to the largest magnitude of the reference."""

    name: str
    found: float
    allowed: float

    @property
    def fits(self) -> bool:
        """Whether it is small enough (NaN is not)."""
        return self.found <= self.allowed


def carried(fmu: Path) -> bool:
    """Tell whether the FMU holds a reference result."""
    with zipfile.ZipFile(fmu) as archive:
        return f"{INSIDE}experiment.json" in archive.namelist()


def read(fmu: Path) -> Reference:
    """Return the reference in the FMU. Raises AeroSloshError where there is none or it is damaged."""
    try:
        with zipfile.ZipFile(fmu) as archive:
            texts = {name: archive.read(INSIDE + name).decode() for name in ("experiment.json", "input.csv", "output.csv")}
        experiment = json.loads(texts["experiment.json"])
        if missing := {"start_values", "step_size", "stop_time", "outputs"} - set(experiment):
            raise ValueError(f"experiment.json lacks {', '.join(sorted(missing))}")
        known = Reference(experiment, _columns(texts["input.csv"], "input.csv"), _columns(texts["output.csv"], "output.csv"))
        if missing := set(experiment["outputs"]) - set(known.outputs):
            raise ValueError(f"output.csv lacks {', '.join(sorted(missing))}")
        return known
    except KeyError as error:
        raise AeroSloshError(
            f"The FMU carries no reference result ({error.args[0]})", str(fmu), "build the FMUs of this project with `make fmus`"
        ) from None
    except (OSError, ValueError, zipfile.BadZipFile) as error:
        raise AeroSloshError(f"The reference result cannot be read: {error}", str(fmu), "build the FMU again") from None


def simulate(fmu: Path, experiment: Mapping[str, Any], inputs: Columns) -> Columns:
    """Run the experiment with FMPy's simulate_fmu and return time and the outputs asked for.

    Raises AeroSloshError when the FMU fails; its own words are in the message."""
    table = None
    if len(inputs) > 1:
        table = np.zeros(inputs["time"].size, dtype=[(name, float) for name in inputs])
        for name, column in inputs.items():
            table[name] = column
    said: list[str] = []
    try:
        result = fmpy.simulate_fmu(
            str(fmu), start_time=0.0, stop_time=experiment["stop_time"], output_interval=experiment["step_size"],
            start_values=dict(experiment["start_values"]), input=table, output=list(experiment["outputs"]), debug_logging=True,
            logger=lambda _environment, _name, status, _category, message: said.append(message.decode(errors="replace")),
        )  # fmt: skip
    except Exception as error:
        what = said[0].strip().splitlines()[0] if said else str(error)
        raise AeroSloshError(f"The reference experiment failed: {what}", str(fmu), "read the message of the FMU") from error
    return {name: np.asarray(result[name], dtype=float) for name in ("time", *experiment["outputs"])}


def check(fmu: Path) -> list[Difference]:
    """Run the FMU's own reference experiment and return how far each output is from it. Raises AeroSloshError."""
    reference = read(fmu)
    folder, _ = unpack.unzip(fmu)  # a plain path, whatever the temporary folder is called
    found = simulate(folder, reference.experiment, reference.inputs)
    return [
        Difference(name, _distance(found[name], reference.outputs[name]), float(allowed))
        for name, allowed in reference.experiment["outputs"].items()
    ]


def _columns(text: str, file: str) -> Columns:
    rows = list(csv.reader(io.StringIO(text)))
    if len(rows) < 3 or len({len(row) for row in rows}) != 1:
        raise ValueError(f"the rows of {file} are not of one length")
    values = np.array(rows[1:], dtype=float)
    return {name: values[:, column] for column, name in enumerate(rows[0])}


def _distance(found: np.ndarray, wanted: np.ndarray) -> float:
    if found.shape != wanted.shape:
        return float("inf")
    largest = float(np.abs(wanted).max())
    return float(np.abs(found - wanted).max()) / (largest if largest > 0.0 else 1.0)
