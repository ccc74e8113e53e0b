"""One march of the flutter protocol: steady start → forced cycles → release → free cycles → verdict."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from master import coupling
from master.damping import Fit, analyse
from master.errors import ComponentError
from master.rig import FlutterRig
from master.similarity import Scales
from master.verdict import Verdict, judge

REALS = {  # history channel: (component, output, unit, long name)
    "h": ("structure", "h", "m", "plunge of the elastic axis, positive down"),
    "h_dot": ("structure", "h_dot", "m s-1", "plunge rate"),
    "h_ddot": ("structure", "h_ddot", "m s-2", "plunge acceleration"),
    "alpha": ("structure", "alpha", "rad", "pitch about the mean, nose-up"),
    "alpha_dot": ("structure", "alpha_dot", "rad s-1", "pitch rate"),
    "alpha_ddot": ("structure", "alpha_ddot", "rad s-2", "pitch acceleration"),
    "lift": ("aero", "lift", "N m-1", "lift per span, positive up"),
    "moment": ("aero", "moment", "N", "moment per span about the elastic axis, nose-up"),
    "C_L": ("aero", "C_L", "1", "lift coefficient"),
    "C_M": ("aero", "C_M", "1", "moment coefficient about the elastic axis, nose-up"),
    "C_D": ("aero", "C_D", "1", "drag coefficient"),
    "residual": ("aero", "residual", "1", "residual of the last subiteration"),
    "slosh_force_x": ("slosh", "force_x", "N m-1", "force of the liquid on the tank, positive aft"),
    "slosh_force_y": ("slosh", "force_y", "N m-1", "force of the liquid on the tank, weight included, positive up"),
    "slosh_moment": ("slosh", "moment", "N", "moment of the liquid about the elastic axis, weight included, nose-up"),
    "slosh_force_y_residual": ("slosh", "force_y_residual", "N m-1", "slosh_force_y less that of the frozen liquid"),
    "slosh_moment_residual": ("slosh", "moment_residual", "N", "slosh_moment less that of the frozen liquid"),
    "wave_height_west": ("slosh", "wave_height_west", "m", "surface above its level at rest at the fore wall"),
    "wave_height_east": ("slosh", "wave_height_east", "m", "surface above its level at rest at the aft wall"),
    "slosh_validity": ("slosh", "validity", "1", "above 1 the slosh model does not hold (largest since the start)"),
}
Watcher = Callable[[int, int, FlutterRig], None]  # step, steps, rig


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
    slosh          the liquid's model; its channels are in the history where it has them"""

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

    @property
    def tau(self) -> np.ndarray:
        """omega_alpha t."""
        return self.history["tau"]

    @property
    def free(self) -> np.ndarray:
        """Channels that the damping fit sees: h/b and alpha from the release on. Shape: (2, n)."""
        return np.vstack([self.history["h_over_b"], self.history["alpha"]])[:, self.release :]


