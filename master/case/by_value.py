"""What an engineer has in hand, turned into the dimensionless case once, right after loading: kg/m, Hz, altitude, airspeed.

Each quantity is given in one of two forms (`ALTERNATIVES`). With b = chord / 2, rho = p / (R T), a = sqrt(gamma R T), U = M a
(gamma and R of module `scales`, so that the way back gives the same kilograms):

    mass_ratio       mu = m / (pi rho b^2)
    x_alpha          S / (m b), or 2 (x_cg - elastic_axis)
    r2_alpha         I / (m b^2), or I_cg / (m b^2) + x_alpha^2
    V_f              U / (b omega_alpha sqrt(mu)), omega_alpha = 2 pi f_alpha, or sqrt(k_alpha / I)
    frequency_ratio  omega_h / omega_alpha, omega_h = 2 pi f_h, or sqrt(k_h / m)
    p, T             of the standard atmosphere at the altitude (module `atmosphere`), T + delta_temperature
    mach             U / a, with U = EAS sqrt(1.225 / rho), or sqrt(2 q / rho)

A wing given by value in given air is fixed: Mach number and air give its V_f, and there is nothing left to choose. A speed takes
the place of the Mach number, not of V_f. Mach number and dynamic pressure (or EAS) together fix the altitude instead, where the
air is not given: p = 2 q / (gamma M^2). Mach number and true airspeed do not: they give the temperature alone, which is the same
all the way from 11 to 20 km.

Formulas: Bisplinghoff, Ashley and Halfman, Aeroelasticity (1955), ch. 9; air: ISO 2533, US Standard Atmosphere 1976."""

from __future__ import annotations

import copy
import math
from typing import TYPE_CHECKING, Any

from ..base import settings
from ..base.errors import AeroSloshError
from . import atmosphere
from .scales import GAMMA, GAS_CONSTANT

if TYPE_CHECKING:
    from .case import Case

SPEEDS = ("flutter.airspeed", "flutter.equivalent_airspeed", "flutter.dynamic_pressure")
PRESSURES = SPEEDS[1:]  # with a Mach number they fix the static pressure
PITCH = ("section.pitch_frequency", "section.pitch_stiffness")
PLUNGE = ("section.plunge_frequency", "section.plunge_stiffness")
ALTERNATIVES: dict[str, tuple[str, ...]] = {  # dimensionless key → the same by value
    "section.mass_ratio": ("section.mass",),
    "section.x_alpha": ("section.static_imbalance", "section.x_cg"),
    "section.r2_alpha": ("section.inertia", "section.inertia_cg"),
    "section.frequency_ratio": PLUNGE,
    "flutter.V_f": PITCH,
    "flow.mach": SPEEDS,
    "flow.static_pressure": ("flow.altitude",),
    "flow.static_temperature": ("flow.altitude", "flow.delta_temperature"),
}
AIR, CHORD, MASS = "flow.altitude", "section.chord", "section.mass"
NEEDS = {  # key by value → what it is converted with ("a or b": either)
    MASS: (CHORD, AIR),
    "section.static_imbalance": (MASS, CHORD),
    "section.inertia": (MASS, CHORD),
    "section.inertia_cg": (MASS, CHORD),
    "section.plunge_frequency": (" or ".join(PITCH),),
    "section.plunge_stiffness": (MASS, " or ".join(PITCH)),
    "section.pitch_frequency": (CHORD, AIR),
    "section.pitch_stiffness": (MASS, CHORD, AIR),
    "flutter.airspeed": (AIR,),
}


def value(case: Case, key: str) -> Any:
    """The value of `key` (table.key)."""
    table, _, name = key.partition(".")
    return getattr(getattr(case, table), name)


def given(case: Case, keys: tuple[str, ...]) -> list[str]:
    """Those of the by-value `keys` that the case gives."""
    return [key for key in keys if value(case, key) is not None]


def known(case: Case, key: str) -> bool:
    """Whether the case says what `key` (table.key) is, in one of its forms."""
    return key in case.given or key in case.derived or bool(given(case, ALTERNATIVES.get(key, ())))


def convert(case: Case, whole: bool = True) -> None:
    """Set the dimensionless keys that follow from those by value, in place; `case.derived` tells which follow from what.

    whole: refuse by-value keys without what they are converted with; else leave out what cannot be converted yet (a sweep may
    bring the rest). Raises AeroSloshError for two forms of one quantity, for missing ones, for what cannot be."""
    case.derived = {}
    _refuse_two_forms(case)
    missing = _missing(case)
    if missing and whole:
        lines = "; ".join(f"{key} needs {', '.join(names)}" for key, names in missing.items())
        wanted = list(dict.fromkeys(name for names in missing.values() for name in names))
        raise AeroSloshError(
            f"Given by value, but not all that it is converted with: {lines}",
            place(case, next(iter(missing))),
            f"write {', '.join(wanted)} in the case too (flow.altitude: or flow.static_pressure with flow.static_temperature), "
            "or give the dimensionless keys instead",
        )
    if delta := _lonely_delta(case):
        if whole:
            raise AeroSloshError("flow.delta_temperature has no effect without flow.altitude", delta, "give flow.altitude too")
        return
    _air(case)
    if missing:
        return
    _mach(case)
    _section(case)
    _frequencies(case)


