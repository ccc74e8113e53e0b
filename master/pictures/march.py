"""Pictures of a march: histories with the fitted envelope, phase plot."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.ticker import MaxNLocator

from ..base.wording import plus_minus
from ..case.fuel_tank import LABEL
from ..flutter.march import March
from ..results import trust
from . import canvas as plt
from .look import BLUE, EVEN, GREY, STYLE
from .look import ORANGE as RED

DEGREES = 180.0 / np.pi


def headline(march: March) -> str:
    """Model, Mach, V_f, verdict, growth rate and frequency in one line."""
    s, fit = march.scales, march.fit
    text = f"{LABEL[march.slosh]}, Mach {s.mach:g}, $V_f$ = {s.V_f:.4g}: {trust.verdict(march)}"
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
        figure, axes = plt.subplots(2, 1, figsize=(8.0, 5.4), sharex=True, constrained_layout=True)
        cycles = march.tau / (2.0 * np.pi)
        data = (
            (march.history["h_over_b"], "plunge $h/b$, down [–]"),
            (march.history["alpha"] * DEGREES, "pitch $\\alpha$, nose-up [deg]"),
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
                    lw=1.4,
                    ls=(0, (2, 5)),  # lies on the computed line, which must be seen between
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
        plt.legend(figure, axes[0])
        axes[1].set_xlabel("cycles $\\omega_\\alpha t / 2\\pi$ [–]")
        axes[1].set_xlim(0.0, cycles[-1] if cycles[-1] > 0 else 1.0)
        figure.suptitle(headline(march), fontsize=11)
        figure.savefig(path)


def phase(march: March, path: Path) -> None:
    """Pitch against its rate, and against plunge; the free part coloured by time."""
    with plt.rc_context(STYLE):
        figure, axes = plt.subplots(1, 2, figsize=(8.6, 4.4), constrained_layout=True)
        h, alpha = march.history["h_over_b"], march.history["alpha"] * DEGREES
        rate = march.history["alpha_dot"] * DEGREES / march.scales.omega_alpha
        r = min(march.release, h.size - 1)
        points = None
        pairs = (
            (alpha, rate, "pitch $\\alpha$, nose-up [deg]", "pitch rate $\\dot\\alpha/\\omega_\\alpha$ [deg]"),
            (h, alpha, "plunge $h/b$, down [–]", "pitch $\\alpha$, nose-up [deg]"),
        )
        for axis, (x, y, x_label, y_label) in zip(axes, pairs, strict=True):
            axis.plot(x[: r + 1], y[: r + 1], color=GREY, lw=0.8, label="forced")
            axis.plot(x[r:], y[r:], color=BLUE, lw=0.5, alpha=0.5)
            points = axis.scatter(x[r:], y[r:], c=march.tau[r:] / (2.0 * np.pi), s=6, cmap=EVEN, zorder=3)
            axis.plot(x[r], y[r], "o", color=RED, ms=5, label="release", zorder=4)
            axis.set_xlabel(x_label)
            axis.xaxis.set_major_locator(MaxNLocator(5))
            axis.set_ylabel(y_label)
        plt.legend(figure, axes[0])
        if points is not None:
            figure.colorbar(points, ax=axes, label="cycles $\\omega_\\alpha t / 2\\pi$ [–]", pad=0.02)
        figure.suptitle(headline(march), fontsize=10.5)
        figure.savefig(path)
