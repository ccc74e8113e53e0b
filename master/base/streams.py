"""Standard streams that may be closed, full or of another encoding: progress never ends a run, a lost result is told."""

from __future__ import annotations

import contextlib
import io
import os
import sys
from typing import Any, TextIO

from .errors import AeroSloshError


class Output(io.TextIOBase):
    """Standard output. A write that fails raises AeroSloshError, once; what comes after it is dropped."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream, self._lost = stream, False

    def write(self, text: str) -> int:
        """Raises AeroSloshError."""
        if self._stream is None:
            self._lose("it is closed")
        else:
            self._try(self._stream.write, text)
        return len(text)

    def flush(self) -> None:
        """Raises AeroSloshError."""
        if self._stream is not None:
            self._try(self._stream.flush)

    def fileno(self) -> int:
        """Of the stream itself."""
        if self._stream is None:
            raise OSError("standard output is closed")
        return self._stream.fileno()

    def isatty(self) -> bool:
        """Whether a person reads it."""
        return self._stream is not None and self._stream.isatty()

    @property
    def encoding(self) -> str:  # type: ignore[override]
        """Of the stream itself."""
        return self._stream.encoding if self._stream is not None else "utf-8"

    def _try(self, what: Any, *words: Any) -> None:
        if self._lost:
            return
        try:
            what(*words)
        except BrokenPipeError:
            self._lose("whoever read it has gone")
        except OSError as error:
            self._lose(error.strerror or str(error))

    def _lose(self, why: str) -> None:
        if not self._lost:
            self._lost = True
            remedy = "what is written to files is whole; read the result there, or run again with an output that takes it"
            raise AeroSloshError(f"The result cannot be printed: {why}", "standard output", remedy)


class Said(io.TextIOBase):
    """Standard error: what cannot be said there is dropped."""

    def __init__(self, stream: TextIO | None) -> None:
        self._stream = stream

    def write(self, text: str) -> int:
        """Never fails."""
        with contextlib.suppress(OSError, ValueError):
            if self._stream is not None:
                self._stream.write(text)
        return len(text)

    def flush(self) -> None:
        """Never fails."""
        with contextlib.suppress(OSError, ValueError):
            if self._stream is not None:
                self._stream.flush()

    def fileno(self) -> int:
        """Of the stream itself."""
        if self._stream is None:
            raise OSError("standard error is closed")
        return self._stream.fileno()

    def isatty(self) -> bool:
        """Whether a person reads it."""
        return self._stream is not None and self._stream.isatty()


def guard() -> None:
    """Put these in place of the process's own streams.

    A closed one's number is taken by /dev/null: else the next file opened would get it, and with it whatever a library prints."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # a locale without α: better an escape than no result
            stream.reconfigure(errors="backslashreplace")
    for number in (0, 1, 2):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # the lowest number that is free: this one
    sys.stdout, sys.stderr = Output(sys.stdout), Said(sys.stderr)
