"""The standard atmosphere: pressure and temperature at an altitude and back, in closed form.

Layers of constant temperature gradient L over geopotential altitude H, hydrostatic: with H_b, T_b, p_b at the foot of a layer

    T = T_b + L (H - H_b)
    p = p_b (T / T_b)^(-g0 / (R L)),   or p_b exp(-g0 (H - H_b) / (R T_b)) where L = 0

Source: ISO 2533:1975, tables 1 and 4; U.S. Standard Atmosphere 1976 (NASA-TM-X-74335), table 4 and equations 23, 33a, 33b: the
same up to 47 km, but for R = 287.05287 there and 287.05307 here (1e-6 of the pressure at 11 km). Altitude is geopotential, what
an altimeter set to 1013.25 hPa shows; the geometric one is r H / (r - H) with r = 6356766 m, 17 m more at 10500 m."""

from __future__ import annotations

import math
from dataclasses import dataclass

G0 = 9.80665  # m/s2
R = 287.05287  # J/(kg K), ISO 2533
SEA_LEVEL_PRESSURE, SEA_LEVEL_TEMPERATURE, SEA_LEVEL_DENSITY = 101325.0, 288.15, 1.225  # Pa, K, kg/m3
LOWEST, HIGHEST = -5000.0, 47000.0  # m, geopotential
_FEET = ((0.0, -6.5e-3), (11000.0, 0.0), (20000.0, 1.0e-3), (32000.0, 2.8e-3))  # H_b [m], L [K/m]


@dataclass(frozen=True)
class Layer:
    """One layer: `foot` [m], `gradient` [K/m], `temperature` [K] and `pressure` [Pa] at its foot."""

    foot: float
    gradient: float
    temperature: float
    pressure: float

    def temperature_at(self, altitude: float) -> float:
        """T at `altitude` [m]."""
        return self.temperature + self.gradient * (altitude - self.foot)

    def pressure_at(self, altitude: float) -> float:
        """p at `altitude` [m]."""
        if self.gradient == 0.0:
            return self.pressure * math.exp(-G0 * (altitude - self.foot) / (R * self.temperature))
        return self.pressure * (self.temperature_at(altitude) / self.temperature) ** (-G0 / (R * self.gradient))

    def altitude_at(self, pressure: float) -> float:
        """The altitude [m] of `pressure` [Pa]."""
        ratio = pressure / self.pressure
        if self.gradient == 0.0:
            return self.foot - R * self.temperature / G0 * math.log(ratio)
        return self.foot + self.temperature / self.gradient * (ratio ** (-R * self.gradient / G0) - 1.0)


def _layers() -> tuple[Layer, ...]:
    layers = [Layer(*_FEET[0], SEA_LEVEL_TEMPERATURE, SEA_LEVEL_PRESSURE)]
    for foot, gradient in _FEET[1:]:
        below = layers[-1]
        layers.append(Layer(foot, gradient, below.temperature_at(foot), below.pressure_at(foot)))
    return tuple(layers)


LAYERS = _layers()


def air(altitude: float) -> tuple[float, float]:
    """Pressure [Pa] and temperature [K] at a geopotential altitude [m] from -5000 to 47000. Raises ValueError outside."""
    if not LOWEST <= altitude <= HIGHEST:
        raise ValueError(f"altitude {altitude:g} m is not in {LOWEST:g} to {HIGHEST:g} m")
    layer = next((one for one in reversed(LAYERS) if altitude >= one.foot), LAYERS[0])
    return layer.pressure_at(altitude), layer.temperature_at(altitude)


def pressure_altitude(pressure: float) -> float:
    """The geopotential altitude [m] at which the standard atmosphere has `pressure` [Pa]; nan outside -5000 to 47000 m."""
    layer = next((one for one in reversed(LAYERS) if pressure <= one.pressure), LAYERS[0])
    altitude = layer.altitude_at(pressure) if pressure > 0.0 else math.nan
    inside = LOWEST - 1e-6 <= altitude <= HIGHEST + 1e-6  # but for rounding
    return min(max(altitude, LOWEST), HIGHEST) if inside else math.nan


def equivalent(speed: float, density: float) -> float:
    """Equivalent airspeed [m/s], of the same dynamic pressure at sea level, of a true one [m/s] in air of `density` [kg/m3]."""
    return speed * math.sqrt(density / SEA_LEVEL_DENSITY)
