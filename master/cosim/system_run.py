"""The run of a system file: initialise, step to the end, keep the history. Non-convergence and failures are outcomes of it."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from ..base.errors import AeroSloshError, ComponentError
from . import assemble as schemes
from .assemble import Statistics
from .checkpoint import Arrays, Checkpoint, Keeper
from .loop import Checkpoints, Cost, Counter, Finite, Loop, Meter, Observer, Watch, Watcher
from .scheme import StepReport
from .system import System
from .system_file import Assembly


@dataclass
class Simulation:
    """What a run gave.

    time       of each sample, the first one being the start. Shape: (n,) [s]
    outputs    "component.output" → its values, each (n,); `passes` of each step; `units` of the outputs
    outcome    "completed", or why the run ended early; `converged` is False when a step did not converge
    failure    the component failure that ended it
    cost       seconds of the run"""

    time: np.ndarray
    outputs: dict[str, np.ndarray]
    passes: np.ndarray
    units: dict[str, str]
    outcome: str
    converged: bool
    scheme: dict[str, Any]
    cost: Cost
    failure: ComponentError | None = None
    loops: list[list[str]] = field(default_factory=list)


class _Recorder(Observer):
    """Keeps every so many steps of all outputs. `values` (rows, n_outputs) and `passes` (rows,) are filled up to `taken`."""

    def __init__(self, every: int, values: np.ndarray, passes: np.ndarray) -> None:
        self._every, self.values, self.passes, self.taken = every, values, passes, 1

    def after(self, loop: Loop, step: int, report: StepReport) -> None:
        """One row, when it is time."""
        if step % self._every == 0:
            self.values[self.taken], self.passes[self.taken] = loop.system.values, report.passes
            self.taken += 1

    def rows(self) -> dict[str, np.ndarray]:
        """What has been recorded."""
        return {"values": self.values[: self.taken], "passes": self.passes[: self.taken]}


def simulate(
    assembly: Assembly,
    system: System,
    watch: Watcher | None = None,
    keeper: Keeper | None = None,
    checkpoint: Checkpoint | None = None,
) -> Simulation:
    """Run `system` (of `system_file.build`, instances fresh). `keeper` writes checkpoints, from `checkpoint` a run goes on.

    Raises AeroSloshError for settings that do not fit the system; a failing step is an outcome."""
    meter = Meter(system)
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
        recorder = _Recorder(run.record_every, np.zeros((rows, system.values.size)), np.zeros(rows))
    except (MemoryError, ValueError):  # ValueError: more than an array can hold at all
        raise AeroSloshError(
            f"A history of {rows} samples of {system.values.size} outputs does not fit into memory",
            assembly.where("run", "record_every"),
            "record fewer samples (run.record_every), or make the run shorter",
        ) from None
    recorder.values[0] = system.values

    def kept(step: int) -> tuple[dict[str, Arrays], dict[str, Any]]:
        return {"history": recorder.rows()}, {"done": step, "dt": dt, "scheme": statistics.data()}

    observers: list[Observer] = [
        Counter(statistics, run.start),
        Finite(lambda step: f"t = {run.start + step * dt:.6g} s"),
        recorder,
        *([Watch(watch)] if watch is not None else []),
        *([Checkpoints(keeper, kept)] if keeper is not None else []),
    ]
    loop = Loop(system, scheme, dt, observers)
    if checkpoint is not None:
        checkpoint.restore(system, scheme)
        past, loop.done = checkpoint.part("history"), checkpoint.about["done"]
        recorder.taken = n = past["passes"].size
        recorder.values[:n], recorder.passes[:n] = past["values"], past["passes"]
        statistics.restore(checkpoint.about["scheme"])
    loop.to(steps)
    outcome = loop.stop.text if loop.stop else "completed"
    if statistics.failed and not loop.stop:
        outcome = f"completed; {statistics.failed} of {steps} steps did not converge"
    return Simulation(
        run.start + dt * (run.record_every * np.arange(recorder.taken)),
        dict(zip(system.output_names(), recorder.values[: recorder.taken].T.copy(), strict=True)),
        recorder.passes[: recorder.taken],
        {f"{c.name}.{n}": c.variables[n].unit or "1" for c in system.components for n in c.outputs.names},
        outcome,
        statistics.failed == 0 and loop.stop is None,
        statistics.data(),
        meter.cost(loop.done),
        loop.failure,
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
    return {
        "outcome": simulation.outcome,
        "converged": simulation.converged,
        "failure": simulation.failure.what if simulation.failure else None,
        "end_time": float(simulation.time[-1]),
        "last": {name: value if np.isfinite(value) else None for name, value in last.items()},
        "algebraic_loops": simulation.loops,
        "scheme": simulation.scheme,
        "cost": {
            "wall_seconds": simulation.cost.wall,
            "cpu_seconds": simulation.cost.total_cpu,
            "cpu_seconds_by_component": simulation.cost.cpu,
            "master_share": simulation.cost.master_share,
        },
    }
