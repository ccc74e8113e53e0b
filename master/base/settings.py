"""Typed tables of settings: read from TOML, overridden, written back resolved. What a case and a system file have in common.

A table is a dataclass, its keys are the fields, each with a `rule` (unit, range, description). A key that does not exist, a
wrong type or a value out of range is refused with file, line, key and remedy (`AeroSloshError`, exit code 2)."""

from __future__ import annotations

import dataclasses
import difflib
import tomllib
import types
import typing
from collections.abc import Collection, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import Any

from . import texts, toml_text
from .errors import AeroSloshError

Lines = dict[tuple[str, str], int]


def rule(
    doc: str,
    unit: str = "1",
    low: float | None = None,
    high: float | None = None,
    above: float | None = None,
    choices: Sequence[str] = (),
    empty: bool = False,
) -> dict[str, Any]:
    """What a key allows: `low` <= value <= `high`, value > `above`, `choices` for words; of lists and inline tables each entry,
    and whether there may be none."""
    limits = {"low": low, "high": high, "above": above, "choices": tuple(choices), "empty": empty}
    return {"doc": doc, "unit": unit} | limits


def key(default: Any, *words: Any, **limits: Any) -> Any:
    """A field of a table with its `rule`."""
    return field(default=default, metadata=rule(*words, **limits))


def read(path: Path, what: str, example: str) -> tuple[dict[str, Any], Lines]:
    """The content of a TOML file and the line of every key. `what` the file is and an `example` go into messages."""
    try:
        text = texts.read(path, what)
    except OSError as error:
        raise AeroSloshError(
            f"The {what} cannot be read: {error.strerror}", str(path), f"give the path of a TOML file, e.g. {example}"
        ) from None
    try:
        return tomllib.loads(text), toml_text.line_numbers(text)
    except tomllib.TOMLDecodeError as error:
        raise AeroSloshError(f"The {what} is not valid TOML: {error}", str(path), "correct the line named") from None


def fill(holder: Any, tables: Mapping[str, Any], data: Mapping[str, Any], lines: Lines, path: Path) -> None:
    """Set the tables of `holder` (attributes named in `tables`) from a file's content."""
    for table, content in data.items():
        where = f"{path}, line {lines.get((table, ''), lines.get(('', table), 1))}"
        if table not in tables:
            raise AeroSloshError(f"Unknown table [{table}]", where, nearest(table, list(tables), "the tables are"))
        fill_table(getattr(holder, table), table, content, lines, path)


def fill_table(target: Any, table: str, content: Any, lines: Lines, path: Path) -> None:
    """Set the dataclass `target` from the content of one table of a file."""
    if not isinstance(content, dict):
        where = f"{path}, line {lines.get((table, ''), lines.get(('', table), 1))}"
        raise AeroSloshError(f"'{table}' is a table", where, f"write [{table}] with keys below it")
    for name, value in content.items():
        line = lines.get((table, name), lines.get((f"{table}.{name}", ""), "?"))
        assign(target, table, name, value, f"{path}, line {line}, key {table}.{name}")


def assign(target: Any, table: str, name: str, value: Any, where: str) -> None:
    """Check one value against the field `name` of the dataclass `target` and set it."""
    fields = {f.name: f for f in dataclasses.fields(target)}
    holder, dot, entry = name.partition(".")
    if dot and entry and isinstance(getattr(target, holder, None), dict):  # one entry of an inline table
        value, name = getattr(target, holder) | {entry: value}, holder
    if name not in fields:
        remedy = nearest(name, list(fields), f"the keys of [{table}] are")
        raise AeroSloshError(f"Unknown key '{name}' in [{table}]", where, remedy)
    hint = typing.get_type_hints(type(target))[name]
    setattr(target, name, _checked(value, hint, fields[name].metadata, f"{table}.{name}", where))


def override(holder: Any, tables: Mapping[str, Any], text: str) -> None:
    """Apply one `table.key=value`; the value is read as TOML, else as a word."""
    dotted, equals, value = text.partition("=")
    table, dot, name = dotted.strip().partition(".")
    where = f"--set {text}"
    if not (equals and dot and table and name):
        raise AeroSloshError("An override has the form section.key=value", where, "for instance --set flow.mach=0.8")
    if table not in tables:
        raise AeroSloshError(f"Unknown table '{table}'", where, nearest(table, list(tables), "the tables are"))
    target = getattr(holder, table)
    read = written(value)
    if not isinstance(read, str) and typing.get_type_hints(type(target)).get(name) is str:
        read = value.strip()  # a text of digits, as flow.airfoil = 23012, needs no quotes here
    assign(target, table, name, read, where)


def written(text: str) -> Any:
    """A value as a command line gives it: TOML, else a word."""
    try:
        return tomllib.loads(f"value = {text.strip()}")["value"]
    except tomllib.TOMLDecodeError:
        return text.strip()


def dump(
    holder: Any, tables: Mapping[str, Any], given: Collection[str] | None = None, other: Mapping[str, Any] | None = None
) -> str:
    """The tables as TOML, each key with its unit and description; keys that are not among those `given` are marked. `other`:
    table.key → value of keys that follow from the others, which are written as comments."""
    text = ""
    for table in tables:
        names = None if given is None else {name.split(".")[1] for name in given if name.startswith(f"{table}.")}
        follow = {k.partition(".")[2]: v for k, v in (other or {}).items() if k.startswith(f"{table}.")}
        text += f"\n[{table}]\n{dump_table(getattr(holder, table), names, follow)}"
    return text


