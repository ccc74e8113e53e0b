"""Is a march shorter than the waves that would end it? What slosh_vof and slosh_rbf say of waves that gravity's changes feed.

The logarithm of their growth (output `wave_growth`, linear theory: Faraday, above 4 ζ g) rises at a rate that the motion sets.
From LOUD on a seed of a thousandth of the depth is as high as the liquid is deep: from then on fuel that looked frozen takes
energy out of the motion. A march that ends before tells of the fuel as it was, not of what it becomes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..flutter.march import March

LOUD = 7.0  # logarithm of the growth
SLOWEST = 0.01  # growth a period of omega_alpha below which waves are not reported: numerical noise, or hundreds of periods
LOOKED = 2.0  # periods of omega_alpha at the end of a march over which the rate is taken


def of_march(march: March) -> dict[str, Any] | None:
    """`growth`: logarithm at the end; `rate` [1/s] there; `free_cycles` at which it is LOUD, None where it never is; `in_time`:
    whether the march saw that. None for a liquid that tells nothing of waves, and after a failure."""
    told = march.history.get("slosh_wave_growth")
    if told is None or told.size < 3 or not np.all(np.isfinite(told)) or told.size - 1 <= march.release:
        return None
    s = march.scales
    back = min(told.size - 1 - march.release, round(LOOKED * s.steps_per_cycle))
    cycles = (told.size - 1 - march.release) / s.steps_per_cycle
    a_cycle = float(told[-1] - told[-1 - back]) * s.steps_per_cycle / back
    loud = None
    if told[-1] >= LOUD:
        loud = max(0.0, float(np.argmax(told >= LOUD) - march.release) / s.steps_per_cycle)
    elif a_cycle > SLOWEST:
        loud = cycles + (LOUD - float(told[-1])) / a_cycle
    return {
        "growth": float(told[-1]),
        "rate": a_cycle / s.period,
        "free_cycles": loud,
        "in_time": loud is not None and loud <= cycles,
    }


def lines(data: dict[str, Any]) -> list[str]:
    """What a person should know of it: nothing where no waves grow."""
    waves = data["waves"]
    if waves is None or waves["free_cycles"] is None:
        return []
    after = math.ceil(waves["free_cycles"])
    if waves["in_time"]:
        return [f"  waves        fed by gravity's changes at the tank, large from free cycle {after} on"]
    return [
        f"  waves        grow by {waves['rate']:.2g} 1/s, fed by gravity's changes at the tank: large from free cycle {after} on",
        f"  warning: this march ends after {data['free_cycles']:.3g}: it does not tell what the fuel does then "
        f"(flutter.free_cycles = {after + 10})",
    ]
