"""How far a surface is from breaking: unevenness of gravity, and the growth of waves that nobody drives (tank.faraday).

D = |gamma| + (l/2)|alpha''|/g: towards 1.5 gravity vanishes or reverses at one end of the tank and the surface breaks there.
"""

from __future__ import annotations

from ..kit.compiled import jit
from .memory import GAMMA, SPIN, Array

EDGE_UNEVEN = 1.5
EDGE_GROWTH = 7.0
"""A seed of a thousandth of the depth has then grown to the depth."""


@jit
def uneven(rows: Array) -> float:
    """D at one instant; rows: a drive (memory.drive)."""
    return abs(rows[GAMMA]) + abs(rows[SPIN])
