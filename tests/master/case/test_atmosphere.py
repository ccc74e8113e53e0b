"""The standard atmosphere against published tables, hydrostatics, and its own inverse."""

from __future__ import annotations

import math

import pytest

from aeroslosh.master.case import atmosphere

TABLE = (  # geopotential altitude [m], T [K], p [Pa], rho [kg/m3]: ISO 2533:1975, table 5; US Standard Atmosphere 1976, table I
    (-2000.0, 301.15, 1.27774e5, 1.47808),
    (0.0, 288.15, 1.01325e5, 1.225),
    (1000.0, 281.65, 8.98746e4, 1.11164),
    (5000.0, 255.65, 5.40199e4, 7.36116e-1),
    (10000.0, 223.15, 2.64363e4, 4.12707e-1),
    (11000.0, 216.65, 2.26321e4, 3.63918e-1),
    (20000.0, 216.65, 5.47489e3, 8.80349e-2),
    (32000.0, 228.65, 8.68019e2, 1.32250e-2),
    (47000.0, 270.65, 1.10906e2, 1.42753e-3),
)


@pytest.mark.parametrize(("altitude", "temperature", "pressure", "density"), TABLE)
def test_published_values(altitude: float, temperature: float, pressure: float, density: float) -> None:
    p, T = atmosphere.air(altitude)
    assert pytest.approx(temperature, abs=1e-9) == T
    assert p == pytest.approx(pressure, rel=6e-6)  # the tables' last digit
    assert p / (atmosphere.R * T) == pytest.approx(density, rel=6e-6)


@pytest.mark.parametrize("altitude", [-3000.0, 5000.0, 15000.0, 25000.0, 40000.0])
def test_air_is_hydrostatic(altitude: float) -> None:
    (above, _), (below, _), (p, T) = (atmosphere.air(altitude + dh) for dh in (1.0, -1.0, 0.0))
    assert (above - below) / 2.0 == pytest.approx(-atmosphere.G0 * p / (atmosphere.R * T), rel=1e-6)


@pytest.mark.parametrize("foot", [11000.0, 20000.0, 32000.0])
def test_layers_meet(foot: float) -> None:
    (p, T), (q, S) = atmosphere.air(foot - 1e-6), atmosphere.air(foot)
    assert p == pytest.approx(q, rel=1e-9) and pytest.approx(S, rel=1e-9) == T


@pytest.mark.parametrize("altitude", [-5000.0, -1.0, 0.0, 9000.0, 11000.0, 13000.0, 20000.0, 31000.0, 47000.0])
def test_pressure_altitude_is_the_inverse(altitude: float) -> None:
    assert atmosphere.pressure_altitude(atmosphere.air(altitude)[0]) == pytest.approx(altitude, abs=1e-6)


def test_beyond_the_tables() -> None:
    for altitude in (-5001.0, 47001.0, math.nan):
        with pytest.raises(ValueError, match="-5000 to 47000"):
            atmosphere.air(altitude)
    assert all(math.isnan(atmosphere.pressure_altitude(p)) for p in (0.0, 50.0, 2e5))


def test_equivalent_airspeed_has_the_same_dynamic_pressure() -> None:
    p, T = atmosphere.air(10000.0)
    density = p / (atmosphere.R * T)
    equivalent = atmosphere.equivalent(250.0, density)
    assert 0.5 * 1.225 * equivalent**2 == pytest.approx(0.5 * density * 250.0**2, rel=1e-14)
    assert equivalent == pytest.approx(145.11, abs=0.01)  # 250 sqrt(0.336904), the density ratio of the table
