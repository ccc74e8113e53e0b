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

from aeroslosh.fmus.build import archive as build_archive
from aeroslosh.fmus.kit import native, sources
from support.doubles import build as doubles_build
from support.once import once
from support.paths import DIST
from support.processes import supported

THIS = Path(os.path.abspath(sys.executable))


def is_current(fmu: Path, folder: Path) -> bool:
    """Tell whether `fmu` was built from the sources that now lie in `folder`."""
    if not fmu.is_file():
        return False
    digest = sources.content_hash(sources.component_files(folder, build_archive.ROOT))
    wanted = f"resources/{folder.name}_{digest}_slave.py"
    with zipfile.ZipFile(fmu) as archive:
        if wanted not in archive.namelist() or archive.read(wanted) != build_archive.script_text(folder, digest):
            return False
        return archive.read(f"binaries/linux64/{folder.name}.so") == native.LIBRARY.read_bytes()


def takes_this_python(fmu: Path) -> bool:
    """Tell whether a host that is no Python program would get the Python that runs the tests."""
    with zipfile.ZipFile(fmu) as archive:
        names = archive.namelist()
        return "resources/python.txt" in names and archive.read("resources/python.txt").strip() == os.fsencode(THIS)


def own(folder: Path, ready: Path, out: Path) -> None:
    """Put the FMU of `folder` into `out`, a copy of `ready` where that is current, installed for this Python."""
    made = Path(shutil.copy(ready, out)) if is_current(ready, folder) else build_archive.build(folder, out)
    build_archive.install(made, THIS)


@pytest.fixture(scope="session")
def fmu(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str | Path], Path]:
    """Return a function: component name, or folder of a test component -> path of its FMU."""
    built: dict[str, Path] = {}

    def get(component: str | Path) -> Path:
        folder = build_archive.ROOT / component if isinstance(component, str) else component
        if folder.name not in built:
            ready = DIST / f"{folder.name}.fmu"
            if not is_current(ready, folder) or not takes_this_python(ready):
                made = once(tmp_path_factory, f"fmu_{folder.name}", lambda out: own(folder, ready, out))
                ready = made / f"{folder.name}.fmu"
            built[folder.name] = ready
        return built[folder.name]

    return get


@pytest.fixture(scope="session")
def host() -> Callable[..., Any]:
    """Return a function that runs a scenario of support/scenarios in a process of its own: a crash there is an error."""

    def run(scenario: str, *arguments: Any, **environment: str) -> Any:
        done = subprocess.run(
            [sys.executable, "-m", "support.scenarios", scenario, json.dumps(arguments)],
            text=True,
            capture_output=True,
            env=supported(**environment),
            timeout=300,
        )
        assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
        return json.loads(done.stdout.splitlines()[-1])

    return run


@pytest.fixture(scope="session")
def springs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with spring.fmu and stubborn.fmu, compiled from spring.c: the second cannot rewind."""
    if doubles_build.compiler() is None:
        pytest.skip("spring.c needs a C compiler `cc` on Linux x86-64")
    return once(tmp_path_factory, "springs", doubles_build.springs)


@pytest.fixture(scope="session")
def doubles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with oscillator.fmu, link.fmu, aero.fmu, plate.fmu, fixed.fmu (an oscillator that cannot rewind)."""
    return once(tmp_path_factory, "doubles", doubles_build.doubles)


@pytest.fixture(scope="session")
def flutter_fmus(doubles: Path, fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the product's structure.fmu and slosh_ems.fmu, and the thin-airfoil double as aero.fmu."""

    def fill(folder: Path) -> None:
        for name in ("structure", "slosh_ems"):
            shutil.copy(fmu(name), folder)
        shutil.copy(doubles / "aero.fmu", folder)

    return once(tmp_path_factory, "flutter_fmus", fill)


@pytest.fixture(scope="session")
def plate_fmus(doubles: Path, flutter_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same with the flat plate in subsonic flow as aero.fmu."""

    def fill(folder: Path) -> None:
        for name in ("structure", "slosh_ems"):
            shutil.copy(flutter_fmus / f"{name}.fmu", folder)
        shutil.copy(doubles / "plate.fmu", folder / "aero.fmu")

    return once(tmp_path_factory, "plate_fmus", fill)
