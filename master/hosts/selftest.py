"""Does an FMU work here? Its checks run in a process of their own, so that a crash is a finding and not the end.

`findings(path)` starts `python -m aeroslosh.master.hosts.selftest FMU` and returns what it found; CHECKS is the list of what is
done there.
"""

from __future__ import annotations

import json
import os
import signal
import statistics
import subprocess
import sys
import time as clock
from collections.abc import Callable
from pathlib import Path

import numpy as np

from ..base.errors import AeroSloshError, ComponentError
from ..base.paths import PLACE
from ..fmi.component import Component
from . import bare
from . import reference as references
from .finding import Finding, ok, problem

STEPS = 4  # of the default experiment, from the start and again after the state was taken
NUDGE = 1e-4  # what each input grows by from step to step, in its own unit
LIMIT = 600.0  # seconds an FMU may take: a first load compiles
AGAIN = "build it again with `make fmus`"


class Subject:
    """The FMU under test: its path, its name, the instances made so far (the first has made `STEPS` steps)."""

    def __init__(self, path: Path) -> None:
        self.path, self.name = path, path.stem
        self.instances: list[Component] = []

    def instance(self) -> Component:
        """One more instance with its default parameters, initialised."""
        component = Component(self.path, self.name)
        self.instances.append(component)
        component.initialize()
        return component

    def step_size(self) -> float:
        """The step [s] of its default experiment."""
        experiment = self.instances[0].description.defaultExperiment
        return float(experiment.stepSize) if experiment is not None and experiment.stepSize else 1e-3

    def march(self, component: Component, steps: int = STEPS) -> np.ndarray:
        """Its Real outputs after each of `steps` steps, with inputs that grow slowly. Shape: (steps, outputs)."""
        starts = np.array([float(component.variables[name].start or 0.0) for name in component.inputs.names])
        rows = []
        for _ in range(steps):
            component.inputs.values[:] = starts + NUDGE * (component.steps + 1)  # something must move, nothing may go far
            component.step(self.step_size())
            rows.append(component.outputs.values.copy())
        return np.array(rows)


def runs(subject: Subject) -> list[Finding]:
    """Load, initialise and make a few steps of the default experiment."""
    begin = clock.perf_counter()
    component = subject.instance()
    loaded = clock.perf_counter() - begin
    times = []
    for _ in range(STEPS):
        begin = clock.perf_counter()
        row = subject.march(component, 1)
        times.append(clock.perf_counter() - begin)
        if not np.isfinite(row).all():
            names = [name for name, value in zip(component.outputs.names, row[0], strict=True) if not np.isfinite(value)]
            return [problem(subject.name, f"outputs that are not finite: {', '.join(names)}", AGAIN)]
    step = statistics.median(times)
    text = f"runs: ready in {loaded:.2f} s, {1e3 * step:.3g} ms a step of {subject.step_size():g} s"
    return [ok(subject.name, text, ready_seconds=loaded, step_seconds=step)]


def second_instance(subject: Subject) -> list[Finding]:
    """A second instance beside the first gives the same numbers to the bit."""
    first, second = subject.instance(), subject.instance()
    if subject.march(first).tobytes() != subject.march(second).tobytes():
        return [problem(subject.name, "two instances with the same inputs give different numbers", AGAIN)]
    return [ok(subject.name, "a second instance gives the same numbers to the bit")]


def state(subject: Subject) -> list[Finding]:
    """The state: back in time, and as bytes into another instance, each to the bit."""
    first = subject.instances[0]
    if not first.can_rewind:
        return [ok(subject.name, "it offers no state (canGetAndSetFMUstate is false): explicit coupling only")]
    saved, data = first.save(), first.serialized() if first.can_serialize else b""
    expected = subject.march(first)
    first.rewind(saved)
    first.free(saved)
    remedy = "build it again with `make fmus`; implicit coupling and checkpoints would be wrong"
    if subject.march(first).tobytes() != expected.tobytes():
        return [problem(subject.name, "a step repeated from a saved state gives other numbers", remedy)]
    if not data:
        return [ok(subject.name, "state: rewinds to the bit; it cannot be written to a file")]
    other = subject.instance()
    other.restore(data, saved.time, saved.steps)
    if subject.march(other).tobytes() != expected.tobytes():
        return [problem(subject.name, "another instance goes on from its state in bytes with other numbers", remedy)]
    return [ok(subject.name, f"state: rewinds to the bit, {len(data)} bytes to a file and back", state_bytes=len(data))]


