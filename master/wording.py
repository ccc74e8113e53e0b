"""Numbers with their uncertainty, as people read them."""

from __future__ import annotations


def plus_minus(value: float, uncertainty: float, digits: int = 5) -> str:
    """`value ± uncertainty`; a small uncertainty keeps one digit instead of becoming 0."""
    small = uncertainty < 0.5 * 10.0**-digits
    return f"{value:.{digits}f} ± " + (f"{uncertainty:.0e}" if small else f"{uncertainty:.{digits}f}")
