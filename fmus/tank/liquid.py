"""A rectangular tank in a wing section and the liquid in it, carried frozen.

Lengths in metres, masses per metre of span where `width` is 1. Positions are relative to the elastic axis: x aft, y up.
"""

from __future__ import annotations

from dataclasses import dataclass


class TankError(ValueError):
    """Tank data that no tank can have; the text names the parameter and the remedy."""


@dataclass(frozen=True)
class Tank:
    """Rectangular tank, centre at (x, y) [m], filled to fill_level (0 to 1) with liquid of `density` [kg/m3]; gravity [m/s2].

    Raises TankError for a size, density or gravity that is not positive, or a fill outside 0 to 1.
    """

    length: float
    height: float
    width: float = 1.0
    fill_level: float = 0.5
    x: float = 0.0
    y: float = 0.0
    density: float = 1000.0
    gravity: float = 9.81

    def __post_init__(self) -> None:
        for name in ("length", "height", "width", "density", "gravity"):
            if not getattr(self, name) > 0.0:
                raise TankError(f"tank {name} = {getattr(self, name)}. Remedy: give a value above 0")
        if not 0.0 < self.fill_level <= 1.0:
            raise TankError(f"fill_level = {self.fill_level}. Remedy: give a value above 0 and at most 1")

    @property
    def depth(self) -> float:
        """Liquid depth at rest [m]."""
        return self.fill_level * self.height

    @property
    def mass(self) -> float:
        """Liquid mass [kg]."""
        return self.density * self.length * self.depth * self.width

    @property
    def centre_y(self) -> float:
        """Height of the liquid's centre of mass at rest above the elastic axis [m]."""
        return self.y - 0.5 * self.height + 0.5 * self.depth

    @property
    def static_moment(self) -> float:
        """Mass times distance aft of the elastic axis [kg m]."""
        return self.mass * self.x

    @property
    def inertia(self) -> float:
        """Moment of inertia of the frozen liquid about the elastic axis [kg m2]."""
        own = self.mass * (self.length**2 + self.depth**2) / 12.0
        return own + self.mass * (self.x**2 + self.centre_y**2)

    @property
    def stiffness(self) -> float:
        """Pitch stiffness of the frozen liquid's weight [N m/rad]: negative where it stands above the elastic axis."""
        return -self.mass * self.gravity * self.centre_y
