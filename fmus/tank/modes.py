"""Linear slosh of a rectangular tank: modal masses, frequencies and heights, fixed mass and inertia.

Graham and Rodriguez, J. Appl. Mech. 19 (1952) 381; NASA SP-106 (1966), chapter 6; Ibrahim, Liquid Sloshing Dynamics (2005). Only
antisymmetric modes are excited at first order; heights are measured up from the liquid's centre of mass. A full tank has no
surface and so no modes: its liquid moves as in a closed box.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .liquid import Tank

Array = NDArray[np.float64]

_SERIES = 400
"""Terms of the series of the rigid-lid inertia: they fall with the fifth power."""


@dataclass(frozen=True)
class Modes:
    """Modal parameters of a tank.

    omega [rad/s], mass [kg], height [m] and elevation (of the surface at x' = +length/2 per displacement of the modal mass) have
    shape (modes,); fixed_mass [kg], fixed_height [m], fixed_inertia [kg m2] of the part that does not slosh;
    lid_inertia [kg m2]: of the liquid under a rigid lid, about its centre of mass.

    What the modes left out still do: rest_mass [kg] at rest_height [m] hangs in the tank without following it sideways (limit
    "high"; 0 for "low"); their surface stays level, which shifts weight by rest_tilt [kg m] and raises the surface at
    x' = +length/2 by rest_elevation [m], both per radian of tilt.
    """

    omega: Array
    mass: Array
    height: Array
    elevation: Array
    fixed_mass: float
    fixed_height: float
    fixed_inertia: float
    lid_inertia: float
    rest_mass: float
    rest_height: float
    rest_tilt: float
    rest_elevation: float

    @property
    def stiffness(self) -> Array:
        """Modal springs [N/m], shape (modes,)."""
        return self.mass * self.omega**2


def modes(tank: Tank, count: int, limit: str = "low") -> Modes:
    """The first `count` modes of a tank.

    limit: what the modes beyond do. "low": they move with the tank (right far below their frequencies), their mass is fixed mass;
    "high": they stay behind (right far above): fixed mass and inertia are those of infinitely many modes.
    """
    if count < 1 or limit not in ("low", "high"):
        raise ValueError(f"modes = {count}, limit = '{limit}'. Remedy: at least one mode, limit 'low' or 'high'")
    first = _oscillators(tank, count)
    rest = first if limit == "low" else _oscillators(tank, 2000)
    omega, mass, height = first
    fixed_mass = tank.mass - float(np.sum(rest[1]))
    fixed_height = -float(np.sum(rest[1] * rest[2])) / fixed_mass
    lid = lid_inertia(tank)
    fixed_inertia = lid - fixed_mass * fixed_height**2 - float(np.sum(rest[1] * rest[2] ** 2))
    rest_mass = float(np.sum(rest[1][count:]))
    rest_height = float(np.sum((rest[1] * rest[2])[count:])) / rest_mass if rest_mass > 0.0 else 0.0
    q = 2 * np.arange(1, count + 1) - 1
    elevation = _surface(tank) * 4 * np.tanh(q * np.pi * tank.depth / tank.length) / (q * np.pi)
    # of all modes together: the level surface of a tilted tank
    tilt = _surface(tank) * tank.mass * tank.length**2 / (12 * tank.depth)
    rise = _surface(tank) * tank.length / 2
    rest_tilt = tilt - float(np.sum(mass / omega**2)) * tank.gravity
    rest_elevation = rise - float(np.sum(elevation / omega**2)) * tank.gravity
    return Modes(omega, mass, height, elevation, fixed_mass, fixed_height, fixed_inertia, lid,
                 rest_mass, rest_height, rest_tilt, rest_elevation)  # fmt: skip


def _surface(tank: Tank) -> float:
    """1, or 0 where the tank is full."""
    return float(tank.fill_level < 1.0)


def _oscillators(tank: Tank, count: int) -> tuple[Array, Array, Array]:
    q = 2 * np.arange(1, count + 1) - 1
    wave = q * np.pi / tank.length
    depth = wave * tank.depth
    omega = np.sqrt(tank.gravity * wave * np.tanh(depth))
    mass = _surface(tank) * tank.mass * 8 * np.tanh(depth) / (np.pi**3 * q**3.0 * tank.depth / tank.length)
    height = tank.depth * (0.5 - np.tanh(0.5 * depth) / (0.5 * depth))
    return omega, mass, height


def lid_inertia(tank: Tank) -> float:
    """Moment of inertia [kg m2] of the liquid in a closed box of its own shape that turns about its centre of mass."""
    r = tank.depth / tank.length
    q = 2 * np.arange(1, _SERIES + 1) - 1
    series = float(np.sum(np.tanh(q * np.pi * r / 2) / q**5.0))
    frozen = tank.mass * (tank.length**2 + tank.depth**2) / 12.0
    return frozen * (1 - 4 / (1 + r**2) + 768 / np.pi**5 / (r * (1 + r**2)) * series)


def wave_frequencies(tank: Tank, halves: Array) -> Array:
    """Frequencies [rad/s] of standing waves with `halves` half waves in the tank's length (odd: antisymmetric)."""
    wave = halves * np.pi / tank.length
    return np.sqrt(tank.gravity * wave * np.tanh(wave * tank.depth))


def stokes_damping(tank: Tank, omega: Array, viscosity: float, halves: Array | None = None) -> Array:
    """Damping ratios, shape like omega [rad/s], of modes from laminar wall layers and the bulk, two-dimensional.

    viscosity: kinematic [m2/s]; halves: half waves in the tank's length, 1, 3, 5 … unless given. Derived from the boundary-layer
    dissipation of the potential mode: right where the layers are thin, damping ratios well below 1.
    """
    wave = _wave_numbers(tank, omega, halves)
    return layer_damping(tank, omega, viscosity, halves) + 2 * viscosity * wave**2 / omega


def layer_damping(tank: Tank, omega: Array, viscosity: float, halves: Array | None = None) -> Array:
    """The part of `stokes_damping` that is the wall layers'."""
    wave = _wave_numbers(tank, omega, halves)
    twice = 2 * wave * tank.depth
    # sinh overflows for short waves, where both terms vanish
    sinh = np.sinh(np.minimum(twice, 300.0))
    layer = (1 - twice / sinh) / tank.length + wave / sinh
    return np.sqrt(viscosity / (2 * omega)) * layer


def _wave_numbers(tank: Tank, omega: Array, halves: Array | None) -> Array:
    q = 2 * np.arange(1, len(omega) + 1) - 1 if halves is None else halves
    return np.asarray(q * np.pi / tank.length)
