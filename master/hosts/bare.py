"""An FMU in a program that is no Python, with nothing in its environment: which Python it finds there, and whether it runs.

Most FMI tools are such programs. `fmus/kit/native/try_fmu` is one: it loads the FMU's library, makes an instance and one step.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from pathlib import Path

import fmpy

from ...fmus.kit import native
from .finding import Finding, ok, warning

PATH = "/usr/bin:/bin"
LIMIT = 300.0  # seconds: a first load compiles
REMEDY = "see docs/hosts.md: set AEROSLOSH_PYTHON in the host's environment, or start it with aeroslosh-launch"


def environment() -> dict[str, str]:
    """A path and a home, no more."""
    return {"PATH": PATH, "HOME": os.environ.get("HOME", "/")}


def findings(name: str, folder: Path, given: Mapping[str, str] | None = None) -> list[Finding]:
    """Try the FMU `name` unzipped to `folder`, in the environment `given` instead of an empty one; [] if it is none of ours."""
    library = next(iter((folder / "binaries" / "linux64").glob("*.so")), None)
    if library is None or not (folder / "resources" / native.ASKED.name).is_file():
        return []
    description = fmpy.read_model_description(str(folder), validate=False)
    step = description.defaultExperiment.stepSize if description.defaultExperiment else None
    with tempfile.TemporaryDirectory(prefix="fmu_") as place:
        program = Path(shutil.copy(native.TRY, place))
        program.chmod(0o755)  # an installed package may have lost the right to run it
        words = [str(program), str(library), (folder / "resources").as_uri(), description.guid, str(step or 1e-3)]
        try:
            done = subprocess.run(
                words, capture_output=True, text=True, errors="replace", timeout=LIMIT, cwd=place,
                env=environment() if given is None else dict(given),
            )  # fmt: skip
        except (OSError, subprocess.TimeoutExpired) as error:
            return [warning(name, f"a program that is no Python could not be tried: {error}", REMEDY)]
    lines = done.stdout.splitlines()
    python = next((line.partition(": ")[2] for line in lines if line.startswith("python: ")), "")
    if done.returncode == 0 and "runs" in lines:
        return [ok(name, f"runs in a program that is no Python, in an empty environment, with {python}", host_python=python)]
    said = " ".join(line for line in lines if not line.startswith("python: ")).replace("%%", "%")
    said = said or done.stderr.strip() or f"it ended with exit code {done.returncode}"
    what, _, remedy = said.partition(" Remedy: ")
    text = f"does not run in a program that is no Python, in an empty environment: {what.removeprefix('doctor: ')}"
    return [warning(name, text, remedy or REMEDY, host_python=python)]
