"""The paper's section with fuel whose waves come to the frequency of flutter, in linear subsonic flow.

The preset four times as large (chord 8 m), gravity raised: the same ratio of masses, waves faster beside the section. `-s` prints
the table of docs/does-slosh-matter.md. Closest to resonance (gravity 100) there is no root near the frozen fuel's."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest

from aeroslosh.fmus.tank.liquid import Tank
from aeroslosh.fmus.tank.modes import modes
from aeroslosh.fmus.tank.potential import harmonic_load
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.scales import scales
from support import possio
from support.paths import CASES

MACH, SIZE, GUESSES = 0.8, 4.0, (1.285, 1.2, 1.35)
GRAVITIES = (9.81, 60.0, 90.0, 110.0, 145.0, 400.0)
CASE = cases.load(CASES / "paper_s.toml", [f"section.chord={2 * SIZE}", f"flow.mach={MACH}"])


def tank(gravity: float) -> Tank:
    """The preset's, four times as large."""
    return Tank(0.5 * SIZE, 0.15 * SIZE, x=1.8 * SIZE, density=800.0, gravity=gravity)


def frozen(box: Tank) -> Callable[[float], np.ndarray]:
    """Dynamic stiffness of the frozen liquid in (h, alpha)."""
    mass = np.array([[box.mass, box.static_moment], [box.static_moment, box.inertia]])
    return lambda omega: np.diag([0.0, box.stiffness]) - omega**2 * mass


def sloshing(box: Tank) -> Callable[[float], np.ndarray]:
    """The same of linear slosh, undamped, all modes."""

    def of(omega: float) -> np.ndarray:
        columns = [harmonic_load(box, abs(omega), h=1.0), harmonic_load(box, abs(omega), alpha=1.0)]
        return np.array([[force for _, force, _ in columns], [-moment for _, _, moment in columns]])

    return of


def neutral(liquid: Callable[[float], np.ndarray]) -> float:
    """The neutral V_f nearest to frozen fuel's; nan where none is found."""
    for guess in GUESSES:
        try:
            return possio.neutral(CASE, MACH, liquid, guess, (1.2, 1.1, 1.3, 1.0, 1.4))
        except AssertionError:
            continue
    return math.nan


def test_far_below_flutter_waves_do_nothing_and_near_it_a_few_percent() -> None:
    changes = {}
    for gravity in GRAVITIES:
        box = tank(gravity)
        still, moving = neutral(frozen(box)), neutral(sloshing(box))
        ratio = float(modes(box, 1).omega[0]) / scales(CASE, MACH, still).omega_alpha
        changes[gravity] = 100.0 * (moving / still - 1.0)
        told = f"frozen {still:.4f}, slosh {moving:.4f} ({changes[gravity]:+.2f} %)"
        print(f"  gravity {gravity:5.4g}: first wave {ratio:.2f} omega_alpha, {told}")
    assert abs(changes[9.81]) < 0.02
    assert all(math.isfinite(change) for change in changes.values())
    assert 1.0 < max(map(abs, changes.values())) < 4.0


def test_the_stiffness_of_sloshing_fuel_is_that_of_frozen_fuel_at_once() -> None:
    """Plunge moves no surface of a level tank: its column is the frozen one's."""
    box = tank(9.81)
    np.testing.assert_allclose(sloshing(box)(8.0)[:, 0], frozen(box)(8.0)[:, 0], rtol=1e-9)
    assert sloshing(box)(8.0)[1, 1] == pytest.approx(frozen(box)(8.0)[1, 1], rel=0.01)
