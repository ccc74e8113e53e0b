"""Growth rate of the flutter mode over V_f, march by march: what tests/master/boundary/test_search_marched.py searches.

`python -m studies.growth_rates CASE SLOSH POINTS MACH …` prints rows of CSV, V_f evenly spread in its logarithm from 0.2 to 3.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np

from aeroslosh.master.boundary.search import sample
from aeroslosh.master.case import case as cases
from aeroslosh.master.flutter import march as flutter_march
from aeroslosh.master.flutter.setup import FlutterSetup, find_fmus

FMUS = Path(__file__).resolve().parents[1] / "dist" / "fmus"
LOW, HIGH = 0.2, 3.0  # V_f


def row(name: str, mach: float, V_f: float, march: flutter_march.March) -> str:
    """case, Mach, V_f, growth rate, its uncertainty, frequency [omega_alpha], 1 where the motion grew out of what a fit reads."""
    s = sample(march)
    numbers = [f"{s.growth_rate:.8f}", f"{s.std:.2e}", f"{s.frequency:.5f}"] if s.known else ["", "", ""]
    return ",".join([name, f"{mach:g}", f"{V_f:.8f}", *numbers, str(int(s.grows))])


def main() -> None:
    """Print the table that the command line asks for."""
    path, slosh, points, *machs = sys.argv[1:]
    case = cases.load(Path(path), [f"slosh.model={slosh}"])
    fmus = find_fmus(FMUS, slosh)
    for mach in map(float, machs):
        with FlutterSetup(case, fmus, mach) as setup:
            for V_f in np.geomspace(LOW, HIGH, int(points)):
                print(row(f"{case.name}_{slosh}", mach, V_f, flutter_march.march(setup, float(V_f))), flush=True)


if __name__ == "__main__":
    main()
