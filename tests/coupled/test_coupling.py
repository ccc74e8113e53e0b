"""Coupling schemes on coupled oscillators, whose motion is known exactly."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

from master.acceleration import Aitken, Constant
from master.component import Component
from master.coupling import GaussSeidel, Implicit, Scheme
from master.errors import AeroSloshError
from master.system import System, wires

M_A, M_B, K_A, K_B, K_LINK, C_LINK = 1.0, 2.0, 4.0, 3.0, 2.0, 0.1
END = 4.0
WIRES = """
a.x -> link.x_a
a.v -> link.v_a
a.a -> link.a_a
b.x -> link.x_b
b.v -> link.v_b
link.force_a -> a.force
link.force_b -> b.force
"""


class Builder:
    """Makes systems of two oscillators and a link, and frees them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.made = folder, list[System]()

    def __call__(self, added_mass: float = 0.0, first: str = "oscillator") -> System:
        a, b = Component(self.folder / f"{first}.fmu", "a"), Component(self.folder / "oscillator.fmu", "b")
        link = Component(self.folder / "link.fmu", "link")
        a.set_all({"mass": M_A, "stiffness": K_A, "initial_x": 1.0})
        b.set_all({"mass": M_B, "stiffness": K_B, "initial_v": -0.5})
        link.set_all({"stiffness": K_LINK, "damping": C_LINK, "mass_a": added_mass})
        system = System([a, b, link], wires(WIRES))
        self.made.append(system)
        return system


@pytest.fixture
def build(doubles: Path) -> Iterator[Builder]:
    builder = Builder(doubles)
    yield builder
    for system in builder.made:
        system.close()


def run(system: System, scheme: Scheme, steps: int, end: float = END) -> tuple[np.ndarray, list[int], bool]:
    """Final (x_a, x_b, v_a, v_b), the passes of each step, and whether every step converged."""
    system.initialize()
    scheme.reset(system)
    reports = [scheme.step(system, end / steps) for _ in range(steps)]
    state = np.array([system[n].get(v) for v in ("x", "v") for n in ("a", "b")])
    return state, [r.passes for r in reports], all(r.converged for r in reports)


def exact(added_mass: float = 0.0, end: float = END) -> np.ndarray:
    """The monolithic solution."""
    inverse = np.diag([1.0 / (M_A + added_mass), 1.0 / M_B])
    stiffness = np.array([[K_A + K_LINK, -K_LINK], [-K_LINK, K_B + K_LINK]])
    damping = C_LINK * np.array([[1.0, -1.0], [-1.0, 1.0]])
    system = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    return expm(system * end) @ [1.0, 0.0, 0.0, -0.5]


def order(errors: list[float]) -> float:
    """Slope of log(error) over log(dt), dt halved each time."""
    return float(-np.polyfit(np.arange(len(errors)) * np.log(2.0), np.log(errors), 1)[0])


@pytest.mark.parametrize(("predictor", "expected"), [(0, 1.0), (1, 2.0), (2, 2.15)])
def test_gauss_seidel_has_the_order_of_its_predictor(build: Builder, predictor: int, expected: float) -> None:
    """Order 1 with held loads, 2 with linear prediction; the loads' linear course in a step limits it to 2."""
    errors = [float(np.linalg.norm(run(build(), GaussSeidel(predictor), n)[0] - exact())) for n in (80, 160, 320, 640)]
    assert order(errors) == pytest.approx(expected, abs=0.2), errors


def test_implicit_has_order_2_and_beats_gauss_seidel(build: Builder) -> None:
    errors = [float(np.linalg.norm(run(build(), Implicit(tolerance=1e-10), n)[0] - exact())) for n in (80, 160, 320)]
    assert order(errors) == pytest.approx(2.0, abs=0.05), errors
    lagged = float(np.linalg.norm(run(build(), GaussSeidel(1), 320)[0] - exact()))
    assert errors[-1] < 0.5 * lagged