def reference(subject: Subject) -> list[Finding]:
    """The reference result that it carries, replayed through FMPy."""
    if not references.carried(subject.path):
        return [ok(subject.name, "it carries no reference result")]
    differences = references.check(subject.path)
    worst = max(differences, key=lambda one: one.found / one.allowed)
    if not all(one.fits for one in differences):
        text = (
            f"its reference result is missed: {worst.name} by {worst.found:.1e} of its largest value, {worst.allowed:g} allowed"
        )
        return [problem(subject.name, text, "compare versions of numpy and numba with requirements.lock, then build it again")]
    text = f"gives its reference result: {len(differences)} outputs, {worst.name} within {worst.found:.1e}"
    return [ok(subject.name, text, reference_difference=worst.found)]


def other_hosts(subject: Subject) -> list[Finding]:
    """In a program that is no Python, with an empty environment, as most tools are started."""
    return bare.findings(subject.name, subject.instances[0].folder)


# What is done to each FMU, in this order: a function that gets the Subject and returns findings, or raises AeroSloshError, which
# becomes one. `runs` comes first.
CHECKS: tuple[Callable[[Subject], list[Finding]], ...] = (runs, second_instance, state, reference, other_hosts)


def examine(path: Path) -> list[Finding]:
    """All checks of one FMU in this process; the first that fails is the last."""
    subject, found = Subject(path), []
    for check in CHECKS:
        try:
            found += check(subject)
        except AeroSloshError as error:
            text = " ".join(error.what.split())
            trace = error.traceback if isinstance(error, ComponentError) else ""
            found.append(problem(subject.name, text, error.remedy or f"see {error.where}", log=trace))
        if found and found[-1].level == "problem":
            break
    return found


def findings(path: Path, limit: float = LIMIT) -> list[Finding]:
    """All checks of the FMU at `path` in a process of its own, which may take `limit` seconds."""
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, [str(PLACE), os.environ.get("PYTHONPATH")]))}
    command = [sys.executable, "-m", "aeroslosh.master.hosts.selftest", str(path.absolute())]
    try:
        done = subprocess.run(command, capture_output=True, text=True, errors="replace", env=environment, timeout=limit)
    except subprocess.TimeoutExpired:
        return [
            problem(path.stem, f"its self-test took more than {limit:g} s", "see whether the machine is busy, then run it again")
        ]
    lines = done.stdout.splitlines()
    if done.returncode == 0 and lines:
        return [Finding(*row) for row in json.loads(lines[-1])]
    return [_crash(path, done.returncode, done.stderr)]


def _crash(path: Path, code: int, said: str) -> Finding:
    """What to say of a process that ended without an answer."""
    last = next((line.strip() for line in reversed(said.splitlines()) if line.strip()), "it said nothing")
    if code < 0:
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        text = f"its process crashed ({name}): {last}"
    else:
        text = f"its process ended with exit code {code}: {last}"
    remedy = "look at the findings above (packages, temporary folder), then build it again with `make fmus`"
    return problem(path.stem, text, remedy, exit_code=code, log=said[-4000:])


def main() -> None:
    """One FMU, from the command line: findings as one line of JSON."""
    found = examine(Path(sys.argv[1]))
    print(json.dumps(found), flush=True)
    os._exit(0)  # an FMU of another make may not survive an ordinary end


if __name__ == "__main__":
    main()
