"""HTML as text that is safe to put together: whatever is no `Markup` is escaped."""

from __future__ import annotations

import html
from collections.abc import Iterable, Sequence
from typing import Any

LONG = 24  # letters of a value that has lines of its own
VOID = ("br", "col", "img", "input", "link", "meta", "hr")


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


def join(parts: Iterable[Any], between: str = "") -> Markup:
    """Parts one after the other; None is left out, what is no Markup is escaped."""
    return Markup(between.join(p if isinstance(p, Markup) else html.escape(str(p)) for p in parts if p is not None))


def tag(name: str, /, *content: Any, **attributes: Any) -> Markup:
    """An element. Attributes: `_` at the end goes (class_), inside it is `-`; None and False are left out, True has no value."""
    words = [name]
    for key, value in attributes.items():
        if value is None or value is False:
            continue
        key = key.rstrip("_").replace("_", "-")
        words.append(key if value is True else f'{key}="{html.escape(str(value))}"')
    if name in VOID:
        return Markup(f"<{' '.join(words)}>")
    return Markup(f"<{' '.join(words)}>{join(content)}</{name}>")


def section(title: str, *content: Any, **attributes: Any) -> Markup:
    """A part of the page under its heading; nothing where there is no content."""
    inner = join(content)
    return tag("section", tag("h2", title), inner, **attributes) if inner else Markup("")


def paragraph(*content: Any, **attributes: Any) -> Markup:
    """A paragraph."""
    return tag("p", *content, **attributes)


def table(head: Sequence[Any], rows: Iterable[Sequence[Any]], caption: str = "") -> Markup:
    """A table; nothing without rows. On a phone the cells of a row stand below each other where there are more than three.

    Numbers are set flush right."""
    lines = [tag("tr", *(_cell(value, head[i]) if i else _first(value, head[i]) for i, value in enumerate(row))) for row in rows]
    if not lines:
        return Markup("")
    header = tag("thead", tag("tr", *(tag("th", word, scope="col") for word in head))) if head else None
    named = tag("caption", caption) if caption else None
    body = tag("table", named, header, tag("tbody", *lines))
    return tag(
        "div",
        body,
        class_="wide" + (" stack" if len(head) > 3 else ""),
        tabindex="0",
        role="region",
        aria_label=caption or "table",
    )


def facts(rows: Iterable[tuple[Any, Any]]) -> Markup:
    """Names and values, one under the other; values None or "" are left out."""
    kept = [(name, value) for name, value in rows if value is not None and value != ""]
    rows_ = [tag("div", tag("dt", n), tag("dd", v), class_="long" if len(f"{v}") > LONG else None) for n, v in kept]
    return tag("dl", *rows_) if kept else Markup("")


def _first(value: Any, head: str) -> Markup:
    """The cell that names its row."""
    return tag("th", "" if value is None else value, scope="row", data_head=head)


def _cell(value: Any, head: str) -> Markup:
    if isinstance(value, bool):
        value = "yes" if value else "no"
    number = isinstance(value, int | float)
    text = "" if value is None else f"{value:.5g}" if isinstance(value, float) else value
    return tag("td", text, class_="number" if number else None, data_head=head)
