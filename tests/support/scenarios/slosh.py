"""Scenarios of every slosh FMU, and of slosh_ems."""

from __future__ import annotations

import math
import time as clock
from typing import Any

from ..instance import Instance

SLOSH_LOADS = ("force_x", "force_y", "moment", "force_x_residual", "force_y_residual", "moment_residual")


def slosh_step(tank: Instance, waves: dict[str, list[float]], time: float, step_size: float) -> None:
    """One step to harmonic motion: `waves` gives amplitude, frequency and phase of h, alpha, x."""
    slosh_motion(tank, waves, time + step_size)
    assert tank.step(time, step_size) == 0, tank["error"]


def slosh_motion(tank: Instance, waves: dict[str, list[float]], time: float) -> None:
    for name, (size, omega, phase) in waves.items():
        s, c = math.sin(omega * time + phase), math.cos(omega * time + phase)
        tank[name], tank[f"{name}_dot"], tank[f"{name}_ddot"] = size * s, size * omega * c, -size * omega**2 * s


def slosh_harmonic(path: str, values: dict[str, Any], waves: dict[str, list[float]], step_size: float, count: int,
                   wanted: list[str]) -> Any:  # fmt: skip
    """Drive a slosh FMU by harmonic motion; returns the `wanted` outputs at the start and after each step."""
    tank = Instance(path)
    slosh_motion(tank, waves, 0.0)
    tank.start(**values)
    rows = [[tank[name] for name in wanted]]
    for i in range(count):
        slosh_step(tank, waves, i * step_size, step_size)
        rows.append([tank[name] for name in wanted])
    return rows


def _slosh_rows(tank: Instance, first: int, last: int, step_size: float) -> list[list[str]]:
    rows = []
    for i in range(first, last):
        slosh_step(tank, {"h": [2e-3, 31.0, 0.2], "alpha": [0.02, 23.0, 0.0], "x": [1e-3, 7.0, 1.0]}, i * step_size, step_size)
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
    tank.take(state)
    return {"first": first, "second": _slosh_rows(tank, 20, 60, step_size)}


def slosh_resume(path: str, step_size: float, kept: str) -> Any:
    """Continue from a file's bytes in a new process, in an instance that was never started with these parameters."""
    tank = Instance(path).start()
    with open(kept, "rb") as file:
        tank.take(tank.fmu.deSerializeFMUstate(file.read()))
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
            slosh_step(tank, waves, 0.01 * i, 0.01)
    for i in range(20):
        slosh_step(alone, waves, 0.01 * i, 0.01)
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
