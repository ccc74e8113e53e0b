"""The standard plan: which records a network of a tank is trained, chosen and tested on.

split        records
train        60 of 4 s, D from 0.05 to 2 in equal ratios within each kind
validation   10 of 4 s, the same kinds with other seeds
test         36: sinusoids of 2 s (plunge, pitch, both; 50 and 90 rad/s; D 0.3, 0.7, 1), growing and decaying, released, other
             seeds of the others
breakup      10 with D from 1.5 to 4, where the surface breaks and loads can be told on average alone
Each of test and breakup is there on a second, finer grid too (name + "_fine"): no surrogate can be better than its teacher.
Where a tank sits in a wing matters to its motion, not to its liquid: records are made with the tank's centre on the axis.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ...tank.liquid import Tank
from .dataset import Planned
from .excitation import HIGH, LOW, Mode, Motion, aprbs, burst, carried, chirp, multisine, released, sine
from .intensity import balanced, scaled_to
from .signals import Array, instants

TANK = Tank(0.5, 0.15)
STEP, LONG = 2e-3, 4.0
SHORT = 2.0
"""Length of sinusoids [s]: where gamma goes beyond 0.2, waves at half their frequency (Faraday; parametric resonance) have grown
to breaking by 3 s, and what is left to compare is chaos."""
NOTHING: Mapping[str, Any] = {}
CELLS, FINE = (100, 30), (200, 60)
ARMS = (0.0, 0.3, 1.8)
"""Distances of the tank aft of the axis in released motions [m]: pitch alone, some plunge by pitch, the tank of cases/paper_s."""
Parts = tuple[float, float, float]
PLUNGE, PITCH, BOTH, SURGE = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 1.0, 0.5)
"""Largest accelerations of plunge, pitch and surge, relative to each other (`intensity.balanced`)."""


def settings(
    tank: Tank, cells: tuple[int, int] | None = CELLS, gas_density: float = 1.2, more: Mapping[str, Any] = NOTHING
) -> dict[str, Any]:
    """Parameters of a slosh FMU for a tank; cells None: for a model without a grid; more: further ones."""
    values: dict[str, Any] = {
        "tank_length": tank.length, "tank_height": tank.height, "tank_width": tank.width, "fill_level": tank.fill_level,
        "tank_x": tank.x, "tank_y": tank.y, "liquid_density": tank.density, "gas_density": gas_density,
        "liquid_viscosity": 1e-6, "gas_viscosity": 1.48e-5, "gravity": tank.gravity,
    }  # fmt: skip
    grid = {} if cells is None else {"cells_x": cells[0], "cells_y": cells[1]}
    return {**values, **grid, **more}


def standard(
    tank: Tank = TANK, step: float = STEP, cells: tuple[int, int] = CELLS, fine: tuple[int, int] | None = FINE,
    gas_density: float = 1.2, more: Mapping[str, Any] = NOTHING,
) -> list[Planned]:  # fmt: skip
    """The plan of the module's text for a tank, sampled every `step` [s]. fine: cells of the second grid, None for one grid."""
    tank = replace(tank, x=0.0, y=0.0)
    times = instants(LONG, step)
    coarse = settings(tank, cells, gas_density, more)
    plan = [Planned(m, coarse, "train") for m in _noises(tank, times, "train", 1000, (8, 8, 16, 6, 8, 6, 8), (0.05, 2.0))]
    plan += [
        Planned(m, coarse, "validation") for m in _noises(tank, times, "validation", 2000, (1, 1, 3, 1, 1, 1, 2), (0.08, 1.6))
    ]
    for split, motions in (("test", _tests(tank, times)), ("breakup", _breakups(tank, times))):
        for motion in motions:
            plan.append(Planned(motion, coarse, split))
            if fine:
                plan.append(Planned(replace(motion, name=f"{motion.name}_fine"), settings(tank, fine, gas_density, more), split))
    return plan


def _noises(
    tank: Tank, times: Array, split: str, seed: int, counts: tuple[int, ...], ends: tuple[float, float]
) -> Iterator[Motion]:
    """So many aprbs in plunge, in pitch, in both, with surge, bursts, multisines, released; D in equal ratios from end to end."""
    kinds = ("plunge", "pitch", "both", "surge", "burst", "multisine", "released")
    for place, (kind, count) in enumerate(zip(kinds, counts, strict=True)):
        # a record alone in its kind takes a place between the ends by its kind
        shares = np.linspace(0.0, 1.0, count) if count > 1 else np.array([(place + 0.5) / len(kinds)])
        for k, target in enumerate(ends[0] * (ends[1] / ends[0]) ** shares):
            seed += 1
            rng = np.random.default_rng([seed, 7])
            share = 0.2 + 0.6 * rng.random()  # of plunge in D
            surge = 0.1 + 0.4 * rng.random() if kind == "surge" else 0.0
            parts = {"plunge": PLUNGE, "pitch": PITCH}.get(kind, (share, 1.0 - share, surge))
            if kind == "released":
                motion = _released(seed, times, tank, float(target))
            else:
                if kind == "burst":
                    motion = burst(seed, times, *parts)
                elif kind == "multisine":
                    motion = multisine(seed, times, *parts, phases=("schroeder", "random")[k % 2])
                else:
                    motion = aprbs(seed, times, *parts)
                motion = scaled_to(balanced(motion, tank, *parts), tank, float(target))
            yield replace(motion, name=f"{split}_{kind}_{k + 1:02d}")


