"""Builds the test doubles once a session, each in a process of its own, and finds the structure FMU."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

DOUBLES = Path(__file__).parent / "doubles"
ROOT = Path(__file__).parents[2]
BUILD = """
import sys
from pathlib import Path
from pythonfmu.builder import FmuBuilder
script, dest, rewind = sys.argv[1:]
FmuBuilder.build_FMU(script, dest, project_files=[Path(script).with_name("double_base.py")],
                     canGetAndSetFMUstate=rewind)
"""


@pytest.fixture(scope="session")
def doubles(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with oscillator.fmu, link.fmu, aero.fmu, fixed.fmu (an oscillator that cannot rewind)."""
    folder = tmp_path_factory.mktemp("doubles")
    for script, name, rewind in (
        ("oscillator", "oscillator", "true"),
        ("link", "link", "true"),
        ("aero", "aero", "true"),
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
def flutter_fmus(doubles: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the product's structure.fmu and the thin-airfoil double as aero.fmu."""
    built = ROOT / "dist" / "fmus" / "structure.fmu"
    folder = tmp_path_factory.mktemp("flutter_fmus")
    if not built.is_file():
        done = subprocess.run(
            [sys.executable, "-m", "fmus.kit.build", "--out", str(folder)],
            cwd=ROOT,
            capture_output=True,
            text=True,
        )
        assert (folder / "structure.fmu").is_file(), f"structure.fmu cannot be built: {done.stderr}"
        (folder / "aero.fmu").unlink(missing_ok=True)
    else:
        shutil.copy(built, folder)
    shutil.copy(doubles / "aero.fmu", folder)
    return folder
