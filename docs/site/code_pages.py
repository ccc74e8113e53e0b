"""Reference of the Python interface, the commands and the exit codes, made from docstrings and the command line's own help."""

from __future__ import annotations

import inspect
import os
import re
import types
from typing import Any

import aeroslosh
from aeroslosh.master import cli
from aeroslosh.master.base.errors import ExitCode
from aeroslosh.master.commands import HELP

ALIGNED = re.compile(r"\S {2,}\S")  # a list of names with their meaning in a docstring


def pages() -> dict[str, str]:
    """Name → Markdown."""
    return {"python-names": python(), "commands": commands(), "exit-codes": exit_codes()}


def python() -> str:
    """Every public name with its signature and docstring, classes with their public methods."""
    parts = [
        "# Python names\n\nMade from the docstrings of `import aeroslosh as ae`. An overview: [python](../docs/python.md).\n"
    ]
    names = [n for n in aeroslosh.__all__ if not n.startswith("_")]
    for name in sorted(names, key=lambda n: (isinstance(getattr(aeroslosh, n), type), n.lower())):
        thing = getattr(aeroslosh, name)
        parts.append(f"## {name}\n\n{_signature(f'ae.{name}', thing)}{described(inspect.getdoc(thing) or '')}")
        for own, member in sorted(vars(thing).items()) if isinstance(thing, type) else ():
            inner = member.fget if isinstance(member, property) else getattr(member, "__func__", member)
            if own.startswith("_") or not isinstance(inner, types.FunctionType):
                continue
            shown = f"{own}" if isinstance(member, property) else _call(own, inner)
            parts.append(f"### {name}.{own}\n\n```text\n{shown}\n```\n\n{described(inspect.getdoc(inner) or '')}")
    return "\n".join(parts)


def commands() -> str:
    """What every command says of itself."""
    os.environ["COLUMNS"] = "100"  # the width that argparse wraps its help to
    parts = ["# Commands\n\nWhat `aeroslosh COMMAND --help` says.\n"]
    for name in HELP:
        top = cli.parser(name)
        sub = next(a for a in top._actions if hasattr(a, "choices") and isinstance(a.choices, dict)).choices
        assert sub is not None
        parts.append(f"## {name}\n\n```text\n{sub[name].format_help()}```\n")
    return "\n".join(parts)


def exit_codes() -> str:
    """The members of `ExitCode` with what its docstring says of each."""
    told = re.split(r"\n\s*(?=[A-Z]{2,} {2,})", inspect.getdoc(ExitCode) or "")
    meaning = {entry.split()[0]: " ".join(entry.split()[1:]) for entry in told[1:]}
    rows = [f"| {int(code)} | `{code.name}` | {meaning[code.name]} |" for code in ExitCode]
    head = "# Exit codes\n\nOf every command (`master/base/errors.py`); in Python `code` of an `AeroSloshError`.\n\n"
    return head + "| code | name | meaning |\n|---|---|---|\n" + "\n".join(rows) + "\n"


def described(text: str) -> str:
    """A docstring as Markdown: prose as prose, lists of names as they stand."""
    parts = []
    for block in re.split(r"\n\s*\n", text):
        plain = not ALIGNED.search(block) and not block.startswith(" ")
        parts.append(block.replace("<", "\\<") if plain else f"```text\n{block}\n```")
    return "\n\n".join(part for part in parts if part) + "\n"


def _signature(shown: str, thing: Any) -> str:
    return f"```text\n{_call(shown, thing)}\n```\n\n" if callable(thing) and not issubclass(type(thing), type(ExitCode)) else ""


def _call(shown: str, thing: Any) -> str:
    """A call with its parameters, one a line where there are many."""
    try:
        signature = inspect.signature(thing)
    except (TypeError, ValueError):
        return shown
    words: list[str] = []
    for p in signature.parameters.values():
        if p.name == "self":
            continue
        if p.kind is p.KEYWORD_ONLY and "*" not in words:
            words.append("*")
        words.append(_typed(p))
    one = f"{shown}({', '.join(words)})"
    return one if len(one) <= 100 else f"{shown}(\n    " + ",\n    ".join(words) + ",\n)"


def _typed(p: inspect.Parameter) -> str:
    if p.annotation is p.empty:
        return str(p)
    kind = p.annotation if isinstance(p.annotation, str) else getattr(p.annotation, "__name__", str(p.annotation))
    default = "" if p.default is inspect.Parameter.empty else f" = {p.default!r}"
    return f"{p.name}: {kind}{default}"
