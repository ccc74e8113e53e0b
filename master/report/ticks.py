"""Where the marks of an axis stand and what they are called."""

from __future__ import annotations

import math

import numpy as np


def limits(values: np.ndarray, margin: float = 0.05) -> tuple[float, float]:
    """Range of the finite `values` with a margin on either side; 0 to 1 where there are none."""
    known = values[np.isfinite(values)]
    if not known.size:
        return 0.0, 1.0
    low, high = float(known.min()), float(known.max())
    # a channel that never moves gets a range in which its last digits are no mountains
    room = margin * (high - low) if high - low > 1e-9 * max(abs(low), abs(high)) else 0.1 * max(abs(low), 1e-12)
    return low - room, high + room


def linear(low: float, high: float, most: int = 5) -> list[float]:
    """At most `most` + 1 round numbers from `low` to `high` (Heckbert 1990, Graphics Gems, "Nice numbers for graph labels")."""
    rough = (high - low) / max(1, most)
    size = 10.0 ** math.floor(math.log10(rough))
    step = size * next(n for n in (1.0, 2.0, 5.0, 10.0) if n * size >= rough * (1.0 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return [n * step for n in range(first, math.floor(high / step + 1e-9) + 1)]


def logarithmic(low: float, high: float) -> list[float]:
    """Powers of ten, with 2 and 5 between where there are few."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    wanted = (1.0, 2.0, 5.0) if len(decades) < 4 else (1.0,)
    found = [n * 10.0**k for k in decades for n in wanted if low * (1 - 1e-9) <= n * 10.0**k <= high * (1 + 1e-9)]
    thin = -(-len(found) // 7)
    return found[::thin]


def text(value: float, step: float) -> str:
    """A mark's number, with no more digits than the `step` between two needs."""
    if value == 0.0 or abs(value) < 1e-9 * abs(step):
        return "0"
    if not 1e-3 <= abs(value) < 1e5:
        return f"{value:.3g}".replace("e-0", "e-").replace("e+0", "e").replace("-", "\N{MINUS SIGN}", value < 0)
    digits = max(0, -math.floor(math.log10(abs(step)) + 1e-9))
    return f"{value:.{digits}f}".replace("-", "\N{MINUS SIGN}")
