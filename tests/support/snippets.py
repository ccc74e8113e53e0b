"""Fenced blocks of a Markdown page, as CI runs them (CONTRIBUTING.md says how to write one).

    ```sh, ```python         run, in order, in one folder a page; the Python blocks of a page share their names
    ```text                  what the block above printed: lines in this order, numbers to their last digit, … for anything
    ```toml after `<!-- ci: file NAME -->`      written to the folder as NAME
    `<!-- ci: slow -->`      before a block: run by `make validate` only
    `<!-- ci: skip, why -->` before a block: not run; counted in tests/docs/test_snippets.py

Any other block is refused, so that no new one goes by unseen."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

FENCE = re.compile(r"^(?P<indent> *)```(?P<kind>[\w{}-]*)\n(?P<text>.*?)^(?P=indent)```[ ]*$", re.DOTALL | re.MULTILINE)
MARK = re.compile(r"<!-- ci: (?P<word>skip|slow|file)(?P<rest>[^>]*) -->\s*\Z")
RUN = ("sh", "python")
NUMBER = r"[-+−]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"


class UnmarkedBlock(Exception):
    """A block that neither runs nor says why not."""


@dataclass(frozen=True)
class Block:
    """kind: sh, python, file, skip. shown: the output that the page shows, None where it shows none."""

    kind: str
    text: str
    place: str
    slow: bool = False
    name: str = ""
    shown: str | None = None


def blocks(page: Path, name: str) -> list[Block]:
    """The blocks of a page in order; `name` goes into places. Raises UnmarkedBlock."""
    text, found, end = page.read_text(encoding="utf-8"), list[Block](), 0
    for match in FENCE.finditer(text):
        before, end = text[end : match.start()], match.end()
        mark = MARK.search(before)
        word, rest = (mark["word"], mark["rest"].strip(" ,")) if mark else ("", "")
        kind, place = match["kind"], f"{name}:{text.count(chr(10), 0, match.start()) + 1}"
        if (word in ("skip", "file")) and not rest:
            raise UnmarkedBlock(f"{place}: '{word}' without a {'reason' if word == 'skip' else 'name'}")
        if word == "skip":
            found.append(Block("skip", match["text"], place))
        elif word == "file":
            found.append(Block("file", match["text"], place, name=rest))
        elif kind in RUN:
            found.append(Block(kind, match["text"], place, word == "slow"))
        elif kind == "text" and found and found[-1].kind in RUN and found[-1].shown is None and not word:
            last = found[-1]
            found[-1] = Block(last.kind, last.text, last.place, last.slow, shown=match["text"])
        else:
            raise UnmarkedBlock(f"{place}: a block '{kind}' that is not run: name its language, or say <!-- ci: skip, why -->")
    return found


def missing(shown: str, printed: str) -> str | None:
    """The first line of `shown` that `printed` has not, after the lines before it; None where all are there."""
    lines, at = printed.splitlines(), 0
    for wanted in filter(str.strip, shown.splitlines()):
        at = next((n + 1 for n in range(at, len(lines)) if same(wanted, lines[n])), -1)
        if at < 0:
            return wanted
    return None


def same(wanted: str, line: str) -> bool:
    """Whether a line says what is shown: the same words, numbers within one of the last digit shown, … for anything."""
    pattern = ""
    for piece in re.split(rf"({NUMBER}|…|\s+)", wanted.strip()):
        if re.fullmatch(NUMBER, piece or ""):
            pattern += rf"(?<![\d.])({NUMBER})(?!\d)"  # a … before it must not eat its first digits
        elif piece == "…":
            pattern += ".*"
        elif piece.isspace():
            pattern += r"\s+"
        else:
            pattern += re.escape(piece)
    found = re.fullmatch(pattern, line.strip())
    return found is not None and all(_near(a, b) for a, b in zip(_numbers(wanted), found.groups(), strict=True))


def _numbers(text: str) -> Sequence[str]:
    return re.findall(NUMBER, text)


def _near(shown: str, printed: str) -> bool:
    """Whole numbers are the same; others differ by at most one in the last digit shown."""
    mantissa, _, exponent = shown.replace("−", "-").partition("e")
    digits = len(mantissa.partition(".")[2])
    unit = 0.0 if not digits and not exponent else 10.0 ** (int(exponent or 0) - digits)
    a, b = (float(word.replace("−", "-")) for word in (shown, printed))
    return abs(a - b) <= 1.0000001 * unit
