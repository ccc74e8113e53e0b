"""What whoever started a computation is told from deep inside it: a line, now and then. Nobody listens unless asked to."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager

_listener: Callable[[str], None] | None = None


@contextmanager
def to(listener: Callable[[str], None]) -> Iterator[None]:
    """Tell `listener` what is said in the block."""
    global _listener
    before, _listener = _listener, listener
    try:
        yield
    finally:
        _listener = before


def say(text: str) -> None:
    """One line."""
    if _listener is not None:
        _listener(text)
