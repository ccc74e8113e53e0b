"""Builds the test doubles: spring.c by the C compiler, the others by pythonfmu, each in a process of its own."""

from __future__ import annotations

import platform
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy

from ..paths import DOUBLES

BUILD = """
import sys
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


def compiler() -> str | None:
    """What compiles spring.c here, if anything does."""
    found = shutil.which("cc")
    return found if (platform.system(), platform.machine()) == ("Linux", "x86_64") else None


def springs(folder: Path) -> None:
    """spring.fmu and stubborn.fmu, compiled from spring.c: the second cannot rewind."""
    headers, cc = Path(fmpy.__file__).parent / "c-code", compiler()
    assert cc is not None
    for name, rewinds in (("spring", True), ("stubborn", False)):
        guid, library = f"{{{name}-1}}", folder / f"{name}.so"
        options = ["-shared", "-fPIC", "-O2", "-ffp-contract=off", f"-I{headers}", f'-DGUID="{guid}"', f"-DREWINDS={rewinds:d}"]
        done = subprocess.run(
            [cc, *options, "-o", str(library), str(DOUBLES / "spring.c"), "-lm"], capture_output=True, text=True
        )
        assert done.returncode == 0, done.stderr
        with zipfile.ZipFile(folder / f"{name}.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", spring_description(name, guid, rewinds))
            archive.write(library, f"binaries/linux64/{name}.so")


def doubles(folder: Path) -> None:
    """oscillator.fmu, link.fmu, aero.fmu, plate.fmu, fixed.fmu (an oscillator that cannot rewind)."""
    for script, name, rewind in (
        ("oscillator", "oscillator", "true"),
        ("link", "link", "true"),
        ("aero", "aero", "true"),
        ("plate", "plate", "true"),
        ("oscillator", "fixed", "false"),
    ):
        words = [str(DOUBLES / f"{script}.py"), str(folder / f"{name}.fmu"), rewind]
        done = subprocess.run([sys.executable, "-c", BUILD, *words], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
