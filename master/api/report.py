"""A run as one HTML page."""

from __future__ import annotations

import os
from pathlib import Path


def report(path: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Path:
    """Write the page of a run folder (`point`, `boundary`, `amplitude`, `run`) or a sweep folder; it needs nothing but a browser.

    path  the folder; out: the page, report.html in the folder where None

    Returns where the page is. Raises AeroSloshError for what is no run, and where the page cannot be written."""
    from ..report import page  # 0.2 s to import

    return page.write(Path(path), None if out is None else Path(out))
