"""The tables of a case and their keys, each with unit, range and meaning (module `case` reads and writes them).

Angles are in degrees only where the key ends in `_deg`, frequencies by value in Hz; everything else is SI and radians. Keys that
are None unless given are the same quantities by value: module `by_value` turns them into the dimensionless ones."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from ..base.settings import key, rule


@dataclass
class Section:
    """The two-degree-of-freedom section, dimensionless (Isogai case A by default) or by value, per metre of span, no liquid."""

    chord: float = key(1.0, "chord c = 2b", "m", above=0.0)
    elastic_axis: float = key(-0.5, "elastic axis x/c, aft of the leading edge positive", low=-10.0, high=10.0)
    x_alpha: float = key(1.8, "centre of mass aft of the elastic axis / b", low=-20.0, high=20.0)
    r2_alpha: float = key(3.48, "radius of gyration about the elastic axis, squared / b^2", above=0.0)
    frequency_ratio: float = key(1.0, "omega_h / omega_alpha (uncoupled)", low=0.0, high=100.0)
    mass_ratio: float = key(60.0, "mu = m / (pi rho b^2)", above=0.0)
    mass: float | None = key(None, "mass per metre of span, instead of mass_ratio", "kg/m", above=0.0)
    static_imbalance: float | None = key(
        None, "mass times distance of its centre aft of the elastic axis, per metre of span, instead of x_alpha", "kg"
    )
    x_cg: float | None = key(None, "centre of mass x/c aft of the leading edge, instead of x_alpha", low=-20.0, high=20.0)
    inertia: float | None = key(
        None, "moment of inertia about the elastic axis, per metre of span, instead of r2_alpha", "kg m", above=0.0
    )
    inertia_cg: float | None = key(
        None, "moment of inertia about the centre of mass, per metre of span, instead of r2_alpha", "kg m", above=0.0
    )
    plunge_frequency: float | None = key(None, "uncoupled plunge frequency, instead of frequency_ratio", "Hz", low=0.0)
    plunge_stiffness: float | None = key(None, "plunge stiffness, instead of frequency_ratio", "N/m per m", low=0.0)
    pitch_frequency: float | None = key(None, "uncoupled pitch frequency, instead of flutter.V_f", "Hz", above=0.0)
    pitch_stiffness: float | None = key(
        None, "pitch stiffness about the elastic axis, instead of flutter.V_f", "N m/rad per m", above=0.0
    )
    damping_ratio_h: float = key(0.0, "structural damping ratio in plunge", low=0.0, high=1.0)
    damping_ratio_alpha: float = key(0.0, "structural damping ratio in pitch", low=0.0, high=1.0)


@dataclass
class Flow:
    """The stream. Air is fixed (gamma 1.4, R 287.05): V_f changes the structure's stiffness, not the stream."""

    mach: float = key(0.825, "freestream Mach number", low=0.05, high=0.98)
    static_pressure: float = key(101325.0, "freestream static pressure", "Pa", above=0.0)
    static_temperature: float = key(288.15, "freestream static temperature", "K", above=0.0)
    altitude: float | None = key(
        None, "geopotential altitude in the standard atmosphere, instead of pressure and temperature", "m",
        low=-5000.0, high=47000.0,
    )  # fmt: skip
    delta_temperature: float | None = key(
        None, "air warmer than standard by this, at the same pressure", "K", low=-100.0, high=100.0
    )
    airfoil: str = key("NACA 64A010", "a NACA 4-, 5-digit or 6A name, or a coordinate file")
    mean_alpha_deg: float = key(0.0, "mean angle of attack; its steady load is trimmed out", "deg", low=-10.0, high=10.0)


@dataclass
class Aero:
    """Settings of the aero FMU; "auto" leaves the FMU's own value, `parameters` reach all that have no key."""

    cells_around: int = key(168, "cells around the airfoil", low=64, high=4096)
    cells_normal: int = key(48, "cells from wall to farfield", low=16, high=1024)
    farfield_chords: float = key(200.0, "distance of the outer boundary", "chords", low=5.0, high=1000.0)
    tolerance: float | str = key("auto", "tolerance of the subiterations", above=0.0, choices=["auto"])
    max_subiterations: int | str = key("auto", "most subiterations a step", low=1, choices=["auto"])
    parameters: dict[str, Any] = field(
        default_factory=dict, metadata=rule("further parameters of the aero FMU: variable = value", empty=True)
    )


