"""A case: every setting of a flutter run, typed, with unit, range and description; read from TOML, written back resolved.

The tables of the file are the dataclasses below, the keys their fields (module `settings` says how they are read). Angles are
in degrees only where the key ends in `_deg`; everything else is SI and radians."""

from __future__ import annotations

import copy
import dataclasses
import typing
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ..base import settings
from ..base.errors import AeroSloshError
from ..base.settings import key, rule
from ..cosim.coupling_settings import Coupling
from . import airfoils, checks


@dataclass
class Section:
    """The two-degree-of-freedom section, dimensionless (Isogai case A by default)."""

    chord: float = key(1.0, "chord c = 2b", "m", above=0.0)
    elastic_axis: float = key(-0.5, "elastic axis x/c, aft of the leading edge positive", low=-10.0, high=10.0)
    x_alpha: float = key(1.8, "centre of mass aft of the elastic axis / b", low=-20.0, high=20.0)
    r2_alpha: float = key(3.48, "radius of gyration about the elastic axis, squared / b^2", above=0.0)
    frequency_ratio: float = key(1.0, "omega_h / omega_alpha (uncoupled)", low=0.0, high=100.0)
    mass_ratio: float = key(60.0, "mu = m / (pi rho b^2)", above=0.0)
    damping_ratio_h: float = key(0.0, "structural damping ratio in plunge", low=0.0, high=1.0)
    damping_ratio_alpha: float = key(0.0, "structural damping ratio in pitch", low=0.0, high=1.0)


@dataclass
class Flow:
    """The stream. Air is fixed (gamma 1.4, R 287.05): V_f changes the structure's stiffness, not the stream."""

    mach: float = key(0.825, "freestream Mach number", low=0.05, high=0.98)
    static_pressure: float = key(101325.0, "freestream static pressure", "Pa", above=0.0)
    static_temperature: float = key(288.15, "freestream static temperature", "K", above=0.0)
    airfoil: str = key("NACA 64A010", "a NACA 4-, 5-digit or 6A name, or a coordinate file")
    mean_alpha_deg: float = key(0.0, "mean angle of attack; its steady load is trimmed out", "deg", low=-10.0, high=10.0)


@dataclass
class Aero:
    """Settings of the aero FMU; "auto" leaves the FMU's own value."""

    cells_around: int = key(168, "cells around the airfoil", low=64, high=4096)
    cells_normal: int = key(48, "cells from wall to farfield", low=16, high=1024)
    farfield_chords: float = key(25.0, "distance of the outer boundary", "chords", low=5.0, high=1000.0)
    tolerance: float | str = key("auto", "tolerance of the subiterations", above=0.0, choices=["auto"])
    max_subiterations: int | str = key("auto", "most subiterations a step", low=1, choices=["auto"])


@dataclass
class Flutter:
    """One march: steady start, forced pitch, release, free response. Cycles are periods 2 pi / omega_alpha."""

    V_f: float = key(0.612, "flutter speed index U / (b omega_alpha sqrt(mu))", low=0.01, high=50.0)
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
        "linear: eigenvalues of a linear model; march: marches alone; both: marches confirm what the model foretells",
        choices=["linear", "march", "both"],
    )
    linear_amplitude_deg: float | str = key(
        "auto", "amplitude of the linear model's motions; auto: flutter.forced_amplitude_deg", "deg",
        above=0.0, high=20.0, choices=["auto"],
    )  # fmt: skip
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
        "none", "a cheaper model that foretells the slosh loads of a step: none, ems or rbf", choices=["none", "ems", "rbf"]
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
    fields: bool = key(True, "four flow fields of the last free period (VTK files, for the Mach picture and ParaView)")


@dataclass
class Case:
    """All tables. `name` is the file's stem.

    source  the file it was read from, "" for a case made in code, whose defaults (Isogai's case A) are the author's affair
    given   "table.key" of every key that file, overrides or sweep set; the others stand at their default (`case_checks`)"""

    name: str = "isogai_a"
    section: Section = field(default_factory=Section)
    flow: Flow = field(default_factory=Flow)
    aero: Aero = field(default_factory=Aero)
    flutter: Flutter = field(default_factory=Flutter)
    coupling: Coupling = field(default_factory=Coupling)
    boundary: Boundary = field(default_factory=Boundary)
    slosh: Slosh = field(default_factory=Slosh)
    sweep: Sweep = field(default_factory=Sweep)
    output: Output = field(default_factory=Output)
    source: str = field(default="", compare=False)
    given: set[str] = field(default_factory=set, compare=False, repr=False)


TABLES: dict[str, Any] = {name: hint for name, hint in typing.get_type_hints(Case).items() if dataclasses.is_dataclass(hint)}


def load(path: Path, overrides: Sequence[str] = (), command: str = "") -> Case:
    """Read a TOML case and apply `section.key=value` overrides. Raises AeroSloshError (file, line, key, remedy).

    command: "point" or "boundary" refuses a case without the keys that it needs (`case_checks.REQUIRED`); "" only reads: a sweep
    may bring them, and whoever marches the case asks then."""
    data, lines = settings.read(path, "case file", "cases/isogai_a.toml")
    case = Case(name=path.stem, source=str(path))
    if "components" in data:
        raise AeroSloshError("This is a system file, not a case", str(path), f"aeroslosh run {path}")
    settings.fill(case, TABLES, data, lines, path)
    case.given = {f"{table}.{name}" for table, content in data.items() for name in content}
    for override in overrides:
        _override(case, override)  # checked together at the end: two overrides may belong together
    # from here on a coordinate file is named by its full path, wherever the command runs
    case.flow.airfoil = airfoils.found(case.flow.airfoil, path, bool(airfoils.set_by(overrides)))
    if command:
        checks.complete(case, command, str(path))
    checks.together(case, str(path))
    return case


def apply_override(case: Case, override: str) -> None:
    """Apply one `section.key=value` in place; the value is read as TOML, else as a word. Raises AeroSloshError."""
    _override(case, override)
    checks.together(case, f"--set {override}")


def _override(case: Case, override: str) -> None:
    settings.override(case, TABLES, override)
    case.given.add(override.partition("=")[0].strip())


def changed(case: Case, values: Mapping[str, Any], where: str, command: str = "") -> Case:
    """A copy of `case` with the keys `values` (table.key → value), checked together, for `command` as in `load`.

    Raises AeroSloshError."""
    copied = copy.deepcopy(case)
    for dotted, value in values.items():
        table, _, name = dotted.partition(".")
        settings.assign(getattr(copied, table), table, name, value, f"{where}, key {dotted}")
        copied.given.add(dotted)
    if command:
        checks.complete(copied, command, where)
    checks.together(copied, where)
    return copied


def dump(case: Case) -> str:
    """The resolved case as TOML, each key with its unit and description, those at their default marked as such."""
    head = f'# resolved case {case.name}: every key with its value, unit and meaning; "default": nobody gave it\n'
    return head + settings.dump(case, TABLES, case.given if case.source else None)


def flat(case: Case) -> dict[str, Any]:
    """All settings as "table.key" → value."""
    return settings.flat(case, TABLES)
