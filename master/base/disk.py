"""What a user is told when a result cannot be put onto the disk."""

from __future__ import annotations

import errno
from pathlib import Path

from .errors import AeroSloshError, ExitCode

FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)
REFUSED = (
    errno.EACCES,
    errno.EPERM,
    errno.EROFS,
    errno.EIO,
    errno.ENAMETOOLONG,
    errno.EISDIR,
    errno.ENOTDIR,
    errno.ENXIO,
    errno.EEXIST,
)


def of_disk(error: OSError) -> bool:
    """Whether the machine, not this program, is the cause."""
    return error.errno in FULL + REFUSED


def explained(error: OSError, where: Path | str, remedy: str = "") -> AeroSloshError:
    """An error with the exit code INCOMPLETE: what was computed is not, or not all, on the disk."""
    full = error.errno in FULL
    what = f"The disk is full ({error.strerror})" if full else f"The result cannot be written: {error.strerror}"
    remedy = remedy or ("free space and run again" if full else "give another place with --out")
    return AeroSloshError(what, str(where), remedy, ExitCode.INCOMPLETE)
