"""The state machine of machine.py on each FMU, in a process of its own: a short run, always the same, and a long random one."""

from __future__ import annotations

import os
import random
import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ENVIRONMENT = dict(os.environ)  # a copy: pytest writes to its own while a thread starts a process
COMPONENTS = ("structure", "aero", "slosh_vof", "slosh_ems", "slosh_rbf")


def fuzz(folder: str, examples: int, calls: int, seed: str, limit: float) -> str:
    """What the machine found, "" if nothing: its falsifying example, or the calls up to the signal or the time limit."""
    command = [sys.executable, str(HERE / "machine.py"), folder, str(examples), str(calls), seed]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, errors="replace", timeout=limit, cwd=folder, env=ENVIRONMENT
        )
        code, out, said = str(done.returncode), done.stdout, done.stderr
    except subprocess.TimeoutExpired as error:
        code, out, said = (
            f"none after {limit} s",
            *((part or b"").decode(errors="replace") for part in (error.stdout, error.stderr)),
        )
    assert out.count("replay") or code != "0", "no run was long enough to be compared"
    last = out[out.rfind("example\n") :]
    return "" if code == "0" else f"seed {seed}, exit code {code}\n{said[-6000:]}\ncalls of the last example:\n{last[-4000:]}"


@pytest.fixture(scope="module")
def short(folders: dict[str, str]) -> dict[str, Future[str]]:
    """The short runs, two processes at a time."""
    pool = ThreadPoolExecutor(2)
    examples = {"aero": 15}  # each comparison solves a steady flow
    return {name: pool.submit(fuzz, folders[name], examples.get(name, 40), 30, "-", 90.0) for name in COMPONENTS}


@pytest.mark.parametrize("component", COMPONENTS)
def test_any_calls_in_any_order(short: dict[str, Future[str]], component: str) -> None:
    found = short[component].result()
    assert not found, found


@pytest.mark.validation
@pytest.mark.parametrize("component", COMPONENTS)
def test_any_calls_in_any_order_for_longer(folders: dict[str, str], component: str) -> None:
    found = fuzz(folders[component], 300 if component == "aero" else 1000, 60, str(random.randrange(10**9)), 900.0)
    assert not found, found
