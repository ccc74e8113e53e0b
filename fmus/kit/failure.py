"""How an FMU fails: no exception leaves a callback, the first cause is kept, the host gets a status and can read why.

The library hands on the statuses that callbacks return (native/fmi2.c says in what form). See `slave` for what a host sees.
"""

from __future__ import annotations

import functools
import traceback
from collections.abc import Callable
from typing import Any

from pythonfmu.enums import Fmi2Status

from .variables import output

FAILURE_OUTPUTS = (
    output("failed", "", "True once this instance has failed; its Real outputs are then NaN", type=bool),
    output("error", "", "What failed and the remedy, in one line; empty while all is well", type=str),
)

OK, WARNING, DISCARD, ERROR = 0, 1, 2, 3
"""fmi2Status."""

_REMEDY = (
    "Remedy: look at parameters, inputs and step size for values out of all proportion, restore an earlier state or reset; "
    "the FMI log has the traceback"
)


class StepError(RuntimeError):
    """A step or a start that cannot be done; the text says what and the remedy. For components to raise."""


def guarded(fallback: Callable[..., Any]) -> Callable[[Callable[..., Any]], Callable[..., Any]]:
    """Let no exception out of a callback: note the failure and return `fallback` of its arguments."""

    def decorate(method: Callable[..., Any]) -> Callable[..., Any]:
        @functools.wraps(method)
        def callback(self: Failing, *args: Any) -> Any:
            try:
                return method(self, *args)
            except BaseException as exception:  # SystemExit would end the host's process just the same
                self.fail(method.__name__, exception)
                return fallback(*args)

        return callback

    return decorate


quiet = guarded(lambda *_: ERROR)


def printable(text: str) -> str:
    """Return `text` with what UTF-8 cannot encode, half a surrogate pair, as a question mark."""
    return text.encode(errors="replace").decode()


class Failing:
    """What an instance remembers of its failure."""

    _failure = ""  # the first cause; lasts until a good state is restored
    _refused: dict[str, str]  # by variable, why its last value was refused; gone once a valid one is set

    def __init__(self, **kwargs: Any) -> None:
        self._refused = {}
        super().__init__(**kwargs)

    @property
    def message(self) -> str:
        """Why this instance cannot go on, in one line; "" while all is well."""
        why = self._failure or " ".join(self._refused.values())
        return f"{' '.join(self.instance_name.split())}: {why}" if why else ""  # type: ignore[attr-defined]

    def fail(self, where: str, exception: BaseException) -> None:
        """Note `exception` of callback `where`, with its traceback in the FMI log."""
        try:
            text = str(exception) or type(exception).__name__
            kind = "" if isinstance(exception, StepError) else f"{type(exception).__name__}: "
            what = " ".join(f"{kind}{text}".split())
            what = what if "Remedy:" in what else f"{what.rstrip('.')}. {_REMEDY}"
            self._failure = self._failure or what
            self.report(f"{where} at t = {self.time!r} s: {what}\n{traceback.format_exc()}")  # type: ignore[attr-defined]
        except BaseException:  # a message must not end the process either
            self._failure = self._failure or "failed, and the message could not be made"

    def complain(self, text: str) -> None:
        """Note a call that the library could not pass on, such as one with null pointers."""
        try:
            self._failure = self._failure or text
            self.report(text)
        except BaseException:
            self._failure = self._failure or "failed, and the message could not be made"

    def refuse(self, name: str, problem: str, status: int = DISCARD) -> int:
        """Note that a value for variable `name` is not applied; return `status`."""
        self._refused[name] = problem
        self.report(problem, status)
        return status

    def report(self, text: str, status: int = ERROR) -> None:
        """Send `text` to the FMI log."""
        # hosts print FMI log texts through printf
        text = printable(f"{self.instance_name}: {text}".replace("%", "%%"))  # type: ignore[attr-defined]
        self.log(text, Fmi2Status(status))  # type: ignore[attr-defined]
