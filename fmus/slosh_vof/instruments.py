"""Pressure probes and wave gauges of the FMU: their variables, and what they read.

A fixed number of each, of which `probe_count` and `gauge_count` are in use; an instrument out of use reads 0 and costs nothing.
Places are measured from the west (fore) wall and the floor, as on a rig.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ..kit.failure import StepError
from ..kit.variables import Variable, output, parameter
from .flow import Flow
from .probes import Probe

PROBES = 6
GAUGES = 4
WINDOW = 0.02
PRESSURES = ("pressure", "pressure_area", "pressure_mean")
UNUSED = {f"probe{n}_{name}": 0.0 for n in range(1, PROBES + 1) for name in PRESSURES} | {
    f"gauge{n}_height": 0.0 for n in range(1, GAUGES + 1)
}
"""What they read where none is in use."""


def parameters() -> tuple[Variable, ...]:
    """Return how many instruments there are and where."""
    own = [parameter("probe_count", 0, "", f"Pressure probes in use: probe1 to at most probe{PROBES}", min=0, max=PROBES)]
    for n in range(1, PROBES + 1):
        own += [
            parameter(f"probe{n}_x", 0.0, "m", f"Probe {n} from the west (fore) wall", min=0.0, quantity="Length"),
            parameter(f"probe{n}_y", 0.0, "m", f"Probe {n} above the floor", min=0.0, quantity="Length"),
            parameter(f"probe{n}_extent", 0.0, "m", f"Length of probe {n}'s face along the nearest wall; 0 = a point", min=0.0,
                      quantity="Length"),
        ]  # fmt: skip
    own.append(parameter("probe_window", WINDOW, "s", "Trailing time of the probes' mean; 0 = none", min=0.0, quantity="Time"))
    own.append(parameter("gauge_count", 0, "", f"Wave gauges in use: gauge1 to at most gauge{GAUGES}", min=0, max=GAUGES))
    own += [parameter(f"gauge{n}_x", 0.0, "m", f"Gauge {n} from the west (fore) wall", min=0.0, quantity="Length")
            for n in range(1, GAUGES + 1)]  # fmt: skip
    return tuple(own)


def outputs(pressure: Iterable[str], surface: Iterable[str]) -> tuple[Variable, ...]:
    """Return what they read; the pressure and the surface at the start are made of the given variables."""
    own = []
    for n in range(1, PROBES + 1):
        place = ("probe_count", f"probe{n}_x", f"probe{n}_y", "tank_length", "tank_height")
        face = (*place, f"probe{n}_extent")
        for name, text, depends in (
            ("pressure", "Pressure at the middle of probe {}, above that of the gas", place),
            ("pressure_area", "Mean pressure over the face of probe {}, above that of the gas", face),
            ("pressure_mean", "Mean of that over the last probe_window (over the run while shorter)", face),
        ):
            own.append(output(f"probe{n}_{name}", "Pa", text.format(n), quantity="Pressure", depends=(*pressure, *depends)))
    own += [
        output(f"gauge{n}_height", "m", f"Liquid column at gauge {n} above the still level, tank axes", quantity="Length",
               depends=(*surface, "gauge_count", f"gauge{n}_x"))
        for n in range(1, GAUGES + 1)
    ]  # fmt: skip
    return tuple(own)


def probes(values: Mapping[str, Any]) -> tuple[Probe, ...]:
    """Return the probes in use of a face with these values. Raises StepError, with the name of the probe, for one outside."""
    found = []
    for n in range(1, values["probe_count"] + 1):
        probe = Probe(*(values[f"probe{n}_{key}"] for key in ("x", "y", "extent")))
        for key, most in (("x", values["tank_length"]), ("y", values["tank_height"])):
            if getattr(probe, key) > most:
                _outside(f"probe{n}_{key}", getattr(probe, key), most)
        found.append(probe)
    for n in range(1, values["gauge_count"] + 1):
        if values[f"gauge{n}_x"] > values["tank_length"]:
            _outside(f"gauge{n}_x", values[f"gauge{n}_x"], values["tank_length"])
    return tuple(found)


def readings(values: Mapping[str, Any], flow: Flow) -> dict[str, float]:
    """Return all outputs of the instruments by name at the present time; 0 of those out of use."""
    found = dict(UNUSED)
    for n, pressures in enumerate(flow.pressures(), 1):
        found |= {f"probe{n}_{name}": value for name, value in zip(PRESSURES, pressures, strict=True)}
    if count := values["gauge_count"]:
        heights = flow.heights(np.array([values[f"gauge{n}_x"] for n in range(1, count + 1)]))
        found |= {f"gauge{n}_height": float(height) for n, height in enumerate(heights, 1)}
    return found


def _outside(name: str, value: float, most: float) -> None:
    raise StepError(f"{name} = {value:g} m lies outside the tank. Remedy: from 0 to {most:g} m, from the west wall or the floor")
