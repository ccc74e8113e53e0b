"""How far a sweep is, on standard error: points done, failed and left, and the time left."""

from __future__ import annotations

import sys
import time as clock

from ..base.terminal import fitted

EVERY = 10.0  # seconds between lines when standard error is no terminal


def duration(seconds: float) -> str:
    """As people say it: 42 s, 3 min 20 s, 5 h 10 min."""
    s = round(seconds)
    if s < 60:
        return f"{s} s"
    return f"{s // 60} min {s % 60} s" if s < 3600 else f"{s // 3600} h {s % 3600 // 60} min"


class SweepProgress:
    """`say` a line that stays, `show` the counts. `workers` compute at a time, a point is expected to take `expected` seconds
    until some are done."""

    def __init__(self, quiet: bool) -> None:
        self.quiet = quiet
        self.workers, self.expected = 1, 0.0
        self._live = not quiet and sys.stderr.isatty()
        self._shown, self._width, self._line = -EVERY, 0, ""
        self._spent, self._points = 0.0, 0

    def say(self, text: str) -> None:
        """One line that stays."""
        if not self.quiet:
            self._clear()
            print(text, file=sys.stderr, flush=True)

    def took(self, wall: float) -> None:
        """A point is finished; its wall time [s]."""
        self._spent, self._points = self._spent + wall, self._points + 1

    def show(self, counts: dict[str, int]) -> None:
        """Points pending, done and failed."""
        if self.quiet:
            return
        now, pending = clock.monotonic(), counts["pending"]
        if pending and now < self._shown + (0.2 if self._live else EVERY):
            return
        each = self._spent / self._points if self._points else self.expected
        left = f", {duration(each * max(1.0, pending / max(1, self.workers)))} left" if pending and each else ""
        failed = f", {counts['failed']} failed" if counts["failed"] else ""
        text = f"  {counts['done']} of {sum(counts.values())} points done{failed}{left}"
        if text == self._line:
            return
        self._shown, self._line = now, text
        if self._live:
            text = fitted(text)
            self._width = max(self._width, len(text))
            print("\r" + text.ljust(self._width), end="\n" if not pending else "", file=sys.stderr, flush=True)
            self._width = self._width if pending else 0
        else:
            print(text, file=sys.stderr, flush=True)

    def _clear(self) -> None:
        if self._live and self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)
            self._width = 0
