"""Coupling schemes on coupled oscillators, whose motion is known exactly."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Callable, Iterator
from pathlib import Path
from types import FrameType

import numpy as np
import pytest
from scipy.linalg import expm

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.cosim.acceleration import Acceleration, Aitken, Constant, QuasiNewton
from aeroslosh.master.cosim.implicit import Criteria, Implicit
from aeroslosh.master.cosim.scheme import GaussSeidel, Jacobi, Scheme, StepReport
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.fmi.component import Component
from support.doubles import LINKED

M_A, M_B, K_A, K_B, K_LINK, C_LINK = 1.0, 2.0, 4.0, 3.0, 2.0, 0.1
END = 4.0


class Builder:
    """Makes systems of two oscillators and a link, and frees them."""

    def __init__(self, folder: Path) -> None:
        self.folder, self.made = folder, list[System]()

    def __call__(
        self,
        added_mass: float = 0.0,
        first: str = "oscillator",
        guess: float | None = None,
        order: tuple[str, ...] = ("a", "b", "link"),
    ) -> System:
        """`guess`: the added mass of a surrogate of the link."""
        a, b = Component(self.folder / f"{first}.fmu", "a"), Component(self.folder / "oscillator.fmu", "b")
        link = Component(self.folder / "link.fmu", "link")
        a.set_all({"mass": M_A, "stiffness": K_A, "initial_x": 1.0})
        b.set_all({"mass": M_B, "stiffness": K_B, "initial_v": -0.5})
        link.set_all({"stiffness": K_LINK, "damping": C_LINK, "mass_a": added_mass})
        surrogates = {}
        if guess is not None:
            surrogates["link"] = Component(self.folder / "link.fmu", "guess")
            surrogates["link"].set("mass_a", guess)
        named = {"a": a, "b": b, "link": link}
        system = System([named[n] for n in order], wires(LINKED), surrogates=surrogates)
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


@pytest.mark.parametrize(("predictor", "expected"), [(0, 1.0), (1, 2.0)])
def test_jacobi_has_the_order_of_its_predictor(build: Builder, predictor: int, expected: float) -> None:
    """Everything lags: order 1 held, 2 extrapolated."""
    errors = [float(np.linalg.norm(run(build(), Jacobi(predictor), n)[0] - exact())) for n in (160, 320, 640)]
    assert order(errors) == pytest.approx(expected, abs=0.2), errors


def test_implicit_has_order_2_and_beats_gauss_seidel(build: Builder) -> None:
    errors = [float(np.linalg.norm(run(build(), Implicit(1, Criteria(1e-10)), n)[0] - exact())) for n in (80, 160, 320)]
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
    state, passes, converged = run(build(), Implicit(1, Criteria(1e-12, max_iterations=60), relaxation), 50)
    assert converged
    assert np.max(np.abs(state - monolithic(50))) < 1e-10
    assert max(passes) > 1


RATIOS = (0.1, 0.3, 0.4, 0.9, 1.1, 3.0, 10.0)  # added mass over mass


def bounded(system: System, scheme: Scheme) -> bool:
    """Whether 300 short steps (1.5 ms, 2 periods in 4 000) stay where the motion is; what is unstable grows every step."""
    with np.errstate(all="ignore"):
        state, _, _ = run(system, scheme, 300, 0.45)
    return bool(np.max(np.abs(state)) < 10.0)


@pytest.mark.parametrize("ratio", RATIOS)
def test_added_mass_in_one_pass_diverges_where_theory_says(build: Builder, ratio: float) -> None:
    """A load −m_added a: its newest value answers the last one by −ratio (held: stable below 1) or by −ratio (2 − 1/z)
    (extrapolated: below 1/3), at any step (docs/coupling.md)."""
    assert bounded(build(ratio), GaussSeidel(0)) == (ratio < 1.0)
    assert bounded(build(ratio), GaussSeidel(1)) == (ratio < 1.0 / 3.0)


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("factor", [1.0, 0.5, 0.15])
def test_constant_relaxation_converges_where_theory_says(build: Builder, ratio: float, factor: float) -> None:
    """Each pass multiplies the error by 1 − factor (1 + ratio): it shrinks below factor = 2 / (1 + ratio)."""
    scheme = Implicit(1, Criteria(1e-8, max_iterations=400, stall=400, retries=0), Constant(factor))
    with np.errstate(all="ignore"):
        _, _, converged = run(build(ratio), scheme, 3, 0.015)
    assert converged == (factor < 2.0 / (1.0 + ratio))


@pytest.mark.parametrize("ratio", RATIOS)
@pytest.mark.parametrize("faster", [Aitken(), QuasiNewton()], ids=lambda faster: faster.name)
def test_added_mass_is_no_matter_for_aitken_and_quasi_newton(build: Builder, ratio: float, faster: Acceleration) -> None:
    """Tolerance: 200 steps a second-order scheme are 2e-3 from the exact motion (measured 8e-4 at ratio 10)."""
    state, passes, converged = run(build(ratio), Implicit(1, Criteria(1e-8, max_iterations=40), faster), 200, 1.0)
    assert converged and max(passes) <= (10 if faster.name == "aitken" else 5)
    assert np.max(np.abs(state - exact(ratio, 1.0))) < 2e-3


def test_a_stiff_loop_of_two_quantities_takes_the_quasi_newton_four_passes(build: Builder) -> None:
    """Added mass 10 and a stiff link: the linear map of the two forces is found in n + 2 = 4 passes, later in 2."""
    system = build(10.0)
    system["link"].set("stiffness", 5e4)
    scheme = Implicit(1, Criteria(1e-9, max_iterations=20, retries=0), QuasiNewton(filter=1e-9))
    _, passes, converged = run(system, scheme, 30, 0.3)
    assert converged and max(passes) <= 4 and max(passes[2:]) <= 2, passes


@pytest.mark.parametrize(("guess", "stable"), [(0.9, False), (1.5, True), (2.0, True), (3.0, True)])
def test_a_surrogate_carries_a_heavy_load_in_one_pass(build: Builder, guess: float, stable: bool) -> None:
    """Of a load of ratio 2, a surrogate of ratio g leaves (2 − g) / (1 + g) to extrapolation, which bears 1/3: g above 1.25."""
    assert bounded(build(2.0, guess=guess), GaussSeidel(1)) == stable


def test_an_exact_surrogate_makes_one_pass_implicit(build: Builder) -> None:
    """With the same model as surrogate, one Gauss–Seidel pass is the converged step (1e-6: the surrogate's own iteration)."""
    system = build(2.0, guess=2.0)
    system.surrogates["link"].set_all({"stiffness": K_LINK, "damping": C_LINK})
    state, passes, _ = run(system, GaussSeidel(1), 100)
    implicit, _, _ = run(build(2.0), Implicit(1, Criteria(1e-10, max_iterations=40), QuasiNewton()), 100)
    assert set(passes) == {1}
    assert np.max(np.abs(state - implicit)) < 1e-6


def test_a_surrogate_must_be_of_use(build: Builder) -> None:
    """Stepped before all that it feeds, a component's answer is known in the pass."""
    system = build(0.0, order=("link", "a", "b"), guess=0.0)
    system.initialize()
    with pytest.raises(AeroSloshError, match="nothing to predict"):
        GaussSeidel(1).reset(system)


def first_step(system: System, scheme: Implicit, dt: float = 0.1) -> StepReport:
    """The report of one step."""
    system.initialize()
    scheme.reset(system)
    return scheme.step(system, dt)


def test_unconverged_steps_are_reported(build: Builder) -> None:
    """Two passes, the second one worse (ratio 2, full residual): the first is made again, so that it stands."""
    report = first_step(build(2.0), Implicit(0, Criteria(1e-14, max_iterations=2, retries=0)))
    assert not report.converged and report.passes == 3 and report.change > 1e-14
    assert report.outcome == "passes used up" and report.worst == "link.force_a" and report.attempts == 1


def test_a_step_that_does_not_converge_is_tried_again(build: Builder) -> None:
    """Plain repetition diverges at ratio 3; the second attempt, with Aitken, converges, and so does every later step."""
    scheme = Implicit(0, Criteria(1e-8, retries=1), Constant(1.0))
    report = first_step(build(3.0), scheme)
    assert report.converged and report.attempts == 2 and report.passes > scheme.criteria.max_iterations
    assert not first_step(build(3.0), Implicit(0, Criteria(1e-8, retries=0), Constant(1.0))).converged


def test_a_stall_ends_an_attempt_and_the_best_pass_stands(build: Builder) -> None:
    """Relaxation 2/(1 + ratio) reflects the error for ever: 3 passes without progress end it; the report has the smallest."""
    scheme = Implicit(0, Criteria(1e-8, max_iterations=100, stall=3, retries=0), Constant(2.0 / 3.0))
    report = first_step(build(2.0), scheme, 1e-3)
    assert report.outcome == "stalled" and report.passes <= 6


def test_tolerances_of_single_quantities(build: Builder) -> None:
    """A loose absolute tolerance on both forces takes one pass; on one of them, the other still counts."""
    strict = Criteria(1e-12, max_iterations=40)
    one = {"link.force_a": 1e3}
    both = {"link.force_a": 1e3, "link.force_b": 1e3}
    alone = first_step(build(2.0), Implicit(0, strict)).passes
    assert first_step(build(2.0), Implicit(0, Criteria(1e-12, absolute_of=both, max_iterations=40))).passes == 1
    assert first_step(build(2.0), Implicit(0, Criteria(1e-12, absolute=1e3, max_iterations=40))).passes == 1
    assert 1 < first_step(build(2.0), Implicit(0, Criteria(1e-12, absolute_of=one, max_iterations=40))).passes <= alone
    loose = {"link.force_a": 0.1, "link.force_b": 0.1}
    assert first_step(build(2.0), Implicit(0, Criteria(1e-12, relative_of=loose, max_iterations=40))).passes < alone
    with pytest.raises(AeroSloshError, match=r"link\.force_c.*is not iterated"):
        first_step(build(), Implicit(0, Criteria(relative_of={"link.force_c": 1e-3})))


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
    """One call to set, to step and to read each of three FMUs, and few of the master's own functions around them: how long
    that takes is told by benchmarks/exchange.py."""
    system = build()
    system.initialize()
    scheme = GaussSeidel(1)
    scheme.reset(system)
    calls: Counter[str] = Counter()

    def counted(name: str, function: Callable[..., int]) -> Callable[..., int]:
        def call(*arguments: object) -> int:
            calls[name] += 1
            return function(*arguments)

        return call

    for component in system.components:
        component._do_step = counted("step", component._do_step)
        for group in (component.inputs, component.outputs, component.whole, component.truth):
            group._getter, group._setter = counted("get", group._getter), counted("set", group._setter)
    own = 0

    def seen(frame: FrameType, event: str, _: object) -> None:
        nonlocal own
        own += event == "call" and "/master/" in frame.f_code.co_filename

    scheme.step(system, 1e-4)
    calls.clear()
    sys.setprofile(seen)
    try:
        for _ in range(10):
            scheme.step(system, 1e-4)
    finally:
        sys.setprofile(None)
    assert calls == {"set": 30, "step": 30, "get": 30}
    print(f"{own / 10:g} calls of the master's functions a step")
    assert 0 < own / 10 < 60
