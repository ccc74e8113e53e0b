"""m x'' + c x' + k x = force, exact for a force linear over the step."""

import numpy as np
from double_base import Double, pin
from scipy.linalg import expm

pin(globals())


class Oscillator(Double):
    VARIABLES = (
        ("mass", "parameter", 1.0, "kg"),
        ("damping", "parameter", 0.0, "kg/s"),
        ("stiffness", "parameter", 1.0, "N/m"),
        ("initial_x", "parameter", 0.0, "m"),
        ("initial_v", "parameter", 0.0, "m/s"),
        ("force", "input", 0.0, "N"),
        ("x", "output", 0.0, "m"),
        ("v", "output", 0.0, "m/s"),
        ("a", "output", 0.0, "m/s2"),
    )
    STATE = ("old_force", "cached")
    old_force, cached = 0.0, (0.0, None)

    def begin(self):
        self.x, self.v, self.old_force = self.initial_x, self.initial_v, self.force
        self._accelerate()

    def advance(self, time, dt):
        if self.cached[0] != dt:
            block = np.zeros((4, 4))
            block[:2, :2] = [[0, 1], [-self.stiffness / self.mass, -self.damping / self.mass]]
            block[1, 2], block[2, 3] = 1.0 / self.mass, 1.0
            self.cached = (dt, expm(block * dt))
        z = self.cached[1] @ [self.x, self.v, self.old_force, (self.force - self.old_force) / dt]
        self.x, self.v, self.old_force = float(z[0]), float(z[1]), self.force
        self._accelerate()

    def _accelerate(self):
        self.a = (self.force - self.damping * self.v - self.stiffness * self.x) / self.mass
