"""Which knowns move which outputs, seen from outside: `python influence.py <unzip folder>` prints it as JSON.

{"initially": {output: {known: how it moves the initial value}}, "stepping": {output: {input: how, between two steps}}}

A known is changed a little, and by a lot, from several points where nothing is zero. It moves an output "clearly", or "in its
last bits". What only reads or writes files is left as it is.
"""

from __future__ import annotations

import json
import sys
import tempfile
from pathlib import Path
from typing import Any

from cases_values import bounds, start_of
from cheap import PARAMETERS, STEP
from raw import OK, Raw, kind

FILES = ("field_folder", "section_file", "write_fields")
ROUNDING = 1e-11


def _surfaces() -> list[str]:
    """Two files of a surface, half a tank of the preset each."""
    folder = Path(tempfile.mkdtemp(prefix="surfaces_"))
    for number, rise in enumerate((0.01, 0.02)):
        (folder / f"{number}.csv").write_text(f"0,{0.075 + rise}\n0.5,{0.075 - rise}\n", encoding="utf-8")
    return [str(folder / f"{number}.csv") for number in range(2)]


SURFACES = _surfaces()
INSTRUMENTS: dict[str, Any] = {
    "probe_count": 6,
    "gauge_count": 4,
    **{f"probe{n}_{axis}": size * n for n in range(1, 7) for axis, size in (("x", 0.07), ("y", 0.02), ("extent", 0.005))},
    **{f"gauge{n}_x": 0.11 * n for n in range(1, 5)},
}
# points to start from, beside the cheap parameters: no known may hide behind a zero or an option
POINTS: dict[str, list[dict[str, Any]]] = {
    "structure": [
        {"liquid_mass": 3.0, "liquid_static_moment": 0.7, "liquid_inertia": 0.9, "liquid_stiffness": 20.0,
         "damping_ratio_h": 0.02, "damping_ratio_alpha": 0.03, "initial_h_dot": 0.3, "initial_alpha_dot": 0.2, "trim_lift": 5.0,
         "trim_moment": 3.0, "load_prediction": 0},
        {"forced_cycles": 2.0, "initial_h": 0.0, "initial_alpha": 0.0},
        {"forced_cycles": 0.0, "initial_h": 0.0, "initial_alpha": 0.0, "forced_ramp_cycles": 0.0},
        {"forced_cycles": 2.0, "initial_h": 0.0, "initial_alpha": 0.0, "forced_ramp_cycles": 0.0},
    ],
    "aero": [{"mean_alpha": 0.01, "mach": 0.5, "tolerance": 0.02}],
    "slosh_ems": [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "modes": 4},
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "modes": 4, "damping_ratio": 0.01, "limit": 0},
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "modes": 4, "parametric": 1},
    ],
    "slosh_rbf": [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05},
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "network": "ems"},
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "network": "bilinear"},
    ],
    "slosh_vof": [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "surface_tension": 0.05, "gas_density": 2.0},
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "initial_wave": 0.0, "gas_density": 2.0},
    ]
    + [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "initial_wave": 0.0, "gas_density": 2.0, "baffle_count": 2,
         "baffle_bottom": 0.0, "baffle_top": top}
        for top in (0.4, 0.8)
    ]
    + [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "gas_density": 2.0, "initial_wave": 0.0, **INSTRUMENTS, **shape}
        for shape in [{"initial_column": width} for width in (0.31, 0.49)]
        + [{"initial_spectrum": 0.01}, {"initial_file": SURFACES[0]}]
    ]
    + [
        {"tank_width": 1.1, "tank_x": 0.1, "tank_y": 0.05, "gas_density": 2.0, "baffle_count": 2, "baffle_bottom": 0.0,
         "baffle_top": top, "initial_wave": wave, **INSTRUMENTS, "probe_count": count, "gauge_count": min(count, 4)}
        for count, top, wave in ((6, 0.4, 0.01), (6, 0.8, 0.0), (4, 0.4, 0.0), (3, 0.4, 0.0), (2, 0.4, 0.0), (1, 0.4, 0.0))
    ],
}  # fmt: skip
TEXTS = {
    "airfoil": ["NACA 0012"],
    "ribs": ["x=0", "x=-0.05 open=0:0.06,0.12:0.15; x=0.1"],
    "network": ["ems", "bilinear"],
    "initial_file": SURFACES,
}


