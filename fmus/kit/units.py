"""Units by name: FMI 2.0 base-unit exponents and the factor to SI.

A unit is written as a plain string ("kg/m", "rad/s"). `BASE[unit]` holds the attributes of FMI's
`<BaseUnit>`: the exponents of kg, m, s, A, K, mol, cd, rad and, where it is not 1, `factor` (value in SI =
factor * value).
Source: FMI 2.0.4 specification, section 2.2.2 "Definition of units".
"""

from __future__ import annotations

Exponents = dict[str, float]

BASE: dict[str, Exponents] = {
    "1": {},
    "%": {"factor": 0.01},
    "kg": {"kg": 1},
    "kg/m": {"kg": 1, "m": -1},
    "kg.m": {"kg": 1, "m": 1},
    "kg.m2": {"kg": 1, "m": 2},
    "kg/m3": {"kg": 1, "m": -3},
    "m": {"m": 1},
    "m2": {"m": 2},
    "m3": {"m": 3},
    "m3/m": {"m": 2},
    "s": {"s": 1},
    "1/s": {"s": -1},
    "Hz": {"s": -1},
    "m/s": {"m": 1, "s": -1},
    "m/s2": {"m": 1, "s": -2},
    "m2/s": {"m": 2, "s": -1},
    "rad": {"rad": 1},
    "rad/s": {"rad": 1, "s": -1},
    "rad/s2": {"rad": 1, "s": -2},
    "deg": {"rad": 1, "factor": 0.017453292519943295},
    "N": {"kg": 1, "m": 1, "s": -2},
    "N/m": {"kg": 1, "s": -2},
    "N.m": {"kg": 1, "m": 2, "s": -2},
    "N.m/m": {"kg": 1, "m": 1, "s": -2},
    "N/rad": {"kg": 1, "m": 1, "s": -2, "rad": -1},
    "J": {"kg": 1, "m": 2, "s": -2},
    "J/m": {"kg": 1, "m": 1, "s": -2},
    "Pa": {"kg": 1, "m": -1, "s": -2},
    "Pa.s": {"kg": 1, "m": -1, "s": -1},
    "K": {"K": 1},
    "J/(kg.K)": {"m": 2, "s": -2, "K": -1},
}

QUANTITY = {
    "kg": "StaticMomentPerLength",
    "kg/m": "MassPerLength",
    "kg.m": "InertiaPerLength",
    "kg/m3": "Density",
    "m": "Length",
    "m3": "Volume",
    "s": "Time",
    "m/s": "Velocity",
    "m/s2": "Acceleration",
    "m2/s": "KinematicViscosity",
    "rad": "Angle",
    "rad/s": "AngularVelocity",
    "rad/s2": "AngularAcceleration",
    "N": "MomentPerLength",
    "N/m": "ForcePerLength",
    "N/rad": "PitchStiffnessPerLength",
    "J/m": "EnergyPerLength",
    "Pa": "Pressure",
    "K": "Temperature",
}
"""What a unit stands for where a variable does not say it: loads, masses and energies here are per metre of span."""


def base(unit: str) -> Exponents:
    """Return the base-unit attributes of `unit`.

    Raises:
        ValueError: the unit is not in the table.
    """
    try:
        return BASE[unit]
    except KeyError:
        raise ValueError(f"Unknown unit '{unit}'. Remedy: add it to fmus/kit/units.py; known: {', '.join(BASE)}") from None
