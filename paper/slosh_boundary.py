"""Does fuel move the transonic flutter boundary? Preset S over Mach number: dry, frozen, linear slosh, two-phase slosh.

`python -m paper.slosh_boundary [--mach M …] [--models MODEL …] [--fmus DIR] [--csv FILE] [--picture FILE]` runs
`aeroslosh boundary cases/paper_s.toml --slosh MODEL` for each: a linear model predicts the onsets, marches of the Euler flow
confirm them.
"""

from __future__ import annotations

import argparse
import csv
from dataclasses import astuple, dataclass, fields
from pathlib import Path

import aeroslosh as ae
from aeroslosh.master.case.fuel_tank import LABEL

ROOT = Path(__file__).resolve().parents[1]
MACH = (0.70, 0.75, 0.775, 0.80, 0.825, 0.85)
MODELS = ("none", "frozen", "ems", "vof")


@dataclass(frozen=True)
class Row:
    """The onset of flutter at one Mach number: marched V_f with its standard uncertainty, frequency over omega_alpha, seconds."""

    slosh: str
    mach: float
    V_f: float
    uncertainty: float
    frequency: float
    linear_V_f: float
    marches: int
    cpu_seconds: float


def boundary(model: str, mach: list[float], fmus: Path) -> list[Row]:
    """The onsets with one model of the liquid."""
    found = ae.boundary(ae.Case.load("paper_s"), mach=mach, slosh=model, fmus=fmus)
    rows = []
    for point in found.data["points"]:
        onset = next(c for c in point["crossings"] if c["direction"] == "onset")
        V_f, doubt, frequency = (float(onset[name]) for name in ("V_f", "V_f_uncertainty", "frequency"))
        cost = point["cost"]
        predicted = [c["V_f"] for c in point["linear"]["crossings"] if c["marched_V_f"] == onset["V_f"]]
        linear = predicted[0] if predicted else float("nan")
        rows.append(Row(model, point["mach"], V_f, doubt, frequency, linear, cost["marches"], cost["cpu_seconds"]))
        print(rows[-1], flush=True)
    return rows


def main() -> None:
    """Run, write the data, print the table, draw."""
    command = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    command.add_argument("--mach", type=float, nargs="+", default=list(MACH))
    command.add_argument("--models", nargs="+", default=list(MODELS))
    command.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    command.add_argument("--csv", type=Path, default=ROOT / "docs" / "data" / "slosh_boundary.csv")
    command.add_argument("--picture", type=Path)
    options = command.parse_args()
    rows = [row for model in options.models for row in boundary(model, options.mach, options.fmus)]
    options.csv.parent.mkdir(parents=True, exist_ok=True)
    with options.csv.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow([f.name for f in fields(Row)])
        table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in astuple(row)] for row in rows)
    print("\n| Mach | " + " | ".join(LABEL[m] for m in options.models) + " |\n|---|" + "---|" * len(options.models))
    for mach in options.mach:
        here = {r.slosh: r for r in rows if r.mach == mach}
        first = here[options.models[0]].V_f
        cells = [f"{r.V_f:.4f} ± {r.uncertainty:.4f} ({100 * (r.V_f / first - 1):+.2f} %)" for r in here.values()]
        print(f"| {mach:.3f} | " + " | ".join(cells) + " |")
    if options.picture:
        draw(rows, options.models, options.picture)


def draw(rows: list[Row], models: list[str], path: Path) -> None:
    """V_f over Mach with two standard deviations; below, the change against the first model."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    style = {"none": ("k", "-", "o"), "frozen": ("#1f5fa8", "--", "s"), "ems": ("#c0392b", "-", "x")}
    figure, (top, low) = plt.subplots(2, 1, figsize=(7, 7), sharex=True, height_ratios=(2, 1), layout="constrained")
    dry = {r.mach: r.V_f for r in rows if r.slosh == models[0]}
    for model in models:
        mine = [r for r in rows if r.slosh == model]
        color, line, mark = style.get(model, ("#2e8b57", ":", "d"))
        mach, error = [r.mach for r in mine], [2.0 * r.uncertainty for r in mine]
        look = {"color": color, "ls": line, "marker": mark, "mfc": "none", "ms": 7, "capsize": 3}
        top.errorbar(mach, [r.V_f for r in mine], error, label=LABEL[model], **look)
        if model != models[0]:
            shift = [100.0 * (r.V_f / dry[r.mach] - 1.0) for r in mine]
            low.errorbar(mach, shift, [100.0 * e / dry[m] for e, m in zip(error, mach, strict=True)], **look)
    low.axhline(0.0, color="k", lw=0.8)
    top.set(
        ylabel="$V_f$ at the onset of flutter",
        title="NACA 64A010, Isogai A ratios, chord 2 m, fuel 13 % of the mass (Euler flow)",
    )
    low.set(xlabel="Mach number", ylabel=f"change against {LABEL[models[0]]} [%]")
    for axis in (top, low):
        axis.grid(alpha=0.3)
    top.legend()
    figure.savefig(path, dpi=120)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
