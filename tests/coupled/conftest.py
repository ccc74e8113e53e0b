"""Builds the test doubles once a session, each in a process of its own, and puts the product's FMUs beside them."""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import fmpy
import pytest

DOUBLES = Path(__file__).parent / "doubles"
BUILD = """
import sys
from collections.abc import Callable
from pathlib import Path
from pythonfmu.builder import FmuBuilder
script, dest, rewind = sys.argv[1:]
FmuBuilder.build_FMU(script, dest, project_files=[Path(script).with_name("double_base.py")],
                     canGetAndSetFMUstate=rewind, canSerializeFMUstate=rewind)
"""

# (name, causality, variability, start, unit) by value reference of spring.c
SPRING = (
    ("mass", "parameter", "fixed", 1.0, "kg"),
    ("damping", "parameter", "fixed", 0.0, "kg/s"),
    ("stiffness", "parameter", "fixed", 1.0, "N/m"),
    ("initial_x", "parameter", "fixed", 0.0, "m"),
    ("initial_v", "parameter", "fixed", 0.0, "m/s"),
    ("force", "input", "continuous", 0.0, "N"),
    ("x", "output", "continuous", None, "m"),
    ("v", "output", "continuous", None, "m/s"),
    ("a", "output", "continuous", None, "m/s2"),
    ("steps", "output", "discrete", None, "1"),
    ("mark", "input", "discrete", 0.0, "1"),  # has no derivatives, and says so when asked for them
)


def spring_description(name: str, guid: str, rewinds: bool) -> str:
    """modelDescription.xml of spring.c; its model structure names no dependencies, as the standard allows."""
    can = str(rewinds).lower()
    units = "".join(f'<Unit name="{unit}"/>' for unit in sorted({row[4] for row in SPRING}))
    variables = ""
    for reference, (variable, causality, variability, start, unit) in enumerate(SPRING):
        first = f' start="{start}"' if start is not None else ""
        variables += f"""
    <ScalarVariable name="{variable}" valueReference="{reference}" causality="{causality}" variability="{variability}">
      <Real unit="{unit}"{first}/>
    </ScalarVariable>"""
    unknowns = "".join(f'<Unknown index="{i + 1}"/>' for i, row in enumerate(SPRING) if row[1] == "output")
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="{name}" guid="{guid}">
  <CoSimulation modelIdentifier="{name}" canHandleVariableCommunicationStepSize="true" canInterpolateInputs="true"
    canGetAndSetFMUstate="{can}" canSerializeFMUstate="{can}"/>
  <UnitDefinitions>{units}</UnitDefinitions>
  <ModelVariables>{variables}
  </ModelVariables>
  <ModelStructure><Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="session")
def springs(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with spring.fmu and stubborn.fmu, compiled from spring.c: the second cannot rewind."""
    compiler = shutil.which("cc")
    if compiler is None or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip("spring.c needs a C compiler `cc` on Linux x86-64")
    folder, headers = tmp_path_factory.mktemp("springs"), Path(fmpy.__file__).parent / "c-code"
    for name, rewinds in (("spring", True), ("stubborn", False)):
        guid, library = f"{{{name}-1}}", folder / f"{name}.so"
        options = ["-shared", "-fPIC", "-O2", "-ffp-contract=off", f"-I{headers}", f'-DGUID="{guid}"', f"-DREWINDS={rewinds:d}"]
        done = subprocess.run(
            [compiler, *options, "-o", str(library), str(DOUBLES / "spring.c"), "-lm"], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        with zipfile.ZipFile(folder / f"{name}.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", spring_description(name, guid, rewinds))
            archive.write(library, f"binaries/linux64/{name}.so")
    return folder


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
