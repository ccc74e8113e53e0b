"""The mean and the scatter of several marches of one point whose starts differ by next to nothing.

Once fuel breaks, two such marches are two draws: their growth rates differ by more than a fit's error bar. What is reported is
the mean, its standard error, and the members' standard deviation, which is what one march may be off by.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np

from .verdict import Judgement, Verdict

SAME_MODE = 0.1  # share of the median frequency within which members show the same mode
SURE = 2.0  # standard errors of the mean beyond which its sign is taken to be known
MORE_MEMBERS = "more members (slosh.members), or more free cycles (flutter.free_cycles)"


@dataclasses.dataclass(frozen=True)
class Member:
    """What counts of one march: growth rate of its critical mode with the fit's standard deviation, frequency (0: a real pole),
    over omega_alpha; nan without a fit."""

    seed: int
    growth_rate: float
    std: float
    frequency: float
    verdict: Verdict


@dataclasses.dataclass(frozen=True)
class Ensemble:
    """Members of one point. Those count whose growth rate is known and of the mode that most of them show: a fit may read
    another one where the fuel's impacts are as large as what is left of the motion."""

    members: tuple[Member, ...]

    @property
    def known(self) -> tuple[Member, ...]:
        """Those that count."""
        found = [m for m in self.members if math.isfinite(m.growth_rate) and m.frequency]
        middle = float(np.median([m.frequency for m in found])) if found else 0.0
        return tuple(m for m in found if abs(m.frequency - middle) <= SAME_MODE * middle)

    @property
    def mean(self) -> float:
        """Of the growth rates."""
        return float(np.mean([m.growth_rate for m in self.known])) if self.known else math.nan

    @property
    def sd(self) -> float:
        """Of the growth rates: how far one march is from the mean. nan of fewer than two."""
        return float(np.std([m.growth_rate for m in self.known], ddof=1)) if len(self.known) > 1 else math.nan

    @property
    def error(self) -> float:
        """Standard error of the mean: scatter and fits."""
        fits = float(np.sqrt(np.mean([m.std**2 for m in self.known]))) if self.known else math.nan
        return math.hypot(self.sd, fits) / math.sqrt(max(1, len(self.known)))

    @property
    def frequency(self) -> tuple[float, float]:
        """Mean and its standard error."""
        values = [m.frequency for m in self.known]
        return float(np.mean(values)), float(np.std(values, ddof=1)) / math.sqrt(len(values))

    def judged(self, band: float) -> Judgement:
        """The verdict on the mean; `band`: growth rates below it are called neutral."""
        verdicts = {m.verdict for m in self.members}
        said = f"{len(self.members)} members: growth rate {self.mean:+.5f} ± {self.error:.5f}, one march ± {self.sd:.5f}"
        if not math.isfinite(self.error):
            said = f"{len(self.members)} members: {len(self.known)} of them with a growth rate of the same mode, no mean"
        if len(verdicts) == 1 and Verdict.UNDETERMINED not in verdicts:
            return Judgement(next(iter(verdicts)), f"all of {said}", True, None)
        if Verdict.DIVERGENCE in verdicts:
            return Judgement(Verdict.UNDETERMINED, f"{said}: divergence in some of them", False, None, MORE_MEMBERS)
        if not math.isfinite(self.error):
            return Judgement(Verdict.UNDETERMINED, said, False, None, MORE_MEMBERS)
        if abs(self.mean) > SURE * self.error:
            return Judgement(Verdict.FLUTTER if self.mean > 0.0 else Verdict.DAMPED, f"mean of {said}", True, None)
        if abs(self.mean) + SURE * self.error <= band:
            return Judgement(Verdict.NEUTRAL, f"mean of {said}", True, None)
        return Judgement(Verdict.UNDETERMINED, f"{said}: the sign is not known", False, None, MORE_MEMBERS)

    def as_data(self) -> dict[str, Any]:
        """For JSON."""
        return {
            "seeds": [m.seed for m in self.members],
            "growth_rates": [m.growth_rate if math.isfinite(m.growth_rate) else None for m in self.members],
            "verdicts": [str(m.verdict) for m in self.members],
            "mean": self.mean if math.isfinite(self.mean) else None,
            "sd": self.sd if math.isfinite(self.sd) else None,
            "standard_error": self.error if math.isfinite(self.error) else None,
        }
