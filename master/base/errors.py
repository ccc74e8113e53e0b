"""Exit codes and the one exception a user may see: what went wrong, where, and the remedy."""

from __future__ import annotations

import sys
import traceback
from enum import IntEnum
from typing import Any


class ExitCode(IntEnum):
    """Exit status of the command `aeroslosh`.

    OK             the run ended and its verdict stands
    DIFFERENT      `compare`: the runs differ
    INPUT          a bad case, override, command line, missing FMU or output folder: nothing was computed; or a result that cannot
                   be printed: standard output is closed or full
    COMPONENT      an FMU failed (its message and traceback were shown); the history so far is kept
    UNDETERMINED   everything ran, but no verdict or no boundary can be given (not converged, too short, too noisy,
                   or the slosh model does not hold)
    INCOMPLETE     not everything could be written or computed (full disk, cluster gone): what is finished is kept
    INTERNAL       a fault of ours, with a traceback
    INTERRUPTED    stopped by Ctrl-C: what is finished of a boundary or sweep is kept
    TERMINATED     the same, asked for by another program (SIGTERM) or a terminal that closes
    """

    OK = 0
    DIFFERENT = 1
    INPUT = 2
    COMPONENT = 3
    UNDETERMINED = 4
    INCOMPLETE = 5
    INTERNAL = 70
    INTERRUPTED = 130
    TERMINATED = 143


class AeroSloshError(Exception):
    """An error told in three parts: `what` happened, `where` (file, line, key, FMU, time), and the `remedy`."""

    def __init__(self, what: str, where: str = "", remedy: str = "", code: ExitCode = ExitCode.INPUT) -> None:
        self.what, self.where, self.remedy, self.code = what, where, remedy, code
        self.traceback = ""
        super().__init__(str(self))

    def __str__(self) -> str:
        lines = [self.what]
        if self.where:
            lines.append(f"  where:  {self.where}")
        if self.remedy:
            lines.append(f"  remedy: {self.remedy}")
        return "\n".join(lines)

    def __reduce__(self) -> tuple[Any, ...]:
        """So that it travels between processes whole, whatever its class is made from."""
        return _again, (type(self), str(self), self.__dict__)


def _again(kind: type[AeroSloshError], text: str, content: dict[str, Any]) -> AeroSloshError:
    """An error as it was in another process."""
    error = kind.__new__(kind, text)
    error.__dict__.update(content)
    return error


class ComponentError(AeroSloshError):
    """An FMU failed. `component` is its name, `time` [s] the start of the step, `traceback` what its log said."""

    def __init__(self, what: str, where: str, remedy: str, component: str, time: float, trace: str) -> None:
        super().__init__(what, where, remedy, ExitCode.COMPONENT)
        self.component, self.time, self.traceback = component, time, trace


class InternalError(AeroSloshError):
    """A fault of ours at one of several tasks, made from the exception at hand: the others go on."""

    def __init__(self, error: Exception, where: str) -> None:
        what = f"internal error: {type(error).__name__}: {error}"
        super().__init__(what, where, "please report it with the case file", ExitCode.INTERNAL)
        self.traceback = "".join(traceback.format_exception(error))


def show(error: AeroSloshError) -> None:
    """An error on standard error; a component's with its own traceback."""
    print(f"aeroslosh: {error}", file=sys.stderr)
    if error.traceback:
        print(f"  {error.component if isinstance(error, ComponentError) else 'Python'} says:", file=sys.stderr)
        for line in error.traceback.strip().splitlines():
            print(f"    | {line}", file=sys.stderr)
