"""A case to fill in: every key with its meaning, unit, range and default, from the tables' own rules (`tables`).

What a case cannot do without (`checks.REQUIRED`) is written out, with the values of Isogai's case A and the paper's tank as an
example that runs; all other keys are comments that show their defaults."""

from __future__ import annotations

import dataclasses
import textwrap
import typing
from typing import Any

from ..base import settings, toml_text
from ..cosim.coupling_settings import Coupling
from . import by_value, checks
from .tables import Aero, Boundary, Flow, Flutter, Output, Section, Slosh, Structure, Sweep

TABLES: dict[str, Any] = {
    "section": Section, "flow": Flow, "flutter": Flutter, "boundary": Boundary, "slosh": Slosh, "aero": Aero,
    "structure": Structure, "coupling": Coupling, "sweep": Sweep, "output": Output,
}  # fmt: skip
EXAMPLE = {  # where the default is no example that fits: a tank inside the section (cases/paper_s.toml)
    "section.chord": 2.0, "slosh.tank_x": 1.8, "slosh.liquid_density": 800.0, "slosh.liquid_viscosity": 2e-6,
}  # fmt: skip
WIDTH = 110  # columns of a comment


def text(name: str, model: str = "none") -> str:
    """The case `name` as TOML. model: the liquid's, whose keys are then written out as well."""
    wanted = {*checks.REQUIRED["point"], *checks.REQUIRED["boundary"]}
    if model != "none":
        wanted |= {*(checks.TANK if model == "frozen" else checks.MOVING), "slosh.model"}
    parts = [
        f"# {name}: a flutter case for aeroslosh. Replace the values that stand without a # by your own; keys behind a # show\n"
        "# defaults, take the # away to change one. Units are SI, degrees only where a key ends in _deg.\n"
        f"#   aeroslosh point {name}.toml         does it flutter at flow.mach and flutter.V_f?\n"
        f"#   aeroslosh boundary {name}.toml      at which V_f does it, for boundary.mach?\n"
    ]
    for table, kind in TABLES.items():
        content = kind()
        summary = " ".join((kind.__doc__ or "").split())
        hints = typing.get_type_hints(kind)
        lines = [*textwrap.wrap(f"# {summary}", WIDTH, subsequent_indent="# "), f"[{table}]"]
        for f in dataclasses.fields(kind):
            key = f"{table}.{f.name}"
            example = model if key == "slosh.model" else EXAMPLE.get(key, getattr(content, f.name))
            value = example if key in wanted else None
            lines += _key(f, key, hints[f.name], getattr(content, f.name), value)
        parts.append("\n".join(lines) + "\n")
    return "\n".join(parts)


def _key(field: dataclasses.Field[Any], key: str, hint: Any, default: Any, value: Any) -> list[str]:
    """A key with its comment above: written out with `value`, or as a comment with its default."""
    rule = field.metadata
    said = f"{rule['doc']}: {settings.allowed(hint, rule)}"
    if value is None and default is not None:
        said += "; the default is shown" if default not in ([], {}) else ""
    elif value is not None:
        forms = by_value.ALTERNATIVES.get(key, ())
        said += "; required" + (f", or by value: {', '.join(forms)}" if forms else "")
    comment = textwrap.wrap(f"# {said}", WIDTH, subsequent_indent="#   ", break_long_words=False)
    if value is not None:
        return [*comment, f"{field.name} = {toml_text.literal(value)}"]
    return [*comment, f"#{field.name} = {'' if default is None else toml_text.literal(default)}".rstrip()]
