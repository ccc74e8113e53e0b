"""Figure 11: the paper's three aeroelastic cases of the Isogai A section, damped, neutral and diverging.

`python -m paper.fig11 [picture.png]` runs `aeroslosh point` for Mach 0.850, V_f 0.439 (paper: damped); 0.825, 0.612 (paper: near
neutral); 0.875, 1.420 (paper: diverging; followed here to its limit cycle) and draws plunge and pitch.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

ROOT = Path(__file__).resolve().parents[1]
CASES = ((0.850, 0.439, 5, "damped"), (0.825, 0.612, 5, "near neutral"), (0.875, 1.420, 14, "diverging"))


def march(mach: float, V_f: float, cycles: int, folder: Path) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """Result and history (tau, h_over_b, alpha) of one march."""
    command = [sys.executable, "-m", "aeroslosh", "point", "cases/isogai_a.toml", "--mach", str(mach), "--vf", str(V_f)]
    command += ["--set", f"flutter.free_cycles={cycles}", "--json", "--quiet", "--no-pictures", "--out", str(folder)]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 4):
        raise SystemExit(done.stderr)
    with netcdf_file(folder / "history.nc", mmap=False) as history:
        names = ("tau", "h_over_b", "alpha")
        return json.loads(done.stdout), {name: np.array(history.variables[name][:]) for name in names}


def main() -> None:
    """Print verdicts beside the paper's and draw the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, rows = plt.subplots(len(CASES), 2, figsize=(9, 7), layout="constrained")
    with tempfile.TemporaryDirectory() as folder:
        for (mach, V_f, cycles, paper), axes in zip(CASES, rows, strict=True):
            result, history = march(mach, V_f, cycles, Path(folder) / f"{mach}")
            print(
                f"Mach {mach:.3f}, V_f {V_f:.3f}: {result['verdict']}, growth rate {result['growth_rate']:+.4f}, frequency "
                f"{result['frequency']:.4f}, {result['cost']['cpu_seconds']:.1f} s CPU; paper: {paper}"
            )
            for axis, name, scale, label in zip(axes, ("h_over_b", "alpha"), (1, 180 / np.pi), ("$h/b$", "α [°]"), strict=True):
                axis.plot(history["tau"] / (2 * np.pi), scale * history[name], lw=1)
                axis.set(ylabel=label, title=f"Mach {mach:.3f}, $V_f$ = {V_f:.3f}: {result['verdict']} (paper: {paper})")
                axis.title.set_fontsize(9)
                axis.grid(alpha=0.3)
    for axis in rows[-1]:
        axis.set_xlabel(r"cycles $\omega_\alpha t / 2\pi$")
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=110)
        print(f"picture: {sys.argv[1]}")


if __name__ == "__main__":
    main()
