"""Values of tank and liquid that were typed in another unit: seen, and refused with what was probably meant.

The limits are far beyond any liquid and any tank: pitch has 1e5 cSt and more, mercury 13,546 kg/m3, the largest ship's tank 60 m,
mercury's surface 0.49 N/m. Zero stands for "none" where a parameter allows it and is none of a unit's business."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple

from ..kit.failure import StepError


class Rule(NamedTuple):
    """SI unit, least and most that is possible, and the other units: name → its size in the SI unit."""

    unit: str
    least: float
    most: float
    others: Mapping[str, float]


_LENGTH = Rule("m", 1e-6, 100.0, {"mm": 1e-3, "cm": 1e-2, "in": 0.0254})
RULES = {
    "tank_length": _LENGTH,
    "tank_height": _LENGTH,
    "liquid_density": Rule("kg/m3", 20.0, 30000.0, {"g/cm3": 1e3, "g/m3": 1e-3}),
    "liquid_viscosity": Rule("m2/s", 0.0, 0.1, {"cSt (mm2/s)": 1e-6, "St (cm2/s)": 1e-4}),
    "gas_viscosity": Rule("m2/s", 0.0, 1.0, {"cSt (mm2/s)": 1e-6, "St (cm2/s)": 1e-4}),
    "gravity": Rule("m/s2", 0.0, 500.0, {"cm/s2": 1e-2, "mm/s2": 1e-3}),
    "surface_tension": Rule("N/m", 0.0, 2.0, {"mN/m (dyn/cm)": 1e-3}),
}


def check(values: Mapping[str, Any]) -> None:
    """Raise StepError for the first of `values` (parameter → value, others pass) beyond all that is possible."""
    for name, rule in RULES.items():
        value = values.get(name)
        if value is None or rule.least <= value <= rule.most:
            continue
        meant = [f"{value:g} {u} is {value * size:.6g} {rule.unit}" for u, size in rule.others.items()
                 if rule.least <= value * size <= rule.most]  # fmt: skip
        likely = f"; {meant[0]}" if meant else ""
        raise StepError(
            f"{name} = {value:g} {rule.unit} is beyond all liquids and tanks ({rule.least:g} to {rule.most:g}). "
            f"Remedy: give it in {rule.unit}{likely}"
        )
