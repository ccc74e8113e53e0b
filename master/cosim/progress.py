"""Live progress on standard error: step, time left, each FMU's share of the cost. Plain lines when not a terminal."""

from __future__ import annotations

import sys
import time as clock

from ..base.terminal import fitted
from .system import System


class Progress:
    """Call `say` for events and `watch` (a march's watcher) each step. Silent with `quiet`."""

    def __init__(self, quiet: bool = False) -> None:
        self.quiet = quiet
        self._live = not quiet and sys.stderr.isatty()
        self._shown = self._begin = 0.0
        self._quarter = 0
        self._width = 0
        self.label = ""
        self._quarters: dict[str, int] = {}

    def say(self, text: str) -> None:
        """One line that stays."""
        if self.quiet:
            return
        self._clear()
        print(text, file=sys.stderr, flush=True)

    def start(self, label: str) -> None:
        """A march begins."""
        self.label, self._begin, self._quarter, self._shown = label, clock.perf_counter(), 0, 0.0

    def watch(self, step: int, steps: int, system: System) -> None:
        """After each step: at most five updates a second, or a line a quarter of the march."""
        if self.quiet:
            return
        now = clock.perf_counter()
        if self._live:
            if now - self._shown < 0.2 and step < steps:
                return
            self._shown = now
            text = fitted(self._text(step, steps, system, now))
            self._width = max(self._width, len(text))
            print("\r" + text.ljust(self._width), end="", file=sys.stderr, flush=True)
            if step == steps:
                self._clear()
        elif 4 * step // steps > self._quarter:
            self._quarter = 4 * step // steps
            print(fitted(self._text(step, steps, system, now)), file=sys.stderr, flush=True)

    def beside(self, label: str, done: int, total: int, line: str) -> None:
        """One of several things at work side by side has come to `done` of `total`; `line` tells of all of them."""
        if self.quiet:
            return
        if self._live:
            line = fitted(line)
            self._width = max(self._width, len(line))
            print("\r" + line.ljust(self._width), end="", file=sys.stderr, flush=True)
        elif total and 4 * done // total > self._quarters.get(label, 0):
            self._quarters[label] = 4 * done // total
            print(f"  {label}  {done} of {total}", file=sys.stderr, flush=True)

    def _text(self, step: int, steps: int, system: System, now: float) -> str:
        spent = now - self._begin
        left = spent / step * (steps - step)
        total = sum(c.cpu for c in system.components) or 1.0
        shares = ", ".join(f"{c.name} {100.0 * c.cpu / total:.0f} %" for c in system.components)
        return f"  {self.label}  {step}/{steps}  {left:.0f} s left  ({shares})"

    def _clear(self) -> None:
        if self._live and self._width:
            print("\r" + " " * self._width + "\r", end="", file=sys.stderr, flush=True)
            self._width = 0
