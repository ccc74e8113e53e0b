"""One march of the flutter protocol: steady start → forced cycles → release → free cycles → verdict."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from ..analysis.damping import Fit
from ..analysis.members import Ensemble
from ..analysis.verdict import Judgement, Verdict
from ..base.errors import AeroSloshError, ComponentError
from ..case.scales import Scales
from ..cosim import assemble
from ..cosim.assemble import Statistics
from ..cosim.checkpoint import Arrays, Checkpoint, Keeper
from ..cosim.loop import Checkpoints, Cost, Counter, End, Finite, Loop, Meter, Observer, Stop, Watch, Watcher
from ..cosim.scheme import StepReport
from . import apparent_mass
from .flow_fields import Fields
from .judging import FEWEST, checked, judged, seen_frequency
from .recorder import History
from .setup import FlutterSetup
from .span import Span

QUARTERS = (0.75, 0.5, 0.25, 0.0)  # of the last period of the flutter mode: instants of the flow fields


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
    note           what a user should know of how it was coupled
    ensemble       the members of which fit and verdict are the mean, if there are several; the history is the first one's"""

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
    ensemble: Ensemble | None = None

    @property
    def tau(self) -> np.ndarray:
        """omega_alpha t."""
        return self.history["tau"]

    @property
    def free(self) -> np.ndarray:
        """Channels that the damping fit sees: h/b and alpha from the release on. Shape: (2, n)."""
        return np.vstack([self.history["h_over_b"], self.history["alpha"]])[:, self.release :]


class _Recorder(Observer):
    """Keeps the history and counts the steps in which a component did not converge."""

    def __init__(self, history: History, unconverged: dict[str, int]) -> None:
        self._history, self._unconverged = history, unconverged

    def after(self, loop: Loop, step: int, report: StepReport) -> None:
        """One sample."""
        for name in self._history.take(step, report.passes):
            self._unconverged[name] += 1


class _Limit(Observer):
    """Ends a march whose pitch exceeds flutter.max_alpha_deg."""

    def __init__(self, history: History, degrees: float) -> None:
        self._history, self._degrees, self._limit = history, degrees, math.radians(degrees)

    def after(self, loop: Loop, step: int, report: StepReport) -> Stop | None:
        """Look at the newest sample."""
        if abs(self._history.values["alpha"][step]) <= self._limit:
            return None
        return Stop(End.TOO_LARGE, f"|alpha| exceeded flutter.max_alpha_deg = {self._degrees:g} at step {step}")


class _FieldsWanted(Observer):
    """Asks for flow fields at four instants of the flutter mode's last period in the march, or of what is left of the march where
    that is less. Half way through the free motion the mode's frequency is read: it shows, and a period is still to come."""

    def __init__(self, fields: Fields, history: History, s: Scales, release: int) -> None:
        self._fields, self._history, self._scales, self._release = fields, history, s, release
        self._steps = self._look = 0
        self._aimed = True

    def until(self, steps: int) -> None:
        """The march is to go to step `steps`; fields of an earlier plan are thrown away."""
        self._steps, self._look, self._aimed = steps, self._release + (steps - self._release) // 2, False
        self._fields.again(())

    def before(self, loop: Loop, step: int) -> None:
        """`step` is about to be made."""
        if not self._aimed and step > self._look:
            self._aimed = True
            s, left = self._scales, self._steps - self._look
            table = self._history.finish(self._look + 1, s) if self._fields.wanted else None
            frequency = seen_frequency(table, self._release) if table is not None else None
            period = min(s.steps_per_cycle / frequency, left) if frequency else s.steps_per_cycle
            self._fields.again(self._steps - round(q * period) for q in QUARTERS)
        self._fields.before(step)


