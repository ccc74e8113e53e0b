"""Builds the test doubles once a session, each in a process of its own, and puts the product's FMUs beside them."""

from __future__ import annotations

import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

DOUBLES = Path(__file__).parent / "doubles"
BUILD = """
import sys
from collections.abc import Callable
from pathlib import Path
from pythonfmu.builder import FmuBuilder
script, dest, rewind = sys.argv[1:]
FmuBuilder.build_FMU(script, dest, project_files=[Path(script).with_name("double_base.py")],
                     canGetAndSetFMUstate=rewind)
"""


@pytest.fixture(scope="session")
def doubles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with oscillator.fmu, link.fmu, aero.fmu, plate.fmu, fixed.fmu (an oscillator that cannot rewind)."""
    folder = tmp_path_factory.mktemp("doubles")
    for script, name, rewind in (
        ("oscillator", "oscillator", "true"),
        ("link", "link", "true"),
        ("aero", "aero", "true"),
        ("plate", "plate", "true"),
        ("oscillator", "fixed", "false"),
    ):
        done = subprocess.run(
            [sys.executable, "-c", BUILD, str(DOUBLES / f"{script}.py"), str(folder / f"{name}.fmu"), rewind],
            capture_output=True,
            text=True,
        )
        assert done.returncode == 0, done.stderr
    return folder


@pytest.fixture(scope="session")
def flutter_fmus(doubles: Path, fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the product's structure.fmu and slosh_ems.fmu, and the thin-airfoil double as aero.fmu."""
    folder = tmp_path_factory.mktemp("flutter_fmus")
    for name in ("structure", "slosh_ems"):
        shutil.copy(fmu(name), folder)
    shutil.copy(doubles / "aero.fmu", folder)
    return folder


@pytest.fixture(scope="session")
def plate_fmus(doubles: Path, flutter_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The same with the flat plate in subsonic flow as aero.fmu."""
    folder = tmp_path_factory.mktemp("plate_fmus")
    for name in ("structure", "slosh_ems"):
        shutil.copy(flutter_fmus / f"{name}.fmu", folder)
    shutil.copy(doubles / "plate.fmu", folder / "aero.fmu")
    return folder
