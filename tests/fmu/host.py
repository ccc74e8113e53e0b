"""A small host: `python host.py <scenario> <json arguments>` runs FMUs through FMPy and prints JSON.

Each scenario has a process of its own, so that a crash is seen as a crash, and ends with `os._exit`
(pythonfmu 0.7 releases its interpreter state twice at process exit).
"""

from __future__ import annotations

import gc
import json
import math
import os
import sys
import tempfile
import time as clock
from ctypes import byref
from pathlib import Path
from typing import Any

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.logging import addLoggerProxy

from master.hosts import reference as references

LOG: list[tuple[int, str, str]] = []


class Instance:
    """One FMU instance with variables by name."""

    def __init__(self, path: str, name: str = "test", folder: str | None = None) -> None:
        if folder is None:
            folder = tempfile.mkdtemp(prefix="fmu_")
            fmpy.extract(path, folder)
        self.folder = folder
        description = fmpy.read_model_description(folder)
        self.variables = {v.name: v for v in description.modelVariables}
        self.fmu = FMU2Slave(
            guid=description.guid,
            unzipDirectory=folder,
            instanceName=name,
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _env, _name, status, category, message: LOG.append((status, category.decode(), message.decode()))
        )
        self.callbacks.allocateMemory = fmpy.fmi2.defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = fmpy.fmi2.defaultCallbacks.freeMemory
        addLoggerProxy(byref(self.callbacks))
        self.fmu.instantiate(callbacks=self.callbacks, loggingOn=True)

    def __getitem__(self, name: str) -> Any:
        variable = self.variables[name]
        reference = [variable.valueReference]
        if variable.type == "Real":
            return self.fmu.getReal(reference)[0]
        if variable.type == "Boolean":
            return bool(self.fmu.getBoolean(reference)[0])
        if variable.type == "String":
            return self.fmu.getString(reference)[0].decode()
        return self.fmu.getInteger(reference)[0]

    def __setitem__(self, name: str, value: Any) -> None:
        variable = self.variables[name]
        reference = [variable.valueReference]
        setter = {"Real": self.fmu.setReal, "Boolean": self.fmu.setBoolean, "String": self.fmu.setString}.get(
            variable.type, self.fmu.setInteger
        )
        setter(reference, [value])

    def start(self, **values: Any) -> Instance:
        """Set `values`, go through initialisation."""
        for name, value in values.items():
            self[name] = value
        self.fmu.setupExperiment(startTime=0.0)
        self.fmu.enterInitializationMode()
        self.fmu.exitInitializationMode()
        return self

    def step(self, time: float, step_size: float) -> int:
        """Step and return the FMI status."""
        try:
            self.fmu.doStep(time, step_size)
        except FMICallException as error:
            return int(error.status)
        return 0


def fault(path: str, kind: int) -> Any:
    """Fail in a step, collect garbage, be told, recover by a state, step again."""
    one = Instance(path).start()
    one["u"] = 1.0
    statuses = [one.step(0.0, 0.1)]
    good = one.fmu.getFMUstate()
    bad = Instance(path).start(fault=kind)
    after_start = bad["failed"]
    bad_statuses = [bad.step(0.0, 0.1), bad.step(0.1, 0.1)]
    gc.collect()
    seen = {"failed": bad["failed"], "error": bad["error"], "y": bad["y"], "after_start": after_start}
    bad.fmu.setFMUstate(good)
    recovered = {"failed": bad["failed"], "error": bad["error"], "y": bad["y"]}
    bad["u"] = 1.0
    bad_statuses.append(bad.step(0.1, 0.1))
    recovered["next"] = bad["y"]
    for _ in range(3):
        gc.collect()
    one.fmu.freeInstance()
    bad.fmu.freeInstance()
    gc.collect()
    return {"good": statuses, "bad": bad_statuses, "seen": seen, "recovered": recovered, "log": LOG}


