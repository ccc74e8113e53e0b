"""Limit-cycle amplitude over V_f at one Mach number, between onset and recovery of flutter.

`python -m studies.limit_cycles [mach] [V_f …]` marches each point for 40 free cycles from 3 degrees and prints a Markdown table.
"""

from __future__ import annotations

import sys

import aeroslosh as ae

CYCLES = 40


def main() -> None:
    """March and print."""
    mach = float(sys.argv[1]) if len(sys.argv) > 1 else 0.875
    speeds = [float(word) for word in sys.argv[2:]] or [0.6, 0.8, 1.0, 1.2, 1.42, 1.6, 1.8]
    case = ae.Case.isogai_a().replace(
        flutter={"free_cycles": CYCLES, "forced_amplitude_deg": 3.0, "max_alpha_deg": 20.0}, output={"fields": False}
    )
    print("| V_f | verdict | pitch amplitude | ω/ω_α | s CPU |\n|---|---|---|---|---|")
    for V_f in speeds:
        point = ae.point(case, mach=mach, V_f=V_f)
        amplitude = point.data["limit_cycle_amplitude_deg"]
        size = "" if amplitude is None else f"{amplitude:.2f}°"
        cost = point.data["cost"]["cpu_seconds"]
        print(f"| {V_f:g} | {point.verdict} | {size} | {point.frequency:.3f} | {cost:.0f} |", flush=True)


if __name__ == "__main__":
    main()
