"""Text files as people have them."""

from __future__ import annotations

import codecs
from pathlib import Path

from .errors import AeroSloshError


def read(path: Path, what: str) -> str:
    """The text of a UTF-8 file, with or without the mark that some editors put in front; every line ends in \\n.

    Raises OSError, and AeroSloshError for another encoding; `what` the file is goes into the message."""
    data = path.read_bytes()
    if data.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)) or b"\0" in data[:4]:
        raise AeroSloshError(f"The {what} is UTF-16 text", str(path), "save it as UTF-8")
    try:
        return data.decode("utf-8-sig").replace("\r\n", "\n").replace("\r", "\n")
    except UnicodeDecodeError as error:
        line = data.count(b"\n", 0, error.start) + 1
        raise AeroSloshError(f"The {what} is not UTF-8 text", f"{path}, line {line}", "save it as UTF-8") from None