def state_faults(path: str, kind: int) -> Any:
    """Take, restore and serialise a state with a face that fails in it."""
    one = Instance(path).start(fault=kind)
    one.step(0.0, 0.1)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)
    again = one.fmu.deSerializeFMUstate(data)
    one.fmu.setFMUstate(again)
    return {"failed": one["failed"], "error": one["error"], "status": one.step(0.1, 0.1)}


def refused(path: str) -> Any:
    """Set values that must be refused, before and after the start."""
    result: dict[str, Any] = {}
    for name, value in (
        ("gain", 9.0),
        ("gain", float("nan")),
        ("count", 7),
        ("fault", 99),
        ("u", float("inf")),
        ("y", 1.0),
    ):
        one = Instance(path)
        one[name] = value
        before = one["error"]
        one.start()
        result[f"{name}={value}"] = [before, one["failed"], one["error"], one.step(0.0, 0.1), str(one["y"])]
    one = Instance(path).start()
    one["u"] = float("nan")
    result["input"] = [one["u"], one.step(0.0, 0.1), one["error"]]
    one["u"] = 1.0
    result["input again"] = [one.step(0.0, 0.1), one["failed"], one["y"]]
    one["gain"] = 3.0
    result["late"] = [one.step(0.1, 0.1), one["error"]]
    result["numbers"] = [one["gain"], one["count"], one["label"]]
    return result


def many(path: str, count: int) -> Any:
    """Instantiate, run and free many times."""
    folder = None
    for i in range(count):
        one = Instance(path, f"i{i}", folder).start()
        folder = one.folder
        assert one.step(0.0, 0.1) == 0
        one.fmu.terminate()
        one.fmu.freeInstance()
    gc.collect()
    return count


def two_versions(first: str, second: str) -> Any:
    """Run two versions of one FMU in one process."""
    one, two = Instance(first, "one").start(), Instance(second, "two").start()
    for instance in (one, two, one, two):
        instance["u"] = 1.0
    one.step(0.0, 0.1)
    two.step(0.0, 0.1)
    state = one.fmu.getFMUstate()
    data = one.fmu.serializeFMUstate(state)
    two.fmu.setFMUstate(two.fmu.deSerializeFMUstate(data))
    return {"y": [one["y"]], "failed": two["failed"], "error": two["error"]}


def reset(path: str) -> Any:
    """Fail, reset, run again."""
    one = Instance(path).start(fault=1)
    statuses = [one.step(0.0, 0.1)]
    one.fmu.reset()
    one.start()
    one["u"] = 1.0
    statuses.append(one.step(0.0, 0.1))
    return {"statuses": statuses, "y": one["y"], "failed": one["failed"]}


def kernels(path: str) -> Any:
    """Run a compiled kernel from a fresh unzip folder."""
    one = Instance(path).start()
    return {"y": one["y"], "hits": one["hits"], "misses": one["misses"], "error": one["error"]}


LOADS = ("lift", "moment", "slosh_force_y", "slosh_moment")
MOTION = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot", "energy")
STEP = 1.3e-3


def _drive(wing: Instance, first: int, last: int) -> list[list[str]]:
    rows = []
    for i in range(first, last):
        for k, name in enumerate(LOADS):
            wing[name] = 500.0 * (k + 1) * ((i * 7919 + k) % 13 - 6)
        assert wing.step(i * STEP, STEP) == 0, wing["error"]
        rows.append([wing[name].hex() for name in MOTION])
    return rows


WING = {"forced_cycles": 0.75, "forced_amplitude": 0.02, "load_prediction": 1, "damping_ratio_h": 0.01}


def rollback(path: str) -> Any:
    """Run, go back, run again; hand out the state in bytes. The release lies between."""
    wing = Instance(path).start(**WING)
    before = _drive(wing, 0, 20)
    state = wing.fmu.getFMUstate()
    data = wing.fmu.serializeFMUstate(state)
    first = _drive(wing, 20, 60)
    wing.fmu.setFMUstate(state)
    second = _drive(wing, 20, 60)
    wing.fmu.freeFMUstate(state)
    return {
        "before": before,
        "first": first,
        "second": second,
        "released": wing["released"],
        "state": data.hex(),
    }


