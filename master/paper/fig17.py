"""Figure 17: the flutter boundary without fuel, with two-phase fuel and with the surrogate."""

from __future__ import annotations

import math

from .boundaries import Onset, conditions, draw, onsets, shifts, table
from .claims import Claim, at_least, at_most
from .outcome import Outcome
from .work import Work

MODELS = ("none", "vof", "rbf")
SIGMAS = 2.0
CLOSE = 3.0
""""Remarkable agreement": 3 % in V_f, or what two standard deviations of both allow."""


def make(work: Work) -> Outcome:
    """Three boundaries."""
    found = {model: onsets(work, model) for model in MODELS}
    dry, flow, net = (found[model] for model in MODELS)
    remarks = [
        f"two-phase fuel from 1°: {shifts(flow, dry)}; surrogate: {shifts(net, dry)}",
        "this is a matter of amplitude: small motions flutter earlier than the dry section, by the fuel's mass (frozen in "
        "fig21; docs/does-slosh-matter.md)",
    ]
    chosen = [
        *conditions(work),
        "surrogate: the network that comes with slosh_rbf, with its violent branch (docs/slosh_violent.md), not the paper's "
        "output-fed network, which fails in free run (fig13)",
    ]
    title = "Fig. 17: neutral $V_f$, NACA 64A010, Isogai A ratios, fuel 13 % of the mass"
    return Outcome(judged(dry, flow, net), chosen, {"boundary": table(found)}, lambda: draw(found, title, MARKED), remarks)


MARKED = {"dry, damped": (0.80, 0.78), "dry, flutter": (0.80, 0.86), "with fuel, flutter (Fig. 15)": (0.80, 0.70)}


def judged(dry: dict[float, Onset], flow: dict[float, Onset], net: dict[float, Onset]) -> list[Claim]:
    """Higher with fuel, and flow and surrogate alike, at each Mach number."""
    claims = []
    for mach, own in dry.items():
        where = "section V, Fig. 17"
        rise, doubt = percent(flow[mach], own)
        what = f"with sloshing V_f is higher, Mach {mach:g}: rise, less {SIGMAS:g} standard deviations"
        claims.append(at_least(what, where, 0.0, rise - SIGMAS * doubt, "fuel that moves little lowers V_f by its mass", " %"))
        apart, doubt = percent(net[mach], flow[mach])
        what = f"surrogate and flow agree, Mach {mach:g}: difference"
        claims.append(at_most(what, where, max(CLOSE, SIGMAS * doubt), abs(apart), "", " %"))
    return claims


def percent(a: Onset, b: Onset) -> tuple[float, float]:
    """By how much `a` is above `b` [%], and the standard deviation of that."""
    return 100.0 * (a.V_f / b.V_f - 1.0), 100.0 * math.hypot(a.doubt / b.V_f, a.V_f * b.doubt / b.V_f**2)
