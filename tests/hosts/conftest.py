"""The C host of examples/c_host compiled, FMUs unzipped, and the ways to start a program that is not Python."""

from __future__ import annotations

import json
import platform
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import fmpy
import pytest

from aeroslosh.master.hosts import hosting

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))  # for host_jobs, which is no test

from host_jobs import LAUNCH, ROOT, clean  # noqa: E402


@pytest.fixture(scope="session")
def c_host(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The program."""
    compiler = shutil.which("cc")
    if compiler is None or (platform.system(), platform.machine()) != ("Linux", "x86_64"):
        pytest.skip("examples/c_host needs a C compiler `cc` on Linux x86-64")
    program, headers = tmp_path_factory.mktemp("c_host") / "host", Path(fmpy.__file__).parent / "c-code"
    options = ["-std=c11", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Werror", f"-I{headers}"]
    source = ROOT / "examples" / "c_host" / "host.c"
    done = subprocess.run([compiler, *options, str(source), "-o", str(program), "-ldl"], capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return program


@pytest.fixture(scope="session")
def launch() -> list[str]:
    """What stands before a program that needs libpython."""
    if hosting.libpython() is None:
        pytest.skip(f"{sys.executable} has no shared libpython: {hosting.missing_libpython()}")
    return LAUNCH


@pytest.fixture(scope="session")
def unzipped(fmu: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[[str], Path]:
    """Name of an FMU → its unzipped folder."""
    out, done = tmp_path_factory.mktemp("unzipped"), set[str]()

    def get(name: str) -> Path:
        if name not in done:
            with zipfile.ZipFile(fmu(name)) as archive:
                archive.extractall(out / name)
            done.add(name)
        return out / name

    return get


@pytest.fixture(scope="session")
def tool(tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[list[str]]]:
    """Run an FMU in a tool of tools.py, in a process of its own: rows of outputs, each number in hexadecimal."""
    kept: dict[str, list[list[str]]] = {}
    elsewhere = tmp_path_factory.mktemp("elsewhere")

    def run(name: str, job: dict[str, Any], *before: str, cwd: Path = elsewhere, **environment: str) -> list[list[str]]:
        words = [*before, sys.executable, str(HERE / "tools.py"), name, json.dumps(job)]
        key = json.dumps([words, str(cwd), environment])
        if key not in kept:
            done = subprocess.run(
                words, capture_output=True, text=True, errors="replace", cwd=cwd, env=clean(**environment), timeout=300
            )
            assert done.returncode == 0, f"exit code {done.returncode}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
            kept[key] = json.loads(done.stdout.splitlines()[-1])
        return kept[key]

    return run
