"""Figure 11: the paper's three aeroelastic cases of the Isogai A section, damped, neutral and diverging.

`python -m paper.fig11 [picture.png]` runs `aeroslosh point` for Mach 0.850, V_f 0.439 (paper: damped); 0.825, 0.612 (paper: near
neutral); 0.875, 1.420 (paper: diverging; followed here to its limit cycle) and draws plunge and pitch.
"""

from __future__ import annotations

import sys

import numpy as np

import aeroslosh as ae

CASES = ((0.850, 0.439, 5, "damped"), (0.825, 0.612, 5, "near neutral"), (0.875, 1.420, 14, "diverging"))


def main() -> None:
    """Print verdicts beside the paper's and draw the picture."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, rows = plt.subplots(len(CASES), 2, figsize=(9, 7), layout="constrained")
    for (mach, V_f, cycles, paper), axes in zip(CASES, rows, strict=True):
        point = ae.point(ae.Case.isogai_a().replace(flutter={"free_cycles": cycles}), mach=mach, V_f=V_f)
        cost = point.data["cost"]["cpu_seconds"]
        print(f"{point}, {cost:.1f} s CPU; paper: {paper}")
        for axis, name, scale, label in zip(axes, ("h_over_b", "alpha"), (1, 180 / np.pi), ("$h/b$", "α [°]"), strict=True):
            axis.plot(point.history["tau"] / (2 * np.pi), scale * point.history[name], lw=1)
            axis.set(ylabel=label, title=f"Mach {mach:.3f}, $V_f$ = {V_f:.3f}: {point.verdict} (paper: {paper})")
            axis.title.set_fontsize(9)
            axis.grid(alpha=0.3)
    for axis in rows[-1]:
        axis.set_xlabel(r"cycles $\omega_\alpha t / 2\pi$")
    if len(sys.argv) > 1:
        figure.savefig(sys.argv[1], dpi=110)
        print(f"picture: {sys.argv[1]}")


if __name__ == "__main__":
    main()
