"""Ctrl-C and a request to end: once, and the command stops in order and keeps what it keeps; again, and it ends at once.

The exception may strike inside an FMU, whose code is Python of this process and turns every exception into a failure of its own.
Therefore what asks an FMU looks here afterwards (`check`): an interrupted component has not failed."""

from __future__ import annotations

import os
import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import FrameType

from .errors import ExitCode

CODES = {"SIGINT": ExitCode.INTERRUPTED, "SIGTERM": ExitCode.TERMINATED, "SIGHUP": ExitCode.TERMINATED}
UNFINISHED: set[Path] = set()  # folders and files that a command removes when it stops in order


class Interrupted(KeyboardInterrupt):
    """The command is to stop; `code` is its exit code. Notes (`add_note`) say what became of its work."""

    def __init__(self, code: ExitCode = ExitCode.INTERRUPTED) -> None:
        super().__init__()
        self.code = code


pending: Interrupted | None = None  # asked for, and perhaps swallowed by an FMU
_first, _held = True, 0


def install() -> None:
    """Listen, but to no signal that whoever started this process had it ignore."""
    if threading.current_thread() is not threading.main_thread():
        return
    for name in CODES:
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) in (signal.SIG_DFL, signal.default_int_handler):
            signal.signal(number, _asked)


def check() -> None:
    """Raise Interrupted if it was asked for since the last time."""
    global pending
    if pending is not None:
        found, pending = pending, None
        raise found


@contextmanager
def held() -> Iterator[None]:
    """Let no interrupt strike in this block, which keeps something: it strikes at its end."""
    global _held
    _held += 1
    try:
        yield
    finally:
        _held -= 1
    if not _held:
        check()


def is_held() -> bool:
    """Whether a block keeps something now, at whose end an interrupt strikes."""
    return _held > 0


def _asked(number: int, _frame: FrameType | None) -> None:
    global pending, _first
    code = CODES[signal.Signals(number).name]
    if _first:
        _first = False
        pending = Interrupted(code)
        if _held:
            return
        raise pending
    left = [str(path) for path in sorted(UNFINISHED) if path.exists()]
    said = f"left there unfinished: {', '.join(left)}" if left else "nothing unfinished is left"
    os.write(2, f"\naeroslosh: interrupted again, ended at once; {said}\n".encode(errors="backslashreplace"))
    os._exit(code)
