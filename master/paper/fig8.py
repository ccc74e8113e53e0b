"""Figure 8: the paper's excitation signals: white noise, APRBS, its level changes, and their spectra.

Spectra are averages (Welch) over a long record; thin lines are theory: holding for N samples gives a sinc², keeping a level with
probability p the factor (1 − p²)/(1 − 2 p cos(omega T) + p²), T the hold."""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from ...fmus.slosh_rbf.training.excitation import aprbs, aprbs_raw
from ...fmus.slosh_rbf.training.signals import instants
from ..pictures import canvas, look
from .claims import Claim, at_most
from .outcome import Outcome, Table
from .work import Work

Array = NDArray[np.float64]
SAMPLE, HOLD, SEED = 0.02, 2, 8
PITCH = 100.0  # frequency of the section in pitch [rad/s]
SHOWN, LONG, SHORT = 4.0, 4000.0, 400.0  # length of the courses shown and of the records behind the spectra [s]
FINE, SMOOTH_LONG = 2e-3, 60.0  # step and length of the band-limited record [s]
KEEPS = (0.0, 0.25, 0.5, 0.75)
COLOURS = (look.BLUE, look.SKY, look.ORANGE, look.PURPLE)
SOURCE = "section III B, Fig. 8"


def make(work: Work) -> Outcome:
    """Signals, spectra, where their energy is."""
    long = work.pick(LONG, SHORT)
    spectra = {f"p{keep:g}": density(signal(HOLD, keep, long)[1]) for keep in KEEPS}
    spectra |= {"white": density(signal(1, 0.0, long)[1]), "smooth": density(smooth()[:, 0], FINE)}
    above = {name: share(*found, PITCH) for name, found in spectra.items()}
    claims = judged(above)
    low = {name: 1.0 - share(*found, 35.0) for name, found in spectra.items()}
    remarks = [
        f"energy below 35 rad/s: white noise {low['white']:.0%}, APRBS {low['p0']:.0%}, levels kept with 0.5 "
        f"{low['p0.5']:.0%}; the band-limited signal that our own surrogate is trained on: {low['smooth']:.0%}"
    ]
    conditions = [
        f"N = {HOLD} samples of {SAMPLE:g} s (the paper does not tell N; half a period of 100 rad/s is 0.031 s), normal "
        f"levels, seed {SEED}; spectra of {long:g} s"
    ]
    rows = [(name, float(w), float(p)) for name, (omega, power) in spectra.items() for w, p in zip(omega, power, strict=True)]
    tables = {"spectra": Table(("signal", "frequency [rad/s]", "PSD of unit variance [s/rad]"), rows)}
    return Outcome(claims, conditions, tables, lambda: draw(spectra), remarks)


def judged(above: dict[str, float]) -> list[Claim]:
    """Shares of the energy above the pitch frequency, by signal: held against what the paper says of them."""
    what = "APRBS cuts off high frequencies: share of its energy above 100 rad/s, against white noise"
    claims = [at_most(what, SOURCE + " (b)", above["white"], above["p0"])]
    for k, keep in enumerate(KEEPS[1:], start=1):
        words = f"the level change tunes the frequencies: share above 100 rad/s, kept with {keep:g}, against {KEEPS[k - 1]:g}"
        claims.append(at_most(words, SOURCE + " (d)", above[f"p{KEEPS[k - 1]:g}"], above[f"p{keep:g}"]))
    return claims


def signal(hold: int, keep: float, duration: float) -> tuple[Array, Array]:
    """Times (n,) [s] and a raw APRBS of peak 1; hold 1 and keep 0 are white noise."""
    motion = aprbs_raw(SEED, instants(duration, SAMPLE), h=1.0, sample=SAMPLE, hold=hold, keep=keep)
    return motion.times, motion.motions[:, 0]


@functools.cache
def smooth() -> Array:
    """Motions (n, 9) of a band-limited APRBS in plunge."""
    return aprbs(SEED, instants(SMOOTH_LONG, FINE), h=1.0).motions


def density(values: Array, step: float = SAMPLE) -> tuple[Array, Array]:
    """Frequencies [rad/s] and power spectral density of values of unit variance [s/rad]."""
    f, power = welch(values / values.std(), 1.0 / step, nperseg=512)
    return 2.0 * np.pi * f[1:], power[1:] / (2.0 * np.pi)


def share(omega: Array, power: Array, least: float) -> float:
    """The part of the energy at frequencies from `least` [rad/s] on."""
    return float(np.sum(power[omega >= least]) / np.sum(power))


def theory(omega: Array, hold: int, keep: float) -> Array:
    """PSD of a sampled signal held for `hold` samples and kept with probability `keep` [s/rad]."""
    half = 0.5 * omega * SAMPLE
    held = (np.sin(hold * half) / np.sin(half)) ** 2 / hold
    return held * (1.0 - keep**2) / (1.0 - 2.0 * keep * np.cos(omega * hold * SAMPLE) + keep**2) * SAMPLE / np.pi


def draw(spectra: dict[str, tuple[Array, Array]]) -> Any:
    """Four panels as in the paper."""
    figure, ((a, b), (c, d)) = canvas.subplots(2, 2, figsize=(10.5, 7.2), layout="constrained")
    a.plot(*signal(1, 0.0, SHOWN), color=look.GREY, lw=1)
    a.set(title="(a) white noise, normalised", xlabel="time [s]", ylabel="signal [–]")
    for name, hold, key, colour in (("white noise", 1, "white", look.GREY), (f"APRBS, N = {HOLD}", HOLD, "p0", look.BLUE)):
        omega, power = spectra[key]
        b.semilogy(omega, power, color=colour, lw=1.6, label=name)
        b.semilogy(omega, theory(omega, hold, 0.0), color=look.INK, lw=0.8, ls=":", label="theory")
    b.set(title="(b) power spectral density", ylabel="PSD of unit variance [s/rad]", ylim=(1e-5, 3e-2))
    c.step(*signal(HOLD, 0.0, SHOWN), color=look.SKY, lw=0.8, where="post", label="every level new")
    c.step(*signal(HOLD, 0.5, SHOWN), color=look.ORANGE, lw=1.2, where="post", label="kept with probability 0.5")
    c.set(title="(c) APRBS with level change", xlabel="time [s]", ylabel="signal [–]")
    for keep, colour in zip(KEEPS, COLOURS, strict=True):
        omega, power = spectra[f"p{keep:g}"]
        d.plot(omega, np.sqrt(power), color=colour, lw=1.5, label=f"kept with probability {keep:g}")
        d.plot(omega, np.sqrt(theory(omega, HOLD, keep)), color=look.INK, lw=0.8, ls=":", label="theory")
    omega, power = spectra["smooth"]
    d.plot(omega, np.sqrt(power), color=look.INK, ls="--", lw=1.5, label="ours, 35 to 105 rad/s")
    d.set(title="(d) amplitude over frequency", ylabel="root of the PSD [√(s/rad)]", ylim=(0.0, None))
    for axis in (b, d):
        axis.axvline(PITCH, color=look.GREY, lw=1, ls=":")
        axis.set(xlabel="frequency [rad/s] (dotted: pitch, 100)", xlim=(0.0, np.pi / SAMPLE))
    figure.suptitle("Fig. 8: excitation of the surrogate, samples of 0.02 s", fontsize=11)
    canvas.legend(figure, b, c, d, columns=4)
    return figure
