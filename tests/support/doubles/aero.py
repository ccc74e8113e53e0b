"""Thin airfoil in unsteady incompressible flow behind the face of aero.fmu: Wagner's function after R. T. Jones.

The airfoil's name plays tricks: "FAIL n" raises in step n, "NAN n" gives a lift of nan in step n, "CUBIC k" adds a
restoring moment −k q c² α³ (limits the amplitude), "UNSTEADY" does not converge at the start.
"""

import base64
import math
import struct
from pathlib import Path

import numpy as np
from double_base import Double, pin

pin(globals())

A, B = np.array([0.165, 0.335]), np.array([0.0455, 0.3])
REALS = (
    ("mach", 0.3, "1"),
    ("mean_alpha", 0.0, "rad"),
    ("chord", 1.0, "m"),
    ("elastic_axis", 0.25, "1"),
    ("static_pressure", 101325.0, "Pa"),
    ("static_temperature", 288.15, "K"),
    ("farfield_chords", 200.0, "1"),
    ("tolerance", 1e-6, "1"),
)


class Aero(Double):
    VARIABLES = (
        *((name, "parameter", start, unit) for name, start, unit in REALS),
        ("airfoil", "parameter", "NACA 0012", ""),
        ("field_folder", "parameter", "", ""),
        ("cells_around", "parameter", 48, ""),
        ("cells_normal", "parameter", 16, ""),
        ("max_subiterations", "parameter", 10, ""),
        ("h", "input", 0.0, "m"),
        ("h_dot", "input", 0.0, "m/s"),
        ("h_ddot", "input", 0.0, "m/s2"),
        ("alpha", "input", 0.0, "rad"),
        ("alpha_dot", "input", 0.0, "rad/s"),
        ("alpha_ddot", "input", 0.0, "rad/s2"),
        ("write_fields", "input", False, ""),
        ("lift", "output", 0.0, "N/m"),
        ("moment", "output", 0.0, "N"),
        ("C_L", "output", 0.0, "1"),
        ("C_M", "output", 0.0, "1"),
        ("C_D", "output", 0.0, "1"),
        ("subiterations", "output", 0, ""),
        ("residual", "output", 0.0, "1"),
        ("converged", "output", False, ""),
        ("cost_seconds", "output", 0.0, "s"),
    )
    STATE = ("lag", "w", "step", "files", "rho", "U", "b", "a", "trick", "at")
    lag, w, step, files = np.zeros(2), 0.0, 0, 0
    rho = U = b = a = 0.0
    trick = at = ""

    def begin(self):
        self.rho = self.static_pressure / (287.05 * self.static_temperature)
        self.U = self.mach * math.sqrt(1.4 * 287.05 * self.static_temperature)
        self.b, self.a = 0.5 * self.chord, 2.0 * self.elastic_axis - 1.0
        self.trick, self.at = [*self.airfoil.split(), "0"][:2]
        self.w = self._downwash()
        self.lag = np.full(2, self.w)
        self._loads()
        self.subiterations, self.converged = 1, self.trick != "UNSTEADY"

    def advance(self, time, dt):
        self.step += 1
        if self.trick == "FAIL" and self.step == int(self.at):
            raise ValueError("the test double was told to fail (100 % on purpose)")
        w, rate = self._downwash(), B * self.U / self.b
        slope, e = (w - self.w) / dt, np.exp(-rate * dt)
        # lag' = rate (w - lag) with w linear in the step
        self.lag = w - slope / rate + (self.lag - self.w + slope / rate) * e
        self.w = w
        self._loads()
        if self.trick == "NAN" and self.step == int(self.at):
            self.lift = math.nan
        if self.write_fields and self.field_folder:
            self._write()

    def _downwash(self):
        alpha = self.alpha + self.mean_alpha
        return self.U * alpha + self.h_dot + self.b * (0.5 - self.a) * self.alpha_dot

    def _loads(self):
        rho, U, b, a = self.rho, self.U, self.b, self.a
        effective = self.w * (1.0 - A.sum()) + A @ self.lag
        circulatory = 2.0 * math.pi * rho * U * b * effective
        mass = math.pi * rho * b**2
        q = 0.5 * rho * U**2
        self.lift = float(circulatory + mass * (self.h_ddot + U * self.alpha_dot - b * a * self.alpha_ddot))
        self.moment = float(
            b * (a + 0.5) * circulatory
            + mass * (b * a * self.h_ddot - U * b * (0.5 - a) * self.alpha_dot - b**2 * (0.125 + a**2) * self.alpha_ddot)
        )
        if self.trick == "CUBIC":
            self.moment -= float(self.at) * q * self.chord**2 * self.alpha**3
        self.C_L, self.C_M = self.lift / (q * self.chord), self.moment / (q * self.chord**2)

    def _write(self):
        """An O-mesh about an ellipse, moved with the section, with a made-up Mach number."""
        ni, nj = self.cells_around, self.cells_normal
        theta, r = np.meshgrid(np.linspace(0, 2 * np.pi, ni + 1), np.geomspace(1.0, 20.0, nj + 1))
        x = self.chord * (0.5 + 0.5 * r * np.cos(theta))
        y = -self.chord * 0.5 * (r - 1.0 + 0.12) * np.sin(theta)
        axis = self.elastic_axis * self.chord
        c, s = math.cos(self.alpha), math.sin(self.alpha)
        points = np.stack([(x - axis) * c + y * s, -self.h - (x - axis) * s + y * c, 0 * x], axis=-1)
        tm, rm = 0.5 * (theta[1:, 1:] + theta[1:, :-1]), 0.5 * (r[1:, 1:] + r[:-1, 1:])
        mach = self.mach + (0.4 + 4 * self.alpha) * np.maximum(np.sin(-tm), -0.5) / rm**2
        cells = {
            "mach": mach,
            "pressure_coefficient": -mach,
            "density": 1 + 0 * mach,
            "velocity": np.stack([mach, 0 * mach, 0 * mach], axis=-1),
        }
        extent = f"0 {ni} 0 {nj} 0 0"
        data = "".join(
            f'<DataArray type="Float32" Name="{n}" format="binary"'
            + (' NumberOfComponents="3">' if v.ndim == 3 else ">")
            + _encode(v)
            + "</DataArray>"
            for n, v in cells.items()
        )
        nodes = f'<DataArray type="Float32" NumberOfComponents="3" format="binary">{_encode(points)}</DataArray>'
        Path(self.field_folder, f"fields_{self.files:06d}.vts").write_text(
            '<VTKFile type="StructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">'
            f'<StructuredGrid WholeExtent="{extent}"><Piece Extent="{extent}"><Points>{nodes}</Points>'
            f"<CellData>{data}</CellData></Piece></StructuredGrid></VTKFile>"
        )
        self.files += 1


def _encode(values):
    raw = np.ascontiguousarray(values, dtype="<f4").tobytes()
    return base64.b64encode(struct.pack("<Q", len(raw)) + raw).decode()