def one_speed(case: Case) -> None:
    """Refuse a boundary over Mach numbers of a case whose speed or dynamic pressure belongs to one. Raises AeroSloshError."""
    for key in given(case, SPEEDS):
        others = [mach for mach in case.boundary.mach if abs(mach - case.flow.mach) > 1e-9]
        if others:
            listed = ", ".join(f"{m:g}" for m in others)
            raise AeroSloshError(
                f"{key} belongs to Mach {case.flow.mach:.6g}, and the boundary is of Mach {listed} too",
                place(case, key),
                f"leave out {key} and give the air by flow.altitude: it is then the same at every Mach number",
            )


def omega_alpha(case: Case) -> float | None:
    """The uncoupled pitch frequency [rad/s] of a wing given by value; None where V_f is free."""
    s = case.section
    if s.pitch_frequency is not None:
        return 2.0 * math.pi * s.pitch_frequency
    if s.pitch_stiffness is None or s.mass is None:
        return None
    return math.sqrt(s.pitch_stiffness / (s.r2_alpha * s.mass * (0.5 * s.chord) ** 2))


def settled(case: Case) -> bool:
    """Whether the dimensionless keys, V_f apart (a search varies it), are those that follow from the keys by value."""
    again = copy.deepcopy(case)
    convert(again)
    return all(value(again, key) == value(case, key) for key in again.derived if key != "flutter.V_f")


def place(case: Case, key: str) -> str:
    """Where a key was given, for messages: file and line, or the override."""
    return case.places.get(key) or (f"{case.source}, key {key}" if case.source else f"key {key}")


def refuse_both(case: Case, keys: list[str], why: str = "the same quantity") -> AeroSloshError:
    """The error of keys that stand for each other."""
    found = "; ".join(place(case, key) for key in keys)
    return AeroSloshError(
        f"{' and '.join(keys)} are {'both' if len(keys) == 2 else 'all'} given, which are {why}",
        found,
        f"keep one of them: leave out {' or '.join(keys)}",
    )


def _matched(case: Case) -> list[str]:
    """The key that fixes the static pressure together with the Mach number."""
    free = case.flow.altitude is None and "flow.static_pressure" not in case.given
    return given(case, PRESSURES) if free and "flow.mach" in case.given else []


def _lonely_delta(case: Case) -> str:
    """Where a delta_temperature was given without an altitude to add it to; "" where all is well."""
    alone = case.flow.delta_temperature is not None and case.flow.altitude is None and not _matched(case)
    return place(case, "flow.delta_temperature") if alone else ""


def _refuse_two_forms(case: Case) -> None:
    for key, forms in ALTERNATIVES.items():
        own = given(case, forms)
        if key == "flow.static_temperature":
            own = own[:1]  # altitude and delta_temperature go together
        if key == "flow.mach" and len(own) == 1 and _matched(case):
            continue
        both = [key, *own] if own and key in case.given else own
        if len(both) < 2:
            continue
        why = "the same quantity"
        if key == "flutter.V_f" and key in both:
            why = "the same quantity: V_f = U / (b omega_alpha sqrt(mu)) follows from pitch frequency, Mach number, mass and air"
        elif key == "flow.mach" and key in both:
            why = "the same quantity once the air is given"
            if own == [SPEEDS[0]] and case.flow.altitude is None:
                why = "no two choices: together they give the air's temperature and leave its pressure open"
        raise refuse_both(case, both, why)


def _missing(case: Case) -> dict[str, list[str]]:
    """By-value key → what is not there to convert it with. Who makes a case in code sees the defaults of chord and air."""
    air = not case.source or known(case, AIR) or case.flow.altitude is not None or bool(_matched(case))
    air = air or {"flow.static_pressure", "flow.static_temperature"} <= case.given
    there = {
        AIR: air,
        CHORD: not case.source or CHORD in case.given,
        MASS: case.section.mass is not None,
        " or ".join(PITCH): bool(given(case, PITCH)),
    }
    needs = NEEDS | dict.fromkeys(PRESSURES, (AIR,))
    found = {key: [name for name in needs[key] if not there[name]] for key in needs if value(case, key) is not None}
    return {key: names for key, names in found.items() if names}


