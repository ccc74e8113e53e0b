"""Kernels compiled before they are needed: what a rehearsal finds, said once; and what goes wrong ends nothing."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from support.paths import COMPONENTS
from support.processes import supported

START = """
import sys
from pathlib import Path
from aeroslosh.master.base import notices
from aeroslosh.master.fmi import kernels
from aeroslosh.master.fmi.component import Component
{before}
with notices.to(print):
    component = Component(Path(sys.argv[1]), "one")
    component.initialize()
print(component.get("y"), component.get("hits"), component.get("misses"))
"""


def started(fmu: Path, cache: Path, before: str = "", **environment: str) -> list[str]:
    """What an instance of `fmu` says in a process of its own: lines of notices, then value, kernels found, kernels compiled."""
    words = [sys.executable, "-c", START.format(before=before), str(fmu)]
    done = subprocess.run(words, env=supported(XDG_CACHE_HOME=str(cache), **environment), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def test_what_a_component_calls_is_compiled_before_and_said_once(fmu: Callable[[Path], Path], tmp_path: Path) -> None:
    """The kernel and the one that it calls; the component finds both in its cache."""
    path = fmu(COMPONENTS / "kernels")
    assert started(path, tmp_path) == ["compiling kernels, once on this machine (about 1 s)", "20.0 1 0"]
    assert len(list(tmp_path.rglob("*.nbi"))) == 2
    assert started(path, tmp_path) == ["20.0 1 0"]


def test_what_only_a_later_step_calls_is_compiled_before_where_the_face_rehearses_it(
    fmu: Callable[[Path], Path], tmp_path: Path
) -> None:
    """The second step calls the kernel in single precision: found too, compiled none."""
    code = START.format(before="").replace("print(component", "component.step(0.1)\ncomponent.step(0.1)\nprint(component")
    words = [sys.executable, "-c", code, str(fmu(COMPONENTS / "kernels"))]
    done = subprocess.run(words, env=supported(XDG_CACHE_HOME=str(tmp_path)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[-1] == "20.0 2 0"


@pytest.mark.parametrize("before", ["kernels._compile = lambda *_: None", "kernels.PROCESSES = 'many'"])
def test_without_a_rehearsal_it_compiles_for_itself(fmu: Callable[[Path], Path], tmp_path: Path, before: str) -> None:
    if "many" in before:  # the rehearsal ends with an error
        before = (
            "kernels.subprocess.Popen = lambda words, popen=kernels.subprocess.Popen, **more: popen([*words[:3], 'x'], **more)"
        )
    assert started(fmu(COMPONENTS / "kernels"), tmp_path, before) == ["20.0 0 1"]


def test_an_fmu_without_kernels_starts_nothing(fmu: Callable[[str | Path], Path], tmp_path: Path) -> None:
    code = START.format(before="kernels._compile = None").rpartition("print(component")[0]
    words = [sys.executable, "-c", code, str(fmu("structure"))]
    done = subprocess.run(words, env=supported(XDG_CACHE_HOME=str(tmp_path)), capture_output=True, text=True)
    assert done.returncode == 0 and done.stdout == "", done.stderr
