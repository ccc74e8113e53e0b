"""The little of TOML that tomllib leaves out: on which line a key stands, and writing a value."""

from __future__ import annotations

import json
import re
from typing import Any

_HEADER = re.compile(r"^\s*\[\s*([A-Za-z0-9_.\-]+)\s*\]")
_KEY = re.compile(r"""^\s*["']?([A-Za-z0-9_\-]+)(?:["']?\s*\.\s*["']?([A-Za-z0-9_\-]+))?["']?\s*=""")


def line_numbers(text: str) -> dict[tuple[str, str], int]:
    """Line (from 1) of every `(table, key)`; `(table, "")` is the header's own line, `("", key)` a key of
    no table. A dotted key below a header, quoted or not, is there as a whole and by its first part."""
    lines: dict[tuple[str, str], int] = {}
    table = ""
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = header.group(1)
            lines.setdefault((table, ""), number)
        elif found := _KEY.match(line):
            first, second = found.groups()
            lines.setdefault((first, second) if second and not table else (table, first), number)
            if second and table:
                lines.setdefault((table, f"{first}.{second}"), number)
    return lines


def literal(value: Any) -> str:
    """`value` (bool, int, float, str, lists and tables of these) as TOML text; floats exact (shortest repr)."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, list):
        return "[" + ", ".join(literal(v) for v in value) + "]"
    if isinstance(value, dict):
        pairs = (f"{json.dumps(name, ensure_ascii=False)} = {literal(v)}" for name, v in value.items())
        return "{ " + ", ".join(pairs) + " }" if value else "{}"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False)
    return repr(value)