def _set(case: Case, key: str, number: float, *sources: str) -> None:
    """Set a dimensionless key that follows from `sources`. Raises AeroSloshError where it is out of range."""
    table, _, name = key.partition(".")
    where = "; ".join(place(case, source) for source in sources)
    settings.assign(getattr(case, table), table, name, number, f"{where} (from which {key} follows)")
    case.derived[key] = sources


def _air(case: Case) -> None:
    f = case.flow
    warmer = f.delta_temperature or 0.0
    sources = ("flow.altitude", "flow.delta_temperature") if warmer else ("flow.altitude",)
    if f.altitude is not None:
        pressure, temperature = atmosphere.air(f.altitude)
        _set(case, "flow.static_pressure", pressure, "flow.altitude")
        _set(case, "flow.static_temperature", temperature + warmer, *sources)
    elif speed := _matched(case):
        sources = ("flow.mach", speed[0])
        eas, q = case.flutter.equivalent_airspeed, case.flutter.dynamic_pressure
        pressure = 2.0 * (q or 0.5 * atmosphere.SEA_LEVEL_DENSITY * (eas or 0.0) ** 2) / (GAMMA * f.mach**2)
        altitude = atmosphere.pressure_altitude(pressure)
        if math.isnan(altitude):
            raise AeroSloshError(
                f"{speed[0]} = {value(case, speed[0]):g} at Mach {f.mach:g} takes a static pressure of {pressure:.4g} Pa, which "
                f"the standard atmosphere has nowhere from {atmosphere.LOWEST:g} to {atmosphere.HIGHEST:g} m",
                place(case, speed[0]),
                "give another speed or Mach number, or flow.altitude in place of one of them",
            )
        _set(case, "flow.static_pressure", pressure, *sources)
        if "flow.static_temperature" not in case.given:
            _set(case, "flow.static_temperature", atmosphere.air(altitude)[1] + warmer, *sources)


def _sound(case: Case) -> float:
    """Speed of sound [m/s]."""
    return math.sqrt(GAMMA * GAS_CONSTANT * case.flow.static_temperature)


def _density(case: Case) -> float:
    """rho [kg/m3]."""
    return case.flow.static_pressure / (GAS_CONSTANT * case.flow.static_temperature)


def _mach(case: Case) -> None:
    speed = given(case, SPEEDS)
    if not speed or _matched(case):
        return
    f = case.flutter
    if f.airspeed is not None:
        true = f.airspeed
    elif f.equivalent_airspeed is not None:
        true = f.equivalent_airspeed * math.sqrt(atmosphere.SEA_LEVEL_DENSITY / _density(case))
    else:
        true = math.sqrt(2.0 * (f.dynamic_pressure or 0.0) / _density(case))
    _set(case, "flow.mach", true / _sound(case), speed[0])


def _section(case: Case) -> None:
    s, b = case.section, 0.5 * case.section.chord
    if s.mass is not None:
        _set(case, "section.mass_ratio", s.mass / (math.pi * _density(case) * b**2), MASS)
    if s.x_cg is not None:
        _set(case, "section.x_alpha", 2.0 * (s.x_cg - s.elastic_axis), "section.x_cg")
    if s.mass is None:
        return
    if s.static_imbalance is not None:
        _set(case, "section.x_alpha", s.static_imbalance / (s.mass * b), "section.static_imbalance")
    if s.inertia is not None:
        least = s.mass * (s.x_alpha * b) ** 2
        if known(case, "section.x_alpha") and s.inertia <= least:
            raise AeroSloshError(
                f"section.inertia = {s.inertia:g} kg m is not above the mass times its distance from the elastic axis squared, "
                f"{least:.4g} kg m",
                place(case, "section.inertia"),
                "it is about the elastic axis; give one about the centre of mass as section.inertia_cg",
            )
        _set(case, "section.r2_alpha", s.inertia / (s.mass * b**2), "section.inertia")
    elif s.inertia_cg is not None:
        _set(case, "section.r2_alpha", s.inertia_cg / (s.mass * b**2) + s.x_alpha**2, "section.inertia_cg")


def _frequencies(case: Case) -> None:
    s, b, omega = case.section, 0.5 * case.section.chord, omega_alpha(case)
    if omega is None:
        return
    if s.plunge_frequency is not None:
        _set(case, "section.frequency_ratio", 2.0 * math.pi * s.plunge_frequency / omega, *given(case, PLUNGE + PITCH))
    elif s.plunge_stiffness is not None and s.mass is not None:
        _set(case, "section.frequency_ratio", math.sqrt(s.plunge_stiffness / s.mass) / omega, *given(case, PLUNGE + PITCH))
    mach = case.flow.mach
    if case.source and not known(case, "flow.mach"):
        if "boundary.mach" not in case.given:
            return  # told by `checks.complete`, or brought by a sweep
        mach = case.boundary.mach[0]
    _set(case, "flutter.V_f", mach * _sound(case) / (b * omega * math.sqrt(s.mass_ratio)), *given(case, PITCH))
