"""The named interfaces: every FMU of the project spells these variables, units and descriptions the same.

Section motion goes from the structure to the fluids, loads come back (docs/design.md). X aft, Y up, `h`
positive down, `alpha` nose-up, loads about the elastic axis (EA) per metre of span.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from .variables import Variable, input_, output, parameter

# name: (unit, quantity, description)
MOTION = {
    "h": ("m", "Length", "Plunge of the elastic axis, positive down"),
    "h_dot": ("m/s", "Velocity", "Plunge rate, positive down"),
    "h_ddot": ("m/s2", "Acceleration", "Plunge acceleration, positive down"),
    "alpha": ("rad", "Angle", "Pitch angle, positive nose-up"),
    "alpha_dot": ("rad/s", "AngularVelocity", "Pitch rate, positive nose-up"),
    "alpha_ddot": ("rad/s2", "AngularAcceleration", "Pitch acceleration, positive nose-up"),
}
SURGE = {
    "x": ("m", "Length", "Surge of the elastic axis, positive aft (0 in flutter)"),
    "x_dot": ("m/s", "Velocity", "Surge rate, positive aft"),
    "x_ddot": ("m/s2", "Acceleration", "Surge acceleration, positive aft"),
}
AERO = {
    "lift": ("N/m", "ForcePerLength", "Lift per metre of span, positive up"),
    "moment": (
        "N",
        "MomentPerLength",
        "Aerodynamic moment about the elastic axis per metre of span, positive nose-up",
    ),
    "C_L": ("1", "LiftCoefficient", "Lift coefficient, lift / (q c)"),
    "C_M": (
        "1",
        "MomentCoefficient",
        "Moment coefficient about the elastic axis, moment / (q c^2), positive nose-up",
    ),
    "C_D": ("1", "DragCoefficient", "Drag coefficient, drag / (q c)"),
}
_WHOLE = "of liquid and gas on the tank, inertial axes, weight included"
_RESIDUAL = "less that of the same liquid frozen (inertia and weight)"
SLOSH = {
    "force_x": ("N/m", "ForcePerLength", f"Force {_WHOLE}, positive aft"),
    "force_y": ("N/m", "ForcePerLength", f"Force {_WHOLE}, positive up"),
    "moment": ("N", "MomentPerLength", f"Moment about the elastic axis {_WHOLE}, positive nose-up"),
    "force_x_residual": ("N/m", "ForcePerLength", f"force_x {_RESIDUAL}"),
    "force_y_residual": ("N/m", "ForcePerLength", f"force_y {_RESIDUAL}"),
    "moment_residual": ("N", "MomentPerLength", f"moment {_RESIDUAL}"),
}
SLOSH_CONSTANT = {
    "static_force_y": ("N/m", "ForcePerLength", "force_y at rest"),
    "static_moment": ("N", "MomentPerLength", "moment at rest"),
    "liquid_mass": ("kg/m", "MassPerLength", "Mass of the liquid per metre of span"),
    "liquid_static_moment": (
        "kg",
        "StaticMomentPerLength",
        "Static moment of the frozen liquid about the elastic axis",
    ),
    "liquid_inertia": (
        "kg.m",
        "InertiaPerLength",
        "Moment of inertia of the frozen liquid about the elastic axis",
    ),
    "liquid_stiffness": ("N/rad", "PitchStiffnessPerLength", "Pitch stiffness of the frozen liquid's weight"),
}
MASS_OF = ("tank_length", "tank_height", "tank_width", "fill_level", "liquid_density")
PLACE = ("tank_x", "tank_y")
CONSTANT_OF = {
    "static_force_y": (*MASS_OF, "gravity"),
    "static_moment": (*MASS_OF, "gravity", "tank_x"),
    "liquid_mass": MASS_OF,
    "liquid_static_moment": (*MASS_OF, "tank_x"),
    "liquid_inertia": (*MASS_OF, *PLACE),
    "liquid_stiffness": (*MASS_OF, "gravity", "tank_y"),
}
"""What the constants of the frozen liquid are made of."""
ACCELERATED = ("h_ddot", "alpha", "alpha_dot", "alpha_ddot", "x_ddot")
"""The motion that a liquid at rest in the tank feels."""
GRAVITY_OF = (*ACCELERATED, "tank_height", "fill_level", *PLACE, "gravity")
"""What the effective gravity at the liquid's centre is made of."""
# name: (start, unit, quantity, text, least, most)
TANK: dict[str, tuple[float, str, str, str, float | None, float | None]] = {
    "tank_length": (0.5, "m", "Length", "Length of the tank along the chord", 1e-6, None),
    "tank_height": (0.15, "m", "Length", "Height of the tank", 1e-6, None),
    "tank_width": (
        1.0,
        "m",
        "Length",
        "Width of the tank along the span; 1 = loads and masses per metre of span, else those of the whole tank",
        1e-6,
        None,
    ),
    "fill_level": (0.5, "1", "", "Depth of the liquid over the height of the tank", 1e-6, 1.0),
    "tank_x": (0.0, "m", "Length", "Centre of the tank aft of the elastic axis", None, None),
    "tank_y": (0.0, "m", "Length", "Centre of the tank above the elastic axis", None, None),
    "liquid_density": (1000.0, "kg/m3", "Density", "Density of the liquid", 1e-9, None),
    "gas_density": (1.2, "kg/m3", "Density", "Density of the gas above it", 0.0, None),
    "liquid_viscosity": (1e-6, "m2/s", "KinematicViscosity", "Kinematic viscosity of the liquid", 0.0, None),
    "gas_viscosity": (1.48e-5, "m2/s", "KinematicViscosity", "Kinematic viscosity of the gas", 0.0, None),
    "gravity": (9.81, "m/s2", "Acceleration", "Gravity", 1e-9, None),
}
WING_LOADS = {
    "lift": AERO["lift"],
    "moment": AERO["moment"],
    "slosh_force_y": ("N/m", "ForcePerLength", "Slosh force on the section, positive up"),
    "slosh_moment": ("N", "MomentPerLength", "Slosh moment about the elastic axis, positive nose-up"),
}
_END = ", at the end of the communication step"


