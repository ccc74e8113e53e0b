"""The command in a process of its own, to be waited for, interrupted, killed."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

COMMAND = [sys.executable, "-m", "aeroslosh"]
QUICK = ("--set", "flow.mach=0.3", "--set", "flutter.steps_per_cycle=72", "--set", "flutter.forced_cycles=1.0", "--no-pictures")


def until(condition: Callable[[], Any], seconds: float = 60.0) -> Any:
    """Wait for `condition`; its value."""
    deadline = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < deadline, "waited in vain"
        time.sleep(0.01)
    return value


@contextmanager
def started(command: list[str]) -> Iterator[subprocess.Popen[str]]:
    """The command at work; killed at the end at the latest."""
    # a shell starts what runs in the background with interrupts ignored, which a child would inherit: not so here
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    finally:
        signal.signal(signal.SIGINT, before)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()
