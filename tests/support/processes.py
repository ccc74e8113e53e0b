"""The command: in this process, or in one of its own, to be waited for, interrupted, killed."""

from __future__ import annotations

import contextlib
import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

from aeroslosh.master import cli

from .paths import ROOT, TESTS

COMMAND = [sys.executable, "-m", "aeroslosh"]
QUICK = ("--set", "flow.mach=0.3", "--set", "flutter.steps_per_cycle=72", "--set", "flutter.forced_cycles=1.0", "--no-pictures")
Done = subprocess.CompletedProcess[str]


def called(*words: object, cwd: Path = ROOT, **environment: str) -> Done:
    """The command in this process, with its messages and its exit code; what it prints is given back.

    A process of its own does the same, and listens to signals and closed streams: a test of those calls `command`."""
    out, err = io.StringIO(), io.StringIO()
    streams = contextlib.redirect_stdout(out), contextlib.redirect_stderr(err)
    with contextlib.chdir(cwd), mock.patch.dict(os.environ, environment), streams[0], streams[1]:
        code = cli._told([str(word) for word in words])
    return Done(words, int(code), out.getvalue(), err.getvalue())


def command(*words: object, cwd: Path = ROOT, **environment: str) -> Done:
    """The command in a process of its own, to its end."""
    line = [*COMMAND, *map(str, words)]
    return subprocess.run(line, cwd=cwd, capture_output=True, text=True, env=os.environ | environment)


def supported(**environment: str) -> dict[str, str]:
    """The environment of a process that imports `aeroslosh` and `support`."""
    return os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (ROOT, TESTS)))} | environment


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
