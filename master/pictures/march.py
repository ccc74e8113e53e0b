"""Pictures of a run: histories with the fitted envelope, phase plot, Mach field at four instants."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ..base import vtk
from ..base.wording import plus_minus
from ..case.fuel_tank import LABEL
from ..flutter.march import March
from ..results import trust
from . import canvas as plt

BLUE, RED, GREY, GREEN = "#1f5fa8", "#c0392b", "#7a7a7a", "#2e8b57"
STYLE: dict[Any, Any] = {
    "font.size": 10,
    "axes.labelsize": 10.5,
    "axes.titlesize": 11,
    "legend.fontsize": 9,
    "figure.dpi": 150,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.alpha": 0.25,
    "lines.linewidth": 1.3,
    "savefig.bbox": "tight",
    "legend.frameon": False,
    "axes.axisbelow": True,
}
DEGREES = 180.0 / np.pi


def headline(march: March) -> str:
    """Mach, V_f, verdict, growth rate and frequency in one line."""
    s, fit = march.scales, march.fit
    liquid = f", {LABEL[march.slosh]}" if march.slosh != "none" else ""
    text = f"Mach {s.mach:g}, $V_f$ = {s.V_f:.4g}{liquid}: {trust.verdict(march)}"
    if not trust.stands(march):
        text += f" (slosh model does not hold; the motion: {march.verdict})\n"
    if fit is None:
        return text
    return text + (
        f"   $\\sigma/\\omega_\\alpha$ = {plus_minus(fit.growth_rate, fit.growth_rate_uncertainty)}, "
        f"$\\omega/\\omega_\\alpha$ = {fit.frequency:.4f}"
    )


def histories(march: March, path: Path) -> None:
    """h/b and alpha over cycles, forced part shaded, with the fit and the flutter mode's envelope."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(2, 1, figsize=(8.0, 5.0), sharex=True)
        cycles = march.tau / (2.0 * np.pi)
        data = (
            (march.history["h_over_b"], "plunge $h/b$"),
            (march.history["alpha"] * DEGREES, "pitch $\\alpha$ [°]"),
        )
        for c, (axis, (values, label)) in enumerate(zip(axes, data, strict=True)):
            axis.plot(cycles, values, color=BLUE, label="computed")
            axis.set_ylabel(label)
            if march.release:
                axis.axvspan(0.0, cycles[min(march.release, cycles.size - 1)], color=GREY, alpha=0.12, lw=0)
            if march.fit is not None:
                tau = march.tau[march.tau >= march.fit.start - 1e-9]
                scale = DEGREES if c else 1.0
                middle, size = march.fit.constants[c], march.fit.envelope(tau)[c]
                axis.plot(
                    tau / (2 * np.pi),
                    scale * march.fit.curve(tau)[c],
                    color=RED,
                    lw=0.9,
                    ls=(0, (4, 2)),
                    label="fit",
                )
                for sign in (-1.0, 1.0):
                    axis.plot(
                        tau / (2 * np.pi),
                        scale * (middle + sign * size),
                        color=RED,
                        lw=0.8,
                        alpha=0.7,
                        label="envelope of the flutter mode" if sign > 0 else None,
                    )
        if march.release:
            axes[0].text(
                0.5 * cycles[min(march.release, cycles.size - 1)],
                1.02,
                "forced",
                transform=axes[0].get_xaxis_transform(),
                ha="center",
                color=GREY,
                fontsize=9,
            )
        axes[0].legend(loc="upper left", ncols=3)
        low, high = axes[0].get_ylim()
        axes[0].set_ylim(low, high + 0.18 * (high - low))  # room for the legend
        axes[1].set_xlabel("cycles $\\omega_\\alpha t / 2\\pi$")
        axes[1].set_xlim(0.0, cycles[-1] if cycles[-1] > 0 else 1.0)
        figure.suptitle(headline(march), fontsize=11)
        figure.savefig(path)


