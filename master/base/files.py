"""A file that is there whole or not at all, also after a loss of power."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Iterator
from pathlib import Path

from . import interrupts


def write(path: Path, data: bytes) -> None:
    """Write to a hidden name beside `path`, onto the disk, then rename. Raises OSError; then nothing new lies there."""
    with part(path) as hidden, hidden.open("wb") as stream:
        stream.write(data)
        stream.flush()
        os.fsync(stream.fileno())
    sync_folder(path.parent)


@contextlib.contextmanager
def part(path: Path, ending: str = "") -> Iterator[Path]:
    """A hidden name beside `path`, of this process alone, for whoever writes a file by its name; renamed at the end, or removed.

    `ending`: for writers that go by it."""
    hidden = path.with_name(f".{path.name}.part-{os.getpid()}{ending}")
    interrupts.UNFINISHED.add(hidden)
    try:
        yield hidden
        os.replace(hidden, path)
    except BaseException:
        with contextlib.suppress(OSError):
            hidden.unlink(missing_ok=True)
        raise
    finally:
        interrupts.UNFINISHED.discard(hidden)


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
    for hidden in folder.glob(".*.part-*"):
        hidden.unlink(missing_ok=True)
