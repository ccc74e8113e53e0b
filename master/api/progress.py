"""How far a computation is: for a bar on standard error, for a callback, or for nobody."""

from __future__ import annotations

import contextlib
import signal
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from types import FrameType
from typing import Protocol

from ..base import interrupts
from ..cosim.progress import Progress
from ..cosim.system import System


class Cancelled(KeyboardInterrupt):
    """A progress callback returned False. What was finished is kept."""


class CallbackFailed(BaseException):
    """A progress callback raised `error`: no failure of a march, so that nobody on the way takes it for one."""

    def __init__(self, error: Exception) -> None:
        super().__init__(str(error))
        self.error = error


@dataclass(frozen=True)
class Update:
    """What a callback is given: `label` of the march or sweep at work, `done` of `total` steps or points, or a `text` alone."""

    label: str = ""
    done: int = 0
    total: int = 0
    text: str = ""


Callback = Callable[[Update], bool | None]


class Reporter(Protocol):
    """Who is told of progress."""

    def say(self, text: str) -> None:
        """An event."""

    def start(self, label: str) -> None:
        """A march begins."""

    def watch(self, step: int, steps: int, system: System) -> None:
        """After each step of it."""

    def beside(self, label: str, done: int, total: int, line: str) -> None:
        """One of several things at work side by side has come to `done` of `total`; `line` tells of all of them."""


class ToCallback:
    """Passes everything on to a callback; its answer False cancels."""

    def __init__(self, callback: Callback) -> None:
        self._callback, self._label = callback, ""

    def say(self, text: str) -> None:
        """An event."""
        self.update(Update(text=text))

    def start(self, label: str) -> None:
        """A march begins."""
        self._label = label

    def watch(self, step: int, steps: int, system: System) -> None:
        """After each step of it."""
        self.update(Update(self._label, step, steps))

    def beside(self, label: str, done: int, total: int, line: str) -> None:
        """One of several things at work side by side."""
        self.update(Update(label, done, total))

    def update(self, update: Update) -> None:
        """Raises Cancelled, CallbackFailed."""
        try:
            answer = self._callback(update)
        except Exception as error:
            raise CallbackFailed(error) from error
        if answer is not None and type(answer).__name__ in ("bool", "bool_") and not answer:  # numpy's False too
            raise Cancelled


def reporter(progress: bool | Callback) -> Progress | ToCallback:
    """`progress` as a caller gives it: True for a bar on standard error, False for silence, or a callback."""
    return ToCallback(progress) if callable(progress) else Progress(quiet=not progress)


@contextlib.contextmanager
def interruptible() -> Iterator[None]:
    """Ctrl-C ends the block in order, also where it strikes inside an FMU, whose Python would make a failure of it.

    In the main thread, where Ctrl-C raises KeyboardInterrupt; elsewhere, and in the command (which listens itself), nothing
    changes. What a progress callback raised leaves the block as it was."""
    try:
        with _listening():
            yield
    except CallbackFailed as failed:
        raise failed.error from None


@contextlib.contextmanager
def _listening() -> Iterator[None]:
    main = threading.current_thread() is threading.main_thread()
    if not main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return

    def asked(number: int, frame: FrameType | None) -> None:
        interrupts.pending = interrupts.Interrupted()
        if not interrupts.is_held():
            raise interrupts.pending

    signal.signal(signal.SIGINT, asked)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
        interrupts.pending = None
