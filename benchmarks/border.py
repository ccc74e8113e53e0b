"""The border of an FMU: what fmi2GetReal, fmi2SetReal and an empty fmi2DoStep cost a host in C, beside pythonfmu's binary.

One face whose step does nothing, with four inputs and six outputs, behind our library and behind pythonfmu's, in turn in the same
minute: the ratio says more than the figures. Needs a C compiler.
"""

from __future__ import annotations

import inspect
import os
import shutil
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

import pythonfmu

from aeroslosh.fmus.build import archive as build
from aeroslosh.master.hosts import hosting

FACE = '''"""Nothing, to see what the way there costs."""

from ..kit.slave import Slave
from ..kit.variables import input_, output


class Idle(Slave):
    """A face whose step does nothing."""

    variables = (
        *(input_(f"u{i}", 0.0, "1", "An input") for i in range(4)),
        *(output(f"y{i}", "1", "An output") for i in range(6)),
    )

    def initialize(self) -> None:
        for i in range(6):
            setattr(self, f"y{i}", float(i))

    def step(self, time: float, step_size: float) -> None:
        return
'''
# what pythonfmu's binary needs of a script: it drops a reference of its globals
PIN = "import ctypes\nctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))\n"
NAMES = ("fmi2GetReal, 6 values", "fmi2SetReal, 4 values", "fmi2DoStep, empty")


def run(calls: int = 20_000, rounds: int = 3) -> None:
    """Print the table."""
    compiler, library = shutil.which("cc"), hosting.libpython()
    if compiler is None or library is None:
        print("  needs a C compiler `cc` and a shared libpython")
        return
    with tempfile.TemporaryDirectory(prefix="fmu_") as name:
        place = Path(name)
        program = place / "border"
        source = Path(__file__).with_name("border.c")
        subprocess.run([compiler, "-std=c11", "-O2", str(source), "-o", str(program), "-ldl"], check=True)
        folders = {"ours": _unzipped(place), "pythonfmu": _with_pythonfmu(place)}
        best = {which: [float("inf")] * 3 for which in folders}
        for _ in range(rounds):
            for which, folder in folders.items():
                words = [str(folder / "binaries" / "linux64" / "idle.so"), (folder / "resources").as_uri(), _guid(folder)]
                words += ["0,1,2,3", "4,5,6,7,8,9", str(calls)]
                done = subprocess.run(
                    [str(program), *words], capture_output=True, text=True, env=hosting.environment(library, os.environ)
                )
                if done.returncode:
                    raise RuntimeError(f"{which}: exit code {done.returncode} {done.stdout} {done.stderr}")
                best[which] = [min(pair) for pair in zip(best[which], map(float, done.stdout.split()), strict=True)]
    for i, what in enumerate(NAMES):
        own, other = best["ours"][i] / 1e3, best["pythonfmu"][i] / 1e3
        print(f"  {what:24s} {own:6.2f} µs   pythonfmu's binary {other:6.2f} µs   {other / own:4.1f} times as much")


def _unzipped(place: Path) -> Path:
    """The idle FMU as it is."""
    root = place / "fmus"
    shutil.copytree(build.ROOT / "kit", root / "kit", ignore=shutil.ignore_patterns("__pycache__"))
    (root / "__init__.py").write_text("")
    (root / "idle").mkdir()
    (root / "idle" / "__init__.py").write_text("")
    (root / "idle" / "fmu.py").write_text(FACE)
    made = build.build(root / "idle", place, check=False, root=root)
    with zipfile.ZipFile(made) as archive:
        archive.extractall(place / "ours")
    (place / "ours" / "resources" / "python.txt").write_text(f"{sys.executable}\n")
    return place / "ours"


def _with_pythonfmu(place: Path) -> Path:
    """The same with pythonfmu's binary."""
    folder = Path(shutil.copytree(place / "ours", place / "pythonfmu"))
    binary = Path(inspect.getfile(pythonfmu)).parent / "resources" / "binaries" / "linux64" / "libpythonfmu-export.so"
    shutil.copy(binary, folder / "binaries" / "linux64" / "idle.so")
    script = next((folder / "resources").glob("*_slave.py"))
    script.write_text(PIN + script.read_text().replace("SLAVE = idle\n", ""))
    return folder


def _guid(folder: Path) -> str:
    return (folder / "resources" / "guid.txt").read_text()
