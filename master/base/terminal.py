"""Lines that are drawn over each other on a terminal: one that wraps leaves its first part behind at every update."""

from __future__ import annotations

import os
import sys
from typing import TextIO

FALLBACK = 80  # columns of a terminal that does not tell


def columns(stream: TextIO | None = None) -> int:
    """Columns of the terminal behind `stream` (standard error); FALLBACK where there is none or it does not tell."""
    try:
        return os.get_terminal_size((stream or sys.stderr).fileno()).columns or FALLBACK
    except (OSError, ValueError, AttributeError):
        return FALLBACK


def fitted(text: str, room: int | None = None) -> str:
    """`text` cut to one line of `room` columns (the terminal's) less one, the cut marked: a full last column wraps on some."""
    most = max(1, (columns() if room is None else room) - 1)
    return text if len(text) <= most else text[: most - 1] + "…"
