"""Linear aerodynamics behind the face of aero.fmu: a rational model read from the JSON file that `airfoil` names.

C(s) = D0 + D1 s + sum R_j s/(s + p_j), in half chords travelled, of the motions (h/b)' and alpha (tests/support/possio.py).
"""

import json
import math
from pathlib import Path

import numpy as np
from double_base import Double, pin

pin(globals())

REALS = (
    ("mach", 0.3, "1"),
    ("mean_alpha", 0.0, "rad"),
    ("chord", 1.0, "m"),
    ("elastic_axis", 0.25, "1"),
    ("static_pressure", 101325.0, "Pa"),
    ("static_temperature", 288.15, "K"),
    ("farfield_chords", 200.0, "1"),
)


class Plate(Double):
    VARIABLES = (
        *((name, "parameter", start, unit) for name, start, unit in REALS),
        ("airfoil", "parameter", "", ""),
        ("cells_around", "parameter", 48, ""),
        ("cells_normal", "parameter", 16, ""),
        ("h", "input", 0.0, "m"),
        ("h_dot", "input", 0.0, "m/s"),
        ("h_ddot", "input", 0.0, "m/s2"),
        ("alpha", "input", 0.0, "rad"),
        ("alpha_dot", "input", 0.0, "rad/s"),
        ("alpha_ddot", "input", 0.0, "rad/s2"),
        ("lift", "output", 0.0, "N/m"),
        ("moment", "output", 0.0, "N"),
        ("C_L", "output", 0.0, "1"),
        ("C_M", "output", 0.0, "1"),
    )
    STATE = ("model", "memory", "u", "U", "b", "q")
    model, memory, u = None, None, None
    U = b = q = 0.0

    def begin(self):
        table = json.loads(Path(self.airfoil).read_text(encoding="utf-8"))
        self.model = {name: np.array(table[name]) for name in ("poles", "D0", "D1", "R")}
        self.b = 0.5 * self.chord
        self.U = self.mach * math.sqrt(1.4 * 287.05 * self.static_temperature)
        self.q = 0.5 * self.static_pressure / (287.05 * self.static_temperature) * self.U**2
        self.u = self._motion()
        self.memory = np.zeros((self.model["poles"].size, 2))
        self._loads()

    def advance(self, time, dt):
        ds, u, p = dt * self.U / self.b, self._motion(), self.model["poles"][:, None]
        slope, e = (u - self.u) / ds, np.exp(-p * ds)
        self.memory = self.memory * e + slope * (1.0 - e) / p  # z' = −p z + u' with u linear in the step
        self.u = u
        self._loads()

    def _motion(self):
        return np.array([self.h_dot / self.U, self.alpha])

    def _loads(self):
        rate = np.array([self.h_ddot, self.alpha_dot * self.U]) * self.b / self.U**2
        m = self.model
        C = m["D0"] @ self.u + m["D1"] @ rate + np.einsum("jab,jb->a", m["R"], self.memory)
        self.C_L, self.C_M = float(C[0]), float(C[1])
        self.lift, self.moment = self.C_L * self.q * self.chord, self.C_M * self.q * self.chord**2
