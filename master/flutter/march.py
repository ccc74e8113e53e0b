"""One march of the flutter protocol: steady start → forced cycles → release → free cycles → verdict."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.damping import Fit, analyse
from ..analysis.verdict import MORE_CYCLES, Judgement, Verdict, judge
from ..base.errors import AeroSloshError, ComponentError
from ..case.case import Case
from ..case.scales import Scales
from ..cosim import assemble as schemes
from ..cosim.assemble import Statistics
from ..cosim.checkpoint import Checkpoint, Keeper
from ..cosim.system import System
from . import apparent_mass
from .flow_fields import Fields
from .recorder import History
from .setup import FlutterRig

FEWEST = 24  # samples that a motion which grew out of reach is fitted on
QUARTERS = (0.75, 0.5, 0.25, 0.0)  # of the last period: instants of the flow fields
GROWTH = 1.5  # a march that is not settled goes on by this factor
MOST_TIMES, MOST_CYCLES = 8.0, 80.0  # max_free_cycles = "auto"
PERIODS = 1.25  # of the slower natural mode that a verdict needs
TIMES_LARGER = 3.0  # a motion that outgrew max_alpha_deg by this factor since its release grows

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
    scheme         what the coupling scheme took (`Statistics.data`)
    settled        whether more cycles could not change the verdict; `remedy` says what to do where there is none
    stiffness      pitch stiffness that the steady flow leaves, over the structure's own; nan where not known
    note           what a user should know of how it was coupled"""

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
    settled: bool = True
    remedy: str = ""
    stiffness: float = math.nan
    note: str = ""

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


@dataclass(frozen=True)
class Span:
    """How long a march is, in steps: to the release, to the first look at its free response, and at most.

    least  what shows the slower of the section's two natural modes for PERIODS of its own: no verdict but growth before"""

    release: int
    planned: int
    least: int
    most: int

    @classmethod
    def of(cls, case: Case, s: Scales) -> Span:
        """That of `case`. A limit that the case leaves to us is no shorter than `least`, within MOST_CYCLES."""
        f, (release, planned) = case.flutter, length(case, s)
        least = PERIODS / max(slower_frequency(case), 1e-3)
        if isinstance(f.max_free_cycles, float | int):
            most = float(f.max_free_cycles)
        else:
            most = min(max(MOST_TIMES * f.free_cycles, least), MOST_CYCLES)
        steps = [release + math.ceil(cycles * s.steps_per_cycle) for cycles in (least, most)]
        return cls(release, planned, steps[0], max(planned, steps[1]))

    def longer(self, steps: int) -> int:
        """Where a march that is not settled after `steps` goes on to."""
        further = self.release + math.ceil(GROWTH * (steps - self.release))
        return min(max(further, self.least), self.most)


def slower_frequency(case: Case) -> float:
    """The lower natural frequency of the section in vacuum, over omega_alpha."""
    s = case.section
    # (1 − x²/r²) λ² − (1 + ratio²) λ + ratio² = 0, λ = (ω/ω_α)²
    ratio, mass = s.frequency_ratio**2, 1.0 - s.x_alpha**2 / s.r2_alpha
    return math.sqrt(2.0 * ratio / (1.0 + ratio + math.sqrt(max((1.0 + ratio) ** 2 - 4.0 * mass * ratio, 0.0))))


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
    rig.slopes()  # for the verdict: part of the steady start, not of the march
    begin_wall, begin_cpu = clock.perf_counter(), clock.process_time()
    before = {c.name: c.cpu for c in rig.system.everyone}
    case, system, s = rig.case, rig.system, rig.start(V_f)
    flutter = case.flutter
    coupling, note = apparent_mass.coupling(case, rig.mach, rig.tank.liquid if rig.tank and rig.tank.carried else None)
    scheme, statistics = schemes.make(coupling), Statistics()
    if keeper is not None:
        keeper.check(system)
    scheme.reset(system)
    span = Span.of(case, s)
    release, steps = span.release, span.planned
    history = History(rig, steps + 1)
    history.take(0)
    fields = Fields(rig.aero, field_folder, (steps - round(q * s.steps_per_cycle) for q in QUARTERS))
    unconverged = {c.name: 0 for c in system.components if c is not rig.structure}
    failure, stopped, done, first = None, "", 0, 1
    limit = math.radians(flutter.max_alpha_deg)
    dt = s.dt
    if checkpoint is not None:
        done, unconverged = checkpoint.about["done"], dict(checkpoint.about["unconverged"])
        if done > span.most:
            raise AeroSloshError(
                f"The checkpoint stands at step {done}, the march ends at step {span.most}",
                f"{checkpoint.path}, flutter.free_cycles = {flutter.free_cycles:g}",
                "give it more free cycles",
            )
        while steps < done:
            steps = span.longer(steps)
        history.extend(steps + 1)
        checkpoint.restore(system, scheme)
        fields.resume()
        history.restore(checkpoint.part("history"))
        statistics.restore(checkpoint.about["scheme"])
        first = done + 1
    judged: Judgement | None = None
    try:
        while True:
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
            if stopped or steps >= span.most:
                break
            judged = _judged(history.finish(steps + 1, s), span, s, rig)
            if judged.settled:
                break
            judged, first, steps = None, steps + 1, span.longer(steps)
            history.extend(steps + 1)
            fields.again(steps - round(q * s.steps_per_cycle) for q in QUARTERS)
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
    table = history.finish(done + 1, s)
    if judged is None:
        judged = _judged(table, span, s, rig, FEWEST if stopped else s.steps_per_cycle)
    judged = _checked(judged, table, release, stopped, statistics.failed, done, rig.stiffness(V_f))
    return March(
        s,
        table,
        release,
        judged.fit,
        judged.verdict,
        judged.reason,
        cost,
        failure,
        stopped,
        {"coupling": statistics.failed} | unconverged,
        [(step * dt * s.omega_alpha, path) for step, path in written],
        case.slosh.model,
        statistics.data(),
        judged.settled,
        judged.remedy,
        rig.stiffness(V_f),
        note,
    )


