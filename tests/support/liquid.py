"""Section and slosh FMU without air: marched through the master, and the same as one linear system."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.linalg import eig

from aeroslosh.master.case import fuel_tank
from aeroslosh.master.cosim.scheme import Scheme
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.fmi.component import Component

Fmu = Callable[[str | Path], Path]
SECTION = {"mass": 230.9, "static_imbalance": 415.6, "inertia": 803.5}  # Isogai's ratios on a chord of 2 m
TANK = {"tank_x": 1.8, "liquid_density": 800.0, "damping_ratio": 0.005, "modes": 3}


def march(
    fmu: Fmu, scheme: Scheme, dt: float, steps: int, section: Mapping[str, float], tank: Mapping[str, Any], split: str = "frozen"
) -> dict[str, np.ndarray]:
    """Free motion from the section's initial values: time [s] and every Real output of both, (steps + 1,) each."""
    structure, liquid = Component(fmu("structure"), "structure"), Component(fmu("slosh_ems"), "slosh")
    system = System([structure, liquid], wires(fuel_tank.wiring(split)))
    try:
        still = dict.fromkeys(("initial_h", "initial_alpha", "initial_h_dot", "initial_alpha_dot"), 0.0)
        liquid.set_all(tank)
        liquid.initialize()
        carried = {name: liquid.get(name) for name in fuel_tank.CARRIED} if split == "frozen" else {}
        force, moment = (liquid.get(name) for name in fuel_tank.LOADS[split])
        liquid.restart()
        liquid.set_all(tank)
        structure.set_all(still | dict(section) | carried | {"trim_lift": force, "trim_moment": moment})
        system.initialize()
        scheme.reset(system)
        rows = [np.concatenate([c.outputs.values for c in system.components])]
        for _ in range(steps):
            scheme.step(system, dt)
            rows.append(np.concatenate([c.outputs.values for c in system.components]))
        names = [f"{c.name}.{name}" for c in system.components for name in c.outputs.names]
    finally:
        system.close()
    table = np.array(rows).T
    return {"time": dt * np.arange(steps + 1)} | dict(zip(names, table, strict=True))


def system(section: Mapping[str, float], tank: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """M, C, K of q = (h, alpha, s_1 … s_N): section and modal masses of a half-full tank 0.5 x 0.15 m, in one system.

    Graham and Rodriguez (1952) with the fixed part of the N modes; plunge row positive down, moment nose-up. The surface of the
    modes left out stays level, which is all that is left of them: −g (m_T l²/(12 h_f) − sum m_n g/omega_n²) in the pitch
    stiffness.
    """
    l, depth, g = 0.5, 0.075, 9.81
    m_T, N = tank["liquid_density"] * l * depth, tank["modes"]
    x_T, y_L = tank["tank_x"], tank.get("tank_y", 0.0) - 0.075 + 0.5 * depth
    q = 2.0 * np.arange(1, N + 1) - 1.0
    k = q * np.pi / l
    omega = np.sqrt(g * k * np.tanh(k * depth))
    m = m_T * 8.0 * np.tanh(k * depth) / (np.pi**3 * q**3 * depth / l)
    H = depth * (0.5 - np.tanh(0.5 * k * depth) / (0.5 * k * depth))
    r, p = depth / l, 2.0 * np.arange(1, 400) - 1.0
    series = np.sum(np.tanh(p * np.pi * r / 2.0) / p**5)
    box = m_T * (l**2 + depth**2) / 12.0
    I_f = box * (1.0 - 4.0 / (1.0 + r**2) + 768.0 / np.pi**5 / (r * (1.0 + r**2)) * series)
    m_0 = m_T - m.sum()
    H_0 = -(m @ H) / m_0
    I_0 = I_f - m_0 * H_0**2 - m @ H**2
    y = y_L + H
    M, C, K = (np.zeros((2 + N, 2 + N)) for _ in range(3))
    M[0, 0] = section["mass"] + m_T
    M[0, 1] = M[1, 0] = section["static_imbalance"] + m_T * x_T
    M[1, 1] = section["inertia"] + I_0 + m_T * x_T**2 + m_0 * (y_L + H_0) ** 2 + m @ y**2
    M[1, 2:] = M[2:, 1] = m * y
    K[0, 0] = section["mass"] * section["omega_h"] ** 2
    K[1, 1] = section["inertia"] * section["omega_alpha"] ** 2 - m_T * g * y_L
    K[1, 1] -= g * (m_T * l**2 / (12.0 * depth) - np.sum(m * g / omega**2))
    K[1, 2:] = K[2:, 1] = -m * g
    i = np.arange(2, 2 + N)
    M[i, i], K[i, i], C[i, i] = m, m * omega**2, 2.0 * tank["damping_ratio"] * omega * m
    return M, C, K


def eigenvalues(M: np.ndarray, C: np.ndarray, K: np.ndarray) -> np.ndarray:
    """Those with positive imaginary part [rad/s], by frequency."""
    n = len(M)
    Z, E = np.zeros((n, n)), np.eye(n)
    values = eig(np.block([[Z, E], [-K, -C]]), np.block([[E, Z], [Z, M]]), right=False)
    values = values[values.imag > 0.0]
    return values[np.argsort(values.imag)]


def motion(M: np.ndarray, C: np.ndarray, K: np.ndarray, start: np.ndarray, times: np.ndarray) -> np.ndarray:
    """Free motion q from `start` at rest. Shape: (n, times)."""
    n = len(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-np.linalg.solve(M, K), -np.linalg.solve(M, C)]])
    values, vectors = np.linalg.eig(A)
    weights = np.linalg.solve(vectors, np.concatenate([start, np.zeros(n)]).astype(complex))
    return (vectors[:n] @ (weights[:, None] * np.exp(np.outer(values, times)))).real
