"""Numbers in words, where one may be missing."""

from __future__ import annotations

from ..base.wording import plus_minus


def number(value: float | None) -> str | None:
    """Four digits; None stays None."""
    return None if value is None else f"{value:.4g}"


def percent(share: float | None) -> str | None:
    """A share as a percentage; None stays None."""
    return None if share is None else f"{100.0 * share:.3g} %"


def with_error(value: float | None, error: float | None, digits: int = 5) -> str:
    """`value ± error`; the value alone where nobody knows its error, "none" without a value."""
    if value is None:
        return "none"
    return f"{value:.{digits}f}" if error is None else plus_minus(value, error, digits)


def sentence(text: str) -> str:
    """With a capital first letter; the symbols in it stay."""
    return text[:1].upper() + text[1:]
