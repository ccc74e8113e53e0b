"""The two-phase tank against interFoam: force and moment of two cases, and the surface as it breaks.

`python -m studies.slosh_vof [picture.png]`. Case B: pitch of 1 degree at 3.14 rad/s. Case C06: pitch of 4 degrees and heave of
7.5 mm at 6.28 rad/s, the roof is hit after 2 s. OpenFOAM 1912's series, made with benchmarks/interfoam.py, come from tests/data.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from aeroslosh.fmus.slosh_vof.flow import Flow
from aeroslosh.fmus.slosh_vof.grid import Grid
from benchmarks.interfoam import case_b, case_c06, from_section
from benchmarks.slosh_vof import STEP, TANK, motion_of

Array = NDArray[np.float64]
DATA = Path(__file__).resolve().parents[1] / "tests" / "data"
CELLS = (200, 60)
SNAPSHOTS = (1.5, 2.2, 2.6, 3.0)


def run(name: str) -> tuple[Array, Array, Array, dict[float, tuple[float, Array]]]:
    """Times (n,), our (fx, fy, mz) (n, 3), interFoam's, and pitch and volume fractions at the snapshots."""
    case = {"B": case_b, "C06": case_c06}[name](CELLS)
    theirs = np.genfromtxt(DATA / f"interfoam_{name}_{CELLS[0]}x{CELLS[1]}.csv", delimiter=",", names=True, skip_header=2)
    motion = motion_of(case)
    flow = Flow(Grid(TANK, *CELLS))
    flow.start(motion(0))
    times, rows, shots = [], [], {}
    for k in range(len(theirs) - 1):
        flow.advance(motion(k), motion(k + 1), STEP)
        times.append(STEP * (k + 1))
        rows.append(from_section(np.array(flow.loads(motion(k + 1))[:3])))
        for t in SNAPSHOTS:
            if abs(times[-1] - t) < 0.5 * STEP:
                shots[t] = (motion(k + 1).alpha, flow.fractions.copy())
    other = np.stack([theirs[column][: len(rows)] for column in ("fx", "fy", "mz")], axis=1)
    return np.array(times), np.array(rows), other, shots


def main() -> None:
    """Print differences and draw the picture."""
    results = {name: run(name) for name in ("B", "C06")}
    for name, (times, mine, theirs, _) in results.items():
        for until in (2.0, times[-1]):
            s = times <= until + 1e-9
            gap = np.sqrt(np.mean((mine[s] - theirs[s]) ** 2, axis=0)) / np.std(theirs[s], axis=0)
            print(f"{name} to {until:g} s: fx {gap[0]:.2%}, mz {gap[2]:.2%}")
    if len(sys.argv) > 1:
        draw(results, Path(sys.argv[1]))


def draw(results: dict[str, tuple[Array, Array, Array, dict[float, tuple[float, Array]]]], path: Path) -> None:
    """Series on top, snapshots of C06 below, turned with the tank."""
    from matplotlib.figure import Figure

    from aeroslosh.master.pictures import canvas, look, tank_film

    with canvas.rc_context(look.STYLE):
        figure = Figure(figsize=(11, 8), layout="constrained")
        grid = figure.add_gridspec(3, 4, height_ratios=(1, 1, 0.75))
        drawn = []
        for row, (name, (times, mine, theirs, _)) in enumerate(results.items()):
            for column, (index, label) in enumerate(((0, "force aft [N/m]"), (2, "moment, anticlockwise [N]"))):
                axes = figure.add_subplot(grid[row, 2 * column : 2 * column + 2])
                axes.plot(times, theirs[:, index], color=look.ORANGE, lw=3.0, alpha=0.5, label="interFoam")
                axes.plot(times, mine[:, index], color=look.BLUE, lw=1.1, label="slosh_vof")
                axes.set(ylabel=label, xlabel="time [s]", title=f"case {name}")
                drawn.append(axes)
        canvas.legend(figure, *drawn)
        x = np.linspace(-0.5, 0.5, CELLS[0] + 1) * TANK.length
        y = np.linspace(-0.5, 0.5, CELLS[1] + 1) * TANK.height
        for column, (t, (alpha, shares)) in enumerate(results["C06"][3].items()):
            axes = figure.add_subplot(grid[2, column])
            px = x[None, :] * np.cos(alpha) + y[:, None] * np.sin(alpha)
            py = -x[None, :] * np.sin(alpha) + y[:, None] * np.cos(alpha)
            axes.pcolormesh(px, py, shares, cmap=tank_film.LIQUID, vmin=0.0, vmax=1.0, rasterized=True)
            axes.set(aspect="equal", title=f"C06, {t:g} s", xticks=[], yticks=[])
            axes.grid(False)
            for side in axes.spines.values():
                side.set_visible(False)
        figure.savefig(path)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
