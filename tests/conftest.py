"""Shared fixtures: FMUs built once a session, or taken from dist/fmus where those are up to date."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # as the command does; before numpy is loaded

from fmus.kit import build, native, sources

THIS = Path(os.path.abspath(sys.executable))
DIST = Path(__file__).resolve().parents[1] / "dist" / "fmus"


def is_current(fmu: Path, folder: Path) -> bool:
    """Tell whether `fmu` was built from the sources that now lie in `folder`."""
    if not fmu.is_file():
        return False
    digest = sources.content_hash(sources.component_files(folder, build.ROOT))
    wanted = f"resources/{folder.name}_{digest}_slave.py"
    with zipfile.ZipFile(fmu) as archive:
        if wanted not in archive.namelist() or archive.read(wanted) != build.script_text(folder, digest):
            return False
        return archive.read(f"binaries/linux64/{folder.name}.so") == native.LIBRARY.read_bytes()


def takes_this_python(fmu: Path) -> bool:
    """Tell whether a host that is no Python program would get the Python that runs the tests."""
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        return "resources/python.txt" in names and archive.read("resources/python.txt").strip() == os.fsencode(THIS)


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str | Path], Path]:
    """Return a function: component name, or folder of a test component -> path of its FMU."""
    out = tmp_path_factory.mktemp("fmus")
    built: dict[str, Path] = {}

    def get(component: str | Path) -> Path:
        folder = build.ROOT / component if isinstance(component, str) else component
        if folder.name not in built:
            ready = DIST / f"{folder.name}.fmu"
            built[folder.name] = ready if is_current(ready, folder) else build.build(folder, out)
            if not takes_this_python(built[folder.name]):
                if built[folder.name].parent != out:
                    built[folder.name] = Path(shutil.copy(built[folder.name], out))
                build.install(built[folder.name], THIS)
        return built[folder.name]

    return get


@pytest.fixture(scope="session")
def host() -> Callable[..., Any]:
    """Return a function that runs a scenario of fmu/host.py in a process of its own: a crash there is an
    error.
    """
    script = Path(__file__).with_name("fmu") / "host.py"

    def run(scenario: str, *arguments: Any, **environment: str) -> Any:
        done = subprocess.run(
            [sys.executable, str(script), scenario, json.dumps(arguments)],
            text=True,
            capture_output=True,
            env={**os.environ, **environment},
            timeout=300,
        )
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return json.loads(done.stdout.splitlines()[-1])

    return run
