"""The text of a coordinate file: from bytes to rows of two numbers, each with its line. No row is left out silently.

Read are files with or without title lines, the labelled and the ISES/MSES kind of XFOIL (a line of four numbers before the
points), counts of Lednicer order, UTF-8, UTF-16 and 8-bit text, numbers as C and Fortran write them ("1.0D+00"), decimal
commas, columns parted by blanks, tabs, commas or semicolons, comments behind "#", "!" or "//", text after the last point.
Source of the formats: M. Drela, XFOIL 6.9 user guide, section "Buffer airfoil file formats".
"""

from __future__ import annotations

import codecs
import re
from dataclasses import dataclass
from pathlib import Path
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from .naca import AirfoilError

Array = NDArray[np.float64]

MOST = 200_000
"""Most points that are read: a scan has fewer."""

_NUMBER = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDdQq][+-]?\d+|[+-]\d{2,3})?")
_NEARLY = re.compile(r"(?=.*\d)(?=.*\.)[0-9+\-.eEdDoOlI]+|[+-]?(?:nan|inf|infinity)|\*{3,}", re.IGNORECASE)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d*,\d+(?:\s*;\s*|\s+)[+-]?\d*,\d+\s*;?\s*")
_MARKS = ((codecs.BOM_UTF8, "utf-8"), (codecs.BOM_UTF32_LE, "utf-32-le"), (codecs.BOM_UTF32_BE, "utf-32-be"),
          (codecs.BOM_UTF16_LE, "utf-16-le"), (codecs.BOM_UTF16_BE, "utf-16-be"))  # fmt: skip
_SIGNS = str.maketrans({"−": "-", "–": "-", "\ufeff": " ", "\x1a": " ", **dict.fromkeys("()[]{}\"'", " ")})


@dataclass(frozen=True)
class Rows:
    """Rows of a file. points: shape (n, 2), in the file's units; lines: (n,), their line numbers; step: smallest difference of
    two numbers that the file's digits can write, in its units; titles: lines before the points that are one whole number, and
    the lines they stand in; notes: what was done to the text."""

    points: Array
    lines: NDArray[np.int64]
    step: float
    singles: tuple[tuple[int, int], ...]
    notes: tuple[str, ...]


def refuse(path: Path, what: str, remedy: str, line: int | None = None) -> NoReturn:
    """Raise AirfoilError with file, line, what was seen and the remedy."""
    where = f"airfoil file '{path}'" + (f", line {line}" if line is not None else "")
    raise AirfoilError(f"{where}: {what}. Remedy: {remedy}")


def read(path: Path) -> Rows:
    """The rows of the file `path`. Raises AirfoilError naming file, line and remedy for whatever is not understood."""
    text, notes = _decoded(path)
    lines = re.split(r"\r\n|\r|\n", text.translate(_SIGNS))
    if _writes_commas(lines):
        lines = [line.replace(",", ".") for line in lines]
        notes.append("decimal commas")
    rows: list[tuple[int, list[float]]] = []
    digits, words, behind = 0, 0, 0  # decimals; line of the first text after points; rows with text behind their numbers
    singles: list[tuple[int, int]] = []
    ended = 0  # line of an end mark "999 999"
    for number, line in enumerate(lines, start=1):
        tokens = [t for t in re.split(r"[\s,;|]+", re.split(r"[#!]|//", line)[0]) if t]
        if not tokens or line.lstrip().startswith("%"):
            continue
        values, decimals = _numbers(tokens)
        if len(values) < 2:
            if not words:
                _check_text(tokens, values, bool(rows), path, number, line)
            if rows:
                words = words or number
            elif len(tokens) == 1 and values:
                singles.append((number, int(values[0])))
            continue
        if ended or (rows and values[0] == values[1] and values[0] in (999.0, 999.9, 9999.0)):
            if ended:
                refuse(path, f"a second element follows the separator '{lines[ended - 1].strip()}'",
                       "one element a file: the flow is about a single section", ended)  # fmt: skip
            ended = number
            continue
        if words:
            refuse(path, f"points again after text ('{lines[words - 1].strip()[:60]}')",
                   "one section a file, its points without text between them", number)  # fmt: skip
        behind += len(tokens) > len(values)
        rows.append((number, values))
        digits = max(digits, decimals)
        if len(rows) > MOST:
            refuse(path, f"more than {MOST:,} points", "a file with at most that many", number)
    if words:
        notes.append(f"text from line {words} on left out")
    if behind:
        notes.append(f"text behind the numbers of {behind} lines left out")
    points, numbers = _two_columns(rows, path, notes)
    return Rows(points, numbers, 10.0**-digits, tuple(singles), tuple(notes))


