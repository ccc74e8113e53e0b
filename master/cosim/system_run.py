"""The run of a system file: initialise, step to the end, keep the history. Non-convergence and failures are outcomes of it."""

from __future__ import annotations

import math
import time as clock
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..base.errors import AeroSloshError, ComponentError
from ..flutter.march import Watcher
from ..results.run_folder import put_attributes, written
from . import assemble as schemes
from .assemble import Statistics
from .checkpoint import Checkpoint, Keeper
from .system import System
from .system_file import Assembly


@dataclass
class Simulation:
    """What a run gave.

    time       of each sample, the first one being the start. Shape: (n,) [s]
    outputs    "component.output" → its values, each (n,); `passes` of each step; `units` of the outputs
    outcome    "completed", or why the run ended early; `converged` is False when a step did not converge
    failure    the component failure that ended it
    cpu        seconds in each component; `wall`, `total_cpu` of the whole run"""

    time: np.ndarray
    outputs: dict[str, np.ndarray]
    passes: np.ndarray
    units: dict[str, str]
    outcome: str
    converged: bool
    scheme: dict[str, Any]
    cpu: dict[str, float]
    wall: float
    total_cpu: float
    failure: ComponentError | None = None
    loops: list[list[str]] = field(default_factory=list)


def simulate(
    assembly: Assembly,
    system: System,
    watch: Watcher | None = None,
    keeper: Keeper | None = None,
    checkpoint: Checkpoint | None = None,
) -> Simulation:
    """Run `system` (of `assembly.build`, instances fresh). `keeper` writes checkpoints, from `checkpoint` a run goes on.

    Raises AeroSloshError for settings that do not fit the system; a failing step is an outcome."""
    begin = clock.perf_counter(), clock.process_time()
    before = {c.name: c.cpu for c in system.everyone}
    run, steps, dt = assembly.run, assembly.steps, assembly.dt
    if checkpoint is not None:
        _check_restart(checkpoint, assembly)
    scheme, statistics = schemes.make(assembly.coupling), Statistics()
    if keeper is not None:
        keeper.check(system)
    system.initialize(run.start)
    scheme.reset(system)
    rows = steps // run.record_every + 1
    try:
        values, passes = np.zeros((rows, system.values.size)), np.zeros(rows)
    except (MemoryError, ValueError):  # ValueError: more than an array can hold at all
        raise AeroSloshError(
            f"A history of {rows} samples of {system.values.size} outputs does not fit into memory",
            assembly.where("run", "record_every"),
            "record fewer samples (run.record_every), or make the run shorter",
        ) from None
    values[0], taken, first = system.values, 1, 1
    outcome, failure = "completed", None
    if checkpoint is not None:
        checkpoint.restore(system, scheme)
        past = checkpoint.part("history")
        taken, first = past["passes"].size, checkpoint.about["done"] + 1
        values[:taken], passes[:taken] = past["values"], past["passes"]
        statistics.restore(checkpoint.about["scheme"])
    try:
        for done in range(first, steps + 1):
            report = scheme.step(system, dt)
            statistics.note(report, run.start + done * dt)
            if not np.isfinite(system.values).all():
                names = [n for n, v in zip(_names(system), system.values, strict=True) if not np.isfinite(v)]
                outcome = f"{names[0]} is not a finite number at step {done}, t = {run.start + done * dt:.6g} s"
                break
            if done % run.record_every == 0:
                values[taken], passes[taken] = system.values, report.passes
                taken += 1
            if watch is not None:
                watch(done, steps, system)
            if keeper is not None and done % keeper.every == 0:
                history = {"values": values[:taken], "passes": passes[:taken]}
                about = {"done": done, "dt": dt, "scheme": statistics.data()}
                keeper.write(system, scheme, {"history": history}, about)
    except ComponentError as error:
        failure, outcome = error, error.what
    if statistics.failed and failure is None and outcome == "completed":
        outcome = f"completed; {statistics.failed} of {steps} steps did not converge"
    return Simulation(
        run.start + dt * (run.record_every * np.arange(taken)),
        dict(zip(_names(system), values[:taken].T.copy(), strict=True)),
        passes[:taken],
        {f"{c.name}.{n}": c.variables[n].unit or "1" for c in system.components for n in c.outputs.names},
        outcome,
        statistics.failed == 0 and outcome == "completed",
        statistics.data(),
        {c.name: c.cpu - before[c.name] for c in system.everyone},
        clock.perf_counter() - begin[0],
        clock.process_time() - begin[1],
        failure,
        system.loops,
    )


def _check_restart(checkpoint: Checkpoint, assembly: Assembly) -> None:
    """The end may have moved, but not to before the checkpoint, nor so that steps would be of another size."""
    done, then = checkpoint.about["done"], checkpoint.about["dt"]
    if not math.isclose(assembly.dt, then, rel_tol=1e-12):  # another step, not another rounding of it
        raise AeroSloshError(
            f"Up to run.end = {assembly.run.end!r} the step would be {assembly.dt!r} s, the checkpoint's is {then!r} s",
            str(checkpoint.path),
            "give an end that is a whole number of steps of the first run",
        )
    if assembly.steps < done:
        raise AeroSloshError(
            f"The checkpoint stands at step {done}, run.end = {assembly.run.end:g} at step {assembly.steps}",
            str(checkpoint.path),
            "give a later end",
        )


def data(simulation: Simulation) -> dict[str, Any]:
    """For the JSON result: last values, what the scheme took, cost."""
    last = {name: float(column[-1]) for name, column in simulation.outputs.items()}
    share = 1.0 - sum(simulation.cpu.values()) / simulation.total_cpu if simulation.total_cpu > 0.0 else 0.0
    return {
        "outcome": simulation.outcome,
        "converged": simulation.converged,
        "failure": simulation.failure.what if simulation.failure else None,
        "end_time": float(simulation.time[-1]),
        "last": {name: value if np.isfinite(value) else None for name, value in last.items()},
        "algebraic_loops": simulation.loops,
        "scheme": simulation.scheme,
        "cost": {
            "wall_seconds": simulation.wall,
            "cpu_seconds": simulation.total_cpu,
            "cpu_seconds_by_component": simulation.cpu,
            "master_share": max(0.0, share),
        },
    }


def write_history(path: Path, simulation: Simulation, about: dict[str, Any]) -> None:
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


def _names(system: System) -> list[str]:
    """The outputs in the order of `system.values`."""
    return [f"{c.name}.{name}" for c in system.components for name in c.outputs.names]
