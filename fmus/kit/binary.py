"""What pythonfmu's binary hands over that needs care: signed references, strings that are none, errors left pending."""

from __future__ import annotations

import functools
import gc
from collections.abc import Callable
from typing import Any

from .failure import StepError


class ByReference(dict[int, Any]):
    """What belongs to the variables of one type, by value reference."""

    def __init__(self, type_: str) -> None:
        self.type = type_

    def __missing__(self, reference: int) -> Any:
        # the binary hands references on as signed numbers
        raise StepError(
            f"there is no {self.type} variable with value reference {reference & 0xFFFFFFFF}. "
            "Remedy: take references and types from modelDescription.xml of this very FMU"
        )


def check_strings(values: list[str]) -> None:
    """Raise StepError where bytes were no UTF-8: the binary leaves a hole in the list, seen by the garbage collector alone."""
    if len(gc.get_referents(values)) != len(values):
        raise StepError("a string that was set is not encoded in UTF-8. Remedy: encode strings in UTF-8")


def settled(method: Callable[..., Any]) -> property:
    """Return `method` as a property that leaves no Python error pending.

    Where a host sets a string that is not UTF-8 (a path in the code page of its machine), pythonfmu 0.7 asks for the method with
    the error of decoding pending: the look-up of any method fails, which ends the process. A property of the leaf class is found
    all the same, and an exception that is raised and caught takes the place of the one pending.
    """

    def look_up(slave: Any) -> Any:
        try:
            raise StepError
        except BaseException:
            pass
        return functools.partial(method, slave)

    return property(look_up)