def march(rig: FlutterRig, V_f: float, field_folder: Path | None = None, watch: Watcher | None = None) -> March:
    """March `rig` at `V_f`. A failing component ends the march: the history so far is kept and judged.

    `field_folder`: where the rig's aero FMU writes flow fields; four instants of the last free period are asked for.
    """
    begin_wall, begin_cpu = clock.perf_counter(), clock.process_time()
    before = {c.name: c.cpu for c in rig.system.components}
    case, s = rig.case, rig.start(V_f)
    flutter = case.flutter
    scheme = coupling.make(
        case.coupling.scheme,
        case.coupling.predictor_order,
        case.coupling.tolerance,
        case.coupling.max_iterations,
    )
    scheme.reset(rig.system)
    release = round(flutter.forced_cycles / flutter.forced_frequency * s.steps_per_cycle)
    steps = release + round(flutter.free_cycles * s.steps_per_cycle)
    history = _History(rig, steps + 1)
    history.take(0)
    instants = {steps - round(q * s.steps_per_cycle) for q in (0.75, 0.5, 0.25, 0.0)} if field_folder else set()
    unconverged = {"coupling": 0} | {c.name: 0 for c in rig.system.components if c is not rig.structure}
    failure, stopped, done, writing = None, "", 0, False
    limit = math.radians(flutter.max_alpha_deg)
    dt = s.dt
    try:
        for done in range(1, steps + 1):
            if (done in instants) is not writing:
                writing = not writing
                rig.aero.set("write_fields", writing)
            report = scheme.step(rig.system, dt)
            unconverged["coupling"] += not report.converged
            for name in history.take(done, report.passes):
                unconverged[name] += 1
            alpha = history.values["alpha"][done]
            if not np.isfinite(rig.system.values).all():
                stopped = f"not-a-number at step {done}, tau = {done * dt * s.omega_alpha:.3f}"
                done -= 1
                break
            if abs(alpha) > limit:
                stopped = f"|alpha| exceeded flutter.max_alpha_deg = {flutter.max_alpha_deg:g} at step {done}"
                break
            if watch is not None:
                watch(done, steps, rig)
    except ComponentError as error:
        failure, done = error, done - 1
        if rig.exchanges_whole_loads:
            failure.remedy = (
                "slosh.split = 'frozen' or coupling.scheme = 'implicit': the whole load of a heavy liquid, exchanged once a "
                f"step, diverges at any step. Else {failure.remedy}"
            )
    finally:
        if writing and failure is None:
            rig.aero.set("write_fields", False)
    table = history.finish(done + 1, s)
    wall, cpu = clock.perf_counter() - begin_wall, clock.process_time() - begin_cpu
    cost = Cost({c.name: c.cpu - before[c.name] for c in rig.system.components}, wall, cpu, done)
    written = sorted(field_folder.glob("fields_*.vts")) if field_folder else []
    moments = [i * dt * s.omega_alpha for i in sorted(instants) if i <= done]
    result = March(
        s,
        table,
        release,
        None,
        Verdict.UNDETERMINED,
        "",
        cost,
        failure,
        stopped,
        unconverged,
        list(zip(moments, written[-len(moments) :] if moments else [], strict=False)),
        case.slosh.model,
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


class _History:
    """Collects the channels step by step into preallocated arrays."""

    def __init__(self, rig: FlutterRig, n: int) -> None:
        self._rig = rig
        running = {c.name: c.output_index for c in rig.system.components}
        # a slosh model tells what it has; the other components always have a column
        columns = [n for n, (c, out, _, _) in REALS.items() if c in running and (c != "slosh" or out in running[c])]
        self.values = {name: np.zeros(n) for name in columns}
        self.values |= {"subiterations": np.zeros(n), "passes": np.zeros(n)}
        self._reals = [
            (
                self.values[name],
                rig.system[component].outputs.values,
                rig.system[component].output_index[output],
            )
            for name, (component, output, _, _) in REALS.items()
            if name in self.values and output in running[component]
        ]
        whole = rig.aero.whole
        self._subiterations = whole.names.index("subiterations") if "subiterations" in whole.names else None
        self._converged = [
            (c.name, c.truth, c.truth.names.index("converged")) for c in rig.system.components if "converged" in c.truth.names
        ]

    def take(self, i: int, passes: int = 0) -> list[str]:
        """Note sample `i`; returns the names of the components that say they did not converge."""
        for column, outputs, position in self._reals:
            column[i] = outputs[position]
        self.values["passes"][i] = passes
        if self._subiterations is not None:
            self._rig.aero.whole.get()
            self.values["subiterations"][i] = self._rig.aero.whole.values[self._subiterations]
        for _, truth, _ in self._converged:
            truth.get()
        return [name for name, truth, place in self._converged if not truth.values[place]]

    def finish(self, n: int, s: Scales) -> dict[str, np.ndarray]:
        """The first `n` samples with time, tau and h/b."""
        time = np.arange(n) * s.dt
        table = {"time": time, "tau": time * s.omega_alpha, "h_over_b": self.values["h"][:n] / s.half_chord}
        return table | {name: column[:n].copy() for name, column in self.values.items()}
