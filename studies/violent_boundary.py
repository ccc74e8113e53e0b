"""Neutral V_f at a forced pitch of a degree: the two-phase tank as an ensemble, and the surrogate, at the same points.

`python -m studies.violent_boundary [--members N] [--cells NX NY] [--csv FILE] [MACH:V_f,V_f,… …]`: each V_f is marched with
slosh_rbf and, for every seed, with slosh_vof, five free cycles long. Two growth rates of a march: the slope of the logarithm of
the pitch amplitude over the free cycles, a mean where damping changes with the amplitude, and that of the fit. A straight line
in V_f through the members' rates gives the V_f where they vanish, with the standard error of that line.
"""

from __future__ import annotations

import argparse
import csv
import io
import math
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

import aeroslosh as ae
from aeroslosh.master.base import files

ROOT = Path(__file__).resolve().parents[1]
HEAD = ("mach", "V_f", "model", "seed", "slope", "fit", "fit_error", "verdict", "validity", "cpu_seconds")
POINTS = (
    "0.70:1.36,1.41,1.46",
    "0.75:1.15,1.20,1.25",
    "0.775:1.00,1.05,1.10",
    "0.80:0.87,0.905,0.94",
    "0.825:0.65,0.69,0.73",
    "0.85:0.55,0.58,0.61",
)
FREE_CYCLES = 5.0
Row = tuple[float, float, str, int, float, float, float, str, float, float]


def slope(point: ae.Point, cycles: float = FREE_CYCLES) -> float:
    """Of ln(pitch amplitude) over the first free `cycles`, over omega_alpha.

    Amplitude: √(α² + (α'/ω)²), averaged over half a period."""
    history = point.history
    tau, time, alpha, rate = (np.asarray(history[name].values, float) for name in ("tau", "time", "alpha", "alpha_dot"))
    release = int(history.attrs["release_index"])
    free = slice(release, int(np.searchsorted(tau, tau[release] + 2.0 * math.pi * cycles + 1e-9)))
    rate = (rate * (time[-1] / tau[-1]))[free]
    tau, alpha = tau[free], alpha[free]
    zeros = np.flatnonzero((alpha[:-1] < 0.0) != (alpha[1:] < 0.0))
    omega = math.pi * (len(zeros) - 1) / float(tau[zeros[-1]] - tau[zeros[0]])
    n = round(math.pi / omega / float(tau[1] - tau[0]))
    size = np.convolve(np.hypot(alpha, rate / omega), np.ones(n) / n, "valid")
    return float(np.polyfit(tau[n // 2 : n // 2 + size.size], np.log(size), 1)[0])


def march(case: ae.Case, mach: float, V_f: float, model: str, seed: int) -> Row:
    """One march."""
    point = ae.point(case.changed({"slosh.seed": seed}), mach=mach, V_f=V_f, slosh=model)
    cost = float(point.data["cost"]["cpu_seconds"])
    fit = point.growth_rate, point.growth_rate_uncertainty
    return mach, V_f, model, seed, slope(point), *fit, str(point.verdict), float(point.data["slosh_validity"] or math.nan), cost


def neutral(rows: Sequence[Row], column: int) -> tuple[float, float]:
    """V_f at which the straight line through a `column` of `rows` over V_f is 0, and its standard error by the delta method.

    Of fewer than three rows the error is nan; of one row a V_f it is the line's departure from the points."""
    x, y = (np.array([row[c] for row in rows], float) for c in (1, column))
    middle = float(x.mean())
    design = np.column_stack([np.ones(x.size), x - middle])
    (mean, rise), *_ = np.linalg.lstsq(design, y, rcond=None)
    root = middle - mean / rise
    if x.size < 3:
        return float(root), math.nan
    left = y - design @ [mean, rise]
    covariance = float(left @ left) / (x.size - 2) * np.linalg.inv(design.T @ design)
    gradient = np.array([-1.0 / rise, mean / rise**2])
    return float(root), float(np.sqrt(gradient @ covariance @ gradient))


def points(words: Sequence[str]) -> Iterator[tuple[float, list[float]]]:
    """Mach number and V_f of each word of the command line."""
    for word in words:
        mach, _, speeds = word.partition(":")
        yield float(mach), [float(v) for v in speeds.split(",")]


def main() -> None:
    """March, write rows as they come, print the table."""
    command = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    command.add_argument("points", nargs="*", metavar="MACH:V_f,V_f", default=POINTS)
    command.add_argument("--members", type=int, default=5)
    command.add_argument("--cells", type=int, nargs=2, default=(100, 30), metavar=("NX", "NY"))
    command.add_argument("--degrees", type=float, default=1.0, help="forced pitch")
    command.add_argument("--csv", type=Path, default=ROOT / "docs" / "data" / "violent_boundary.csv")
    options = command.parse_args()
    nx, ny = options.cells
    case = ae.Case.load("paper_s").changed(
        {
            "flutter.forced_amplitude_deg": options.degrees,
            "flutter.free_cycles": FREE_CYCLES,
            "flutter.max_free_cycles": FREE_CYCLES,
            "flutter.companion": False,
            "output.fields": False,
            "slosh.cells_x": nx,
            "slosh.cells_y": ny,
        }
    )
    rows: list[Row] = []
    print("| Mach | rate | RBF | VOF, mean of members | one member ± | difference |\n|---|---|---|---|---|---|", flush=True)
    for mach, speeds in points(options.points):
        for V_f in speeds:
            for model, seed in [("rbf", 0), *(("vof", seed) for seed in range(options.members))]:
                rows.append(march(case, mach, V_f, model, seed))
                write(options.csv, rows)
        rbf, vof = ([row for row in rows if row[0] == mach and row[2] == model] for model in ("rbf", "vof"))
        for name in ("slope", "fit"):
            (theirs, _), (ours, error) = (neutral(of_model, HEAD.index(name)) for of_model in (rbf, vof))
            one = error * math.sqrt(options.members)
            print(
                f"| {mach:g} | {name} | {theirs:.4f} | {ours:.4f} ± {error:.4f} | {one:.4f} | {theirs / ours - 1:+.1%} |",
                flush=True,
            )


def write(path: Path, rows: Sequence[Row]) -> None:
    """All rows so far."""
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(HEAD)
    table.writerows([f"{v:.6g}" if isinstance(v, float) else v for v in row] for row in rows)
    path.parent.mkdir(parents=True, exist_ok=True)
    files.write(path, text.getvalue().encode())


if __name__ == "__main__":
    main()
