"""Slosh under gravity that changes in time: modal masses on parabolic tracks in the moving tank, at finite angle.

Mass n slides on the track x' = x_T + s, y' = y_n + kappa s²/2 with kappa = omega_n²/g, y_n = y_L + H_n. Newton's law along it
(Coriolis' force does no work on it) reads

    (1 + kappa² s²)(s'' + 2 zeta omega s') + kappa² s s'² = f_x + kappa s f_y

with f the body force felt at the mass (gravity less the acceleration of that point of the wing, tank.motion.body_force). To first
order in s this is linear potential theory with the gravity of the moment (Benjamin and Ursell, Proc. R. Soc. A 225 (1954) 505,
doi:10.1098/rspa.1954.0218): s'' + 2 zeta omega s' + (kappa g_n − alpha'²) s = f_x(x_T, y_n), g_n = −f_y. The tracks make it an
exact mechanical system: no energy comes in but by the work of the loads, which are those of the accelerated masses.

Time steps: exponential collocation at Gauss points (Hochbruck and Ostermann, Appl. Numer. Math. 53 (2005) 323,
doi:10.1016/j.apnum.2004.08.005): the oscillators are exact, the rest N = s'' + 2 zeta omega s' + omega² s is a polynomial through
its values at the points, found by fixed-point sweeps over all points and modes at once. A step that does not settle, or whose
polynomial still bends in its last coefficient, is halved.
"""

from __future__ import annotations

import numpy as np

from ..tank.frozen import Load, to_inertial
from ..tank.liquid import Tank
from ..tank.modes import Modes
from ..tank.motion import SectionMotion
from ..tank.oscillators import Array, Complex
from .linear import LinearSlosh

POINTS = 6
SWEEPS = 30
SETTLED = 1e-13  # last change of the amplitudes over the largest of them
BEND = 1e-6  # last coefficient's share: the ends of the step are far more accurate than the polynomial
SPLITS = 14
LONGEST = 8.0  # phase [rad] of the fastest mode in one step
_CACHED_STEPS = 64

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(POINTS)
_SHARES = 0.5 * (_NODES + 1.0)
_POWERS = np.arange(6.0)[:, None]
_LAST = 0.5 * _WEIGHTS * np.polynomial.legendre.legval(_NODES, [0.0] * (POINTS - 1) + [1.0]) * (2 * POINTS - 1)
"""Values at the points → last coefficient of their Legendre series."""


class SurfaceLost(RuntimeError):
    """The surface no longer is one: the text says why and the remedy."""


