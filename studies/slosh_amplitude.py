"""When does sloshing begin to matter? Growth rate of preset S over the forced pitch: fuel frozen, linear, two-phase.

`python -m studies.slosh_amplitude [--fmus DIR] [--csv FILE] [--picture FILE]`: Mach 0.80, V_f 0.75, where frozen fuel is neutral.
At the tank, 1.8 m behind the axis, a degree of pitch is an acceleration of seven g.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import aeroslosh as ae

ROOT = Path(__file__).resolve().parents[1]
MACH, V_F = 0.80, 0.75
AMPLITUDES_DEG = (0.02, 0.05, 0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0)
FINE: dict[str, object] = {"slosh.cells_x": 200, "slosh.cells_y": 60}
CURVES: dict[str, tuple[str, dict[str, object], tuple[float, ...]]] = {
    "frozen": ("frozen", {}, AMPLITUDES_DEG),
    "linear slosh (EMS)": ("ems", {}, AMPLITUDES_DEG),
    "two-phase, 100 x 30": ("vof", {}, AMPLITUDES_DEG),
    "two-phase, 200 x 60": ("vof", FINE, (0.1, 0.3, 0.5, 1.0, 2.0)),
    "two-phase, implicit": ("vof", {"coupling.scheme": "implicit"}, (0.1, 0.5, 1.0)),
}
Row = tuple[str, float, float, float, float, str, float]


def point(model: str, amplitude_deg: float, settings: dict[str, object], fmus: Path) -> ae.Point:
    """One march. Raises ComponentError where an FMU fails."""
    case = ae.Case.load("paper_s").changed({"flutter.forced_amplitude_deg": amplitude_deg} | settings)
    return ae.point(case, mach=MACH, V_f=V_F, slosh=model, fmus=fmus)


def run(fmus: Path) -> list[Row]:
    """Rows of curve, amplitude [deg], growth rate and its uncertainty [omega_alpha], frequency, verdict, CPU seconds."""
    rows: list[Row] = []
    for name, (model, settings, amplitudes) in CURVES.items():
        for amplitude in amplitudes:
            p = point(model, amplitude, settings, fmus)
            numbers = p.growth_rate, p.growth_rate_uncertainty, p.frequency
            rows.append((name, amplitude, *numbers, str(p.verdict), float(p.data["cost"]["cpu_seconds"])))
            print(f"{name}, {amplitude:g} deg: {p}", flush=True)
    return rows


def main() -> None:
    """Run, write the data, draw."""
    command = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    command.add_argument("--fmus", type=Path, default=ROOT / "dist" / "fmus")
    command.add_argument("--csv", type=Path, default=ROOT / "docs" / "data" / "slosh_amplitude.csv")
    command.add_argument("--picture", type=Path)
    options = command.parse_args()
    rows = run(options.fmus)
    options.csv.parent.mkdir(parents=True, exist_ok=True)
    with options.csv.open("w", newline="", encoding="utf-8") as stream:
        table = csv.writer(stream, lineterminator="\n")
        table.writerow(
            ["curve", "forced_amplitude_deg", "growth_rate", "growth_rate_uncertainty", "frequency", "verdict", "cpu_seconds"]
        )
        table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in rows)
    if options.picture:
        draw(rows, options.picture)


def draw(rows: list[Row], path: Path) -> None:
    """Growth rate over amplitude."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, axes = plt.subplots(figsize=(7, 4.5), layout="constrained")
    marks = ("s--", "x-", "o-", "D:", "^:")
    for mark, name in zip(marks, CURVES, strict=True):
        mine = [row for row in rows if row[0] == name]
        x, y, doubt = ([row[c] for row in mine] for c in (1, 2, 3))
        axes.errorbar(x, y, doubt, fmt=mark, mfc="none", capsize=3, label=name)
    axes.axhline(0.0, color="k", lw=0.8)
    axes.set(
        xscale="log",
        xlabel="forced pitch [°]",
        ylabel=r"growth rate / $\omega_\alpha$",
        title=f"Preset S, Mach {MACH:.2f}, $V_f$ {V_F:.2f}: fuel frozen, linear, two-phase",
    )
    axes.grid(alpha=0.3, which="both")
    axes.legend()
    figure.savefig(path, dpi=120)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