def flat(holder: Any, tables: Mapping[str, Any]) -> dict[str, Any]:
    """All settings as "table.key" → value, less those that nobody gave and that have no default."""
    return {
        f"{table}.{f.name}": value
        for table in tables
        for t in [getattr(holder, table)]
        for f in dataclasses.fields(t)
        if (value := getattr(t, f.name)) is not None
    }


def dump_table(content: Any, given: Collection[str] | None = None, other: Mapping[str, Any] | None = None) -> str:
    """The keys of one table as TOML; those not `given` (None: all are) are marked as defaults, those in `other` are comments
    with the value there; what nobody gave and has no default is left out."""
    text, other = "", other or {}
    for f in dataclasses.fields(content):
        unit = f.metadata["unit"]
        note = f.metadata["doc"] if unit == "1" else f"{f.metadata['doc']} [{unit}]"
        mark = "" if given is None or f.name in given else "default: "
        if f.name in other:  # None: nobody knows it yet
            text += "" if other[f.name] is None else f"# {f.name} = {toml_text.literal(other[f.name])}  # follows: {note}\n"
        elif (value := getattr(content, f.name)) is not None:
            text += f"{f.name} = {toml_text.literal(value)}  # {mark}{note}\n"
    return text


def _checked(value: Any, hint: Any, rule: Any, name: str, where: str) -> Any:
    """`value` as the type `hint`, inside the field's range; raises with the remedy."""
    if typing.get_origin(hint) is list:
        words = {str: ("texts", '["a", "b"]'), int: ("whole numbers", "[20, 40]"), float: ("numbers", "[0.8, 0.85]")}
        kind, example = words[typing.get_args(hint)[0]]
        if not isinstance(value, list) or not (value or rule["empty"]):
            raise AeroSloshError(
                f"{name} is a list of {kind}, at least one, not {value!r}", where, f"write {name.split('.')[-1]} = {example}"
            )
        return [_checked(v, typing.get_args(hint)[0], rule, name, where) for v in value]
    if hint is Any:
        return value
    if typing.get_origin(hint) is dict:
        if not isinstance(value, dict):
            key_name = name.split(".")[-1]
            raise AeroSloshError(f"{name} is a table, not {value!r}", where, f'write {key_name} = {{ "name" = value, … }}')
        inner = typing.get_args(hint)[1]
        return {k: _checked(v, inner, rule, f"{name}.{k}", where) for k, v in value.items()}
    kinds = tuple(k for k in typing.get_args(hint) if k is not type(None)) if isinstance(hint, types.UnionType) else (hint,)
    if isinstance(value, int) and not isinstance(value, bool) and float in kinds:
        value = float(value)
    if type(value) not in kinds:
        raise AeroSloshError(f"{name} has the wrong type: {value!r}", where, f"give {_expected(kinds, rule)}")
    if isinstance(value, str):
        if rule["choices"] and value not in rule["choices"]:
            remedy = f"available: {', '.join(rule['choices'])}"
            if len(kinds) > 1:
                remedy = f"give {_expected(kinds, rule)}"
            raise AeroSloshError(f'{name} = "{value}" is not available', where, remedy)
    elif not isinstance(value, bool):
        low, high, above = rule["low"], rule["high"], rule["above"]
        inside = (low is None or value >= low) and (high is None or value <= high) and (above is None or value > above)
        if not inside or value != value or value in (float("inf"), float("-inf")):
            raise AeroSloshError(f"{name} = {value!r} is out of range ({rule['doc']})", where, f"give {_expected(kinds, rule)}")
    return value


def allowed(hint: Any, rule: Any) -> str:
    """What a key of type `hint` with this `rule` may be: type, range and unit in words."""
    if typing.get_origin(hint) is list:
        return f"a list of {_expected(typing.get_args(hint), rule).removeprefix('a ').replace('number', 'numbers', 1)}"
    if typing.get_origin(hint) is dict:
        return "a table"
    kinds = tuple(k for k in typing.get_args(hint) if k is not type(None)) if isinstance(hint, types.UnionType) else (hint,)
    return _expected(kinds, rule)


def _expected(kinds: tuple[Any, ...], rule: Any) -> str:
    """The words of a remedy: type, range and unit."""
    names = {float: "a number", int: "a whole number", str: "a text", bool: "true or false"}
    parts = [names[k] for k in kinds if k is not str]
    if str in kinds:
        parts.append(" or ".join(f'"{c}"' for c in rule["choices"]) or names[str])
    text = " or ".join(parts)
    if rule["above"] is not None:
        text += f" above {rule['above']:g}"
    if rule["low"] is not None:
        text += f" from {rule['low']:g}"
    if rule["high"] is not None:
        text += f" to {rule['high']:g}"
    return text + ("" if rule["unit"] == "1" else f" [{rule['unit']}]")


def nearest(name: str, known: list[str], lead: str) -> str:
    """A remedy: 'did you mean …?' with all names."""
    close = difflib.get_close_matches(name, known, n=1, cutoff=0.5) or difflib.get_close_matches(
        name.lower(), known, n=1, cutoff=0.4
    )
    hint = f"did you mean '{close[0]}'? " if close else ""
    return f"{hint}({lead}: {', '.join(known)})"
