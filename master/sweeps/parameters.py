"""The keys that a sweep changes and the values they take, as a case file or the command line writes them."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base import settings
from ..base.errors import AeroSloshError
from ..case import case as cases
from ..case.case import Case

MOST = 100_000  # values of a key, and points of a sweep
RANGE = ["from", "to", "count", "spacing"]
EXAMPLE = 'write [0.7, 0.8] or { from = 0.4, to = 0.8, count = 5, spacing = "linear" }'


@dataclass(frozen=True)
class Parameter:
    """A swept key: its `values`, or a range `low` to `high` (evenly spread in the logarithm when `log`) of `count` values.
    `where` names the line or the argument it comes from, `written` is its content in a case file."""

    name: str
    where: str
    written: Any
    values: tuple[Any, ...] = ()
    low: float = math.nan
    high: float = math.nan
    count: int = 0
    log: bool = False


def from_case(case: Case, path: Path) -> list[Parameter]:
    """The parameters of the table [sweep.parameters]. `path` is the case's file, for messages. Raises AeroSloshError."""
    lines: settings.Lines = settings.read(path, "case file", "cases/fill_sweep.toml")[1] if path.is_file() else {}
    found = []
    for name, content in _flat(case.sweep.parameters).items():
        header = "sweep.parameters"
        places = ((header, name), (f"{header}.{name}", ""), (header, ""), ("sweep", "parameters"))
        line = next((lines[place] for place in places if place in lines), "?")
        found.append(parameter(name, content, f"{path}, line {line}, key sweep.parameters.{name}"))
    return found


def from_words(text: str, flag: str) -> Parameter:
    """`flow.mach=0.7,0.8` or `slosh.fill_level=0.1:0.9:5` (low:high[:count][:log]) of the command line. Raises AeroSloshError."""
    name, equals, written = (part.strip() for part in text.partition("="))
    where = f"{flag} {text}"
    if not equals or not written:
        raise AeroSloshError("A swept key has the form table.key=values", where, f"for instance {flag} flow.mach=0.7,0.8")
    content: Any
    parts = written.split(":")
    if len(parts) > 1:
        log = parts[-1] == "log"
        try:
            low, high, *count = (float(part) for part in (parts[:-1] if log else parts))
            if len(count) > 1 or not all(c.is_integer() for c in count):
                raise ValueError
            content = (
                {"from": low, "to": high} | ({"count": int(count[0])} if count else {}) | ({"spacing": "log"} if log else {})
            )
        except ValueError:
            raise AeroSloshError(
                f"'{written}' is no range", where, f"for instance {flag} {name}=0.1:0.9:5, or =0.1:10:5:log"
            ) from None
    else:
        try:
            content = tomllib.loads(f"values = [{written}]")["values"]
        except tomllib.TOMLDecodeError:
            content = [word.strip() for word in written.split(",")]
    return parameter(name, content, where)


def parameter(name: str, content: Any, where: str) -> Parameter:
    """One swept key with its values or its range, checked for itself. Raises AeroSloshError."""
    if isinstance(content, list):
        if not content:
            raise AeroSloshError(f"{name} has no values", where, EXAMPLE)
        return Parameter(name, where, content, tuple(content))
    if not isinstance(content, dict):
        raise AeroSloshError(f"{name} is to be a list of values or a range, not {content!r}", where, EXAMPLE)
    unknown = [key for key in content if key not in RANGE]
    if unknown:
        raise AeroSloshError(
            f"Unknown key '{unknown[0]}' in the range of {name}",
            where,
            settings.nearest(unknown[0], RANGE, "a range has"),
        )
    ends = [content.get("from"), content.get("to")]
    low, high = (float(v) if isinstance(v, int | float) and not isinstance(v, bool) else math.nan for v in ends)
    if not -math.inf < low < high < math.inf:
        raise AeroSloshError(f"The range of {name} needs numbers from < to, not {ends[0]!r} and {ends[1]!r}", where, EXAMPLE)
    spacing, count = content.get("spacing", "linear"), content.get("count", 0)
    if spacing not in ("linear", "log"):
        raise AeroSloshError(f'spacing = "{spacing}" is not available', where, "available: linear, log")
    if spacing == "log" and low <= 0.0:
        raise AeroSloshError(
            f"A logarithmic range starts above 0, not at {low!r}", where, 'give from above 0, or spacing = "linear"'
        )
    if not isinstance(count, int) or isinstance(count, bool) or count < 0 or ("count" in content and count < 2) or count > MOST:
        raise AeroSloshError(f"count = {count!r} of {name}", where, f"a whole number from 2 to {MOST}")
    return Parameter(name, where, content, (), low, high, count, spacing == "log")


def _flat(content: Mapping[str, Any]) -> dict[str, Any]:
    """`flow.mach = …` written without quotes is a table in TOML: both ways of writing mean the same key."""
    flat: dict[str, Any] = {}
    for name, value in content.items():
        if name in cases.TABLES and isinstance(value, dict):
            flat |= {f"{name}.{key}": inner for key, inner in value.items() if key != "parameters" or not isinstance(inner, dict)}
            inner = value.get("parameters")  # of an FMU
            flat |= {f"{name}.parameters.{key}": v for key, v in inner.items()} if isinstance(inner, dict) else {}
        else:
            flat[name] = value
    return flat
