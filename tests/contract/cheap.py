"""Each FMU made cheap, and a motion or load that drives it: the numbers that abuse must not change."""

from __future__ import annotations

import math
from typing import Any

from raw import OK, Raw, bits

STEP = 1e-3
PARAMETERS: dict[str, dict[str, Any]] = {
    "structure": {"initial_h": 0.01, "initial_alpha": 0.02, "damping_ratio_h": 0.01, "load_prediction": 1},
    # two internal steps a step
    "aero": {"cells_around": 64, "cells_normal": 16, "tolerance": 0.1, "max_subiterations": 5, "max_step": 0.2},
    "slosh_vof": {"cells_x": 16, "cells_y": 16, "initial_wave": 0.01, "wall_layer": 1},
    "slosh_ems": {"modes": 5},
    "slosh_rbf": {"network": "default"},
}
AMPLITUDES = {"lift": 900.0, "moment": 300.0, "slosh_force_y": 20.0, "slosh_moment": 5.0}


def started(folder: str, name: str = "cheap", start: float = 0.0, **values: Any) -> Raw:
    """An instance that stands at its start."""
    return start_up(Raw(folder, name), start, **values)


def prepared(one: Raw, **values: Any) -> Raw:
    """Set the cheap parameters and `values`."""
    for key, value in {**PARAMETERS[one.description.modelName], **values}.items():
        one[key] = value
    return one


def start_up(one: Raw, start: float = 0.0, **values: Any) -> Raw:
    """Set the cheap parameters and `values`, go through initialisation."""
    prepared(one, **values)
    assert (one.setup(start), one.enter(), one.leave()) == (OK, OK, OK)
    one.assert_well()
    return one


def drive(one: Raw, step: int, share: float = 1.0) -> None:
    """Inputs at the end of a step: a harmonic plunge and pitch with its true rates, or loads; a blow in the second step.

    What is kept of the largest value so far is then a part of the state that counts.
    """
    share *= 3.0 if step == 1 else 1.0
    t, values = (step + 1) * STEP, {}
    for name, size, omega in (("h", 0.002, 60.0), ("alpha", 0.004, 45.0), ("x", 0.001, 30.0)):
        phase = omega * t
        rates = (size * math.sin(phase), size * omega * math.cos(phase), -size * omega**2 * math.sin(phase))
        values.update(zip((name, f"{name}_dot", f"{name}_ddot"), rates, strict=True))
    values.update({name: size * math.sin(50.0 * t) for name, size in AMPLITUDES.items()})
    inputs = one.named("input", "Real")
    assert one.set("Real", [v.valueReference for v in inputs], [share * values[v.name] for v in inputs]) == OK


def march(one: Raw, first: int, count: int, start: float = 0.0, share: float = 1.0) -> list[str]:
    """Step `count` times from step `first`: all Real outputs after each step, exact."""
    rows = []
    for step in range(first, first + count):
        drive(one, step, share)
        assert one.step(start + step * STEP, STEP) == OK, one["error"]
        rows.append(bits(one.outputs()))
    return rows
