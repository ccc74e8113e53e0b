"""Sweeps over keys by value: every point is converted anew."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.case import atmosphere, dimensions
from aeroslosh.master.case import case as cases
from aeroslosh.master.case.scales import scales
from aeroslosh.master.sweeps import parameters, plan
from support.wing import write


def planned(tmp_path: Path, text: str, **changes: Any) -> plan.Plan:
    fmus = tmp_path / "fmus"
    fmus.mkdir(exist_ok=True)
    for name in ("structure", "aero"):
        (fmus / f"{name}.fmu").write_bytes(name.encode())
    path = write(tmp_path / "wing.toml", **changes)
    path.write_text(path.read_text() + text)
    case = cases.load(path)
    return plan.make(case, parameters.from_case(case, path), fmus, str(path))


def test_a_sweep_over_altitude_converts_every_point(tmp_path: Path) -> None:
    text = '[sweep.parameters]\n"flow.altitude" = [0.0, 5000.0, 10000.0]\n'
    made = planned(tmp_path, text, flow__static_pressure=None, flow__static_temperature=None)
    assert len({p.id for p in made.points}) == 3
    for point, altitude in zip(made.points, (0.0, 5000.0, 10000.0), strict=True):
        c = point.case
        s = scales(c, c.flow.mach, c.flutter.V_f)
        assert c.flow.static_pressure == atmosphere.air(altitude)[0]
        assert (s.mass, s.omega_alpha) == pytest.approx((60.0 * math.pi, 20.0 * math.pi), rel=1e-13)
        assert dimensions.stream(s)["pressure_altitude"] == pytest.approx(altitude, abs=1e-6)
    ratios = [p.case.section.mass_ratio for p in made.points]
    assert ratios[2] / ratios[0] == pytest.approx(1.225 / 0.412707, rel=1e-5)


def test_sweeps_over_other_keys_by_value(tmp_path: Path) -> None:
    made = planned(tmp_path, '[sweep.parameters]\n"section.mass" = { from = 100.0, to = 200.0, count = 3 }\n')
    assert [p.case.section.mass for p in made.points] == [100.0, 150.0, 200.0]
    assert [p.case.section.mass_ratio * 1.2 * math.pi for p in made.points] == pytest.approx([100.0, 150.0, 200.0])
    with pytest.raises(AeroSloshError, match=r"flutter\.V_f and section\.pitch_frequency are both given"):
        planned(tmp_path, '[sweep.parameters]\n"flutter.V_f" = [0.4, 0.5]\n')


def test_a_sweep_s_case_toml_is_read_again(tmp_path: Path) -> None:
    """What the sweep brings is in no other form in the folder's case."""
    path = write(tmp_path / "wing.toml", flow__static_pressure=None, flow__static_temperature=None)
    path.write_text(path.read_text() + '[sweep.parameters]\n"flow.altitude" = [0.0, 5000.0]\n')
    case = cases.load(path)
    case.given |= {"flow.altitude"}
    (tmp_path / "again.toml").write_text(cases.dump(case))
    again = cases.load(tmp_path / "again.toml")
    moved = [cases.changed(c, {"flow.altitude": 5000.0}, "here", "point") for c in (case, again)]
    assert moved[0].section == moved[1].section and moved[0].flow == moved[1].flow
