"""The paper's tank alone: half full, driven by a slosh FMU through harmonic motions about its centre."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ...fmus.slosh_rbf.training.excitation import sine
from ...fmus.tank.liquid import Tank
from ..api.case import Case
from ..api.simulate import simulate
from .work import Work

Array = NDArray[np.float64]
NAMES = ("h", "h_dot", "h_ddot", "alpha", "alpha_dot", "alpha_ddot", "x", "x_dot", "x_ddot")
ABOUT = (
    "tank of 0.5 x 0.15 m, half full, of the fuel of cases/paper_s.toml (800 kg/m³, 2e-6 m²/s, 0.025 N/m); two-phase flow on "
    "100 x 30 cells, from rest, motion risen within its first period; lateral and vertical: along the tank's walls (equations "
    "8)"
)
CENTRE = f"{ABOUT}; pitch about the tank's centre (the paper does not place its axis)"
PEAK = 0.1
"""A peak of a spectrum counts where it is at least a tenth of the highest."""


class Loads(NamedTuple):
    """Loads on the tank over time (n,) [s]: lateral and vertical force along its walls (equations 8a and b) [N/m], moment about
    the axis, nose-up [N]; the vertical one without the weight; `aft` [N/m]: the lateral one in inertial axes; `settled` (n,):
    whether the motion has been at its full size for a period and more."""

    time: Array
    aft: Array
    lateral: Array
    vertical: Array
    moment: Array
    settled: NDArray[np.bool_]


def tank(work: Work) -> Tank:
    """The tank with the fuel of cases/paper_s.toml, its centre on the axis."""
    slosh = Case.load("paper_s").core.slosh
    return Tank(slosh.tank_length, slosh.tank_height, fill_level=slosh.fill_level, density=slosh.liquid_density)


def parameters(work: Work, model: str) -> dict[str, Any]:
    """Parameters of a slosh FMU for that tank."""
    slosh = Case.load("paper_s").core.slosh
    names = ["tank_length", "tank_height", "fill_level", "liquid_density", "liquid_viscosity", "gas_density"]
    values = {name: getattr(slosh, name) for name in names}
    if model == "slosh_vof":
        cells = work.pick((100, 30), (30, 16))
        values |= {"surface_tension": slosh.surface_tension, "cells_x": cells[0], "cells_y": cells[1]}
    return values if model != "slosh_ems" else values | {"damping_ratio": slosh.damping_ratio}


def driven(
    work: Work,
    model: str,
    frequency: float,
    periods: int,
    *,
    h: float = 0.0,
    alpha: float = 0.0,
    arm: float = 0.0,
    samples: int = 60,
) -> Loads:
    """`periods` of plunge h and pitch alpha [m, rad: amplitudes, in phase] at `frequency` [rad/s] about an axis `arm` [m] ahead
    of the tank's centre, `samples` rows a period.

    Raises ComponentError where the FMU fails."""
    period = 2.0 * math.pi / frequency
    times = np.linspace(0.0, periods * period, periods * samples + 1)
    motion = sine(times, frequency, h, alpha, ramp=period).motions
    table = {"time": times, **dict(zip(NAMES, motion.T, strict=True))}
    out = simulate(work.fmu(model), table, parameters=parameters(work, model) | {"tank_x": arm})
    aft, up, weight = (out[name].values for name in ("force_x", "force_y", "static_force_y"))
    sin, cos = np.sin(table["alpha"]), np.cos(table["alpha"])
    lateral, vertical = aft * cos - up * sin, aft * sin + up * cos - weight
    return Loads(times, aft, lateral, vertical, out["moment"].values, times >= 2.0 * period - 1e-9)


def amplitude(values: Array) -> float:
    """Half of the range."""
    return 0.5 * float(values.max() - values.min())


def spectrum(loads: Loads, values: Array, frequency: float, highest: float = 8.0) -> tuple[Array, Array]:
    """Frequencies, over `frequency`, up to `highest`, and amplitudes of the settled part of `values`, whole periods, its mean
    taken off. Shapes: (m,)."""
    y = values[loads.settled][:-1]
    y = y - y.mean()
    step = loads.time[1] - loads.time[0]
    size = 2.0 * np.abs(np.fft.rfft(y)) / y.size
    at = 2.0 * np.pi * np.fft.rfftfreq(y.size, step) / frequency
    return at[at <= highest + 1e-9], size[at <= highest + 1e-9]


def peaks(size: Array) -> int:
    """How many peaks a spectrum (m,) has: higher than both neighbours, at least PEAK of the highest."""
    inner = (size[1:-1] > size[:-2]) & (size[1:-1] >= size[2:]) & (size[1:-1] >= PEAK * size.max())
    return int(np.sum(inner))


def beyond_first(at: Array, size: Array) -> float:
    """The part of a spectrum that is not at the forcing frequency: rms of the rest over rms of all, 0 for a linear answer."""
    first = np.abs(at - 1.0) < 1e-6
    return math.sqrt(float(np.sum(size[~first] ** 2) / np.sum(size**2)))
