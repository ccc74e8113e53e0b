"""Is a case typed in the right units? Values that no tank, liquid or air has are refused with what was probably meant; unusual
ones are told.

Tank and liquid have the limits that the slosh FMUs have (`fmus/tank/plausible.py`; a test holds the two together), so that a case
is refused by its file and key, and before anything is computed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Protocol

from ..base.errors import AeroSloshError
from . import scales

if TYPE_CHECKING:
    from .case import Case

HEAVY = 5.0  # liquid over section: more is unusual
FAR = 10.0  # chords: no tank of a section is longer or further away


class WithLiquid(Protocol):
    """A case with the table [slosh]: of flutter, or of training."""

    slosh: Any


def _times(factor: float) -> Callable[[float], float]:
    return lambda value: value * factor


@dataclass(frozen=True)
class Rule:
    """Possible and usual values in the SI `unit` (0 passes where allowed), and how other units become it, likeliest first."""

    unit: str
    possible: tuple[float, float]
    usual: tuple[float, float]
    others: dict[str, Callable[[float], float]] = field(default_factory=dict)

    def meant(self, value: float) -> str:
        """What was probably meant, "" where nothing fits."""
        for name, convert in self.others.items():
            if self.usual[0] <= convert(value) <= self.usual[1]:
                return f"{value:g} {name} is {convert(value):.6g} {self.unit}"
        return ""


_LENGTHS = {"mm": _times(1e-3), "cm": _times(1e-2), "in": _times(0.0254)}
_STOKES = {"cSt (mm2/s)": _times(1e-6), "St (cm2/s)": _times(1e-4)}
FLOW = {
    "section.chord": Rule("m", (1e-3, 100.0), (0.02, 30.0), _LENGTHS),
    "flow.static_pressure": Rule(
        "Pa", (10.0, 1e8), (4000.0, 1e6),
        {"bar": _times(1e5), "kPa": _times(1e3), "hPa (mbar)": _times(100.0)},
    ),
    "flow.static_temperature": Rule(
        "K", (60.0, 3000.0), (90.0, 400.0), {"degC": lambda v: v + 273.15, "degF": lambda v: (v + 459.67) / 1.8}
    ),
    "flow.altitude": Rule("m", (-5000.0, 47000.0), (-500.0, 16000.0), {"ft": _times(0.3048)}),
    "section.pitch_frequency": Rule("Hz", (0.0, 1e5), (0.2, 500.0), {"rad/s": _times(0.5 / math.pi)}),
}  # fmt: skip
LIQUID = {
    "slosh.tank_length": Rule("m", (1e-6, 100.0), (0.01, 20.0), _LENGTHS),
    "slosh.tank_height": Rule("m", (1e-6, 100.0), (0.005, 20.0), _LENGTHS),
    "slosh.liquid_density": Rule("kg/m3", (20.0, 30000.0), (50.0, 5000.0), {"g/cm3": _times(1e3), "g/m3": _times(1e-3)}),
    "slosh.liquid_viscosity": Rule("m2/s", (0.0, 0.1), (1e-7, 3e-4), _STOKES),
    "slosh.gas_viscosity": Rule("m2/s", (0.0, 1.0), (1e-8, 1e-2), _STOKES),
    "slosh.gravity": Rule("m/s2", (0.0, 500.0), (0.1, 30.0), {"cm/s2": _times(1e-2), "ft/s2": _times(0.3048)}),
    "slosh.surface_tension": Rule("N/m", (0.0, 2.0), (1e-4, 0.6), {"mN/m (dyn/cm)": _times(1e-3)}),
}


def refuse(case: Case, where: str) -> None:
    """Refuse a value beyond all that is possible. Raises AeroSloshError."""
    _refuse(_numbers(case, FLOW), where)
    if case.slosh.model == "none":
        return
    refuse_liquid(case, where)
    s, chord = case.slosh, case.section.chord
    for name in ("tank_length", "tank_height", "tank_x", "tank_y"):
        value = getattr(s, name)
        if abs(value) > FAR * chord:
            meant = LIQUID["slosh.tank_length"].meant(abs(value))
            raise AeroSloshError(
                f"slosh.{name} = {value:g} m is more than {FAR:g} chords (section.chord = {chord:g} m)",
                f"{where}, key slosh.{name}",
                "give tank and chord in m, of the same wing" + (f": {meant}" if meant else ""),
            )


def refuse_liquid(holder: WithLiquid, where: str) -> None:
    """The same for the table [slosh] alone."""
    _refuse(_numbers(holder, LIQUID), where)
    s = holder.slosh
    if s.gas_density >= s.liquid_density:
        raise AeroSloshError(
            f"slosh.gas_density = {s.gas_density:g} is not below slosh.liquid_density = {s.liquid_density:g} kg/m3",
            f"{where}, key slosh.gas_density",
            "both in kg/m3: air 1.2, water 1000, kerosene 800",
        )


def doubts(case: Case) -> list[str]:
    """What is unusual, a sentence each."""
    found = []
    for name, rule, value in _numbers(case, FLOW | (LIQUID if case.slosh.model != "none" else {})):
        low, high = rule.usual
        if value == 0.0 or low <= value <= high:
            continue
        meant = rule.meant(value)
        if name == "slosh.liquid_viscosity" and low <= value / case.slosh.liquid_density <= high:
            dynamic = f"a dynamic viscosity of {value:g} Pa s is {value / case.slosh.liquid_density:.3g} m2/s"
            meant = f"{meant}, {dynamic}" if meant else dynamic
        text = f"{name} = {value:g} {rule.unit} is unusual (most lie in {low:g} to {high:g})"
        found.append(text + (f"; {meant}" if meant else ""))
    if case.slosh.model == "none":
        return found
    s, chord = case.slosh, case.section.chord
    if s.tank_length > chord:
        found.append(f"slosh.tank_length = {s.tank_length:g} m is longer than the chord ({chord:g} m)")
    if s.tank_height > 0.5 * chord:
        found.append(f"slosh.tank_height = {s.tank_height:g} m is more than half the chord ({chord:g} m)")
    section = scales.scales(case, case.flow.mach, case.flutter.V_f).mass
    liquid = s.liquid_density * s.tank_length * s.tank_height * s.fill_level * s.tank_width
    if liquid > HEAVY * section:
        found.append(f"the liquid weighs {liquid / section:.2g} times the section ({liquid:.3g} and {section:.3g} kg/m)")
    return found


def _refuse(numbers: Iterable[tuple[str, Rule, float]], where: str) -> None:
    for name, rule, value in numbers:
        low, high = rule.possible
        if not (low <= value <= high):
            meant = rule.meant(value)
            raise AeroSloshError(
                f"{name} = {value:g} {rule.unit} is beyond all that is possible ({low:g} to {high:g} {rule.unit})",
                f"{where}, key {name}",
                f"give it in {rule.unit}" + (f": {meant}" if meant else ""),
            )


def _numbers(holder: Any, rules: dict[str, Rule]) -> Iterator[tuple[str, Rule, float]]:
    """Key, rule and value of every number ("auto" is none)."""
    for name, rule in rules.items():
        table, _, key = name.partition(".")
        value = getattr(getattr(holder, table), key)
        if isinstance(value, int | float):
            yield name, rule, float(value)
