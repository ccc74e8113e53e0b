"""Scenarios of structure and aero."""

from __future__ import annotations

import gc
import os
from typing import Any

from ..instance import Instance

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
    wing.take(state)
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
    wing.take(state)
    assert not wing["failed"], wing["error"]
    return _drive(wing, 20, 60)


def damaged(path: str, data: str) -> Any:
    """Restore damaged bytes."""
    wing = Instance(path).start()
    raw = bytearray(bytes.fromhex(data))
    raw[len(raw) // 2] ^= 1
    wing.take(wing.fmu.deSerializeFMUstate(bytes(raw)))
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
    flow.take(state)
    with open(keep, "wb") as file:
        file.write(data)
    return {"first": first, "second": _pitch(flow, 4, 12, step_size)}


def aero_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process."""
    flow = Instance(path).start(**COARSE)
    with open(kept, "rb") as file:
        flow.take(flow.fmu.deSerializeFMUstate(file.read()))
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
