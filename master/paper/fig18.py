"""Figure 18: modal masses, springs and frequencies of linear slosh, beside the paper's equations 17 and 20 as printed."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ...fmus.tank.liquid import Tank
from ...fmus.tank.modes import Modes, modes
from ..pictures import canvas, look
from .claims import Claim, within
from .outcome import Outcome, Table
from .tank import Array, tank
from .work import Work

COUNT = 8


def make(work: Work) -> Outcome:
    """The first eight modes."""
    box = tank(work)
    m = modes(box, COUNT)
    n = np.arange(1.0, COUNT + 1)
    omega = frequencies(box, n)
    mass, spring = printed_mass(box, n), printed_spring(box, n)
    share, stiff = m.mass / box.mass, m.stiffness / box.mass
    rows = [tuple(float(v) for v in row) for row in zip(n, m.omega, omega, share, mass, stiff, spring, strict=True)]
    header = (
        "mode", "omega [rad/s]", "omega, eq. 17 as printed [rad/s]", "mass/liquid", "mass/liquid, eq. 20a as printed",
        "K/liquid mass [1/s2]", "K/liquid mass, eq. 20b as printed [1/s2]",
    )  # fmt: skip
    remarks = [
        f"the first mode holds {share[0]:.2%} of the liquid, all eight {share.sum():.2%}; equation 20a as printed begins with "
        f"the second mode and has {mass[0]:.3%}, equation 20b a spring of {spring[0]:.1f} for {stiff[0]:.2f} 1/s²",
    ]
    conditions = [
        "tank of 0.5 x 0.15 m, depth 0.075 m, g = 9.81 m/s², as the paper has it; its own curves cannot be read from the "
        "text, so its equations are held against the conditions that it derives them from",
    ]
    claims = judged(m, box, mass, spring)
    return Outcome(claims, conditions, {"modes": Table(header, rows)}, lambda: draw(n, m, box), remarks)


def judged(m: Modes, box: Tank, mass: Array, spring: Array) -> list[Claim]:
    """Equations 17 and 20 as printed, against ours and the paper's own K = m omega²."""
    omega = frequencies(box, np.arange(1.0, len(m.omega) + 1))
    why = "2n + 1 with n = 1 skips the first mode, and the tank's height stands for the depth"
    root = math.sqrt(spring[0] / mass[0])
    return [
        within("first natural frequency by equation 17 [rad/s]", "equation 17", float(omega[0]), float(m.omega[0]), 1e-3),
        within("eighth", "equation 17", float(omega[-1]), float(m.omega[-1]), 1e-3),
        within("first modal mass over the liquid's by equation 20a", "equation 20a", float(mass[0]), float(m.mass[0] / box.mass),
               0.01 * float(mass[0]), why),
        within("frequency that the printed K_1 and m_1 give [rad/s]", "equations 20a, b; K = m ω²", root, float(m.omega[0]), 0.05,
               "20b also lacks π² and the square of tanh"),
    ]  # fmt: skip


def frequencies(box: Tank, n: Array) -> Array:
    """Equation 17, as printed [rad/s]."""
    q = (2 * n - 1) * math.pi / box.length
    return np.sqrt(q * box.gravity * np.tanh(q * box.depth))


def printed_mass(box: Tank, n: Array) -> Array:
    """Equation 20a, as printed: h is the tank's height there."""
    q = 2 * n + 1
    return np.asarray(8 / math.pi**3 * np.tanh(q * math.pi * box.depth / box.length) / (q**3 * box.height / box.length))


def printed_spring(box: Tank, n: Array) -> Array:
    """Equation 20b, as printed, over the liquid's mass [1/s²]."""
    q = 2 * n + 1
    return np.asarray(box.gravity / box.depth * 8 * np.tanh(q * math.pi * box.depth / box.length) / q**2)


def draw(n: Array, m: Modes, box: Tank) -> Any:
    """Three panels as in the paper."""
    figure, axes = canvas.subplots(1, 3, figsize=(11, 4.2), layout="constrained")
    curves = (
        ("(a) modal mass", m.mass / m.mass[0], printed_mass(box, n) / printed_mass(box, n)[0], "mass over the first's [–]"),
        ("(b) spring", m.stiffness / box.mass, printed_spring(box, n), "spring over the liquid's mass [1/s²]"),
        ("(c) natural frequency", m.omega, frequencies(box, n), "frequency [rad/s]"),
    )
    for axis, (title, ours, printed, label) in zip(axes, curves, strict=True):
        axis.plot(n, ours, "o-", color=look.BLUE, mfc="none", label="potential theory (ours)")
        axis.plot(n, printed, "x--", color=look.ORANGE, label="equations 17 and 20 as printed")
        axis.set(title=title, xlabel="mode [–]", ylabel=label, yscale="log" if label != "frequency [rad/s]" else "linear")
    figure.suptitle("Fig. 18: linear slosh, tank of 0.5 x 0.15 m half full", fontsize=11)
    canvas.legend(figure, axes[0])
    return figure
