"""The library that is kept compiled is that of its source, and asks of a machine what it says."""

from __future__ import annotations

import importlib.util
import json
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from aeroslosh.fmus.kit import native
from aeroslosh.fmus.kit.native import compile as compiling

FUNCTIONS = {
    "GetTypesPlatform", "GetVersion", "SetDebugLogging", "Instantiate", "FreeInstance", "SetupExperiment",
    "EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "GetReal", "GetInteger", "GetBoolean",
    "GetString", "SetReal", "SetInteger", "SetBoolean", "SetString", "GetFMUstate", "SetFMUstate", "FreeFMUstate",
    "SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate", "GetDirectionalDerivative",
    "SetRealInputDerivatives", "GetRealOutputDerivatives", "DoStep", "CancelStep", "GetStatus", "GetRealStatus",
    "GetIntegerStatus", "GetBooleanStatus", "GetStringStatus",
}  # fmt: skip


@pytest.mark.parametrize("made", compiling.MADE, ids=lambda path: path.name)
def test_what_is_kept_was_compiled_from_the_source(made: Path) -> None:
    """By the hashes that were noted: run `python -m aeroslosh.fmus.kit.native.compile` after a change."""
    noted = json.loads(native.RECORD.read_text())[made.name]
    assert (noted["source"], noted["result"]) == (compiling.sha256(compiling.MADE[made][0]), compiling.sha256(made))


@pytest.mark.parametrize("made", compiling.MADE, ids=lambda path: path.name)
def test_the_noted_compiler_makes_the_same_bytes(made: Path, tmp_path: Path) -> None:
    if importlib.util.find_spec("ziglang") is None:
        pytest.skip("ziglang is not installed: pip install 'aeroslosh[dev]'")
    compiling.compile_to(tmp_path / "made", made)
    assert compiling.sha256(tmp_path / "made") == compiling.sha256(made)


@pytest.mark.parametrize("made", compiling.MADE, ids=lambda path: path.name)
def test_another_compiler_takes_it_without_a_warning(made: Path, tmp_path: Path) -> None:
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler `cc`")
    source, more = compiling.MADE[made]
    command = [compiler, *compiling.OPTIONS, *more, "-Werror", "-o", str(tmp_path / "made"), str(source), *compiling.LIBRARIES]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


def test_it_exports_the_standards_functions_and_asks_for_an_old_c_library_alone() -> None:
    if shutil.which("nm") is None:
        pytest.skip("no binutils")
    told = subprocess.run(["nm", "-D", str(native.LIBRARY)], capture_output=True, text=True, check=True).stdout
    exported = {line.split()[-1] for line in told.splitlines() if " T " in line or " D " in line}
    assert exported == {f"fmi2{name}" for name in FUNCTIONS}
    wanted = [line.split()[-1] for line in told.splitlines() if " U " in line or " w " in line]
    assert not [name for name in wanted if name.startswith(("Py", "_Py"))]
    versions = [tuple(map(int, version.split("."))) for version in re.findall(r"@GLIBC_([\d.]+)", told)]
    assert versions and max(versions) <= (2, 17)
