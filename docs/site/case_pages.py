"""Reference of every key of a case, a training file and a system file, made from their data classes."""

from __future__ import annotations

import dataclasses
import typing
from collections.abc import Mapping
from typing import Any

from aeroslosh.master.base import settings, toml_text
from aeroslosh.master.case import by_value, checks, template
from aeroslosh.master.cosim import system_file
from aeroslosh.master.training import case as training_case

INTRODUCTION = """# Keys of a case

Made from the data classes that read a case (`master/case/tables.py`). **Bold** keys have no usual value: a case must say them
([for which command](../docs/cases.md)). `aeroslosh init my_wing.toml` writes the same as a file to fill in.
"""
HEAD = "| key | default | value | unit | meaning |\n|---|---|---|---|---|\n"


def pages() -> dict[str, str]:
    """Name → Markdown."""
    return {"case-keys": case(), "file-keys": files()}


def case() -> str:
    """Every table of a case."""
    parts = [INTRODUCTION]
    must = dict.fromkeys((*checks.TANK, *checks.MOVING), "must be given with a liquid")
    must |= dict.fromkeys((key for keys in checks.REQUIRED.values() for key in keys), "must be given")
    for name, kind in template.TABLES.items():
        parts.append(table(name, kind, must))
    return "\n".join(parts)


def files() -> str:
    """The tables of the other files."""
    parts = ["# Keys of training and system files\n\nMade from their data classes.\n", "## Training file (`aeroslosh train`)\n"]
    parts.append("Beside `[slosh]` as in a case ([keys](case-keys.md#slosh)):\n")
    own = {name: kind for name, kind in training_case.TABLES.items() if name != "slosh"}
    parts += [table(name, kind, {}, "###") for name, kind in own.items()]
    parts.append("## System file (`aeroslosh run`)\n\nBeside `[coupling]` as in a case ([keys](case-keys.md#coupling)):\n")
    tables = {"components.NAME": system_file.Part, "system": system_file.Wiring, "run": system_file.Run}
    parts += [table(name, kind, {}, "###") for name, kind in tables.items()]
    return "\n".join(parts)


def table(name: str, kind: Any, must: Mapping[str, str], level: str = "##") -> str:
    """A data class as a section; must: "table.key" of the keys without a usual value → when."""
    hints, content = typing.get_type_hints(kind), kind()
    rows = [row(f"{name}.{f.name}", f, hints[f.name], getattr(content, f.name), must) for f in dataclasses.fields(kind)]
    about = " ".join((kind.__doc__ or "").split())
    return f"{level} {name}\n\n{cell(about)}\n\n{HEAD}" + "\n".join(rows) + "\n"


def row(key: str, field: dataclasses.Field[Any], hint: Any, default: Any, must: Mapping[str, str]) -> str:
    """A key with default, type and range, unit, meaning."""
    rule = field.metadata
    unit = "" if rule["unit"] == "1" else rule["unit"]
    value = settings.allowed(hint, rule).removesuffix(f" [{rule['unit']}]")
    meaning = rule["doc"]
    if forms := by_value.ALTERNATIVES.get(key, ()):
        meaning += f"; or by value: {', '.join(forms)}"
    said = must[key] if key in must else "none" if default is None else f"`{toml_text.literal(default)}`"
    named = f"**`{field.name}`**" if key in must else f"`{field.name}`"
    return f"| {named} | {said} | {cell(value)} | {unit} | {cell(meaning)} |"


def cell(text: str) -> str:
    """Words in a table: signs that Markdown would take for its own are kept."""
    for sign in ("\\", "|", "*", "_", "<", ">", "[", "]", "~", "$"):
        text = text.replace(sign, f"\\{sign}")
    return text
