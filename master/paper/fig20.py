"""Figure 20: amplitude of the lateral force over the forcing frequency, linear potential flow and the slosh_ems FMU."""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np

from ...fmus.tank.modes import modes
from ...fmus.tank.potential import harmonic_load
from ..pictures import canvas, look
from .claims import Claim, within
from .outcome import Outcome, Table
from .tank import Array, amplitude, driven, tank
from .work import Work

PSI = np.radians(1.0)  # amplitude of the pitch
LOWEST, HIGHEST, COUNT = 0.5, 30.0, 4000  # [rad/s]
TRIED = (2.0, 4.0, 7.5, 9.0, 15.0, 19.0, 25.0)  # frequencies at which the FMU is driven [rad/s]
SHOWN = 4  # natural frequencies in the picture


def make(work: Work) -> Outcome:
    """The closed form, its peaks, and the FMU beside it."""
    box = tank(work)
    omega = np.linspace(LOWEST, HIGHEST, COUNT)
    force = np.array([abs(harmonic_load(box, float(w), alpha=float(PSI))[0]) for w in omega])
    natural = modes(box, SHOWN).omega
    found = spikes(omega, force, natural)
    fmu = [(w, driven_force(work, w), abs(harmonic_load(box, w, alpha=float(PSI))[0])) for w in work.pick(TRIED, TRIED[:2])]
    conditions = [
        f"pitch of 1° about the tank's centre, force in inertial axes (equation 18a); {COUNT} frequencies of the closed form "
        "(equation 18a corrected: the depth for h), and slosh_ems driven for 40 periods with its damping of 0.005 at some",
    ]
    apart = max(abs(got / exact - 1.0) for _, got, exact in fmu)
    remarks = [f"slosh_ems.fmu lies within {apart:.1%} of the closed form at {len(fmu)} frequencies off resonance"]
    rows = [tuple(float(v) for v in row) for row in zip(omega, force, strict=True)]
    tables = {
        "force": Table(("frequency [rad/s]", "force [N/m]"), rows),
        "fmu": Table(("frequency [rad/s]", "slosh_ems [N/m]", "closed form [N/m]"), fmu),
    }
    claims = [judged(k + 1, float(natural[k]), found[k], omega[1] - omega[0]) for k in range(len(found))]
    return Outcome(claims, conditions, tables, lambda: draw(omega, force, natural, fmu), remarks)


def driven_force(work: Work, frequency: float) -> float:
    """Amplitude of the FMU's answer at the forcing frequency [N/m]: what is left of the start has other frequencies."""
    loads = driven(work, "slosh_ems", frequency, 40, alpha=float(PSI))
    half = loads.time >= 20.0 * 2.0 * np.pi / frequency
    t, y = loads.time[half], loads.aft[half]
    sides = np.stack([np.sin(frequency * t), np.cos(frequency * t), np.ones_like(t)], axis=1)
    fitted = np.linalg.lstsq(sides, y, rcond=None)[0]
    return amplitude(sides[:, :2] @ fitted[:2])


def spikes(omega: Array, force: Array, natural: Array) -> list[float]:
    """The highest force near each natural frequency: where it lies [rad/s]."""
    edges = np.concatenate([[omega[0]], 0.5 * (natural[1:] + natural[:-1]), [natural[-1] + 1.5]])
    places = []
    for low, high in itertools.pairwise(edges):
        inside = np.flatnonzero((omega >= low) & (omega < high))
        places.append(float(omega[inside[np.argmax(force[inside])]]))
    return places


def judged(number: int, natural: float, spike: float, step: float) -> Claim:
    """The force spikes at a natural frequency, to a step of the frequencies looked at."""
    what = f"spike of the force at natural frequency {number} [rad/s]"
    return within(what, "section IV E, Fig. 20", natural, spike, 1.01 * float(step))


def draw(omega: Array, force: Array, natural: Array, fmu: list[tuple[float, float, float]]) -> Any:
    """Force over frequency, in logarithms."""
    figure, axis = canvas.subplots(figsize=(8.0, 5.0), layout="constrained")
    axis.semilogy(omega, force, color=look.BLUE, label="linear potential flow")
    axis.semilogy([w for w, _, _ in fmu], [f for _, f, _ in fmu], "o", color=look.ORANGE, mfc="none", label="slosh_ems driven")
    for k, w in enumerate(natural):
        axis.axvline(float(w), color=look.GREY, lw=0.9, ls=":", label="natural frequencies" if k == 0 else None)
    axis.set(xlabel="forcing frequency [rad/s]", ylabel="amplitude of the lateral force [N/m]")
    figure.suptitle("Fig. 20: pitch of 1°, half-full tank, linear slosh", fontsize=11)
    canvas.legend(figure, axis)
    return figure