def _tests(tank: Tank, times: Array) -> Iterator[Motion]:
    short = times[times <= SHORT + 1e-9]
    for name, parts in (("plunge", PLUNGE), ("pitch", PITCH), ("both", BOTH)):
        for frequency in (50.0, 90.0):
            for target in (0.3, 0.7, 1.0):
                motion = sine(short, frequency, *parts, phase=0.7)
                yield _named(f"test_sine{frequency:.0f}_{name}", motion, tank, parts, target)
    for name, growth in (("growing", 1.5), ("decaying", -1.5)):
        for frequency in (50.0, 70.0):
            yield _named(
                f"test_{name}{frequency:.0f}", sine(short, frequency, 1.0, 1.0, phase=0.7, growth=growth), tank, BOTH, 1.0
            )
    for k, target in enumerate((0.3, 0.7, 1.0, 1.0)):
        yield _label(f"test_released{k + 1}", _released(3000 + k, times, tank, target), target)
    for k, (name, parts, target) in enumerate(
        (("plunge", PLUNGE, 0.5), ("pitch", PITCH, 0.5), ("both", BOTH, 0.1), ("both", BOTH, 0.3), ("both", BOTH, 0.7),
         ("both", BOTH, 1.2), ("surge", SURGE, 0.5))
    ):  # fmt: skip
        yield _named(f"test_aprbs_{name}", aprbs(3010 + k, times, *parts), tank, parts, target)
    yield _named("test_multisine", multisine(3020, times, 1.0, 1.0, phases="random"), tank, BOTH, 0.5)
    yield _named("test_burst", burst(3021, times, 1.0, 1.0), tank, BOTH, 0.7)
    yield _named("test_chirp", chirp(times, 1.0, 1.0, phase=0.7), tank, BOTH, 0.7)


def _breakups(tank: Tank, times: Array) -> Iterator[Motion]:
    short = times[times <= SHORT + 1e-9]
    for k, (name, parts, target) in enumerate(
        (("both", BOTH, 1.5), ("both", BOTH, 2.0), ("both", BOTH, 3.0), ("both", BOTH, 4.0), ("plunge", PLUNGE, 3.0),
         ("pitch", PITCH, 3.0))
    ):  # fmt: skip
        yield _named(f"breakup_aprbs_{name}", aprbs(4000 + k, times, *parts), tank, parts, target)
    for target in (2.0, 3.0):
        yield _named("breakup_sine50_both", sine(short, 50.0, 1.0, 1.0, phase=0.7), tank, BOTH, target)
        yield _label("breakup_released", _released(4010 + int(target), times, tank, 1.0 + target), 1.0 + target)


def _named(name: str, motion: Motion, tank: Tank, parts: Parts, target: float) -> Motion:
    """With accelerations in the proportion of `parts`, at D = `target`, named by it."""
    return _label(name, scaled_to(balanced(motion, tank, *parts), tank, target), target)


def _label(name: str, motion: Motion, target: float) -> Motion:
    return replace(motion, name=f"{name}_D{target:g}")


def _released(seed: int, times: Array, tank: Tank, target: float) -> Motion:
    """Two to four forced cycles, then a mode that hardly grows or decays and one that dies out, at D = `target`."""
    draw = np.random.default_rng([seed, 8]).random
    frequency = LOW * (HIGH / LOW) ** draw()
    arm = ARMS[int(draw() * len(ARMS))]
    size = 0.05 * 30.0 ** draw()  # plunge over pitch [m/rad]: from pitch to plunge
    turn = 2.0 * np.pi
    first = Mode(LOW * (60.0 / LOW) ** draw(), -1.0 + 1.8 * draw(), size, turn * draw())
    second = Mode(70.0 * (HIGH / 70.0) ** draw(), -6.0 + 4.5 * draw(), -size * (0.5 + draw()), 0.5 * draw())
    motion = released(times, 1e-3, frequency, first, second, cycles=2.0 + int(3.0 * draw()))
    # D of a tank behind the axis is that of the carried motion: scaled first, the geometry stays exact
    scaled = scaled_to(replace(motion, seed=seed), replace(tank, x=arm), target)
    return carried(scaled, arm) if arm else scaled
