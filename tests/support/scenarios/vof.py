"""Scenarios of slosh_vof."""

from __future__ import annotations

import math
import os
from typing import Any

import fmpy
import numpy as np

from ..instance import Instance
from .slosh import SLOSH_LOADS, slosh_motion, slosh_step

BOX = {"cells_x": 32, "cells_y": 16}
VOF_OUTPUTS = (*SLOSH_LOADS, "force_x_tank", "force_y_tank", "force_west", "force_east", "liquid_volume", "wave_height_west",
               "wave_height_east", "work", "time_step", "residual")  # fmt: skip
VOF_WAVES = {"h": [2e-3, 31.0, 0.2], "alpha": [0.06, 6.0, 0.0], "x": [1e-3, 7.0, 1.0]}


def _vof_rows(tank: Instance, first: int, last: int, step_size: float) -> list[list[Any]]:
    rows = []
    for i in range(first, last):
        slosh_step(tank, VOF_WAVES, i * step_size, step_size)
        rows.append([*(tank[name].hex() for name in VOF_OUTPUTS), tank["steps"], tank["iterations"], tank["converged"]])
    return rows


def vof_rollback(path: str, values: dict[str, Any], step_size: float, keep: str) -> Any:
    """Drive, go back twice, drive again; the state as bytes in the file `keep`."""
    tank = Instance(path).start(**values)
    before = _vof_rows(tank, 0, 10, step_size)[-1]
    state = tank.fmu.getFMUstate()
    with open(keep, "wb") as file:
        file.write(tank.fmu.serializeFMUstate(state))
    runs = [_vof_rows(tank, 10, 30, step_size)]
    for _ in range(2):
        tank.take(state)
        now = [tank[name].hex() for name in VOF_OUTPUTS]
        runs.append(_vof_rows(tank, 10, 30, step_size))
    return {"before": before, "now": now, "runs": runs}


def vof_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process, in an instance that was never started with these parameters."""
    tank = Instance(path).start(**BOX)
    with open(kept, "rb") as file:
        tank.take(tank.fmu.deSerializeFMUstate(file.read()))
    assert not tank["failed"], tank["error"]
    return _vof_rows(tank, 10, 30, step_size)


def vof_starts(path: str, cases: list[dict[str, Any]], wanted: list[str]) -> Any:
    """Each case's `wanted` outputs at the start."""
    folder = Instance(path).folder
    starts = [Instance(path, f"i{i}", folder).start(**{**BOX, **case}) for i, case in enumerate(cases)]
    return [[one[name] for name in wanted] for one in starts]


def vof_steps(
    path: str, values: dict[str, Any], waves: dict[str, list[float]], runs: list[list[float]], wanted: list[str]
) -> Any:
    """Harmonic motion in steps of each size, `runs` of [step size, steps]: outputs at the start and after each step, by run."""
    folder, found = Instance(path).folder, []
    for number, (step_size, count) in enumerate(runs):
        tank = Instance(path, f"run{number}", folder)
        slosh_motion(tank, waves, 0.0)
        tank.start(**values)
        rows = [[tank[name] for name in wanted]]
        for i in range(int(count)):
            slosh_step(tank, waves, i * step_size, step_size)
            rows.append([tank[name] for name in wanted])
        found.append(rows)
    return found


def vof_simulate(path: str, values: dict[str, Any], table: list[list[float]], names: list[str], wanted: list[str]) -> Any:
    """FMPy's simulate_fmu with a table of inputs (first column: time, equal steps); the `wanted` outputs at its times."""
    signals = np.array([tuple(row) for row in table], dtype=[(name, float) for name in ["time", *names]])
    times = signals["time"]
    result = fmpy.simulate_fmu(
        path, start_time=times[0], stop_time=times[-1], output_interval=times[1] - times[0], start_values=values, input=signals,
        output=wanted,
    )  # fmt: skip
    return [[float(row[name]) for name in ["time", *wanted]] for row in result]


def vof_family(path: str) -> Any:
    """Three tanks in one process, stepped in turn: shallow, deep, deep with a baffle; then the first one alone."""
    kinds = [{"fill_level": 0.3}, {"fill_level": 0.7}, {"fill_level": 0.7, "baffle_count": 1, "baffle_top": 0.6}]
    tanks = [Instance(path, f"tank{i}").start(**BOX, **values) for i, values in enumerate(kinds)]
    for i in range(20):
        for tank in tanks:
            slosh_step(tank, VOF_WAVES, 0.01 * i, 0.01)
    alone = Instance(path, "alone").start(**BOX, **kinds[0])
    for i in range(20):
        slosh_step(alone, VOF_WAVES, 0.01 * i, 0.01)
    return [[tank["force_x"], tank["moment"]] for tank in (*tanks, alone)]


def vof_bad_starts(path: str, cases: list[dict[str, Any]]) -> Any:
    """Start with values that must be refused, each in an instance of its own."""
    folder, seen = Instance(path).folder, []
    for i, values in enumerate(cases):
        one = Instance(path, f"i{i}", folder).start(**{**BOX, **values})
        seen.append({"failed": one["failed"], "error": one["error"], "status": one.step(0.0, 1e-3)})
    return seen


def vof_bad_inputs(path: str, cases: list[list[Any]]) -> Any:
    """Bad values [name, value] as inputs of a running tank, after each a good one; its load at the end and without all that."""
    tank, calm = Instance(path).start(**BOX, initial_wave=0.01), Instance(path, "calm").start(**BOX, initial_wave=0.01)
    seen = []
    for i, (name, value) in enumerate(cases):
        tank[name] = math.nan if value is None else value
        seen.append({"status": tank.step(0.01 * i, 0.01), "error": tank["error"], "force_x": str(tank["force_x"])})
        tank[name] = 0.0
        seen[-1]["again"] = tank.step(0.01 * i, 0.01)
        assert calm.step(0.01 * i, 0.01) == 0
    return {"seen": seen, "failed": tank["failed"], "loads": [tank["force_x"], calm["force_x"]]}


def vof_fields(path: str, folder: str) -> Any:
    """Write VTK files at the start and on the second of three steps; refuse without a folder."""
    tank = Instance(path).start(**BOX, field_folder=folder, write_fields=True, tank_x=0.3, baffle_count=1,
                                ribs="x=0.125 open=0.1125:0.15")  # fmt: skip
    for i in range(3):
        tank["write_fields"] = i == 1
        tank["h"], tank["x"], tank["alpha"] = 0.01 * i, 0.1 * i, 0.02 * i
        assert tank.step(i * 1e-3, 1e-3) == 0, tank["error"]
    homeless = Instance(path).start(**BOX)
    homeless["write_fields"] = True
    return {
        "files": sorted(os.listdir(folder)), "volume": tank["liquid_volume"],
        "status": homeless.step(0.0, 1e-3), "error": homeless["error"],
    }  # fmt: skip
