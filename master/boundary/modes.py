"""Damping and frequency of every mode over V_f at one Mach number: the V–g and V–f curves of the linear model, with the marches
on them; as data, as a table, and as a picture.

Damping is g = 2 σ/ω, the structural damping that would make a mode neutral (negative: damped without it); of a real pole, which
has no ω, the growth rate alone is given."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

from ..case.scales import scales
from ..linear.model import BAND, LinearModel
from .search import BoundaryPoint

WIDE, ALIKE = 1.6, 1.35  # ratios of V_f, and of |eigenvalue| / V_f, by which the flow's own poles are told
QUICKLY_DAMPED = -0.8  # σ/ω_α: modes damped more than this everywhere are the flow's and the wake's own


def modes(model: LinearModel, low: float, high: float) -> list[dict[str, np.ndarray]]:
    """One entry a mode of section and flow: V_f, growth_rate, frequency (over omega_alpha) and damping g, each (n,).

    Oscillations at reduced frequencies that the model knows and that are not damped at once; last the largest real eigenvalue,
    where it comes near zero."""
    loci = model.loci(low, high)
    V_f, found = loci.parameters, []
    for j in loci.upper():
        e = loci.eigenvalues[:, j]
        shown = (e.imag > 1e-6) & (e.imag <= BAND * _rate(model, V_f))
        if shown.any() and e.real[shown].max() > QUICKLY_DAMPED and not _of_the_flow(V_f[shown], e[shown]):
            rate, frequency = np.where(shown, e.real, np.nan), np.where(shown, e.imag, np.nan)
            found.append({"V_f": V_f, "growth_rate": rate, "frequency": frequency, "damping": 2.0 * rate / frequency})
    real = loci.real(BAND * _rate(model, V_f))
    static = model.divergence()
    if low <= static <= high:
        nothing = np.full(V_f.size, np.nan)
        found.append({"V_f": V_f, "growth_rate": real, "frequency": np.where(np.isnan(real), np.nan, 0.0), "damping": nothing})
    return found


def _of_the_flow(V_f: np.ndarray, e: np.ndarray) -> bool:
    """Whether a damped locus `e` (n,) is of the flow alone, whose poles are constant per half chord: |e| goes as V_f."""
    per_chord = np.abs(e) / V_f
    wide = V_f[-1] > WIDE * V_f[0]
    return bool(wide and e.real.max() < -0.005 and per_chord.max() < ALIKE * per_chord.min())


def _rate(model: LinearModel, V_f: np.ndarray) -> np.ndarray:
    """U / (b omega_alpha): the frequency over omega_alpha at which the reduced frequency is 1. Shape: (n,)."""
    s = scales(model.case, model.mach, 1.0)
    return V_f * s.speed / (s.half_chord * s.omega_alpha)


def as_data(model: LinearModel, low: float, high: float) -> list[dict[str, Any]]:
    """`modes` as lists, None where a mode is not shown."""
    return [
        {name: [None if np.isnan(x) else float(x) for x in column] for name, column in mode.items()}
        for mode in modes(model, low, high)
    ]


def write(point: BoundaryPoint, low: float, high: float, path: Path) -> None:
    """The table: mode, V_f, growth_rate, frequency, damping, source (linear or march)."""
    model = point.linear
    rows: list[tuple[Any, ...]] = []
    for i, mode in enumerate(modes(model, low, high) if model is not None else []):
        columns = (mode["V_f"], mode["growth_rate"], mode["frequency"], mode["damping"])
        rows += [(i + 1, *(float(x) for x in row), "linear") for row in zip(*columns, strict=True) if not np.isnan(row[1])]
    for V_f, growth, frequency in marched(point):
        rows.append(("", V_f, growth, frequency, 2.0 * growth / frequency if frequency else float("nan"), "march"))
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(("mode", "V_f", "growth_rate", "frequency", "damping", "source"))
        writer.writerows(("" if isinstance(x, float) and np.isnan(x) else x for x in row) for row in rows)


def marched(point: BoundaryPoint) -> list[tuple[float, float, float]]:
    """(V_f, growth_rate, frequency) of every pole that a march shows clearly; of real ones (frequency 0) those that are slow."""
    found = []
    for march in point.marches:
        if march.fit is None or not march.settled:
            continue
        for mode in [*march.fit.modes, *march.fit.reals]:
            slow = mode.frequency > 0.0 or abs(mode.growth_rate) < 0.1
            if mode.share >= 0.05 and mode.growth_rate_std < 0.01 and slow:
                found.append((march.scales.V_f, mode.growth_rate, mode.frequency))
    return found
