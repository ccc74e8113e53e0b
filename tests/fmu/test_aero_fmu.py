"""The aero FMU through FMPy: rollback, several instances, bad input, VTK files."""

from __future__ import annotations

import base64
from collections.abc import Callable
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from aeroslosh.fmus.aero.airfoil import contour

Fmu = Callable[[str], Path]
Host = Callable[..., Any]
STEP = 1.0e-3
ERROR = 3  # fmi2Error


def test_description_has_no_problems(fmu: Fmu) -> None:
    assert validate_fmu(str(fmu("aero"))) == []


def test_rollback_and_restart_in_a_new_process_are_exact_to_the_bit(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    kept = str(tmp_path / "state")
    seen = host("aero_rollback", str(fmu("aero")), STEP, kept)
    assert seen["first"] == seen["second"]
    assert seen["first"][0] != seen["first"][-1]
    assert host("aero_resume", str(fmu("aero")), STEP, kept) == seen["first"]


def test_two_flows_and_a_structure_live_in_one_process(fmu: Fmu, host: Host) -> None:
    seen = host("family", str(fmu("aero")), str(fmu("structure")))
    assert seen["alpha"] > 0
    # compressibility: the faster flow carries more lift
    assert 0.05 < seen["slow"] < seen["fast"] < 0.5


def test_long_steps_at_low_speed_are_divided(fmu: Fmu, host: Host) -> None:
    """At Mach 0.1 sound outruns the stream: undivided, these steps diverge."""
    rows = host("slow_stream", str(fmu("aero")))
    assert all(status == 0 for status, _, _ in rows)
    assert sum(converged for _, converged, _ in rows) >= 6
    # the apparent mass of the start fades: lift a radian falls towards its steady value
    slopes = [slope for _, _, slope in rows]
    assert slopes == sorted(slopes, reverse=True)
    assert 5.0 < slopes[-1] < 20.0


def test_two_hundred_instances(fmu: Fmu, host: Host) -> None:
    assert host("many_flows", str(fmu("aero")), 200, {"cells_around": 64, "cells_normal": 16}) == 200


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"mach": 3.0}, ["'mach' = 3.0", "at most 0.98"]),
        ({"airfoil": "99Z999"}, ["airfoil '99Z999'", "NACA 4- or 5-digit", "Remedy"]),
        ({"static_temperature": -1.0}, ["'static_temperature' = -1.0"]),
        ({"cells_around": 8}, ["'cells_around' = 8", "at least 64"]),
        ({"max_subiterations": 1}, ["'max_subiterations' = 1", "at least 3"]),
    ],
    ids=["mach", "airfoil", "temperature", "cells", "subiterations"],
)
def test_bad_parameters_are_clear_errors(fmu: Fmu, host: Host, values: dict[str, Any], words: list[str]) -> None:
    seen = host("bad_start", str(fmu("aero")), values)
    assert seen["failed"] is True
    assert seen["status"] == ERROR
    for word in words:
        assert word in seen["error"]


def test_self_intersecting_airfoil_file_is_named(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    points = contour("0012")[::5].copy()
    points[20:40] = points[20:40][::-1]
    path = tmp_path / "knot.dat"
    np.savetxt(path, points)
    seen = host("bad_start", str(fmu("aero")), {"airfoil": str(path)})
    assert seen["failed"] is True
    assert "knot.dat" in seen["error"]
    assert "crosses itself" in seen["error"]
    assert any("Traceback" in text for _, _, text in seen["log"])


def test_not_a_number_as_input_is_refused_and_the_instance_lives_on(fmu: Fmu, host: Host) -> None:
    seen = host("bad_input", str(fmu("aero")), "alpha_dot")
    assert seen["statuses"] == [ERROR, 0]
    assert "'alpha_dot' = nan" in seen["error"]
    assert seen["failed"] is False


def values(path: Path, name: str) -> np.ndarray:
    element = next(e for e in ElementTree.parse(path).iter("DataArray") if e.attrib["Name"] == name)
    raw = base64.b64decode(element.text or "")
    assert int(np.frombuffer(raw[:8], "<u8")[0]) == len(raw) - 8
    return np.frombuffer(raw[8:], {"Float32": "<f4", "Int64": "<i8"}[element.attrib["type"]])


def test_fields_are_written_on_request(fmu: Fmu, host: Host, tmp_path: Path) -> None:
    folder = tmp_path / "fields"
    folder.mkdir()
    seen = host("aero_fields", str(fmu("aero")), str(folder))
    assert seen["files"] == ["fields_000002.vts", "surface_000002.vtp"]
    assert seen["status"] == ERROR
    assert "field_folder" in seen["error"]
    mach = values(folder / "fields_000002.vts", "mach").reshape(16, 64)
    np.testing.assert_allclose(mach[-1], 0.8, atol=0.01)
    points = values(folder / "fields_000002.vts", "points").reshape(17, 65, 3)
    # leading edge half a chord aft of the elastic axis, sunk by the plunge of one centimetre
    nose = points[0, 32]
    np.testing.assert_allclose(nose, [0.5, -0.01, 0.0], atol=1e-6)
    pressure = values(folder / "surface_000002.vtp", "pressure_coefficient")
    assert 0.9 < pressure.max() < 1.2  # stagnation at Mach 0.8: 1.17
    assert len(pressure) == 64