def phase(march: March, path: Path) -> None:
    """Pitch against its rate, and against plunge; the free part coloured by time."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(8.6, 4.0), constrained_layout=True)
        h, alpha = march.history["h_over_b"], march.history["alpha"] * DEGREES
        rate = march.history["alpha_dot"] * DEGREES / march.scales.omega_alpha
        r = min(march.release, h.size - 1)
        points = None
        pairs = (
            (alpha, rate, "pitch $\\alpha$ [°]", "pitch rate $\\dot\\alpha/\\omega_\\alpha$ [°]"),
            (h, alpha, "plunge $h/b$", "pitch $\\alpha$ [°]"),
        )
        for axis, (x, y, x_label, y_label) in zip(axes, pairs, strict=True):
            axis.plot(x[: r + 1], y[: r + 1], color=GREY, lw=0.8, label="forced")
            axis.plot(x[r:], y[r:], color=BLUE, lw=0.5, alpha=0.5)
            points = axis.scatter(x[r:], y[r:], c=march.tau[r:] / (2.0 * np.pi), s=6, cmap="viridis", zorder=3)
            axis.plot(x[r], y[r], "o", color=RED, ms=5, label="release", zorder=4)
            axis.set_xlabel(x_label)
            axis.set_ylabel(y_label)
        axes[0].legend(loc="upper right")
        if points is not None:
            figure.colorbar(points, ax=axes, label="cycles", pad=0.02)
        figure.suptitle(headline(march), fontsize=10.5)
        figure.savefig(path)


def mach_field(march: March, path: Path, chord: float, elastic_axis: float) -> None:
    """Mach number about the airfoil at the recorded instants (four), with the sonic line.

    The files' origin is the elastic axis at rest; x/c of the picture counts from the leading edge at rest."""
    with plt.rc_context(STYLE | {"axes.grid": False}):
        n = len(march.fields)
        figure, axes = plt.subplots(
            2,
            (n + 1) // 2,
            figsize=(9.2, 6.0),
            squeeze=False,
            sharex=True,
            sharey=True,
            constrained_layout=True,
        )
        fields = [vtk.read(file).scaled(chord, elastic_axis) for _, file in march.fields]
        seen = np.concatenate([f.cells["mach"][_window(f)] for f in fields])
        # the few cells at the stagnation point would take half the colours
        low, high = float(np.percentile(seen, 1.0)), float(seen.max())
        mesh = None
        for axis, field, (tau, _) in zip(axes.flat, fields, march.fields, strict=False):
            mach = field.cells["mach"]
            mesh = axis.pcolormesh(field.x, field.y, mach, cmap="turbo", vmin=low, vmax=high, rasterized=True)
            x, y = (0.25 * (p[1:, 1:] + p[:-1, 1:] + p[1:, :-1] + p[:-1, :-1]) for p in (field.x, field.y))
            if low < 1.0 < high:  # closed around the O-mesh by repeating the first column
                closed = [np.hstack([a, a[:, :1]]) for a in (x, y, mach)]
                axis.contour(*closed, levels=[1.0], colors="white", linewidths=0.9)
            axis.fill(field.x[0], field.y[0], color="0.15", zorder=3)
            i = int(np.argmin(np.abs(march.tau - tau)))
            axis.set_title(
                f"cycle {tau / (2 * np.pi):.2f}:  $\\alpha$ = {march.history['alpha'][i] * DEGREES:+.2f}°, "
                f"$h/b$ = {march.history['h_over_b'][i]:+.4f}",
                fontsize=9.5,
            )
            axis.set_xlim(-0.5, 1.5)
            axis.set_ylim(-0.75, 0.75)
            axis.set_aspect("equal")
        for axis in axes.flat[n:]:
            axis.set_visible(False)
        for axis in axes[-1]:
            axis.set_xlabel("$x/c$")
        for axis in axes[:, 0]:
            axis.set_ylabel("$y/c$")
        if mesh is not None:
            figure.colorbar(mesh, ax=axes, label="Mach number (white line: sonic)", shrink=0.85, extend="min")
        figure.suptitle(headline(march), fontsize=10.5)
        figure.savefig(path)


def _window(field: vtk.Field) -> np.ndarray:
    """Cells inside the picture. Shape: (nj, ni), bool."""
    x, y = field.x[:-1, :-1], field.y[:-1, :-1]
    return (x > -0.5) & (x < 1.5) & (np.abs(y) < 0.75)
