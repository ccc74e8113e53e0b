"""Is a case whole, and does it make sense as a whole? Which keys nobody can do without, and which stand at their default.

A key is required where a wrong value is a wrong answer and no value is a usual one: what the section is (elastic axis, centre of
mass, radius of gyration, frequency and mass ratio, airfoil), where it flies (Mach, V_f), and with a liquid the size of all this
in metres (chord), the tank and what is in it. Another section's values in their place would give a verdict on that section. A key
has a default where there is a usual value (sea level, no mean incidence, no structural damping, 9.81 m/s2, air above the liquid),
where it is only a scale (the chord of a dry section: nothing dimensionless depends on it), and where it is a setting of the
computation. Defaults are told: on the terminal, in case.toml, in the result.

Only cases read from a file are asked for their keys: who makes a `Case` in code sees the defaults of its classes."""

from __future__ import annotations

import dataclasses
from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING, Any

from ..base.errors import AeroSloshError
from . import by_value, plausible

if TYPE_CHECKING:
    from .case import Case

SECTION = (
    "section.elastic_axis", "section.x_alpha", "section.r2_alpha", "section.frequency_ratio", "section.mass_ratio",
    "flow.airfoil",
)  # fmt: skip
REQUIRED = {  # command → keys; "setup": an open setup, which is told its Mach number and V_f
    "setup": SECTION,
    "point": (*SECTION, "flow.mach", "flutter.V_f"),
    "boundary": (*SECTION, "boundary.mach"),
}
TANK = (
    "section.chord", "slosh.tank_length", "slosh.tank_height", "slosh.fill_level", "slosh.tank_x", "slosh.tank_y",
    "slosh.liquid_density",
)  # fmt: skip
MOVING = (*TANK, "slosh.liquid_viscosity")  # a frozen liquid has no friction
READS = {  # the tables that decide what a command computes, those told key by key first
    "point": ("section", "flow", "slosh", "flutter", "aero", "structure", "coupling"),
    "boundary": ("section", "flow", "slosh", "flutter", "boundary", "aero", "structure", "coupling"),
}
IDLE = {"boundary": ("flow.mach",)}  # keys that a command does not read
TOLD = ("section", "flow", "slosh")  # tables whose defaults are told with their values: they are physics
STARTS = ("initial_h", "initial_alpha", "initial_h_dot")  # parameters of the structure FMU that disturb a free start
_OWN = ("ems", "rbf", "vof", "implicit", "iqn-ils")  # a key's description begins with what it belongs to


def required(case: Case, command: str) -> tuple[str, ...]:
    """The keys that `command` ("setup", "point" or "boundary") cannot do without in this case."""
    model = case.slosh.model
    return REQUIRED[command] + {"none": (), "frozen": TANK}.get(model, MOVING)


def complete(case: Case, command: str, where: str) -> None:
    """Refuse a case read from a file in which a required key is missing in all its forms. Raises AeroSloshError that names all
    of them; also for keys by value that have been changed since they were converted."""
    if command == "setup" and not by_value.settled(case):
        raise AeroSloshError(
            "The case's keys by value were changed after they had been converted", where, "change a case with `case.changed`"
        )
    if case.source:
        liquid = f' with slosh.model = "{case.slosh.model}"' if case.slosh.model != "none" else ""
        asks = "march" if command == "setup" else command
        names = required(case, command)
        require(case, names, {name for name in names if by_value.known(case, name)}, where, f"a {asks}{liquid}")


def require(holder: Any, names: Sequence[str], given: Collection[str], where: str, asks: str) -> None:
    """Refuse to go without one of the keys `names` (table.key) of the tables of `holder`; `asks`: who wants them.

    Raises AeroSloshError that names all that are missing, each with its meaning and unit."""
    missing = [name for name in names if name not in given]
    if not missing:
        return
    lines = []
    for name in missing:
        table, _, key = name.partition(".")
        rule = next(f.metadata for f in dataclasses.fields(getattr(holder, table)) if f.name == key)
        forms = by_value.ALTERNATIVES.get(name, ())
        lines.append(f"            {name}: {rule['doc']}" + ("" if rule["unit"] == "1" else f" [{rule['unit']}]"))
        lines[-1] += f"; or by value: {' or '.join(forms)}" if forms else ""
    count, them = ("a key", "it") if len(missing) == 1 else (f"{len(missing)} keys", "them")
    raise AeroSloshError(
        f"The case leaves out {count} that {asks} cannot do without: {', '.join(missing)}",
        where,
        f"write {them} in the case ([{missing[0].replace('.', '] ', 1)} = …), or give --set {missing[0]}=VALUE; "
        "no other case's value stands in:\n" + "\n".join(lines),
    )


