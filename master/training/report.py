"""The report page of a training: every model beside the others, in Markdown."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

HEAD = "| model | Fx | Fy | Mz | largest Fx | Fy | Mz | amplitude | phase | work |\n|---|---|---|---|---|---|---|---|---|---|"


def table(summary: Mapping[str, Mapping[str, float]]) -> str:
    """A line a model: mean and largest errors of free run over the load's std, of first harmonics, of work."""
    lines = [HEAD]
    for name, s in summary.items():
        means = " | ".join(f"{s[f'mean_{n}']:.2%}" for n in ("fx", "fy", "mz"))
        most = " | ".join(f"{s[f'most_{n}']:.2%}" for n in ("fx", "fy", "mz"))
        waves = f"{s['amplitude']:.2%} | {s['phase_deg']:.2f}°" if "amplitude" in s else " | "
        lines.append(f"| {name} | {means} | {most} | {waves} | {s['work_error']:.1e} |")
    return "\n".join(lines)


def records(rows: list[dict[str, Any]], models: tuple[str, ...]) -> str:
    """A line a record: D and errors of some models."""
    lines = [f"| record | D | {' | '.join(models)} |", f"|---|---|{'---|' * len(models)}"]
    for name in dict.fromkeys(row["record"] for row in rows):
        mine = {row["model"]: row for row in rows if row["record"] == name}
        cells = [" / ".join(f"{100 * e:.2f}" for e in mine[m]["errors"]) if m in mine else "" for m in models]
        lines.append(f"| {name} | {next(iter(mine.values()))['D']:.2f} | {' | '.join(cells)} |")
    return "\n".join(lines)


def write(path: Path, name: str, result: Mapping[str, Any]) -> str:
    """Write the page; returns it."""
    shown = ("ems", "bilinear", "quadratic", "rbf", "arx", "second grid")
    tried = "\n".join(
        f"- seed {r['seed']}: {r['records']} records, validation {r['validation_error']:.4%}, {r['training_cpu_s']:.0f} s CPU"
        for r in result["seeds"]
    )
    page = f"""# Training of {name}

Records cost {result["records_cpu_s"]:.0f} s CPU, training {result["training_cpu_s"]:.0f} s.

{tried}

## Records not seen in training, surface whole (D up to 1)

Free run. Errors: rms of the difference over the load's std (at least 0.2 % of the weight); work: of eta
(fmus/slosh_rbf/training/measures.py).

D up to 0.75:

{table(result["calm"])}

D up to 1:

{table(result["whole"])}

## The same, record by record (Fx / Fy / Mz in per cent)

{records(result["rows"]["test"], shown)}

## Beyond break-up

{table(result["breakup"])}

{records(result["rows"]["breakup"], shown)}
"""
    path.write_text(page, encoding="utf-8")
    return page
