"""A file that is there whole or not at all, also after a loss of power."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path


def write(path: Path, data: bytes) -> None:
    """Write to a hidden name beside `path`, onto the disk, then rename. Raises OSError; then nothing new lies there."""
    part = path.with_name(f".{path.name}.part-{os.getpid()}")
    try:
        with part.open("wb") as stream:
            stream.write(data)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(part, path)
    except BaseException:
        with contextlib.suppress(OSError):
            part.unlink(missing_ok=True)
        raise
    sync_folder(path.parent)


def sync_folder(folder: Path) -> None:
    """Put the names in `folder` onto the disk: a rename alone is not there after a loss of power."""
    with contextlib.suppress(OSError):  # some network file systems know no fsync of folders
        handle = os.open(folder, os.O_RDONLY)
        try:
            os.fsync(handle)
        finally:
            os.close(handle)


def remove_parts(folder: Path) -> None:
    """Remove what writers that were killed left in `folder`; no writer may be at work there."""
    for part in folder.glob(".*.part-*"):
        part.unlink(missing_ok=True)
