"""A march's numbers by value: what the dimensionless case means in kg/m, Hz, m/s and metres of altitude.

The other direction of module `by_value`: from the scales of one Mach number and V_f, for results and for the resolved case."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from . import atmosphere, by_value
from .scales import GAMMA, GAS_CONSTANT, Scales, scales

if TYPE_CHECKING:
    from .case import Case


def stream(s: Scales) -> dict[str, float]:
    """The stream of `s` and its air: airspeed, equivalent_airspeed [m/s], dynamic_pressure, static_pressure [Pa],
    static_temperature [K], density [kg/m3], pressure_altitude [m] (nan beyond the atmosphere's tables)."""
    sound = s.speed / s.mach
    pressure = s.density * sound**2 / GAMMA
    return {
        "airspeed": s.speed,
        "equivalent_airspeed": atmosphere.equivalent(s.speed, s.density),
        "dynamic_pressure": 0.5 * s.density * s.speed**2,
        "static_pressure": pressure,
        "static_temperature": sound**2 / (GAMMA * GAS_CONSTANT),
        "density": s.density,
        "pressure_altitude": atmosphere.pressure_altitude(pressure),
    }


def section(s: Scales) -> dict[str, float]:
    """The section of `s` per metre of span: mass [kg/m], static_imbalance [kg], inertia and inertia_cg [kg m], frequencies
    [Hz], stiffnesses [N/m2 and N/rad]."""
    return {
        "mass": s.mass,
        "static_imbalance": s.static_imbalance,
        "inertia": s.inertia,
        "inertia_cg": s.inertia - s.static_imbalance**2 / s.mass,
        "plunge_frequency": s.omega_h / (2.0 * math.pi),
        "plunge_stiffness": s.mass * s.omega_h**2,
        "pitch_frequency": s.omega_alpha / (2.0 * math.pi),
        "pitch_stiffness": s.inertia * s.omega_alpha**2,
    }


def crossing(s: Scales, own_omega_alpha: float | None) -> dict[str, float | None]:
    """What a neutral V_f means in the stream of `s`, whose V_f it is: the pitch frequency [Hz] that would be neutral there with
    the same masses and frequency ratio; and of a wing with a pitch frequency of its own [rad/s] its V_f, the margin (neutral
    V_f over its own), and the speeds at which it would be neutral with its own stiffness at this Mach number and this density.

    That speed is V_f b omega_alpha sqrt(mu) = margin x airspeed: a flight condition (a matched point) only where the margin is
    1, for this air's temperature ties the speed to the Mach number. None where the wing has no frequency of its own."""
    neutral: dict[str, float | None] = {"neutral_pitch_frequency": s.omega_alpha / (2.0 * math.pi)}
    names = ("own_V_f", "margin", "flutter_airspeed", "flutter_equivalent_airspeed", "flutter_dynamic_pressure")
    if own_omega_alpha is None:
        return neutral | dict.fromkeys(names)
    margin = own_omega_alpha / s.omega_alpha
    true = margin * s.speed
    values = (s.V_f / margin, margin, true, atmosphere.equivalent(true, s.density), 0.5 * s.density * true**2)
    return neutral | dict(zip(names, values, strict=True))


def comments(case: Case) -> dict[str, Any]:
    """The keys of the resolved case that follow from others, with their values: the dimensionless ones of what was given by
    value, those by value of what was given dimensionless. None: a key in whose place another form was, or is swept."""
    found: dict[str, Any] = {key: by_value.value(case, key) for key in case.derived}
    for key, forms in by_value.ALTERNATIVES.items():
        replaced = any(form in case.given or by_value.value(case, form) is not None for form in forms)
        if replaced and key not in case.given and key not in found:
            found[key] = None
    names = ("section.mass_ratio", "section.x_alpha", "section.r2_alpha", "section.frequency_ratio", "flow.mach", "flutter.V_f")
    if (case.source and not all(by_value.known(case, name) for name in names)) or None in found.values():
        return found
    s = scales(case, case.flow.mach, case.flutter.V_f)
    air = stream(s)
    other: dict[str, float] = {f"section.{name}": value for name, value in section(s).items()}
    other |= {f"flutter.{name}": air[name] for name in ("airspeed", "equivalent_airspeed", "dynamic_pressure")}
    other |= {"section.x_cg": case.section.elastic_axis + 0.5 * case.section.x_alpha}
    if math.isfinite(altitude := air["pressure_altitude"]):
        warmer = air["static_temperature"] - atmosphere.air(altitude)[1]
        other |= {"flow.altitude": altitude, "flow.delta_temperature": warmer if abs(warmer) > 1e-6 else 0.0}
    return found | {k: float(f"{v:.8g}") for k, v in other.items() if by_value.value(case, k) is None and k not in case.given}
