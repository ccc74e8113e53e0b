"""Units of FMUs as SSP writes them. Source: SSP 1.0 (Modelica Association, 2019), section 4.3.3; FMI 2.0.4, section 2.2.2."""

from __future__ import annotations

from collections.abc import Iterable

from ..base.errors import AeroSloshError
from .system import Part

EXPONENTS = ("kg", "m", "s", "A", "K", "mol", "cd", "rad")
Base = dict[str, str]  # attributes of ssc:BaseUnit


def of_parts(parts: Iterable[Part]) -> dict[str, Base]:
    """Name of a unit → its base unit, of all units of the FMUs that have one (a unit of SSP must).

    Raises AeroSloshError where two FMUs mean different things by one name: an archive has one list of units."""
    found: dict[str, Base] = {}
    owner: dict[str, str] = {}
    for part in parts:
        for unit in part.description.unitDefinitions or []:
            if unit.baseUnit is None:
                continue
            base = _base(unit.baseUnit)
            if found.setdefault(unit.name, base) != base:
                raise AeroSloshError(
                    f"'{unit.name}' is one unit in {owner[unit.name]} and another in {part.name}",
                    f"{part.path}, unit {unit.name}",
                    "an SSP archive has one list of units: rename it in one of the FMUs",
                )
            owner.setdefault(unit.name, part.name)
    return found


def _base(unit: object) -> Base:
    """Attributes that differ from their defaults: exponents 0, factor 1, offset 0."""
    base = {name: str(int(getattr(unit, name))) for name in EXPONENTS if int(getattr(unit, name))}
    for name, default in (("factor", 1.0), ("offset", 0.0)):
        value = float(getattr(unit, name))
        if value != default:
            base[name] = repr(value)
    return base
