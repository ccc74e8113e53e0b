"""Figure 21: the flutter boundary with every model of the fuel: dry, frozen, linear slosh (EMS), surrogate, two-phase."""

from __future__ import annotations

from .boundaries import Onset, conditions, draw, onsets, shifts, table
from .claims import Claim, at_least
from .fig17 import MARKED, SIGMAS, percent
from .outcome import Outcome
from .work import Work

MODELS = ("none", "frozen", "ems", "rbf", "vof")


def make(work: Work) -> Outcome:
    """Five boundaries."""
    found = {model: onsets(work, model) for model in MODELS}
    dry = found["none"]
    apart = max(abs(found["ems"][m].V_f / found["frozen"][m].V_f - 1.0) for m in dry)
    worst = max(o.validity for o in found["ems"].values())
    remarks = [
        *(f"{model}: {shifts(found[model], dry)}" for model in MODELS[1:]),
        f"linear slosh is frozen fuel: their V_f differ by {apart:.3%} at most; the first wave (5.2 rad/s) is far below the "
        "flutter frequency",
        "the paper calls the EMS boundary slightly deviated in section IV E and its correlation poor in section V",
        f"validity of the EMS in these motions is up to {worst:.0f} (1 is the edge): at 1° it tells what linear theory says, "
        "not what fuel does, and `aeroslosh boundary` gives no verdict on it",
    ]
    title = "Fig. 21: neutral $V_f$ with each model of the fuel, forced pitch of 1°"
    claims = judged(found["ems"], found["vof"])
    return Outcome(claims, conditions(work), {"boundary": table(found)}, lambda: draw(found, title, MARKED), remarks)


def judged(linear: dict[float, Onset], flow: dict[float, Onset]) -> list[Claim]:
    """The paper: the EMS boundary correlates poorly with that of the flow."""
    claims = []
    for mach in linear:
        apart, doubt = percent(linear[mach], flow[mach])
        what = f"EMS and flow differ by more than their error bars, Mach {mach:g}"
        claims.append(at_least(what, "sections IV E and V, Fig. 21", SIGMAS * doubt, abs(apart), "", " %"))
    return claims
