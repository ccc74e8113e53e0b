"""Mach number around the section at the recorded instants, with the sonic line."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import QuadMesh
from matplotlib.ticker import MultipleLocator
from scipy import ndimage

from ..base import vtk
from ..flutter.march import March
from . import canvas
from .look import EVEN, STYLE
from .march import DEGREES, headline

WINDOW = (-0.5, 1.5, -0.75, 0.75)  # left, right, bottom, top [x/c, y/c]
FINER, SMOOTH = 4, 0.8  # the sonic line's grid is so much finer than the cells; values are averaged over so many of them


def save(march: March, path: Path, chord: float, elastic_axis: float) -> None:
    """A panel an instant of `march` into the PNG `path`.

    The files' origin is the elastic axis at rest; x/c of the picture counts from the leading edge at rest."""
    with canvas.rc_context(STYLE | {"axes.grid": False}):
        n = len(march.fields)
        rows = 2 if n > 1 else 1
        figure, axes = canvas.subplots(
            rows, -(-n // rows), figsize=(9.2, 6.3), squeeze=False, sharex=True, sharey=True, constrained_layout=True
        )
        fields = [vtk.read(file).scaled(chord, elastic_axis) for _, file in march.fields]
        low, high = limits(fields)
        for axis, field, (tau, _) in zip(axes.flat, fields, march.fields, strict=False):
            mesh = draw(axis, field, low, high)
            i = int(np.argmin(np.abs(march.tau - tau)))
            axis.set_title(
                f"cycle {tau / (2 * np.pi):.2f}{_phase(march, tau)}:  $\\alpha$ = {march.history['alpha'][i] * DEGREES:+.2f}°, "
                f"$h/b$ = {march.history['h_over_b'][i]:+.4f}",
                fontsize=9,
            )
            axis.set_xlim(*WINDOW[:2])
            axis.set_ylim(*WINDOW[2:])
            axis.set_aspect("equal")
            axis.xaxis.set_major_locator(MultipleLocator(0.5))
            axis.yaxis.set_major_locator(MultipleLocator(0.25))
        for axis in axes.flat[n:]:
            axis.set_visible(False)
        for axis in axes[-1]:
            axis.set_xlabel("chordwise place $x/c$ [–]")
        for axis in axes[:, 0]:
            axis.set_ylabel("height $y/c$ [–]")
        said = "local Mach number [–]" + (" (white line: 1)" if low < 1.0 < high else "")
        figure.colorbar(mesh, ax=axes, label=said, shrink=0.85, extend="min")
        figure.suptitle(headline(march), fontsize=10.5)
        figure.savefig(path)


def draw(axis: Axes, field: vtk.Field, low: float, high: float) -> QuadMesh:
    """One field (lengths in chords) with its sonic line and the section; the mesh of colours, for a scale."""
    mach = field.cells["mach"]
    mesh = axis.pcolormesh(field.x, field.y, mach, cmap=EVEN, vmin=low, vmax=high, rasterized=True)
    if low < 1.0 < high:
        axis.contour(*smooth(field), levels=[1.0], colors="white", linewidths=1.1)
    axis.fill(field.x[0], field.y[0], color="0.15", zorder=3)
    return mesh


def limits(fields: Sequence[vtk.Field]) -> tuple[float, float]:
    """Lowest and highest Mach number drawn: the few cells at the stagnation point would take half the colours."""
    seen = np.concatenate([f.cells["mach"][_window(f)] for f in fields])
    return float(np.percentile(seen, 1.0)), float(seen.max())


def smooth(field: vtk.Field) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """x, y and Mach number on a finer grid around the section, closed, the values averaged over neighbouring cells: the line of
    one value is then no staircase of cells. Shapes: about FINER times the cells each way."""
    cells = [0.25 * (p[1:, 1:] + p[:-1, 1:] + p[1:, :-1] + p[:-1, :-1]) for p in (field.x, field.y)]
    near = slice(0, max(4, int(np.argmax(np.hypot(cells[0] - 0.5, cells[1]).min(axis=1) > 3.0)) or cells[0].shape[0]))
    mach = ndimage.gaussian_filter(field.cells["mach"][near], SMOOTH, mode=("nearest", "wrap"))
    columns = mach.shape[1]
    rows = np.linspace(0.0, mach.shape[0] - 1.0, FINER * (mach.shape[0] - 1) + 1)
    around = np.linspace(0.0, columns, FINER * columns + 1)
    places = np.meshgrid(rows, around, indexing="ij")
    x, y, m = (
        ndimage.map_coordinates(np.pad(a, ((0, 0), (3, 4)), mode="wrap"), [places[0], places[1] + 3.0], order=1)
        for a in (cells[0][near], cells[1][near], mach)
    )
    return x, y, ndimage.gaussian_filter(m, SMOOTH * FINER / 2.0, mode=("nearest", "wrap"))


def _phase(march: March, tau: float) -> str:
    """Where an instant lies in the flutter mode's own cycle, counted from the first instant shown."""
    if march.fit is None or not march.fit.frequency:
        return ""
    degrees = np.degrees(march.fit.frequency * (tau - march.fields[0][0])) % 360.0
    return f", {round(degrees) % 360:d}° of the mode"


def _window(field: vtk.Field) -> np.ndarray:
    """Cells inside the picture. Shape: (nj, ni), bool."""
    x, y = field.x[:-1, :-1], field.y[:-1, :-1]
    return (x > WINDOW[0]) & (x < WINDOW[1]) & (np.abs(y) < WINDOW[3])