class ParametricSlosh(LinearSlosh):
    """The modes of LinearSlosh on their tracks; same state."""

    def __init__(self, tank: Tank, modes: Modes, damping: Array) -> None:
        super().__init__(tank, modes, damping)
        self.kappa = modes.omega**2 / tank.gravity
        self._collocations: dict[float, tuple[Complex, Complex]] = {}

    def advance(self, w: Complex, course: Array, duration: float) -> Complex:
        """Amplitudes after `duration` [s]. Raises SurfaceLost where no step is small enough, or the surface leaves the tank."""
        with np.errstate(all="ignore"):  # a sweep that runs away is seen and the step halved
            w = self._advance(w, course, duration, 0.0, 1.0, SPLITS)
        rise = float(self.modes.elevation @ self.oscillators.displacement(w))
        if abs(rise) > self.tank.length:
            raise SurfaceLost(
                f"the surface rose by {rise:.3g} m at the wall, more than the tank is long: effective gravity was negative, or a "
                "wave is in parametric resonance. Remedy: parametric = false, fewer modes, more damping_ratio, or slosh_vof"
            )
        return w

    def _advance(self, w: Complex, course: Array, duration: float, start: float, share: float, splits: int) -> Complex:
        """Amplitudes after the part from `start` to `start` + `share` of the step."""
        new = None
        if duration * share * self.modes.omega[-1] <= LONGEST:
            new = self._collocate(w, course @ (start + share * _SHARES) ** _POWERS, duration * share)
        if new is not None:
            return new
        if splits == 0:
            raise SurfaceLost(
                f"slosh cannot be followed in steps of {duration * share:.1e} s. Remedy: parametric = false, fewer modes, slower "
                "motion, or slosh_vof"
            )
        half = 0.5 * share
        middle = self._advance(w, course, duration, start, half, splits - 1)
        return self._advance(middle, course, duration, start + half, half, splits - 1)

    def _collocate(self, w: Complex, motion: Array, duration: float) -> Complex | None:
        """Amplitudes after one collocation step, None where it does not settle. motion: at the points, shape (9, POINTS)."""
        free, weights = self._collocation(duration)
        felt = self._felt(motion)
        drift = free * w
        now = drift[:POINTS]
        for _ in range(SWEEPS):
            N = self._rest(now, felt)
            new = drift[:POINTS] + (weights[:POINTS] * N).sum(axis=1)
            scale = float(np.abs(new).max())
            change = float(np.abs(new - now).max())
            if not change < 1e100:
                return None
            now = new
            if change <= SETTLED * scale:
                break
        else:
            return None
        bend = duration * float(np.abs(_LAST @ N).max())
        if bend > BEND * scale:
            return None
        return drift[POINTS] + (weights[POINTS] * N).sum(axis=0)

    def _collocation(self, duration: float) -> tuple[Complex, Complex]:
        """exp(c lambda T) and the weights of the values at the points, at the points and the end.

        Shapes: (POINTS + 1, modes), (POINTS + 1, POINTS, modes).
        """
        if duration not in self._collocations:
            if len(self._collocations) >= _CACHED_STEPS:
                self._collocations.clear()
            z = self.oscillators.rate * duration
            ends = np.append(_SHARES, 1.0)
            # Gauss quadrature of exp((c − t) z) L_j(t) over 0 to c
            nodes, weights = np.polynomial.legendre.leggauss(24)
            t = 0.5 * ends[:, None] * (nodes + 1.0)
            basis = np.stack([np.prod([(t - other) / (own - other) for other in _SHARES if other != own], axis=0)
                              for own in _SHARES])  # fmt: skip
            decay = np.exp((ends[:, None] - t)[:, :, None] * z)
            found = np.einsum("c,q,jcq,cqn->cjn", 0.5 * ends * duration, weights, basis, decay)
            self._collocations[duration] = np.exp(ends[:, None] * z), found
        return self._collocations[duration]

    def _felt(self, motion: Array) -> tuple[Array, ...]:
        """Body force along x' and y' at the elastic axis, alpha'² and alpha'', at the points. Shapes: (points, 1)."""
        _, _, h_ddot, alpha, rate, turn, _, _, x_ddot = motion[:, :, None]
        s, c = np.sin(alpha), np.cos(alpha)
        down = self.tank.gravity - h_ddot
        return down * s - x_ddot * c, -down * c - x_ddot * s, rate**2, turn

    def _rest(self, w: Complex, felt: tuple[Array, ...]) -> Array:
        """N = s'' + 2 zeta omega s' + omega² s [m/s2]; shapes of w: (points, modes)."""
        along, up, spin, turn = felt
        s, v = self.oscillators.displacement(w), self.oscillators.velocity(w)
        slope = self.kappa * s
        x, y = self.tank.x + s, self.lever + 0.5 * slope * s
        force = along - y * turn + x * spin + slope * (up + x * turn + y * spin)
        return (force - self.kappa * slope * v**2) / (1.0 + slope**2) + self.modes.omega**2 * s

    def energy(self, w: Complex, motion: SectionMotion) -> float:
        """Energy of the masses on their tracks, kinetic in tank axes and potential above their lowest points [J]."""
        s, v = self.oscillators.displacement(w), self.oscillators.velocity(w)
        lowest = np.tan(motion.alpha) / self.kappa
        kinetic = (1.0 + (self.kappa * s) ** 2) * v**2
        return 0.5 * float(self.modes.mass @ (kinetic + self.modes.omega**2 * np.cos(motion.alpha) * (s - lowest) ** 2))

    def load(self, w: Complex, motion: SectionMotion) -> Load:
        """Whole load: of the masses on their tracks, exact at any angle, of the fixed part, and of the modes left out."""
        tank, modes, m = self.tank, self.modes, self.modes.mass
        along, up, spin, turn = (float(value[0, 0]) for value in self._felt(np.array(motion)[:, None]))
        rate = motion.alpha_dot
        s, v = self.oscillators.displacement(w), self.oscillators.velocity(w)
        a = self._rest(w[None], self._felt(np.array(motion)[:, None]))[0] - modes.omega**2 * s
        a = a - 2.0 * self.oscillators.damping * modes.omega * v
        slope = self.kappa * s
        x, y, v_y, a_y = tank.x + s, self.lever + 0.5 * slope * s, slope * v, self.kappa * v**2 + slope * a
        f_x = m * (along - y * turn + x * spin - a - 2.0 * rate * v_y)
        f_y = m * (up + x * turn + y * spin - a_y + 2.0 * rate * v)
        x_0, y_0, m_0 = tank.x, self.fixed_lever, modes.fixed_mass
        f_x0, f_y0 = m_0 * (along - y_0 * turn + x_0 * spin), m_0 * (up + x_0 * turn + y_0 * spin)
        moment = float(y @ f_x - x @ f_y) + y_0 * f_x0 - x_0 * f_y0 - modes.fixed_inertia * turn
        load = to_inertial(float(f_x.sum()) + f_x0, float(f_y.sum()) + f_y0, moment, motion.alpha)
        # modes left out hang in the tank (limit "high"): they take vertical force alone; in both limits their surface stays level
        sin, cos = np.sin(motion.alpha), np.cos(motion.alpha)
        x_r, y_r = tank.x, tank.centre_y + modes.rest_height
        lift = modes.rest_mass * (-sin * (along - y_r * turn + x_r * spin) + cos * (up + x_r * turn + y_r * spin))
        arm = x_r * cos + y_r * sin
        tilt = modes.rest_tilt * tank.gravity * sin
        return Load(load.force_x, load.force_y + lift, load.moment - arm * lift + tilt)