def _judged(table: dict[str, np.ndarray], span: Span, s: Scales, rig: FlutterRig, enough: int = 0) -> Judgement:
    """Fit and verdict of the free part, if there are `enough` samples of it."""
    tau, free = table["tau"][span.release :], np.vstack([table["h_over_b"], table["alpha"]])[:, span.release :]
    if tau.size < enough:
        return Judgement(Verdict.UNDETERMINED, "the free response is shorter than one period", False, None, MORE_CYCLES)
    said = judge(tau, free, analyse(tau, free), rig.case.flutter.neutral_band, rig.stiffness(s.V_f))
    if span.release + tau.size - 1 >= span.least or said.verdict in (Verdict.FLUTTER, Verdict.DIVERGENCE, Verdict.UNDETERMINED):
        return said
    slower = f"{PERIODS:g} periods of the slower natural mode ({slower_frequency(rig.case):.3f} omega_alpha)"
    return Judgement(Verdict.UNDETERMINED, f"the free response is shorter than {slower}", False, said.fit, MORE_CYCLES)


def _checked(
    judged: Judgement, table: dict[str, np.ndarray], release: int, stopped: str, failed: int, steps: int, stiffness: float
) -> Judgement:
    """`judged` in the light of how the march ended."""
    if failed > 0.05 * max(1, steps):
        reason = f"the coupling iteration did not converge in {failed} steps"
        return Judgement(Verdict.UNDETERMINED, reason, False, judged.fit, "coupling.max_iterations, or smaller steps")
    unstable = judged.verdict in (Verdict.FLUTTER, Verdict.DIVERGENCE)
    if not stopped.startswith("|alpha|") or unstable:
        return judged
    alpha = np.abs(table["alpha"][release:])
    first = float(np.max(alpha[: max(2, alpha.size // 3)])) if alpha.size else 0.0
    forced = float(np.max(np.abs(table["alpha"][: release + 1])))
    if alpha.size and alpha[-1] > TIMES_LARGER * max(forced, 1e-300) and alpha[-1] > 1.05 * first:
        # the largest motion so far, on one side since it was half as large: it does not oscillate any more
        small = np.flatnonzero(alpha < 0.5 * alpha[-1])
        late = table["alpha"][release + (int(small[-1]) if small.size else 0) :]
        static = stiffness < 0.0 and bool(np.all(late > 0.0) or np.all(late < 0.0))
        verdict = Verdict.DIVERGENCE if static else Verdict.FLUTTER
        how = "without oscillating" if static else "out of reach"
        return Judgement(verdict, f"the motion grows {how}: {stopped}", True, judged.fit)
    return Judgement(
        Verdict.UNDETERMINED, stopped, False, judged.fit, "a smaller flutter.forced_amplitude_deg, or a greater max_alpha_deg"
    )