@dataclass
class Structure:
    """Settings of the structure FMU that belong to no section and no protocol."""

    parameters: dict[str, Any] = field(
        default_factory=dict, metadata=rule("further parameters of the structure FMU: variable = value", empty=True)
    )


@dataclass
class Flutter:
    """One march: steady start, forced pitch, release, free response. Cycles are periods 2 pi / omega_alpha."""

    V_f: float = key(0.612, "flutter speed index U / (b omega_alpha sqrt(mu))", low=0.01, high=50.0)
    airspeed: float | None = key(None, "true airspeed, instead of flow.mach", "m/s", above=0.0)
    equivalent_airspeed: float | None = key(
        None, "airspeed sqrt(rho / 1.225 kg/m3), instead of flow.mach, or with it instead of the altitude", "m/s", above=0.0
    )
    dynamic_pressure: float | None = key(
        None, "dynamic pressure, instead of flow.mach, or with it instead of the altitude", "Pa", above=0.0
    )
    forced_amplitude_deg: float = key(1.0, "amplitude of the forced pitch", "deg", low=0.0, high=20.0)
    forced_frequency: float = key(1.0, "forced frequency / omega_alpha", above=0.0)
    forced_cycles: float = key(2.0, "forced periods; 0 starts free", "cycles", low=0.0, high=100.0)
    forced_ramp_cycles: float = key(1.0, "forced periods in which the amplitude grows", "cycles", low=0.0, high=100.0)
    free_cycles: float = key(5.0, "free periods after release", "cycles", low=1.5, high=1000.0)
    max_free_cycles: float | str = key(
        "auto",
        "a march whose verdict is not settled goes on to this many free periods; auto: 8 x free_cycles, 80 at most",
        "cycles",
        low=1.5,
        high=10000.0,
        choices=["auto"],
    )
    steps_per_cycle: int | str = key(
        "auto",
        "steps a period; auto: 0.2 chords of travel, at least 72",
        low=12,
        high=100000,
        choices=["auto"],
    )
    initial_alpha_dot: float = key(0.0, "initial pitch rate / omega_alpha (starts without forcing)", "rad", low=-1, high=1)
    max_alpha_deg: float = key(12.0, "the march ends when |alpha| exceeds this", "deg", above=0.0, high=90.0)
    neutral_band: float = key(5e-4, "|growth rate| / omega_alpha below this is called neutral", low=0.0, high=0.1)
    companion: bool = key(
        True,
        "of `point`: two marches on a coarser mesh with longer steps, one with half the amplitude, into the error bars; "
        "in a sweep only where its case sets it",
    )


@dataclass
class Boundary:
    """The search for neutral V_f at each Mach number."""

    mach: list[float] = field(default_factory=lambda: [0.80, 0.825, 0.85], metadata=rule("Mach numbers", low=0.05, high=0.98))
    V_f_range: list[float] = field(
        default_factory=lambda: [0.2, 3.0],
        metadata=rule("V_f is searched in this range", low=0.01, high=50.0),
    )
    tolerance: float = key(0.005, "relative tolerance of V_f", low=1e-5, high=0.2)
    max_marches: int = key(12, "most marches a Mach number; with a linear model half of them a crossing at most", low=2, high=200)
    method: str = key(
        "both",
        "linear: eigenvalues of a linear model; march: marches alone; both: marches confirm what the model predicts",
        choices=["linear", "march", "both"],
    )
    linear_amplitude_deg: float | str = key(
        "auto", "amplitude of the linear model's motions; auto: flutter.forced_amplitude_deg", "deg",
        above=0.0, high=20.0, choices=["auto"],
    )  # fmt: skip
    companion: bool = key(
        True,
        "sweeps (without a linear model: marches) on a coarser mesh with longer steps, and with half the amplitude: what these "
        "change, into the error bars",
    )
    uncertainty: bool = key(
        False, "three more marches a crossing: half the step, half the amplitude, coarser mesh, into its error bar"
    )
    richardson: bool = key(False, "uncertainty, its mesh part from three meshes: observed order, extrapolated V_f, GCI")


