"""Draw the icons of the FMUs: `python docs/icons.py` writes fmus/<component>/icon.png (model.png in the FMU)."""

from __future__ import annotations

import sys
from pathlib import Path

import matplotlib
import numpy as np

matplotlib.use("Agg")
from matplotlib import pyplot
from matplotlib.axes import Axes

ROOT = Path(__file__).resolve().parents[1]
INK, LIQUID, WARM, PALE = "#1b2733", "#3f8fd2", "#d2583f", "#eef3f7"


def section(axis: Axes, y: float = 0.5, size: float = 0.8, angle: float = 0.12) -> None:
    """A symmetric airfoil."""
    x = 0.5 * (1.0 - np.cos(np.linspace(0.0, np.pi, 60)))
    half = 0.7 * (0.2969 * np.sqrt(x) - 0.126 * x - 0.3516 * x**2 + 0.2843 * x**3 - 0.1036 * x**4)
    outline = size * np.array([np.r_[x, x[::-1]] - 0.5, np.r_[half, -half[::-1]]])
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    axis.fill(*(turn @ outline + [[0.5], [y]]), facecolor="white", edgecolor=INK, lw=3, zorder=3)


def spring(axis: Axes, x: float, low: float, high: float) -> None:
    """A zigzag."""
    heights = np.linspace(low, high, 12)
    axis.plot(x + 0.045 * np.r_[0, 0, (-1.0) ** np.arange(8), 0, 0], heights, color=WARM, lw=3)


def box(axis: Axes) -> None:
    """A tank."""
    axis.plot([0.12, 0.12, 0.88, 0.88], [0.82, 0.2, 0.2, 0.82], color=INK, lw=5, solid_joinstyle="round", zorder=4)


def structure(axis: Axes) -> None:
    """A section on a spring."""
    spring(axis, 0.5, 0.1, 0.48)
    axis.plot([0.25, 0.75], [0.1, 0.1], color=INK, lw=5)
    section(axis, 0.6)
    axis.plot(0.5, 0.6, "o", color=WARM, ms=9, zorder=5)


def aero(axis: Axes) -> None:
    """A section in a stream with a shock."""
    x = np.linspace(0.05, 0.95, 50)
    for offset in (-0.3, -0.2, 0.2, 0.3):
        axis.plot(x, 0.5 + offset + 0.22 * offset * np.exp(-(((x - 0.45) / 0.22) ** 2)), color=LIQUID, lw=3)
    axis.plot([0.62, 0.66], [0.55, 0.86], color=WARM, lw=4)
    section(axis)


def slosh_vof(axis: Axes) -> None:
    """A wave with a crest."""
    x = np.linspace(0.12, 0.88, 200)
    top = 0.45 + 0.12 * np.cos(np.pi * (x - 0.12) / 0.76) + 0.04 * np.sin(6.0 * np.pi * x)
    axis.fill_between(x, 0.2, top, color=LIQUID)
    for spot in ((0.3, 0.7), (0.38, 0.76), (0.45, 0.68)):
        axis.plot(*spot, "o", color=LIQUID, ms=6)
    box(axis)


def slosh_ems(axis: Axes) -> None:
    """A mass between springs in a tank."""
    axis.fill_between([0.12, 0.88], 0.2, 0.35, color=LIQUID, alpha=0.5)
    for low, high in ((0.14, 0.4), (0.6, 0.86)):
        along = np.linspace(low, high, 12)
        axis.plot(along, 0.52 + 0.045 * np.r_[0, 0, (-1.0) ** np.arange(8), 0, 0], color=WARM, lw=3)
    axis.add_patch(pyplot.Rectangle((0.4, 0.42), 0.2, 0.2, facecolor=LIQUID, edgecolor=INK, lw=3, zorder=3))
    box(axis)


def slosh_rbf(axis: Axes) -> None:
    """A network over a level surface."""
    axis.fill_between([0.12, 0.88], 0.2, 0.35, color=LIQUID)
    for a in (0.42, 0.58, 0.74):
        axis.plot([0.25, 0.5, 0.75], [0.58, a, 0.58], color=INK, lw=1.5)
        axis.plot(0.5, a, "o", color=WARM, ms=12, zorder=5)
    axis.plot([0.25, 0.75], [0.58, 0.58], "o", color=INK, ms=12, zorder=5)
    box(axis)


def main() -> int:
    """Draw all; returns the exit code."""
    for draw in (structure, aero, slosh_vof, slosh_ems, slosh_rbf):
        figure = pyplot.figure(figsize=(2.0, 2.0), dpi=96)
        axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axis.add_patch(pyplot.Rectangle((0.02, 0.02), 0.96, 0.96, facecolor=PALE, edgecolor=INK, lw=2))
        draw(axis)
        axis.set(xlim=(0, 1), ylim=(0, 1))
        axis.set_axis_off()
        figure.savefig(ROOT / "fmus" / draw.__name__ / "icon.png", metadata={"Software": None})
        pyplot.close(figure)
    return 0


if __name__ == "__main__":
    sys.exit(main())