def motion_inputs(limits: Mapping[str, float] | None = None) -> tuple[Variable, ...]:
    """Return section motion h … alpha_ddot as inputs (aero, slosh); limits: largest magnitudes by name, in the input's unit."""
    return _inputs(MOTION, limits)


def surge_inputs(limits: Mapping[str, float] | None = None) -> tuple[Variable, ...]:
    """Return surge x, x_dot, x_ddot as inputs (slosh); limits as above."""
    return _inputs(SURGE, limits)


def tank_parameters() -> tuple[Variable, ...]:
    """Return tank_length … gravity as parameters (slosh)."""
    return tuple(
        parameter(name, start, unit, text, quantity=quantity, min=least, max=most)
        for name, (start, unit, quantity, text, least, most) in TANK.items()
    )


def wing_load_inputs() -> tuple[Variable, ...]:
    """Return lift, moment, slosh_force_y, slosh_moment as inputs (structure)."""
    return _inputs(WING_LOADS)


def frozen_liquid_parameters() -> tuple[Variable, ...]:
    """Return liquid_mass … liquid_stiffness as parameters (structure), 0 for no liquid carried frozen."""
    return tuple(
        parameter(
            n,
            0.0,
            unit,
            f"{text}; 0 = none",
            quantity=quantity,
            min=0.0 if n in ("liquid_mass", "liquid_inertia") else None,
        )
        for n, (unit, quantity, text) in SLOSH_CONSTANT.items()
        if n.startswith("liquid_")
    )


def motion_outputs(depends: Mapping[str, Iterable[str]]) -> tuple[Variable, ...]:
    """Return section motion as outputs (structure); `depends`: by name, what the initial value is made of."""
    return _outputs(MOTION, depends)


def aero_outputs(depends: Iterable[str], force: Iterable[str], arm: Iterable[str]) -> tuple[Variable, ...]:
    """Return the aerodynamic loads lift, moment, C_L, C_M, C_D as outputs.

    Their initial values are made of `depends`, of `force` those with a dimension, of `arm` those about the elastic axis.
    """
    flow, size, axis = tuple(depends), tuple(force), tuple(arm)
    own = {"lift": (*flow, *size), "moment": (*flow, *size, *axis), "C_L": flow, "C_M": (*flow, *axis), "C_D": flow}
    return _outputs(AERO, own)


def slosh_outputs(
    loads: Iterable[str], gas: bool = False, more: Mapping[str, Iterable[str]] | None = None
) -> tuple[Variable, ...]:
    """Return the slosh loads, whole and residual, and the constants of the frozen liquid, as outputs.

    Args:
        loads: parameters and inputs that the loads at the start are made of.
        gas: the weight of the gas is in the static loads.
        more: of some loads, by name, what else they are made of.
    """
    extra = more or {}
    whole = {name: (*loads, *extra.get(name, ())) for name in SLOSH}
    weight = {name: ("gas_density",) if gas and name.startswith("static_") else () for name in CONSTANT_OF}
    return _outputs(SLOSH, whole) + _outputs(SLOSH_CONSTANT, {name: (*CONSTANT_OF[name], *weight[name]) for name in CONSTANT_OF})


def _inputs(table: dict[str, tuple[str, str, str]], limits: Mapping[str, float] | None = None) -> tuple[Variable, ...]:
    most = limits or {}
    return tuple(
        input_(n, 0.0, unit, text + _END, quantity=quantity, min=-most[n] if n in most else None, max=most.get(n))
        for n, (unit, quantity, text) in table.items()
    )


def _outputs(table: dict[str, tuple[str, str, str]], depends: Mapping[str, Iterable[str]]) -> tuple[Variable, ...]:
    return tuple(output(n, unit, text, quantity=quantity, depends=depends[n]) for n, (unit, quantity, text) in table.items())