def _decoded(path: Path) -> tuple[str, list[str]]:
    """The file's text and a note where it is not UTF-8."""
    try:
        data = path.read_bytes()
    except OSError as error:
        refuse(path, f"cannot be read ({error.strerror})", "a readable text file")
    for mark, name in _MARKS:
        if data.startswith(mark):
            return data[len(mark) :].decode(name, errors="replace"), [] if name == "utf-8" else [name.upper()]
    if len(data) > 3 and 0 in data[:4]:
        name = "utf-16-le" if data[1] == 0 else "utf-16-be"
        text = data.decode(name, errors="replace")
        if "\x00" not in text and "\ufffd" not in text:
            return text, [name.upper()]
    if b"\0" in data:
        refuse(path, "is no text (it holds bytes 0)", "a text file with one 'x y' a line")
    try:
        return data.decode("utf-8"), []
    except UnicodeDecodeError:
        return data.decode("latin-1"), ["8-bit text"]


def _writes_commas(lines: list[str]) -> bool:
    """Whether the numbers have decimal commas: some rows cannot be read otherwise, and none has a decimal point."""
    return sum(bool(_DECIMAL_COMMA.fullmatch(line)) for line in lines) >= 3 and not any(
        re.match(r"\s*[+-]?\d*\.\d", line) for line in lines
    )


def _numbers(tokens: list[str]) -> tuple[list[float], int]:
    """The numbers at the start of a line, and the most decimals one of them has."""
    values, decimals = [], 0
    for token in tokens:
        if not _NUMBER.fullmatch(token):
            break
        mantissa, exponent = re.fullmatch(r"([+-]?[\d.]+)(.*)", token).groups()  # type: ignore[union-attr]
        power = int(exponent.lstrip("EeDdQq") or 0)
        values.append(float(f"{mantissa}e{power}"))
        decimals = max(decimals, len(mantissa.partition(".")[2]) - power)
    return values, decimals


def _check_text(tokens: list[str], values: list[float], inside: bool, path: Path, number: int, line: str) -> None:
    """Refuse a line that is no row but looks like a spoilt one: as a title or a remark its point would be lost silently."""
    spoilt = bool(_NEARLY.fullmatch(tokens[0])) and not (tokens[0].startswith("*") and len(tokens) != 2)
    if values:  # one number, then nothing or a word
        spoilt = "." in tokens[0] or (inside and len(tokens) <= 2)
    if spoilt:
        refuse(path, f"'{line.strip()[:60]}' is not two numbers",
               "one 'x y' a line, e.g. '0.950000 0.013450'; a title begins with a letter", number)  # fmt: skip


def _two_columns(rows: list[tuple[int, list[float]]], path: Path, notes: list[str]) -> tuple[Array, NDArray[np.int64]]:
    """Rows as points, shape (n, 2), with their lines: without the four numbers of an ISES file and a constant third column."""
    if len(rows) > 1 and len(rows[0][1]) in (4, 5) and len(rows[1][1]) == 2:
        notes.append(f"the {len(rows[0][1])} numbers of line {rows[0][0]} (ISES, MSES: size of a grid) left out")
        rows = rows[1:]
    widths = [len(values) for _, values in rows]
    if not rows or max(widths) == 2:
        table = np.array([values for _, values in rows], dtype=float).reshape(-1, 2)
        return _finite(table, rows, path)
    usual = max(set(widths), key=widths.count)
    odd = next((number for number, values in rows if len(values) != usual), None)
    if odd is not None:
        refuse(path, f"not {usual} numbers as in the other lines", "one 'x y' a line", odd)
    table = np.array([values for _, values in rows], dtype=float)
    if usual == 3 and np.all(table[:, 2] == table[0, 2]):
        notes.append(f"third column, {table[0, 2]:g} everywhere, left out")
        return _finite(table[:, :2], rows, path)
    remedy = "two columns 'x y': a loop around the section, or its upper and its lower side one after the other"
    refuse(path, f"{usual} numbers a line, of which it is not known what they mean", remedy, rows[0][0])


def _finite(table: Array, rows: list[tuple[int, list[float]]], path: Path) -> tuple[Array, NDArray[np.int64]]:
    """`table` with the lines of `rows`; refuses numbers beyond what a double holds."""
    numbers = np.array([number for number, _ in rows], dtype=np.int64)
    wild = ~np.all(np.abs(table) < 1e12, axis=1)
    if np.any(wild):
        refuse(path, "a number beyond 1e12", "coordinates in chords, percent or mm", int(numbers[np.argmax(wild)]))
    return table, numbers
