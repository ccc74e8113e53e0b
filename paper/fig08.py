"""Figure 8: the paper's excitation signals: white noise, APRBS, its level changes, and their spectra.

`python -m paper.fig08 [picture.png]`. Signals of 0.02 s a sample as in the paper's runs; it does not tell its N, here 2 (a hold
of 0.04 s, near half a period of 100 rad/s). Spectra are averages (Welch) over a long record; thin lines are theory: holding for N
samples gives a sinc², keeping a level with probability p the factor (1 − p²)/(1 − 2 p cos(omega T) + p²), T the hold.
"""

from __future__ import annotations

import functools
import sys
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from aeroslosh.fmus.slosh_rbf.training.excitation import aprbs, aprbs_raw
from aeroslosh.fmus.slosh_rbf.training.signals import instants

Array = NDArray[np.float64]
SAMPLE, HOLD, SEED = 0.02, 2, 8
PITCH = 100.0  # frequency of the section in pitch [rad/s]
SHOWN, LONG = 4.0, 4000.0  # length of the courses shown and of the records behind the spectra [s]
FINE, SMOOTH_LONG = 2e-3, 60.0  # step and length of the band-limited record [s]
KEEPS = (0.0, 0.25, 0.5, 0.75)


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


def theory(omega: Array, hold: int, keep: float) -> Array:
    """The same of a sampled signal held for `hold` samples and kept with probability `keep` [s/rad]."""
    half = 0.5 * omega * SAMPLE
    held = (np.sin(hold * half) / np.sin(half)) ** 2 / hold
    return held * (1.0 - keep**2) / (1.0 - 2.0 * keep * np.cos(omega * hold * SAMPLE) + keep**2) * SAMPLE / np.pi


def main() -> None:
    """Print where the energy is, and draw the picture."""
    for name, (omega, power) in {
        "white noise": density(signal(1, 0.0, LONG)[1]),
        "APRBS": density(signal(HOLD, 0.0, LONG)[1]),
        "APRBS, levels kept with 0.5": density(signal(HOLD, 0.5, LONG)[1]),
        "band-limited APRBS, position": density(smooth()[:, 0], FINE),
        "band-limited APRBS, acceleration": density(smooth()[:, 2], FINE),
    }.items():
        parts = [np.sum(power[(omega >= a) & (omega < b)]) / np.sum(power) for a, b in ((0, 35), (35, 105), (105, 1e9))]
        print(f"{name}: {parts[0]:.1%} below 35 rad/s, {parts[1]:.1%} from 35 to 105, {parts[2]:.1%} above")
    if len(sys.argv) > 1:
        draw(Path(sys.argv[1]))


def draw(path: Path) -> None:
    """Four panels as in the paper."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    figure, ((a, b), (c, d)) = plt.subplots(2, 2, figsize=(10.5, 6.6), layout="constrained")
    a.plot(*signal(1, 0.0, SHOWN), "C7", lw=1)
    a.set(title="(a) white noise, normalised", xlabel="time [s]", ylabel="u")
    for name, hold, keep, colour in (("white noise", 1, 0.0, "C7"), (f"APRBS, N = {HOLD}", HOLD, 0.0, "C0")):
        omega, power = density(signal(hold, keep, LONG)[1])
        b.semilogy(omega, power, colour, lw=1.5, label=name)
        b.semilogy(omega, theory(omega, hold, keep), "k", lw=0.6)
    b.set(title="(b) power spectral density", ylabel="PSD of unit variance [s/rad]", ylim=(1e-5, 3e-2))
    c.step(*signal(HOLD, 0.0, SHOWN), "C0", lw=0.6, alpha=0.6, where="post", label="every level new")
    c.step(*signal(HOLD, 0.5, SHOWN), "C3", lw=1.2, where="post", label="kept with probability 0.5")
    c.set(title="(c) APRBS with level change", xlabel="time [s]", ylabel="u")
    for k, keep in enumerate(KEEPS):
        omega, power = density(signal(HOLD, keep, LONG)[1])
        d.plot(omega, np.sqrt(power), f"C{k}", lw=1.5, label=f"kept with probability {keep:g}")
        d.plot(omega, np.sqrt(theory(omega, HOLD, keep)), "k", lw=0.6)
    omega, power = density(smooth()[:, 0], FINE)
    d.plot(omega, np.sqrt(power), "C4--", lw=1.5, label="ours, 35 to 105 rad/s")
    d.set(title="(d) amplitude over frequency", ylabel="√PSD", ylim=(0.0, None))
    for axis in (b, d):
        axis.axvline(PITCH, color="0.6", lw=1, ls=":")
        axis.set(xlabel="frequency [rad/s] (dotted: pitch)", xlim=(0.0, np.pi / SAMPLE))
    for axis in (b, c, d):
        axis.legend(fontsize=8)
    for axis in (a, b, c, d):
        axis.grid(alpha=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)
    print(f"picture: {path}")


if __name__ == "__main__":
    main()