def resume(path: str, data: str) -> Any:
    """Continue from bytes in a new process, in an instance that was never started with these parameters."""
    wing = Instance(path).start()
    state = wing.fmu.deSerializeFMUstate(bytes.fromhex(data))
    wing.fmu.setFMUstate(state)
    assert not wing["failed"], wing["error"]
    return _drive(wing, 20, 60)


def damaged(path: str, data: str) -> Any:
    """Restore damaged bytes."""
    wing = Instance(path).start()
    raw = bytearray(bytes.fromhex(data))
    raw[len(raw) // 2] ^= 1
    wing.fmu.setFMUstate(wing.fmu.deSerializeFMUstate(bytes(raw)))
    return {"failed": wing["failed"], "error": wing["error"], "h": str(wing["h"])}


def free_decay(path: str, start: dict[str, float], step_size: float, steps: int) -> Any:
    """Free motion from `start`; returns h and alpha after each step."""
    wing = Instance(path).start(**start)
    rows = [[wing["h"], wing["alpha"]]]
    for i in range(steps):
        assert wing.step(i * step_size, step_size) == 0, wing["error"]
        rows.append([wing["h"], wing["alpha"]])
    return rows


COARSE = {"cells_around": 64, "cells_normal": 16}


def _pitch(flow: Instance, first: int, last: int, step_size: float) -> list[list[str]]:
    rows = []
    for i in range(first, last):
        angle = 1e-3 * (i + 1)
        flow["alpha"], flow["alpha_dot"] = angle, 1e-3 / step_size
        assert flow.step(i * step_size, step_size) == 0, flow["error"]
        rows.append([flow[name].hex() for name in ("lift", "moment", "C_L", "C_M", "C_D")])
    return rows


def aero_rollback(path: str, step_size: float, keep: str) -> Any:
    """Pitch, go back, pitch again; the state as bytes in the file `keep`."""
    flow = Instance(path).start(**COARSE)
    _pitch(flow, 0, 4, step_size)
    state = flow.fmu.getFMUstate()
    data = flow.fmu.serializeFMUstate(state)
    first = _pitch(flow, 4, 12, step_size)
    flow.fmu.setFMUstate(state)
    with open(keep, "wb") as file:
        file.write(data)
    return {"first": first, "second": _pitch(flow, 4, 12, step_size)}


def aero_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process."""
    flow = Instance(path).start(**COARSE)
    with open(kept, "rb") as file:
        flow.fmu.setFMUstate(flow.fmu.deSerializeFMUstate(file.read()))
    assert not flow["failed"], flow["error"]
    return _pitch(flow, 4, 12, step_size)


def family(aero: str, structure: str) -> Any:
    """Two flows at two Mach numbers and a structure in one process, stepped in turn."""
    slow, fast = Instance(aero, "slow"), Instance(aero, "fast", None)
    slow.start(mach=0.5, mean_alpha=0.02, **COARSE)
    fast.start(mach=0.75, mean_alpha=0.02, **COARSE)
    wing = Instance(structure, "wing").start(forced_cycles=1.0, forced_ramp_cycles=0.0)
    step_size = 1e-3
    for i in range(5):
        assert wing.step(i * step_size, step_size) == 0
        for flow in (slow, fast):
            for name in ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot"):
                flow[name] = wing[name]
            assert flow.step(i * step_size, step_size) == 0, flow["error"]
    return {"alpha": wing["alpha"], "slow": slow["C_L"], "fast": fast["C_L"]}


def bad_start(path: str, values: dict[str, Any]) -> Any:
    """Start with values that must be refused."""
    one = Instance(path).start(**values)
    return {"failed": one["failed"], "error": one["error"], "status": one.step(0.0, 1e-3), "log": LOG}


def bad_input(path: str, name: str) -> Any:
    """A value that is not a number as an input, then a good one."""
    one = Instance(path).start(**COARSE)
    one[name] = float("nan")
    statuses, error = [one.step(0.0, 1e-3)], one["error"]
    one[name] = 0.0
    statuses.append(one.step(0.0, 1e-3))
    return {"statuses": statuses, "error": error, "failed": one["failed"]}


def aero_fields(path: str, folder: str) -> Any:
    """Write VTK files on the second of three steps; refuse without a folder."""
    flow = Instance(path).start(field_folder=folder, **COARSE)
    for i in range(3):
        flow["write_fields"] = i == 1
        flow["h"] = 0.01 * i
        assert flow.step(i * 1e-3, 1e-3) == 0, flow["error"]
    homeless = Instance(path).start(**COARSE)
    homeless["write_fields"] = True
    return {"files": sorted(os.listdir(folder)), "status": homeless.step(0.0, 1e-3), "error": homeless["error"]}


def slow_stream(path: str) -> Any:
    """Steps at Mach 0.1 in which sound travels two chords."""
    flow = Instance(path).start(mach=0.1, **COARSE)
    step_size = 2.0 / 340.3
    rows = []
    for i in range(8):
        angle = 2e-3 * (i + 1) ** 2
        flow["alpha"], flow["alpha_dot"] = angle, 4e-3 * (i + 1) / step_size
        status = flow.step(i * step_size, step_size)
        rows.append([status, flow["converged"], flow["C_L"] / angle])
    return rows


def many_flows(path: str, count: int, values: dict[str, Any]) -> Any:
    """Instantiate and free many times, with a flow in the first and the last."""
    folder = None
    for i in range(count):
        one = Instance(path, f"i{i}", folder)
        folder = one.folder
        if i in (0, count - 1):
            one.start(**values)
            assert one.step(0.0, 1e-3) == 0
        one.fmu.freeInstance()
    gc.collect()
    return count


SLOSH_LOADS = ("force_x", "force_y", "moment", "force_x_residual", "force_y_residual", "moment_residual")


def _slosh_step(tank: Instance, waves: dict[str, list[float]], time: float, step_size: float) -> None:
    """One step to harmonic motion: `waves` gives amplitude, frequency and phase of h, alpha, x."""
    _slosh_motion(tank, waves, time + step_size)
    assert tank.step(time, step_size) == 0, tank["error"]


def _slosh_motion(tank: Instance, waves: dict[str, list[float]], time: float) -> None:
    for name, (size, omega, phase) in waves.items():
        s, c = math.sin(omega * time + phase), math.cos(omega * time + phase)
        tank[name], tank[f"{name}_dot"], tank[f"{name}_ddot"] = size * s, size * omega * c, -size * omega**2 * s


def slosh_harmonic(path: str, values: dict[str, Any], waves: dict[str, list[float]], step_size: float, count: int,
                   wanted: list[str]) -> Any:  # fmt: skip
    """Drive a slosh FMU by harmonic motion; returns the `wanted` outputs at the start and after each step."""
    tank = Instance(path)
    _slosh_motion(tank, waves, 0.0)
    tank.start(**values)
    rows = [[tank[name] for name in wanted]]
    for i in range(count):
        _slosh_step(tank, waves, i * step_size, step_size)
        rows.append([tank[name] for name in wanted])
    return rows


def _slosh_rows(tank: Instance, first: int, last: int, step_size: float) -> list[list[str]]:
    rows = []
    for i in range(first, last):
        _slosh_step(tank, {"h": [2e-3, 31.0, 0.2], "alpha": [0.02, 23.0, 0.0], "x": [1e-3, 7.0, 1.0]}, i * step_size, step_size)
        rows.append([tank[name].hex() for name in (*SLOSH_LOADS, "validity", "wave_height_east")])
    return rows


def slosh_rollback(path: str, values: dict[str, Any], step_size: float, keep: str) -> Any:
    """Drive, go back, drive again; the state as bytes in the file `keep`."""
    tank = Instance(path).start(**values)
    _slosh_rows(tank, 0, 20, step_size)
    state = tank.fmu.getFMUstate()
    with open(keep, "wb") as file:
        file.write(tank.fmu.serializeFMUstate(state))
    first = _slosh_rows(tank, 20, 60, step_size)
    tank.fmu.setFMUstate(state)
    return {"first": first, "second": _slosh_rows(tank, 20, 60, step_size)}


def slosh_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process, in an instance that was never started with these parameters."""
    tank = Instance(path).start()
    with open(kept, "rb") as file:
        tank.fmu.setFMUstate(tank.fmu.deSerializeFMUstate(file.read()))
    assert not tank["failed"], tank["error"]
    return _slosh_rows(tank, 20, 60, step_size)


def slosh_two(path: str) -> Any:
    """Two tanks of different fills in one process, stepped in turn; then one alone for comparison."""
    shallow, deep, alone = (Instance(path, name) for name in ("shallow", "deep", "alone"))
    shallow.start(fill_level=0.2)
    deep.start(fill_level=0.8)
    alone.start(fill_level=0.2)
    waves = {"x": [1e-3, 3.0, 0.0]}
    for i in range(20):
        for tank in (shallow, deep):
            _slosh_step(tank, waves, 0.01 * i, 0.01)
    for i in range(20):
        _slosh_step(alone, waves, 0.01 * i, 0.01)
    return [tank["force_x"] for tank in (shallow, deep, alone)]


def slosh_cost(path: str, values: dict[str, Any], step_size: float, steps: int) -> Any:
    """Microseconds a step through FMI with harmonic motion: nine inputs, the step, six loads; the best of five stretches."""
    tank = Instance(path).start(**values)
    inputs = [tank.variables[f"{name}{order}"].valueReference for name in ("h", "alpha", "x") for order in ("", "_dot", "_ddot")]
    outputs = [tank.variables[name].valueReference for name in SLOSH_LOADS]
    best, omega = math.inf, 2.0 * math.pi / 72 / step_size
    for stretch in range(5):
        begin = clock.perf_counter()
        for i in range(stretch * steps, (stretch + 1) * steps):
            s, c = math.sin(omega * step_size * (i + 1)), math.cos(omega * step_size * (i + 1))
            wave = [s, omega * c, -(omega**2) * s]
            tank.fmu.setReal(inputs, [size * value for size in (1e-4, 1e-3, 1e-4) for value in wave])
            tank.fmu.doStep(i * step_size, step_size)
            tank.fmu.getReal(outputs)
        best = min(best, (clock.perf_counter() - begin) / steps)
    return 1e6 * best


def ems_let_go(path: str, values: dict[str, Any], tilt: float, step_size: float, steps: int) -> Any:
    """A level surface in a tilted tank that is set level in the first step: wave energy and height after each step."""
    tank = Instance(path).start(alpha=tilt, **values)
    rows = []
    tank["alpha"] = 0.0
    for i in range(steps):
        assert tank.step(i * step_size, step_size) == 0, tank["error"]
        rows.append([tank["wave_energy"], tank["wave_height_east"]])
    return rows


def slosh_lost(path: str, values: dict[str, Any]) -> Any:
    """Let the tank fall faster than gravity until the FMU gives up; its status, error, and whether a new start cures it."""
    tank = Instance(path).start(alpha=0.02, **values)
    status, steps = 0, 0
    while status == 0 and steps < 2000:
        tank["h_ddot"] = 30.0
        status = tank.step(0.01 * steps, 0.01)
        steps += 1
    seen = {"status": status, "error": tank["error"], "force_x": str(tank["force_x"]), "steps": steps}
    tank.fmu.reset()
    tank.start(alpha=0.0, h_ddot=0.0)
    return {**seen, "again": tank.step(0.0, 0.01)}


BOX = {"cells_x": 32, "cells_y": 16}
VOF_OUTPUTS = (*SLOSH_LOADS, "force_x_tank", "force_y_tank", "force_west", "force_east", "liquid_volume", "wave_height_west",
               "wave_height_east", "time_step", "residual")  # fmt: skip
VOF_WAVES = {"h": [2e-3, 31.0, 0.2], "alpha": [0.06, 6.0, 0.0], "x": [1e-3, 7.0, 1.0]}


def _vof_rows(tank: Instance, first: int, last: int, step_size: float) -> list[list[Any]]:
    rows = []
    for i in range(first, last):
        _slosh_step(tank, VOF_WAVES, i * step_size, step_size)
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
        tank.fmu.setFMUstate(state)
        now = [tank[name].hex() for name in VOF_OUTPUTS]
        runs.append(_vof_rows(tank, 10, 30, step_size))
    return {"before": before, "now": now, "runs": runs}


def vof_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process, in an instance that was never started with these parameters."""
    tank = Instance(path).start(**BOX)
    with open(kept, "rb") as file:
        tank.fmu.setFMUstate(tank.fmu.deSerializeFMUstate(file.read()))
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
        _slosh_motion(tank, waves, 0.0)
        tank.start(**values)
        rows = [[tank[name] for name in wanted]]
        for i in range(int(count)):
            _slosh_step(tank, waves, i * step_size, step_size)
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
            _slosh_step(tank, VOF_WAVES, 0.01 * i, 0.01)
    alone = Instance(path, "alone").start(**BOX, **kinds[0])
    for i in range(20):
        _slosh_step(alone, VOF_WAVES, 0.01 * i, 0.01)
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
    tank = Instance(path).start(**BOX, field_folder=folder, write_fields=True, tank_x=0.3, baffle_count=1)
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


def predicted(path: str, switch: str, values: dict[str, Any], names: list[str], keep: str) -> Any:
    """One instance that foretells its inputs, one that is told them, one that goes on from the first's bytes."""
    ahead, told = Instance(path, "ahead").start(**values, **{switch: 1}), Instance(path, "told").start(**values)
    outputs = [v.name for v in ahead.variables.values() if v.causality == "output" and v.type == "Real"]
    rows: dict[str, list[Any]] = {"ahead": [], "told": [], "resumed": []}
    old, time, past, resumed = [0.0] * len(names), 0.0, math.inf, None
    for i in range(12):
        step_size = 1e-3 * (1.0 + 0.5 * (i % 3))
        new = [1e-3 * math.sin((3.0 + place) * 40.0 * time) for place in range(len(names))]
        for one in [ahead, told] + ([resumed] if resumed else []):
            for name, a, b in zip(names, new, old, strict=True):
                share = step_size / past
                one[name] = (1.0 + share) * a - share * b if one is told else a
            assert one.step(time, step_size) == 0, one["error"]
        assert [ahead[name] for name in names] == new  # a host reads back what it set
        rows["ahead"].append([ahead[name].hex() for name in outputs])
        rows["told"].append([told[name].hex() for name in outputs])
        if resumed:
            rows["resumed"].append([resumed[name].hex() for name in outputs])
        old, past, time = new, step_size, time + step_size
        if i == 5:
            with open(keep, "wb") as file:
                file.write(ahead.fmu.serializeFMUstate(ahead.fmu.getFMUstate()))
            resumed = Instance(path, "resumed").start(**values)
            with open(keep, "rb") as file:
                resumed.fmu.setFMUstate(resumed.fmu.deSerializeFMUstate(file.read()))
    return rows


def reference(path: str) -> Any:
    """The FMU against its own reference result: name, difference, allowed."""
    return [[one.name, one.found, one.allowed] for one in references.check(Path(path))]


if __name__ == "__main__":
    answer = globals()[sys.argv[1]](*json.loads(sys.argv[2]))
    print("\n" + json.dumps(answer), flush=True)
    os._exit(0)