@dataclass
class Slosh:
    """The fuel tank and the model of its liquid. Tank and liquid go by the names of the slosh FMUs' parameters; the keys
    below them belong to one model, and "auto" leaves the FMU's own value."""

    model: str = key("none", "none (dry), frozen, ems, rbf or vof", choices=["none", "frozen", "ems", "rbf", "vof"])
    predictor: str = key(
        "none", "a cheaper model that predicts the slosh loads of a step: none, ems or rbf", choices=["none", "ems", "rbf"]
    )
    split: str = key(
        "frozen",
        "frozen: the structure carries the frozen liquid and takes the residual loads; none: it takes the whole loads",
        choices=["frozen", "none"],
    )
    tank_length: float = key(0.5, "length of the tank along the chord", "m", above=0.0)
    tank_height: float = key(0.15, "height of the tank", "m", above=0.0)
    tank_width: float = key(1.0, "width along the span; 1 = loads per metre of span", "m", above=0.0)
    fill_level: float = key(0.5, "depth of the liquid over the tank's height", above=0.0, high=1.0)
    tank_x: float = key(0.0, "centre of the tank aft of the elastic axis", "m", low=-1000.0, high=1000.0)
    tank_y: float = key(0.0, "centre of the tank above the elastic axis", "m", low=-1000.0, high=1000.0)
    liquid_density: float = key(1000.0, "density of the liquid", "kg/m3", above=0.0)
    gas_density: float = key(1.2, "density of the gas above it", "kg/m3", low=0.0)
    liquid_viscosity: float = key(1e-6, "kinematic viscosity of the liquid", "m2/s", low=0.0)
    gas_viscosity: float = key(1.48e-5, "kinematic viscosity of the gas", "m2/s", low=0.0)
    gravity: float = key(9.81, "gravity", "m/s2", above=0.0)
    modes: int | str = key("auto", "ems: modes that slosh", low=1, high=400, choices=["auto"])
    damping_ratio: float | str = key(
        "auto", "ems: damping ratio of every mode; 0: from the viscosity", low=0.0, high=0.9, choices=["auto"]
    )
    parametric: bool | str = key("auto", "ems: gravity of the moment and finite angles", choices=["auto"])
    network: str = key("auto", "rbf: trained network in the FMU, or bilinear or ems (equations alone); auto: its default")
    cells_x: int | str = key("auto", "vof: cells along the tank", low=16, high=2048, choices=["auto"])
    cells_y: int | str = key("auto", "vof: cells over its height", low=16, high=2048, choices=["auto"])
    wall_slip: bool | str = key("auto", "vof: walls without friction", choices=["auto"])
    surface_tension: float | str = key("auto", "vof: surface tension", "N/m", low=0.0, choices=["auto"])
    members: int = key(
        1, "vof: marches of each point, from surfaces disturbed by 1e-5 m; growth rate and verdict are those of their mean",
        low=1, high=1000,
    )  # fmt: skip
    seed: int = key(0, "vof: seed of that disturbance, of the first member; 0: a level surface", low=0, high=2**30)
    parameters: dict[str, Any] = field(
        default_factory=dict, metadata=rule("further parameters of the slosh FMU: variable = value", empty=True)
    )


@dataclass
class Sweep:
    """Many points from one case: what each computes, and which keys take which values (module `plan` reads them)."""

    command: str = key("point", "what each point computes: point, boundary", choices=["point", "boundary"])
    mode: str = key(
        "grid",
        "grid: every combination; list: the first values together, then the second ones, …; latin-hypercube: drawn from ranges",
        choices=["grid", "list", "latin-hypercube"],
    )
    samples: int = key(20, "latin-hypercube: points", low=1, high=100000)
    seed: int = key(1, "latin-hypercube: seed of the random numbers", low=0)
    parameters: dict[str, Any] = field(
        default_factory=dict,
        metadata=rule('"table.key" = [values], or { from, to, count, spacing = "linear" or "log" }'),
    )


@dataclass
class Output:
    """What a run writes."""

    pictures: bool = key(True, "PNG pictures")
    fields: bool = key(True, "four flow fields over the flutter mode's last period (VTK, for the Mach picture and ParaView)")
