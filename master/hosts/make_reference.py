"""Make the reference result of an FMU anew: `python -m aeroslosh.master.hosts.make_reference FMU FOLDER`.

FOLDER holds experiment.json (see `reference`); input.csv, output.csv and picture.svg are written beside it."""

from __future__ import annotations

import argparse
import io
import json
import os
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import fmpy
import numpy as np

from ..base import files
from .reference import Columns, simulate


def motion(experiment: Mapping[str, Any], names: Mapping[str, Any]) -> Columns:
    """Return the columns of input.csv: harmonic inputs that rise over `ramp` [s], each with its rate and acceleration where the
    FMU (`names`) has those.

    A row holds what is true one step later; the motion begins after the first step, so that the first row is rest."""
    step = experiment["step_size"]
    times = step * np.arange(round(experiment["stop_time"] / step) + 1)
    columns = {"time": times}
    for name, wave in experiment["inputs"].items():
        values = _harmonic(times, wave["amplitude"], wave["omega"], wave["ramp"])
        for suffix, column in zip(("", "_dot", "_ddot"), values, strict=True):
            if name + suffix in names:
                columns[name + suffix] = column
    return columns


def _harmonic(t: np.ndarray, amplitude: float, omega: float, ramp: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A r(t) sin(omega t), r a quintic from 0 to 1 over `ramp`, and its two derivatives."""
    u = np.clip(t / ramp, 0.0, 1.0)
    inside = (u > 0.0) & (u < 1.0)
    r = u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    r1 = np.where(inside, 30.0 * u**2 * (1.0 - u) ** 2, 0.0) / ramp
    r2 = np.where(inside, 60.0 * u * (1.0 - u) * (1.0 - 2.0 * u), 0.0) / ramp**2
    s, c = np.sin(omega * t), np.cos(omega * t)
    return (
        amplitude * r * s,
        amplitude * (r1 * s + r * omega * c),
        amplitude * (r2 * s + 2.0 * r1 * omega * c - r * omega**2 * s),
    )


def make(fmu: Path, folder: Path) -> list[Path]:
    """Write input.csv, output.csv and picture.svg of the experiment in `folder`; returns the paths. Raises AeroSloshError."""
    experiment = json.loads((folder / "experiment.json").read_text(encoding="utf-8"))
    description = fmpy.read_model_description(str(fmu), validate=False)
    units = {variable.name: variable.unit or "1" for variable in description.modelVariables}
    inputs = motion(experiment, units)
    outputs = simulate(fmu, experiment, inputs)
    paths = [folder / "input.csv", folder / "output.csv", folder / "picture.svg"]
    files.write(paths[0], _text(inputs).encode())
    files.write(paths[1], _text(outputs).encode())
    _draw(paths[2], experiment["title"], inputs, outputs, units)
    return paths


def _draw(path: Path, title: str, inputs: Columns, outputs: Columns, units: Mapping[str, str]) -> None:
    """Inputs (positions and loads) and outputs over time."""
    from ..pictures import canvas

    shown = {name: column for name, column in inputs.items() if name != "time" and not name.endswith("dot")}
    panels = [(inputs["time"], name, column, "C7") for name, column in shown.items()]
    panels += [(outputs["time"], name, column, "C0") for name, column in outputs.items() if name != "time"]
    rows = -(-len(panels) // 2)
    figure, axes = canvas.subplots(rows, 2, figsize=(9.0, 1.6 * rows + 0.6), sharex=True, squeeze=False, layout="constrained")
    for axis, (times, name, column, colour) in zip(axes.flat, panels, strict=False):
        axis.plot(times, column, color=colour, lw=1.2)
        axis.set_ylabel(f"{name} [{units[name]}]", fontsize=8)
        axis.tick_params(labelsize=7)
        axis.grid(alpha=0.3)
    for axis in axes.flat[len(panels) :]:
        axis.set_axis_off()
    for axis in axes[-1]:
        axis.set_xlabel("time [s]", fontsize=8)
    figure.suptitle(title, fontsize=10)
    picture = io.BytesIO()
    # the same picture is the same file; texts stay texts
    with canvas.rc_context({"svg.hashsalt": "aeroslosh", "svg.fonttype": "none"}):
        figure.savefig(picture, format="svg", metadata={"Date": None})
    files.write(path, picture.getvalue())


def _text(columns: Columns) -> str:
    lines = [",".join(columns)]
    lines += [",".join(map(repr, row)) for row in zip(*(column.tolist() for column in columns.values()), strict=True)]
    return "\n".join(lines) + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Make a reference anew; returns the exit code."""
    parser = argparse.ArgumentParser(
        prog="python -m aeroslosh.master.hosts.make_reference", description="Make an FMU's reference result anew."
    )
    parser.add_argument("fmu", type=Path, help="e.g. dist/fmus/aero.fmu")
    parser.add_argument("folder", type=Path, help="e.g. fmus/aero/reference, with its experiment.json")
    options = parser.parse_args(arguments)
    print(*make(options.fmu, options.folder), sep="\n")
    return 0


if __name__ == "__main__":
    code = main()
    sys.stdout.flush()
    os._exit(code)  # pythonfmu releases its interpreter state twice at a normal exit
