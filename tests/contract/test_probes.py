"""What fmus/kit/README.md says that pythonfmu's binary does not guard: true of the version that is installed.

Where a probe starts to give another answer, a new pythonfmu guards it, and that section of the README can be shortened.
"""

from __future__ import annotations

import subprocess
import sys
from concurrent.futures import Future, ThreadPoolExecutor
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ENDS = ("null_resources", "no_such_resources", "null_name", "name_not_utf8", "null_logger", "callbacks_gone", "null_component",
        "null_pointers_with_a_count", "null_category")  # fmt: skip
ANSWERS = {
    "wrong_guid": "True",
    "model_exchange": "True",
    "null_callbacks": "True",
    "null_logger_without_logging": "2",
    "free_null_component": "nothing",
    "free_null_state": "0",
    "freed_state_is_null": "False",
    "take_into_a_state": "False",
    "serialise_into_too_little": "(0, True)",
    "ordinary_exit": "done",
}


@pytest.fixture(scope="module")
def probed(folders: dict[str, str]) -> dict[str, Future[subprocess.CompletedProcess[str]]]:
    """All probes, two processes at a time."""
    pool = ThreadPoolExecutor(2)

    def probe(name: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, str(HERE / "probes.py"), name, folders["structure"]]
        return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=60)

    return {name: pool.submit(probe, name) for name in (*ENDS, *ANSWERS)}


@pytest.mark.parametrize("name", ENDS)
def test_ends_the_process(probed: dict[str, Future[subprocess.CompletedProcess[str]]], name: str) -> None:
    assert probed[name].result().returncode < 0  # a signal


@pytest.mark.parametrize(("name", "answer"), ANSWERS.items())
def test_is_survived(probed: dict[str, Future[subprocess.CompletedProcess[str]]], name: str, answer: str) -> None:
    done = probed[name].result()
    assert (done.returncode, done.stdout.strip()) == (0, answer), done.stderr