def defaults(case: Case, command: str) -> dict[str, Any]:
    """table.key → value of the keys that `command` reads in this case and nobody gave."""
    found = {}
    for table in READS[command]:
        if table == "slosh" and case.slosh.model == "none":
            continue
        content = getattr(case, table)
        for f in dataclasses.fields(content):
            name = f"{table}.{f.name}"
            value = getattr(content, f.name)
            nobodys = name not in case.given and name not in case.derived and value is not None and f.name != "parameters"
            if nobodys and name not in IDLE.get(command, ()) and _matters(case, f.metadata["doc"]):
                found[name] = value
    return found


def told(case: Case, command: str) -> str:
    """The defaults in one line: those of the physics by name and value, of the others their number. "" where there are none."""
    found = defaults(case, command)
    if not found:
        return ""
    shown, others = [], dict.fromkeys(READS[command], 0)
    for name, value in found.items():
        table, _, key = name.partition(".")
        if table not in TOLD:
            others[table] += 1
            continue
        unit = next(f.metadata["unit"] for f in dataclasses.fields(getattr(case, table)) if f.name == key)
        shown.append(f"{name} = {value:g}" if isinstance(value, float) else f"{name} = {value}")
        shown[-1] += "" if unit == "1" else f" {unit}"
    shown += [f"{count} of [{table}]" for table, count in others.items() if count]
    keys = "1 key at its default" if len(found) == 1 else f"{len(found)} keys at their default"
    return f"{keys}: {', '.join(shown)} (case.toml marks each)"


def _matters(case: Case, doc: str) -> bool:
    """Whether a key of a model or scheme belongs to the one chosen."""
    owner = doc.partition(":")[0]
    if owner not in _OWN:
        return True
    scheme = case.coupling.scheme == "implicit"
    chosen = {"implicit": scheme, "iqn-ils": scheme and case.coupling.acceleration == "iqn-ils"}
    return chosen.get(owner, owner in (case.slosh.model, case.slosh.predictor))


def together(case: Case, where: str) -> None:
    """Refuse what no single key can tell, and units that cannot be. Raises AeroSloshError."""
    plausible.refuse(case, where)
    s, f, b = case.section, case.flutter, case.boundary
    if case.slosh.predictor == case.slosh.model != "none" or (case.slosh.predictor != "none" and case.slosh.model == "none"):
        raise AeroSloshError(
            f'slosh.predictor = "{case.slosh.predictor}" for slosh.model = "{case.slosh.model}"',
            where,
            "a cheaper model of the moving liquid predicts a more expensive one: ems or rbf for vof, ems for rbf",
        )
    known = not case.source or all(by_value.known(case, name) for name in ("section.x_alpha", "section.r2_alpha"))
    if known and s.r2_alpha <= s.x_alpha**2:
        raise AeroSloshError(
            f"section.r2_alpha = {s.r2_alpha:g} is not above x_alpha^2 = {s.x_alpha**2:g}: the mass matrix is not positive",
            where,
            "the radius of gyration is about the elastic axis: r2_alpha = x_alpha^2 + (r_cg/b)^2",
        )
    starts = [f"structure.parameters.{name}" for name in case.structure.parameters if name in STARTS]
    if f.forced_cycles > 0.0 and starts:
        raise AeroSloshError(
            f"{starts[0]} has no effect while the pitch is forced",
            case.places.get(starts[0], where),
            "set flutter.forced_cycles = 0 for a free start, or leave it out",
        )
    if f.forced_cycles == 0.0 and f.initial_alpha_dot == 0.0 and not starts:
        raise AeroSloshError(
            "Nothing disturbs the section: flutter.forced_cycles and flutter.initial_alpha_dot are both 0",
            where,
            "force at least one cycle, or give an initial pitch rate",
        )
    if f.forced_cycles > 0.0 and f.initial_alpha_dot != 0.0:
        raise AeroSloshError(
            "flutter.initial_alpha_dot has no effect while the pitch is forced",
            where,
            "set flutter.forced_cycles = 0 for a free start, or the rate to 0",
        )
    if f.forced_cycles > 0.0 and f.forced_amplitude_deg == 0.0:
        raise AeroSloshError("flutter.forced_amplitude_deg is 0", where, "give an amplitude, for instance 1")
    if len(b.V_f_range) != 2 or b.V_f_range[0] >= b.V_f_range[1]:
        raise AeroSloshError(f"boundary.V_f_range = {b.V_f_range} is not [low, high]", where, "write V_f_range = [0.2, 3.0]")
    twice = sorted({m for m in b.mach if b.mach.count(m) > 1})
    if twice:
        raise AeroSloshError(f"boundary.mach names {twice[0]:g} twice", where, "give each Mach number once")
