"""What the paper claims, held against what was computed: the verdict of a figure comes from these and from nothing else."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any


@dataclass(frozen=True)
class Claim:
    """One statement of the paper.

    what    the statement, in words
    source  where it stands
    paper   the paper's value, as a text
    ours    what was computed, as a text
    agrees  whether the two agree by the rule named in `paper`
    why     what the difference comes from, where it is known; said only where they differ"""

    what: str
    source: str
    paper: str
    ours: str
    agrees: bool
    why: str = ""

    def data(self) -> dict[str, Any]:
        """For JSON."""
        return asdict(self)


def within(what: str, source: str, paper: float, ours: float, tolerance: float, why: str = "", unit: str = "") -> Claim:
    """Ours is the paper's value, give or take `tolerance`. What is not finite agrees with nothing."""
    said = f"{paper:.4g}{unit} ± {tolerance:.2g}{unit}"
    return Claim(what, source, said, f"{ours:.4g}{unit}", bool(abs(ours - paper) <= tolerance), why)


def between(what: str, source: str, low: float, high: float, ours: float, why: str = "", unit: str = "") -> Claim:
    """Ours lies between two values of the paper; infinite ends are open."""
    if math.isinf(low) or math.isinf(high):
        said = f"at most {high:.4g}{unit}" if math.isinf(low) else f"at least {low:.4g}{unit}"
    else:
        said = f"{low:.4g}{unit} to {high:.4g}{unit}"
    return Claim(what, source, said, f"{ours:.4g}{unit}", bool(low <= ours <= high), why)


def at_most(what: str, source: str, paper: float, ours: float, why: str = "", unit: str = "") -> Claim:
    """Ours is no larger than the paper's value."""
    return between(what, source, -math.inf, paper, ours, why, unit)


def at_least(what: str, source: str, paper: float, ours: float, why: str = "", unit: str = "") -> Claim:
    """Ours is no smaller than the paper's value."""
    return between(what, source, paper, math.inf, ours, why, unit)


def word(what: str, source: str, paper: str, ours: str, same: Sequence[str] = (), why: str = "") -> Claim:
    """The paper's word for what happens, and ours; `same`: words of ours that mean the paper's (default: that word)."""
    return Claim(what, source, paper, ours, ours in (same or (paper,)), why)


def verdict(claims: Sequence[Claim]) -> str:
    """ "agrees" where all claims do, else "differs: " and why, claim by claim.

    Raises ValueError where there is no claim: a figure that nothing was compared with has no verdict."""
    if not claims:
        raise ValueError("no claim was compared")
    apart = [c for c in claims if not c.agrees]
    if not apart:
        return "agrees"
    said = [f"{c.what}: {c.ours}, paper {c.paper}" + (f" ({c.why})" if c.why else "") for c in apart]
    return "differs: " + "; ".join(said)
