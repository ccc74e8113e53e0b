"""The dry flutter boundary beside the linear model's, as the table of docs/boundary.md.

`aeroslosh boundary cases/isogai_a_boundary.toml --out runs/boundary`, then `python -m studies.boundary runs/boundary`.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

PARTS = ("fit", "discretisation", "amplitude")


def rows(result: dict[str, Any]) -> list[str]:
    """Markdown rows: Mach, linear V_f, marched V_f with its error bar, their difference, frequency, parts of the bar; a part that
    could not be had is named."""
    lines = []
    for point in result["points"]:
        linear = point["linear"]
        if not linear["crossings"]:
            lines.append(f"| {point['mach']:.3f} | none | none: {len(point['marches'])} marches | | | | | |")
        for predicted in linear["crossings"]:
            own = next((c for c in point["crossings"] if c["V_f"] == predicted["marched_V_f"]), None)
            start = f"| {point['mach']:.3f} | {predicted['direction']} {predicted['V_f']:.4f} |"
            if own is None:
                lines.append(f"{start} {predicted['state']} | | {predicted['frequency']:.3f} | | | |")
                continue
            parts = own["uncertainty_parts"]
            told = [f"{parts[name]:+.4f}" if name in parts else "not had" for name in PARTS]
            lines.append(
                f"{start} {own['V_f']:.4f} ± {own['V_f_uncertainty']:.4f} | {100 * (predicted['V_f'] / own['V_f'] - 1):+.2f} % "
                f"| {own['frequency']:.3f} | {' | '.join(told)} |"
            )
    return lines


def main() -> None:
    """Print table and totals of the run folder named on the command line."""
    result = json.loads((Path(sys.argv[1]) / "result.json").read_text(encoding="utf-8"))
    print("| Mach | linear V_f | marched V_f | linear − marched | ω/ω_α | fit | discretisation | amplitude |")
    print("|---|---|---|---|---|---|---|---|")
    print("\n".join(rows(result)))
    crossings = sum(len(point["crossings"]) for point in result["points"])
    marches = sum(len(point["marches"]) for point in result["points"])
    print(f"\n{crossings} crossings, {marches} marches, {result['cost']['cpu_seconds']:.0f} s CPU")


if __name__ == "__main__":
    main()