def march(
    setup: FlutterSetup,
    V_f: float,
    field_folder: Path | None = None,
    watch: Watcher | None = None,
    keeper: Keeper | None = None,
    checkpoint: Checkpoint | None = None,
) -> March:
    """March `setup` at `V_f`. A failing component ends the march: the history so far is kept and judged.

    `field_folder`: where the setup's aero FMU writes flow fields; four instants of the flutter mode's last period
    are asked for.
    `keeper` writes checkpoints; from one (`checkpoint`) the march goes on as if it had not been interrupted.
    """
    setup.slopes()  # for the verdict: part of the steady start, not of the march
    meter = Meter(setup.system)
    case, system, s = setup.case, setup.system, setup.start(V_f)
    coupling, note = apparent_mass.coupling(case, setup.mach, setup.tank.liquid if setup.tank and setup.tank.carried else None)
    scheme, statistics = assemble.make(coupling), Statistics()
    if keeper is not None:
        keeper.check(system)
    scheme.reset(system)
    span = Span.of(case, s, setup.needed_cycles(V_f), setup.enough_cycles)
    steps, history = span.planned, History(setup, span.planned + 1)
    history.take(0)
    fields = Fields(setup.aero, field_folder)
    wanted = _FieldsWanted(fields, history, s, span.release)
    unconverged = {c.name: 0 for c in system.components if c is not setup.structure}
    observers = [
        wanted,
        Counter(statistics),
        Finite(lambda step: f"tau = {step * s.dt * s.omega_alpha:.3f}"),
        _Recorder(history, unconverged),
        _Limit(history, case.flutter.max_alpha_deg),
        *([Watch(watch)] if watch is not None else []),
        *([Checkpoints(keeper, lambda step: _kept(step, history, unconverged, statistics))] if keeper is not None else []),
    ]
    loop = Loop(system, scheme, s.dt, observers)
    if checkpoint is not None:
        loop.done = checkpoint.about["done"]
        if loop.done > span.most:
            raise AeroSloshError(
                f"The checkpoint stands at step {loop.done}, the march ends at step {span.most}",
                f"{checkpoint.path}, flutter.free_cycles = {case.flutter.free_cycles:g}",
                "give it more free cycles",
            )
        unconverged |= checkpoint.about["unconverged"]
        while steps < loop.done:
            steps = span.longer(steps)
        history.extend(steps + 1)
        checkpoint.restore(system, scheme)
        fields.resume()
        history.restore(checkpoint.part("history"))
        statistics.restore(checkpoint.about["scheme"])
    wanted.until(steps)
    said: Judgement | None = None
    while loop.to(steps) and steps < span.most:
        said = judged(history.finish(steps + 1, s), span, V_f, setup)
        if said.settled:
            break
        said, steps = None, span.longer(steps)
        history.extend(steps + 1)
        wanted.until(steps)
    if loop.failure is not None and setup.exchanges_whole_loads:
        loop.failure.remedy = (
            "slosh.split = 'frozen' or coupling.scheme = 'implicit': the whole load of a heavy liquid, exchanged once a "
            f"step, diverges at any step. Else {loop.failure.remedy}"
        )
    written = fields.end(loop.done, failed=loop.failure is not None)
    cost = meter.cost(loop.done)
    table = history.finish(loop.done + 1, s)
    stop = loop.stop if loop.failure is None else None
    if said is None:
        said = judged(table, span, V_f, setup, FEWEST if stop else s.steps_per_cycle)
    said = checked(said, table, span.release, stop, statistics.failed, loop.done, setup.stiffness(V_f))
    return March(
        s,
        table,
        span.release,
        said.fit,
        said.verdict,
        said.reason,
        cost,
        loop.failure,
        stop.text if stop else "",
        {"coupling": statistics.failed} | unconverged,
        [(step * s.dt * s.omega_alpha, path) for step, path in written],
        case.slosh.model,
        statistics.data(),
        said.settled,
        said.remedy,
        setup.stiffness(V_f),
        note,
    )


def _kept(
    step: int, history: History, unconverged: dict[str, int], statistics: Statistics
) -> tuple[dict[str, Arrays], dict[str, Any]]:
    """What a checkpoint after `step` keeps besides the FMUs' states."""
    about = {"done": step, "unconverged": unconverged, "scheme": statistics.data()}
    return {"history": {name: column[: step + 1] for name, column in history.values.items()}}, about
