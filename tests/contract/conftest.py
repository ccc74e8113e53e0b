"""The five FMUs unzipped once, and processes that run a module of cases on one of them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import fmpy
import pytest

HERE = Path(__file__).resolve().parent
ENVIRONMENT = dict(os.environ)  # a copy: pytest writes to its own while a thread starts a process
COMPONENTS = ("structure", "aero", "slosh_vof", "slosh_ems", "slosh_rbf")
Results = dict[str, str]


@pytest.fixture(scope="session")
def folders(fmu: Callable[[str | Path], Path], tmp_path_factory: pytest.TempPathFactory) -> dict[str, str]:
    """Unzip folder of each FMU."""
    found = {}
    for component in COMPONENTS:
        found[component] = str(tmp_path_factory.mktemp(component))
        fmpy.extract(str(fmu(component)), found[component])
    return found


@pytest.fixture(scope="session")
def contract(folders: dict[str, str]) -> Callable[[str, str, str], str]:
    """Return a function: component, module, case -> what went wrong, "" if nothing.

    The first time a module is asked for, it is run on all FMUs, in two processes at a time.
    """
    pool = ThreadPoolExecutor(2)
    runs: dict[str, dict[str, Future[Results]]] = {}

    def ask(component: str, module: str, case: str) -> str:
        if module not in runs:
            runs[module] = {name: pool.submit(_run, module, folders, name) for name in COMPONENTS}
        results = runs[module][component].result()
        return results.get(case, results.get("", "the process ended without a word of this case"))

    return ask


def _run(module: str, folders: dict[str, str], component: str) -> Results:
    """Results by case; under "" how the process ended, if not well."""
    try:
        done = subprocess.run(
            [sys.executable, str(HERE / "runner.py"), module, json.dumps(folders), component],
            capture_output=True, timeout=900, cwd=folders[component], env=ENVIRONMENT,
        )  # fmt: skip
        code, out, said = str(done.returncode), done.stdout, done.stderr
    except subprocess.TimeoutExpired as error:
        code, out, said = "timeout", error.stdout or b"", error.stderr or b""
    results, running = {}, ""
    for line in out.decode(errors="replace").splitlines():
        if line.startswith(">case_"):
            running = line[1:]
        elif line.startswith("case_"):
            name, _, text = line.partition(" ")
            results[name], running = json.loads(text), ""
    if code != "0":
        results[""] = f"the process ended (code {code}) in {running}:\n{said.decode(errors='replace')[-6000:]}"
    return results
