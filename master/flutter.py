"""One march of the flutter protocol: steady start → forced cycles → release → free cycles → verdict."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from master import scheme as schemes
from master.case import Case
from master.channels import History
from master.checkpoint import Checkpoint, Keeper
from master.damping import Fit, analyse
from master.errors import AeroSloshError, ComponentError
from master.fields import Fields
from master.rig import FlutterRig
from master.scheme import Statistics
from master.similarity import Scales
from master.system import System
from master.verdict import Verdict, judge

Watcher = Callable[[int, int, System], None]  # step, steps, system


@dataclass
class Cost:
    """Seconds of one march. `cpu` by component, `wall` of the whole march, `total_cpu` of the process in it."""

    cpu: dict[str, float]
    wall: float
    total_cpu: float
    steps: int

    @property
    def master_share(self) -> float:
        """The part of the CPU time spent outside the FMUs."""
        return max(0.0, 1.0 - sum(self.cpu.values()) / self.total_cpu) if self.total_cpu > 0 else 0.0


@dataclass
class March:
    """A march with its outcome. `history` arrays have shape (n_steps + 1,), the first entry being the start.

    release        index of the first free sample (the release itself)
    failure        the component failure that ended the march, if one did; `stopped` any other early end
    unconverged    steps whose coupling iteration, or whose iteration inside aero or slosh, did not converge
    slosh          the liquid's model; its channels are in the history where it has them
    scheme         what the coupling scheme took (`Statistics.data`)"""

    scales: Scales
    history: dict[str, np.ndarray]
    release: int
    fit: Fit | None
    verdict: Verdict
    reason: str
    cost: Cost
    failure: ComponentError | None = None
    stopped: str = ""
    unconverged: dict[str, int] = field(default_factory=dict)
    fields: list[tuple[float, Path]] = field(default_factory=list)
    slosh: str = "none"
    scheme: dict[str, Any] = field(default_factory=dict)

    @property
    def tau(self) -> np.ndarray:
        """omega_alpha t."""
        return self.history["tau"]

    @property
    def free(self) -> np.ndarray:
        """Channels that the damping fit sees: h/b and alpha from the release on. Shape: (2, n)."""
        return np.vstack([self.history["h_over_b"], self.history["alpha"]])[:, self.release :]


def length(case: Case, s: Scales) -> tuple[int, int]:
    """Steps of the forced phase, and of the whole march."""
    release = round(case.flutter.forced_cycles / case.flutter.forced_frequency * s.steps_per_cycle)
    return release, release + round(case.flutter.free_cycles * s.steps_per_cycle)


def march(
    rig: FlutterRig,
    V_f: float,
    field_folder: Path | None = None,
    watch: Watcher | None = None,
    keeper: Keeper | None = None,
    checkpoint: Checkpoint | None = None,
) -> March:
    """March `rig` at `V_f`. A failing component ends the march: the history so far is kept and judged.

    `field_folder`: where the rig's aero FMU writes flow fields; four instants of the last free period are asked for.
    `keeper` writes checkpoints; from one (`checkpoint`) the march goes on as if it had not been interrupted.
    """
    begin_wall, begin_cpu = clock.perf_counter(), clock.process_time()
    before = {c.name: c.cpu for c in rig.system.everyone}
    case, system, s = rig.case, rig.system, rig.start(V_f)
    flutter = case.flutter
    scheme, statistics = schemes.make(case.coupling), Statistics()
    if keeper is not None:
        keeper.check(system)
    scheme.reset(system)
    release, steps = length(case, s)
    history = History(rig, steps + 1)
    history.take(0)
    fields = Fields(rig.aero, field_folder, (steps - round(q * s.steps_per_cycle) for q in (0.75, 0.5, 0.25, 0.0)))
    unconverged = {c.name: 0 for c in system.components if c is not rig.structure}
    failure, stopped, done, first = None, "", 0, 1
    limit = math.radians(flutter.max_alpha_deg)
    dt = s.dt
    if checkpoint is not None:
        done, unconverged = checkpoint.about["done"], dict(checkpoint.about["unconverged"])
        if done > steps:
            raise AeroSloshError(
                f"The checkpoint stands at step {done}, the march ends at step {steps}",
                f"{checkpoint.path}, flutter.free_cycles = {flutter.free_cycles:g}",
                "give it more free cycles",
            )
        checkpoint.restore(system, scheme)
        fields.resume()
        history.restore(checkpoint.part("history"))
        statistics.restore(checkpoint.about["scheme"])
        first = done + 1
    try:
        for done in range(first, steps + 1):
            fields.before(done)
            report = scheme.step(system, dt)
            statistics.note(report, done * dt)
            for name in history.take(done, report.passes):
                unconverged[name] += 1
            alpha = history.values["alpha"][done]
            if not np.isfinite(system.values).all():
                stopped = f"not-a-number at step {done}, tau = {done * dt * s.omega_alpha:.3f}"
                done -= 1
                break
            if abs(alpha) > limit:
                stopped = f"|alpha| exceeded flutter.max_alpha_deg = {flutter.max_alpha_deg:g} at step {done}"
                break
            if watch is not None:
                watch(done, steps, system)
            if keeper is not None and done % keeper.every == 0:
                about = {"done": done, "unconverged": unconverged, "scheme": statistics.data()}
                samples = {name: column[: done + 1] for name, column in history.values.items()}
                keeper.write(system, scheme, {"history": samples}, about)
    except ComponentError as error:
        failure, done = error, done - 1
        if rig.exchanges_whole_loads:
            failure.remedy = (
                "slosh.split = 'frozen' or coupling.scheme = 'implicit': the whole load of a heavy liquid, exchanged once a "
                f"step, diverges at any step. Else {failure.remedy}"
            )
    written = fields.end(done, failed=failure is not None)
    wall, cpu = clock.perf_counter() - begin_wall, clock.process_time() - begin_cpu
    cost = Cost({c.name: c.cpu - before[c.name] for c in system.everyone}, wall, cpu, done)
    result = March(
        s,
        history.finish(done + 1, s),
        release,
        None,
        Verdict.UNDETERMINED,
        "",
        cost,
        failure,
        stopped,
        {"coupling": statistics.failed} | unconverged,
        [(step * dt * s.omega_alpha, path) for step, path in written],
        case.slosh.model,
        statistics.data(),
    )
    _conclude(result, flutter.neutral_band)
    return result


def _conclude(result: March, neutral_band: float) -> None:
    """Fit and verdict of the free part, if there is enough of it."""
    if result.tau.size - result.release >= result.scales.steps_per_cycle:
        result.fit = analyse(result.tau[result.release :], result.free)
        result.verdict, result.reason = judge(result.tau[result.release :], result.free, result.fit, neutral_band)
    else:
        result.reason = "the free response is shorter than one period"
    if result.unconverged["coupling"] > 0.05 * max(1, result.cost.steps):
        result.verdict = Verdict.UNDETERMINED
        result.reason = f"the coupling iteration did not converge in {result.unconverged['coupling']} steps"
    if result.stopped.startswith("|alpha|") and result.verdict is not Verdict.FLUTTER and result.fit is None:
        result.verdict, result.reason = Verdict.FLUTTER, result.stopped
