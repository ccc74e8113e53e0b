"""Every call that a host must not make, on the library of one FMU: a status, no signal; what fmus/kit/README.md says of it."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).resolve().parent
ANSWERS = {
    "wrong_guid": "False",  # no instance
    "model_exchange": "False",
    "null_resources": "True",  # those beside the library
    "no_such_resources": "True",
    "null_name": "False",
    "name_not_utf8": "True",
    "null_callbacks": "True",
    "null_logger": "3",
    "null_logger_without_logging": "3",
    "callbacks_gone": "3",
    "null_component": "{3}",
    "anything_as_component": "{3}",
    "other_library": "(3, 3, 3, 0)",
    "free_null_component": "nothing",
    "free_twice": "nothing",
    "use_after_free": "3",
    "null_pointers_with_a_count": "{3}",
    "more_values_than_variables": "{3}",
    "null_results": "([3, 3, 3, 3, 3, 2, 2], False)",
    "step_within_a_message": "(3, [True])",
    "null_category": "3",
    "set_null_state": "(3, 3)",
    "set_freed_state": "(3, True)",
    "free_null_state": "0",
    "free_state_twice": "(0, 3)",
    "free_state_by_value": "(0, 3, 3)",
    "freed_state_is_null": "True",
    "take_into_a_state": "True",
    "serialise_into_too_little": "(3, False)",
    "serialise_into_too_much": "3",
    "exit_of_a_fork": "(7, True)",
    "ordinary_exit": "done",
}


@pytest.fixture(scope="module")
def probed(folders: dict[str, str]) -> subprocess.CompletedProcess[str]:
    """All probes in one process: none may harm those behind it."""
    command = [sys.executable, str(HERE / "probes.py"), folders["structure"], *ANSWERS]
    return subprocess.run(command, capture_output=True, text=True, errors="replace", timeout=120)


@pytest.mark.parametrize(("name", "answer"), ANSWERS.items())
def test_is_answered(probed: subprocess.CompletedProcess[str], name: str, answer: str) -> None:
    assert f"{name}: {answer}" in probed.stdout.splitlines(), probed.stdout[-2000:] + probed.stderr[-3000:]


def test_the_process_that_saw_it_all_ends_well(probed: subprocess.CompletedProcess[str]) -> None:
    assert probed.returncode == 0, probed.stderr[-3000:]
