"""A value as a variable of an FMU takes it: its type, its range, the items of an enumeration."""

from __future__ import annotations

import math
from typing import Any

from ..base import toml_text
from ..base.errors import AeroSloshError

Value = float | int | bool | str


def fitted(variable: Any, value: Any, name: str, where: str) -> Value:
    """`value` as FMPy's `variable` takes it: the number of an enumeration's name, a whole number where that is meant.

    Raises AeroSloshError for another type or a value out of range."""
    kind = variable.type
    items = {item.name: int(item.value) for item in getattr(variable.declaredType, "items", None) or []}
    if kind == "Enumeration" and isinstance(value, str) and value in items:
        return items[value]
    number = isinstance(value, int | float) and not isinstance(value, bool)
    kinds = {
        "Real": number and math.isfinite(value),
        "Integer": number and float(value).is_integer(),
        "Enumeration": number and value in items.values(),
        "Boolean": isinstance(value, bool),
        "String": isinstance(value, str),
    }
    wanted = {"Real": "a number", "Integer": "a whole number", "Boolean": "true or false", "String": 'a text in "quotes"'}
    low, high = (_limit(variable, end) for end in ("min", "max"))
    expected = wanted.get(kind) or f"one of {', '.join(items)}"
    expected += f" from {low:g}" if low is not None else ""
    expected += f" to {high:g}" if high is not None else ""
    expected += f" [{variable.unit}]" if variable.unit not in (None, "1") else ""
    if not kinds[kind]:
        raise AeroSloshError(f"{name} has the wrong type: {toml_text.literal(value)}", where, f"give {expected}")
    if number and ((low is not None and value < low) or (high is not None and value > high)):
        raise AeroSloshError(f"{name} = {value!r} is out of range ({variable.description})", where, f"give {expected}")
    if kind == "Real":
        return float(value)
    return int(value) if kind in ("Integer", "Enumeration") else value


def _limit(variable: Any, end: str) -> float | None:
    """`min` or `max` of a variable, or of its type."""
    given = getattr(variable, end, None)
    given = getattr(variable.declaredType, end, None) if given is None else given
    return None if given is None or variable.type == "Enumeration" else float(given)
