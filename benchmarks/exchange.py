"""FMI and master: what a step costs when every physics does nothing, beside a step of aero, structure and two-phase slosh.

The FMUs' own `step` methods are replaced by nothing; what is left is the master, its history, FMPy's library calls, the FMUs'
library and the kit's guards. The trivial FMUs are plain pythonfmu ones.
"""

from __future__ import annotations

import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from aeroslosh.master.case import case as cases
from aeroslosh.master.cosim.scheme import GaussSeidel
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.flutter import march
from aeroslosh.master.flutter.march import March
from aeroslosh.master.flutter.recorder import History
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus
from aeroslosh.master.fmi.component import Component

ROOT = Path(__file__).resolve().parents[1]
TRIVIAL = """
import sys
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
sys.__dict__.setdefault("_fmu_pins", []).append(globals())
class Trivial(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.u, self.v, self.x, self.y = 0.0, 0.0, 0.0, 0.0
        for name in ("u", "v"):
            self.register_variable(Real(name, causality=Fmi2Causality.input))
        for name in ("x", "y"):
            self.register_variable(Real(name, causality=Fmi2Causality.output))
    def do_step(self, current_time, step_size):
        self.x, self.y = 0.5 * self.u, 0.5 * self.v
        return True
"""
BUILD = "import sys; from pythonfmu.builder import FmuBuilder; FmuBuilder.build_FMU(sys.argv[1], sys.argv[2])"


@contextmanager
def idle() -> Iterator[None]:
    """The `step` of every loaded FMU of this product does nothing."""
    faces = [
        face
        for name, module in list(sys.modules.items())
        if name.endswith(".fmu") and "_" in name.split(".")[0]
        for face in vars(module).values()
        if isinstance(face, type) and "variables" in vars(face) and "step" in vars(face)
    ]
    steps = {face: face.__dict__["step"] for face in faces}
    for face in faces:
        face.step = lambda self, time, step_size: None  # type: ignore[attr-defined]
    try:
        yield
    finally:
        for face, step in steps.items():
            face.step = step  # type: ignore[attr-defined]


def exchange(setup: FlutterSetup, V_f: float, steps: int = 500) -> float:
    """CPU seconds of one step with its history, physics idle."""
    scale = setup.start(V_f)
    scheme = GaussSeidel(1)
    scheme.reset(setup.system)
    history = History(setup, steps + 1)
    with idle():
        begin = time.process_time()
        for k in range(1, steps + 1):
            scheme.step(setup.system, scale.dt)
            history.take(k, 1)
        return (time.process_time() - begin) / steps


def trivial(steps: int = 2000) -> float:
    """CPU seconds of one step of two plain pythonfmu FMUs in a loop."""
    with tempfile.TemporaryDirectory() as folder:
        script = Path(folder) / "trivial.py"
        script.write_text(TRIVIAL)
        fmu = Path(folder) / "trivial.fmu"
        subprocess.run([sys.executable, "-c", BUILD, str(script), str(fmu)], check=True, capture_output=True)
        pair = [Component(fmu, "a"), Component(fmu, "b")]
    system = System(pair, wires(["a.x -> b.u", "a.y -> b.v", "b.x -> a.u", "b.y -> a.v"]))
    system.initialize()
    scheme = GaussSeidel(1)
    scheme.reset(system)
    times = []
    for _ in range(5):
        begin = time.process_time()
        for _ in range(steps):
            scheme.step(system, 1e-3)
        times.append((time.process_time() - begin) / steps)
    system.close()
    return statistics.median(times)


def run(repeat: int = 5) -> None:
    """Print the cost of an exchange and its share of a step."""
    fmus = find_fmus(ROOT / "dist" / "fmus", "vof")
    print(f"  two trivial FMUs                      {1e6 * trivial():6.1f} µs a step: all there is")
    for label, amplitude in (("calm fuel, 0.1 deg", 0.1), ("fuel that hits the roof, 1 deg", 1.0)):
        case = cases.load(ROOT / "cases" / "paper_s.toml", ["slosh.model=vof", f"flutter.forced_amplitude_deg={amplitude}"])
        with FlutterSetup(case, fmus, case.flow.mach) as setup:
            march.march(setup, case.flutter.V_f)
            marches: list[March] = []
            idles: list[float] = []
            for _ in range(repeat):
                marches.append(march.march(setup, case.flutter.V_f))
                idles.append(exchange(setup, case.flutter.V_f))
            full = statistics.median(m.cost.total_cpu / m.cost.steps for m in marches)
            share = statistics.median(idles)
            print(f"  structure + aero + slosh_vof, {label:30s} {1e3 * full:6.2f} ms a step, FMI and master "
                  f"{1e6 * share:5.1f} µs, {100 * share / full:.1f} %")  # fmt: skip