def monolithic(steps: int) -> np.ndarray:
    """The implicit equations solved directly: oscillators under forces linear in the step, forces from its end."""
    dt = END / steps

    def oscillator(mass: float, stiffness: float) -> np.ndarray:
        block = np.zeros((4, 4))
        block[:2, :2] = [[0.0, 1.0], [-stiffness / mass, 0.0]]
        block[1, 2], block[2, 3] = 1.0 / mass, 1.0
        return expm(block * dt)[:2]

    maps = [oscillator(M_A, K_A), oscillator(M_B, K_B)]
    state = np.array([1.0, 0.0, 0.0, -0.5])  # x_a, v_a, x_b, v_b
    link = np.array([-K_LINK, -C_LINK, K_LINK, C_LINK])
    force = link @ state
    transition = np.zeros((4, 4))
    transition[:2, :2], transition[2:, 2:] = maps[0][:, :2], maps[1][:, :2]
    old = np.concatenate([maps[0][:, 2] - maps[0][:, 3] / dt, -(maps[1][:, 2] - maps[1][:, 3] / dt)])
    new = np.concatenate([maps[0][:, 3] / dt, -maps[1][:, 3] / dt])
    for _ in range(steps):
        free = transition @ state + old * force
        force = (link @ free) / (1.0 - link @ new)
        state = free + new * force
    return state[[0, 2, 1, 3]]


@pytest.mark.parametrize("relaxation", [Aitken(), Constant(0.7)])
def test_implicit_equals_the_monolithic_equations(build: Builder, relaxation: Aitken | Constant) -> None:
    """Iterated with rollback, the FMUs solve the coupled step to the tolerance asked for."""
    state, passes, converged = run(build(), Implicit(1, 1e-12, 60, relaxation), 50)
    assert converged
    assert np.max(np.abs(state - monolithic(50))) < 1e-10
    assert max(passes) > 1


@pytest.mark.parametrize("ratio", [0.5, 2.0, 10.0])
def test_added_mass_needs_aitken(build: Builder, ratio: float) -> None:
    """A load −m_added·a: one pass blows up, constant relaxation 1 diverges above ratio 1, Aitken converges."""
    steps = 200
    state, passes, converged = run(build(ratio), Implicit(1, 1e-8, 40), steps, 1.0)
    assert converged and max(passes) <= 10
    assert np.max(np.abs(state - exact(ratio, 1.0))) < 2e-3
    with np.errstate(all="ignore"):
        loose, _, _ = run(build(ratio), GaussSeidel(1), steps, 1.0)
        assert not np.max(np.abs(loose)) < 10.0
        if ratio > 1.0:
            assert not run(build(ratio), Implicit(1, 1e-8, 12, Constant(1.0)), 5, 0.025)[2]


def test_unconverged_steps_are_reported(build: Builder) -> None:
    system = build(2.0)
    system.initialize()
    scheme = Implicit(0, 1e-14, 2)
    scheme.reset(system)
    report = scheme.step(system, 0.1)
    assert not report.converged and report.passes == 2 and report.change > 1e-14


def test_a_converged_rewind_leaves_no_trace(build: Builder) -> None:
    """Stepping, rewinding and stepping again gives the same bits."""
    system = build()
    system.initialize()
    scheme = GaussSeidel(1)
    scheme.reset(system)
    for _ in range(5):
        scheme.step(system, 0.05)
    saved = [c.save() for c in system.components]
    inputs = [c.inputs.values.copy() for c in system.components]
    outputs = []
    for _ in range(2):
        for component, state, values in zip(system.components, saved, inputs, strict=True):
            component.rewind(state)
            component.inputs.values[:] = values
        for component in system.components:
            component.step(0.05)
        outputs.append([c.outputs.values.copy() for c in system.components])
    assert all((x == y).all() for x, y in zip(*outputs, strict=True))
    for component, state in zip(system.components, saved, strict=True):
        component.free(state)


def test_implicit_refuses_components_that_cannot_rewind(build: Builder) -> None:
    system = build(first="fixed")
    system.initialize()
    with pytest.raises(AeroSloshError, match="'a' cannot rewind"):
        Implicit().reset(system)
    state, _, _ = run(build(first="fixed"), GaussSeidel(1), 200)
    assert np.max(np.abs(state - exact())) < 1e-2


def test_an_exchange_is_cheap(build: Builder) -> None:
    """The master's own share of a step of three trivial FMUs (a loose bound: other work runs beside the tests)."""
    import time

    system = build()
    system.initialize()
    scheme = GaussSeidel(1)
    scheme.reset(system)
    best = np.inf
    for _ in range(5):
        begin, inside = time.perf_counter(), sum(c.wall for c in system.components)
        for _ in range(200):
            scheme.step(system, 1e-4)
        spent = time.perf_counter() - begin - (sum(c.wall for c in system.components) - inside)
        best = min(best, spent / 200)
    assert best < 300e-6, f"{best * 1e6:.0f} µs a step"
