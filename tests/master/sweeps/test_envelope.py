"""Altitude and speed at which a wing flutters, from boundaries over altitude and Mach number."""

from __future__ import annotations

import csv
import io
from typing import Any

import pytest

from aeroslosh.master.sweeps import envelope
from aeroslosh.master.sweeps.ledger import Row

SOUND = {0.0: 340.0, 5000.0: 320.0}


def row(altitude: float, mach: float, margin: float | None, fill: float = 0.5, holds: bool | None = None) -> Row:
    """A finished point whose wing has V_f 0.5 Mach / 0.7 of its own."""
    own, speed = 0.5 * mach / 0.7, mach * SOUND[altitude]
    data: dict[str, Any] = {"own_V_f": own, "margin": margin, "airspeed": speed, "equivalent_airspeed": 0.9 * speed}
    data |= {"dynamic_pressure": 0.5 * speed**2, "pressure_altitude": altitude}
    result = {"points": [{"mach": mach, "by_value": data, "slosh_holds": holds}]}
    overrides = {envelope.ALTITUDE: altitude, envelope.MACH: mach, "slosh.fill_level": fill}
    return Row(f"{altitude}{mach}", 0, overrides, "done", True, result, "x.nc", "", "", "", 1, "w", 1.0, 1.0)


NAMES = (envelope.ALTITUDE, envelope.MACH, "slosh.fill_level")


def test_margins_that_pass_one_give_matched_points() -> None:
    rows = [row(0.0, 0.8, 0.9), row(0.0, 0.7, 1.1), row(5000.0, 0.7, 1.3), row(5000.0, 0.8, 1.2)]
    (found,) = envelope.points(rows, NAMES)
    # V_f neutral 0.55 and 0.5143, own 0.5 and 0.5714: apart by +0.05 and -0.0571
    mach = 0.7 + 0.1 * 0.05 / (0.05 + 0.1 * 0.5 * 0.8 / 0.7)
    assert found["altitude"] == 0.0 and found["mach"] == pytest.approx(mach, rel=1e-12) and found["onset"] is True
    assert found["airspeed"] == pytest.approx(mach * 340.0) and found["equivalent_airspeed"] == pytest.approx(0.9 * mach * 340.0)
    told = envelope.lines([found], rows)
    assert "altitude 0 m: flutters from about Mach 0.7467" in told[0] and "altitude 5000 m: the margin" in told[1]
    (line,) = csv.DictReader(io.StringIO(envelope.as_csv([found], NAMES).decode()))
    assert float(line["mach"]) == found["mach"] and line["slosh.fill_level"] == "0.5" and line["mach_above"] == "0.8"


def test_each_value_of_another_key_has_its_own_and_doubt_gives_none() -> None:
    rows = [row(0.0, m, g, f) for f, g7, g8 in ((0.2, 1.1, 0.9), (0.8, 0.9, 1.1)) for m, g in ((0.7, g7), (0.8, g8))]
    found = envelope.points(rows, NAMES)
    assert [(p["slosh.fill_level"], p["onset"]) for p in found] == [(0.2, True), (0.8, False)]
    assert envelope.points([row(0.0, 0.7, 1.1), row(0.0, 0.8, 0.9, holds=False)], NAMES) == []
    assert envelope.points([row(0.0, 0.7, 1.1), row(0.0, 0.8, None)], NAMES) == []


def test_only_boundaries_over_altitude_and_mach_number_have_one() -> None:
    assert envelope.wanted("boundary", NAMES)
    assert not envelope.wanted("point", NAMES) and not envelope.wanted("boundary", NAMES[1:])
