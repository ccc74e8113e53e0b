"""The report page of a violent training, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

HEAD = "| records | R2 of the force | loss factor, rms error | bias | cycles |\n|---|---|---|---|---|"


def table(splits: Mapping[str, Any]) -> str:
    """A line a split: what the force and the loss factors of cycles are worth."""
    return "\n".join(
        [
            HEAD,
            *(
                f"| {n} | {s['R2']:.3f} | {s['loss_rms']:.4f} | {s['loss_bias']:+.4f} | {s['cycles']} |"
                for n, s in splits.items()
            ),
        ]
    )


def write(path: Path, name: str, report: Mapping[str, Any]) -> str:
    """Write the page; returns it."""
    splits = report["splits"]
    tried = "\n".join(
        f"- {r['centres']} Gaussians, spread {r['spread']:g}, ridge {r['ridge']:g}: loss factor rms {r['loss_rms']:.4f}, bias "
        f"{r['loss_bias']:+.4f}, R2 {r['R2']:.3f}"
        for r in report["tried"]
    )
    bands = "\n".join(
        f"| {n} | {b['from']:g}–{b['to']:g} | {b['loss']:.3f} | {b['loss_rms']:.4f} | {b['loss_bias']:+.4f} | {b['cycles']} |"
        for n in ("test", "twins")
        for b in splits.get(n, {}).get("bands", ())
    )
    fills = "\n".join(
        f"| {f['fill']:g} | {f['R2']:.3f} | {f['loss_rms']:.4f} | {f['loss_bias']:+.4f} | {f['cycles']} |"
        for f in splits["test"]["fills"]
    )
    page = f"""# Training of the violent branch {name}

{report["records"]} records, {report["simulated_s"]:.0f} s simulated, {report["records_cpu_s"]:.0f} s CPU; training \
{report["fit_cpu_s"]:.0f} s CPU.

Loss factor of a cycle: the work that the liquid takes out of it over pi m a X (amplitudes of acceleration and displacement;
cycles of 1 g and more). R2: of the force up over (Q + 0.3 g). Twins: the same tests from a motion that differs by 1e-5.

{table(splits)}

Tried, on the records of validation:

{tried}

## Tests by amplitude of acceleration [g]

| | amplitude | mean loss factor | rms error | bias | cycles |
|---|---|---|---|---|---|
{bands}

## Tests by fill

| fill | R2 | loss factor, rms error | bias | cycles |
|---|---|---|---|---|
{fills}
"""
    path.write_text(page, encoding="utf-8")
    return page
