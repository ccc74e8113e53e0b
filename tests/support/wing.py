"""A wing by value, in files with keys changed or left out, and the same wing in other words."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.case import Case

WING: dict[str, dict[str, Any]] = {
    "section": {
        "chord": 2.0, "elastic_axis": 0.35, "mass": 60.0 * math.pi, "x_cg": 0.45, "inertia": 15.0 * math.pi,
        "plunge_frequency": 4.0, "pitch_frequency": 10.0,
    },
    # 1.2 kg/m3 in the master's air (R = 287.05)
    "flow": {"mach": 0.5, "static_pressure": 1.2 * 287.05 * 300.0, "static_temperature": 300.0, "airfoil": "NACA 0012"},
}  # fmt: skip
SOUND = math.sqrt(1.4 * 287.05 * 300.0)


def write(path: Path, **changes: Any) -> Path:
    """WING as a file, with keys (table__key) changed, or left out where None."""
    tables: dict[str, dict[str, Any]] = {name: dict(content) for name, content in WING.items()}
    for dotted, value in changes.items():
        table, _, key = dotted.partition("__")
        tables.setdefault(table, {})[key] = value
    lines = []
    for table, content in tables.items():
        lines.append(f"[{table}]")
        lines += [f"{k} = {v!r}".replace("'", '"') for k, v in content.items() if v is not None]
    path.write_text("\n".join(lines) + "\n")
    return path


def loaded(tmp_path: Path, command: str = "point", overrides: tuple[str, ...] = (), **changes: Any) -> Case:
    return cases.load(write(tmp_path / "wing.toml", **changes), overrides, command)


def refused(tmp_path: Path, command: str = "point", overrides: tuple[str, ...] = (), **changes: Any) -> str:
    with pytest.raises(AeroSloshError) as caught:
        loaded(tmp_path, command, overrides, **changes)
    assert caught.value.code == ExitCode.INPUT and caught.value.remedy
    return str(caught.value)


FORMS = {  # the same wing in other words
    "imbalance": {"section__x_cg": None, "section__static_imbalance": 12.0 * math.pi},
    "inertia about the centre of mass": {"section__inertia": None, "section__inertia_cg": (15.0 - 60.0 * 0.04) * math.pi},
    "pitch stiffness": {
        "section__pitch_frequency": None, "section__pitch_stiffness": 15.0 * math.pi * (20.0 * math.pi) ** 2,
    },
    "plunge stiffness": {
        "section__plunge_frequency": None, "section__plunge_stiffness": 60.0 * math.pi * (8.0 * math.pi) ** 2,
    },
    "dimensionless centre of mass": {"section__x_cg": None, "section__x_alpha": 0.2},
    "dimensionless inertia": {"section__inertia": None, "section__r2_alpha": 0.25},
    "dimensionless plunge": {"section__plunge_frequency": None, "section__frequency_ratio": 0.4},
    "airspeed": {"flow__mach": None, "flutter__airspeed": 0.5 * SOUND},
    "equivalent airspeed": {"flow__mach": None, "flutter__equivalent_airspeed": 0.5 * SOUND * math.sqrt(1.2 / 1.225)},
    "dynamic pressure": {"flow__mach": None, "flutter__dynamic_pressure": 0.5 * 1.2 * (0.5 * SOUND) ** 2},
    "all dimensionless": {
        "section__mass": None, "section__x_cg": None, "section__inertia": None, "section__plunge_frequency": None,
        "section__pitch_frequency": None, "section__mass_ratio": 50.0, "section__x_alpha": 0.2, "section__r2_alpha": 0.25,
        "section__frequency_ratio": 0.4, "flutter__V_f": 0.5 * SOUND / (20.0 * math.pi * math.sqrt(50.0)),
    },
}  # fmt: skip
