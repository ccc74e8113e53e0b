"""Error bars of neutral V_f against the finest settings: other sections, Mach numbers and parameters than they were chosen on.

Two coarse linear models and one on the default mesh make the bar, as `aeroslosh boundary --method linear` does; a model on
240 x 72 cells with three quarters of the step, an outer boundary at 300 chords and a tenth of the tolerance is the truth.
17 minutes on one core."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.analysis.crossings import Crossing
from aeroslosh.master.boundary import companion
from aeroslosh.master.boundary.companion import Companion
from aeroslosh.master.case.case import Aero, Case
from aeroslosh.master.flutter.setup import FlutterSetup
from aeroslosh.master.linear import model as linear_model
from aeroslosh.master.linear.model import LinearCrossing, LinearModel

pytestmark = pytest.mark.validation

FLOWS = [  # airfoil, axis in half chords, Mach number
    ("NACA 64A010", -0.5, 0.6),
    ("NACA 64A010", -0.5, 0.7),
    ("NACA 64A010", -0.5, 0.8),
    ("NACA 64A004", 0.35, 0.3),
    ("NACA 64A004", 0.35, 0.85),
    ("NACA 0012", 0.4, 0.5),
    ("NACA 0012", 0.4, 0.75),
    ("NACA 2412", 0.3, 0.6),
    ("NACA 64A010", -0.5, 0.825),
    ("NACA 64A010", -0.5, 0.85),
    ("NACA 64A010", -0.5, 0.875),
    ("NACA 0012", 0.4, 0.8),
    ("NACA 2412", 0.3, 0.72),
]  # of the last five 0.825 and 0.875 were looked at when the rule of the neighbourhood was made, the others were not
SECTIONS = [  # x_alpha, r2_alpha, frequency ratio, mass ratio
    (1.8, 3.48, 1.0, 60.0),
    (0.25, 0.75, 1.0, 75.0),
    (0.2, 0.25, 0.5, 40.0),
    (0.1, 0.3, 0.8, 20.0),
    (0.3, 0.5, 1.2, 100.0),
    (0.2, 0.25, 0.5, 200.0),
]
FINEST = Aero(cells_around=240, cells_normal=72, farfield_chords=300.0, tolerance=1e-3)
RANGE = 0.1, 4.0


def of_section(model: LinearModel, values: tuple[float, float, float, float]) -> LinearModel:
    """The same flow carrying another section: its model does not know of the structure."""
    x_alpha, r2, ratio, mu = values
    section = dataclasses.replace(model.case.section, x_alpha=x_alpha, r2_alpha=r2, frequency_ratio=ratio, mass_ratio=mu)
    return dataclasses.replace(model, case=dataclasses.replace(model.case, section=section))


def same(c: LinearCrossing, fine: list[LinearCrossing]) -> LinearCrossing | None:
    """The crossing of the finest model that is `c`."""
    alike = [o for o in fine if (o.direction, o.kind) == (c.direction, c.kind)]
    near = min(alike, key=lambda o: abs(o.V_f - c.V_f), default=None)
    return near if near is not None and abs(near.V_f / c.V_f - 1.0) < 0.2 else None


def test_the_truth_is_inside_two_standard_deviations(fmu: Callable[[str], Path]) -> None:
    fmus = {name: fmu(name) for name in ("structure", "aero")}
    scores: list[float] = []
    changes: list[float] = []
    for airfoil, axis, mach in FLOWS:
        case = Case()
        case.flow.airfoil, case.flow.mach, case.section.elastic_axis = airfoil, mach, axis

        def opened(of: Case, at: float) -> FlutterSetup:
            return FlutterSetup(of, fmus, at)

        with opened(case, mach) as setup:
            own = linear_model.identify(setup, 1.0)
        beside = companion.identify(opened, own)
        assert beside is not None
        with opened(dataclasses.replace(case, aero=FINEST), mach) as setup:
            finest = linear_model.identify(setup, 1.0, step=0.75 * linear_model.STEP)
        for values in SECTIONS:
            model, coarse, half = (of_section(m, values) for m in (own, beside.coarse, beside.half))
            bars = Companion(model, coarse, half)
            fine = of_section(finest, values).crossings(*RANGE)
            for c in model.crossings(*RANGE):
                bare = Crossing(c.V_f, c.frequency, c.direction, c.slope, True, {"model": c.uncertainty})
                told = bars.widened(bare, c)
                truth = same(c, fine)
                name = f"{airfoil}, axis {axis:g}, Mach {mach:g}, {values}: {c.kind} {c.direction}"
                if truth is None or told.missing:
                    print(
                        f"{name} at {c.V_f:.4f}: {'no such crossing of the finest' if truth is None else told.missing}",
                        flush=True,
                    )
                    continue
                scores.append((truth.V_f - c.V_f) / told.uncertainty)
                changes.append(truth.V_f / c.V_f - 1.0)
                parts = ", ".join(f"{part} {100 * value / c.V_f:+.2f} %" for part, value in told.parts.items())
                print(
                    f"{name} {c.V_f:.4f}, truth {truth.V_f:.4f} ({100 * changes[-1]:+.2f} %), bar "
                    f"{100 * told.uncertainty / c.V_f:.2f} % ({parts}), z {scores[-1]:+.2f}",
                    flush=True,
                )
    z = np.abs(scores)
    inside = float(np.mean(z <= 2.0))
    print(
        f"{z.size} crossings, {100 * inside:.0f} % inside 2 sd, {100 * np.mean(z <= 1.0):.0f} % inside 1 sd, rms z "
        f"{np.sqrt(np.mean(z**2)):.2f}; V_f off by {100 * np.median(np.abs(changes)):.2f} % in the median, "
        f"{100 * np.max(np.abs(changes)):.2f} % at most"
    )
    assert z.size >= 40 and inside >= 0.9
    assert np.sqrt(np.mean(z**2)) > 0.3  # and no bar is an excuse