def others(name: str, variable: Any, value: Any) -> list[Any]:
    """Values near by and farther away, within the range."""
    if name in FILES:
        return []
    if name in TEXTS:
        return [text for text in TEXTS[name] if text != value]
    if kind(variable) == "Boolean":
        return [1 - value]
    if kind(variable) == "Integer":
        low, high = bounds(variable)
        return [new for new in (value + 1, value + 8, value - 1) if low <= new <= high]
    low, high = bounds(variable)
    size = value if value else 0.01
    far = [low + 0.37 * (high - low)] if high - low < 1e6 else []
    return [new for new in (value + 1e-3 * size, value + 0.11 * size, *far) if low <= new <= high]


def outputs(one: Raw) -> dict[str, Any]:
    """All outputs but those that tell of a failure."""
    return {v.name: one[v.name] for v in one.named("output") if v.name not in ("failed", "error")}


def note(found: dict[str, dict[str, str]], known: str, before: dict[str, Any], after: dict[str, Any]) -> None:
    """Add how `known` moved the outputs."""
    for name, old in before.items():
        new = after[name]
        if new == old or (new != new and old != old):
            continue
        rounding = isinstance(old, float) and abs(new - old) <= ROUNDING * max(abs(old), abs(new))
        if not rounding or known not in found[name]:
            found[name][known] = "in its last bits" if rounding else "clearly"


def begin(one: Raw, values: dict[str, Any]) -> dict[str, Any] | None:
    """Initial outputs for some values of the knowns; None where they are refused."""
    assert one.reset() == OK
    for name, value in values.items():
        if one.put(name, value) != OK:
            return None
    if (one.setup(), one.enter(), one.leave()) != (OK, OK, OK):
        return None
    return outputs(one)


def initially(one: Raw) -> dict[str, dict[str, str]]:
    """Output → knowns → how."""
    component = one.description.modelName
    variables = {v.name: v for v in one.named("parameter") + one.named("input")}
    inputs = {v.name: 0.011 + 0.004 * i for i, v in enumerate(one.named("input", "Real"))}
    found: dict[str, dict[str, str]] = {name: {} for name in outputs(one)}
    for point in POINTS[component]:
        start = {name: start_of(v) for name, v in variables.items()}
        values = {**start, **inputs, **PARAMETERS[component], **point}
        base = begin(one, values)
        assert base is not None, one["error"]
        for name, variable in variables.items():
            for new in others(name, variable, values[name]):
                after = begin(one, {**values, name: new})
                if after is not None:
                    note(found, name, base, after)
    return found


def stepping(one: Raw) -> dict[str, dict[str, str]]:
    """Output → inputs that move it without a step → how."""
    component = one.description.modelName
    found: dict[str, dict[str, str]] = {name: {} for name in outputs(one)}
    assert begin(one, PARAMETERS[component]) is not None
    for step in range(2):
        assert one.step(step * STEP, STEP) == OK
        before = outputs(one)
        for variable in one.named("input"):
            if variable.name in FILES:
                continue
            old = one[variable.name]
            one[variable.name] = old + 0.01
            note(found, variable.name, before, outputs(one))
            one[variable.name] = old
    return found


def main(folder: str) -> None:
    """Both, as JSON."""
    one = Raw(folder, "influence", logging=False)
    print(json.dumps({"initially": initially(one), "stepping": stepping(one)}))


if __name__ == "__main__":
    main(sys.argv[1])
