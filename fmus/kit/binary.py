"""Value references of one type, as a host hands them in: what is none says so, what comes again and again is remembered."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import itemgetter
from typing import Any, TypeVar

from .failure import StepError

Found = TypeVar("Found")
MOST = 64
"""Sets of value references that are remembered."""


class ByReference(dict[int, Any]):
    """What belongs to the variables of one type, by value reference."""

    def __init__(self, type_: str) -> None:
        self.type = type_

    def __missing__(self, reference: int) -> Any:
        raise StepError(
            f"there is no {self.type} variable with value reference {reference}. "
            "Remedy: take references and types from modelDescription.xml of this very FMU"
        )


def remember(table: dict[tuple[int, ...], Found], references: tuple[int, ...], found: Found) -> Found:
    """Keep what was found for some references; return it."""
    if len(table) >= MOST:
        table.clear()
    table[references] = found
    return found


def taker(names: Sequence[str]) -> Callable[[dict[str, Any]], tuple[Any, ...]]:
    """Return what takes the values of `names` out of a dictionary, as a tuple."""
    if len(names) > 1:
        return itemgetter(*names)
    return lambda values: tuple(values[name] for name in names)
