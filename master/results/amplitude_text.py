"""The boundary over amplitude in words: one V_f of `aeroslosh amplitude` as a line, for the command, its log and its page."""

from __future__ import annotations

from typing import Any


def said(row: dict[str, Any]) -> str:
    """A V_f in a line. row: one of the `speeds` of `api.amplitude.Amplitude.data`."""
    found = [
        f"{'stable' if c['stable'] else 'unstable'} limit cycle at {c['amplitude_deg']:.3g} ± {c['std_deg']:.1g} deg"
        + (f" (marched from {c['confirmed']})" if c["confirmed"] else " (not confirmed)")
        for c in row["cycles"]
    ]
    if found:
        return f"V_f {row['V_f']:g}: " + ", ".join(found)
    if not row["curve"]:
        return f"V_f {row['V_f']:g}: no march was long enough to read an envelope. Remedy: more free cycles (--cycles)"
    low, high = row["curve"][0]["amplitude_deg"], row["curve"][-1]["amplitude_deg"]
    return f"V_f {row['V_f']:g}: no limit cycle, motions of {low:.2g} to {high:.2g} deg {trend(row)}"


def trend(row: dict[str, Any]) -> str:
    """What motions of all amplitudes marched do: grow, decay, or both."""
    rates = [p["growth_rate"] for p in row["curve"]]
    return "grow" if all(r > 0.0 for r in rates) else "decay" if all(r < 0.0 for r in rates) else "grow and decay"
