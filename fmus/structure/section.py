"""Typical section with plunge and pitch: matrices, exact free motion under loads linear in time.

    M q'' + C q' + K q = Q,   q = (h [m], alpha [rad]),   Q = (force down [N/m], moment nose-up [N])

    M = [[m + m_l, S + S_l], [S + S_l, I + I_l]]     C = diag(2 zeta_h m w_h, 2 zeta_alpha I w_alpha)
    K = diag(m w_h^2, I w_alpha^2 + k_l)

per metre of span, `h` positive down, `alpha` nose-up, about the elastic axis; m_l, S_l, I_l, k_l are the
liquid carried frozen. Over a step the state y = (h, alpha, h', alpha') follows the matrix exponential of the
system augmented with the linear load (Van Loan 1978, doi:10.1109/TAC.1978.1101743), so the step size makes no
error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

Array = NDArray[np.float64]
CACHED_STEPS = 256
SINGULAR = 1e-9  # a mass matrix whose determinant is below this share of its products is taken for singular


class SectionError(ValueError):
    """Section data that no structure can have; the text names the parameter and the remedy."""


@dataclass(frozen=True)
class SectionData:
    """Structural data per metre of span; defaults: Isogai case A in air at 288 K, 101325 Pa, chord 1 m."""

    mass: float = 57.73  # [kg/m]
    static_imbalance: float = 51.957  # [kg], positive where the centre of gravity is aft of the elastic axis
    inertia: float = 50.2251  # [kg m], about the elastic axis
    omega_h: float = 100.0  # [rad/s], uncoupled, without liquid
    omega_alpha: float = 100.0  # [rad/s]
    damping_ratio_h: float = 0.0
    damping_ratio_alpha: float = 0.0
    liquid_mass: float = 0.0  # [kg/m]
    liquid_static_moment: float = 0.0  # [kg]
    liquid_inertia: float = 0.0  # [kg m]
    liquid_stiffness: float = 0.0  # [N/rad], may be negative


class Section:
    """Matrices of a section and its exact propagation. Stateless but for a cache of propagators.

    Attributes:
        M, C, K: mass, damping and stiffness matrix. Shape: (2, 2).

    Raises:
        SectionError: mass matrix not positive definite, or negative pitch stiffness.
    """

    def __init__(self, data: SectionData) -> None:
        imbalance = data.static_imbalance + data.liquid_static_moment
        mass = data.mass + data.liquid_mass
        inertia = data.inertia + data.liquid_inertia
        self.M: Array = np.array([[mass, imbalance], [imbalance, inertia]])
        self.C: Array = np.diag(
            [
                2.0 * data.damping_ratio_h * data.mass * data.omega_h,
                2.0 * data.damping_ratio_alpha * data.inertia * data.omega_alpha,
            ]
        )
        self.K: Array = np.diag([data.mass * data.omega_h**2, data.inertia * data.omega_alpha**2 + data.liquid_stiffness])
        if not (mass > 0.0 and mass * inertia > (1.0 + SINGULAR) * imbalance**2):
            raise SectionError(
                f"the mass matrix is not positive definite: mass {mass:g} kg/m, inertia {inertia:g} kg m, "
                f"static imbalance {imbalance:g} kg (liquid included). Remedy: inertia must be above "
                f"imbalance^2 / mass = {imbalance**2 / mass if mass > 0.0 else np.inf:g} kg m"
            )
        if self.K[1, 1] < 0.0:
            raise SectionError(
                f"the pitch stiffness is negative: inertia omega_alpha^2 + liquid_stiffness = "
                f"{self.K[1, 1]:g} N. Remedy: raise omega_alpha, or lower the liquid"
            )
        self._M_inverse: Array = np.linalg.inv(self.M).astype(np.float64)
        self._propagators: dict[float, tuple[Array, Array, Array]] = {}

    def natural_frequencies(self) -> Array:
        """Return the undamped natural frequencies, ascending [rad/s]. Shape: (2,)."""
        squares = np.sort(np.linalg.eigvals(self._M_inverse @ self.K).real)
        return np.asarray(np.sqrt(np.maximum(squares, 0.0)))

    def acceleration(self, y: Array, load: Array) -> Array:
        """Return (h'' [m/s2], alpha'' [rad/s2]) in state `y` under `load`. Shapes: (2,), (4,), (2,)."""
        return self._M_inverse @ (load - self.C @ y[2:] - self.K @ y[:2])

    def energy(self, y: Array) -> float:
        """Return kinetic and strain energy, liquid included [J/m]. `y` has shape (4,)."""
        q, rate = y[:2], y[2:]
        return float(0.5 * (rate @ self.M @ rate + q @ self.K @ q))

    def propagate(self, y: Array, load_start: Array, load_end: Array, duration: float) -> Array:
        """Return the state after `duration` [s] under a load linear in time.

        Shapes: `y` and result (4,), loads (2,) = (force down [N/m], moment nose-up [N]).
        """
        if duration <= 0.0:
            return y
        free, constant, ramp = self._propagator(duration)
        return free @ y + constant @ load_start + ramp @ (load_end - load_start)

    def _propagator(self, duration: float) -> tuple[Array, Array, Array]:
        """Return the matrices of state, constant load and load rising by one. Shapes: (4, 4), (4, 2), (4,
        2).
        """
        if duration not in self._propagators:
            if len(self._propagators) >= CACHED_STEPS:
                self._propagators.clear()
            # time in steps and rates per step balance the matrix: the exponential keeps its digits
            scale = np.array([1.0, 1.0, duration, duration])
            A = np.zeros((8, 8))
            A[:2, 2:4] = np.eye(2)
            A[2:4, :2] = -self._M_inverse @ self.K * duration**2
            A[2:4, 2:4] = -self._M_inverse @ self.C * duration
            A[2:4, 4:6] = self._M_inverse * duration**2
            A[4:6, 6:8] = np.eye(2)
            E = expm(A)
            self._propagators[duration] = (
                E[:4, :4] * scale[None, :] / scale[:, None],
                E[:4, 4:6] / scale[:, None],
                E[:4, 6:8] / scale[:, None],
            )
        return self._propagators[duration]
