"""Substeps, waveforms and an FMU in C that is none of ours (doubles/spring.c), against motions known exactly."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm

from aeroslosh.master.base.errors import AeroSloshError, ComponentError
from aeroslosh.master.cosim import assemble as schemes
from aeroslosh.master.cosim.coupling_settings import Coupling
from aeroslosh.master.cosim.implicit import Criteria, Implicit
from aeroslosh.master.cosim.scheme import GaussSeidel, Jacobi, Scheme
from aeroslosh.master.cosim.substeps import Pace, Stride
from aeroslosh.master.cosim.system import System, wires
from aeroslosh.master.fmi.component import Component
from support.doubles import LINKED

PARTS: dict[str, dict[str, float]] = {
    "a": {"mass": 1.0, "stiffness": 4.0, "damping": 0.2, "initial_x": 1.0},
    "b": {"mass": 2.0, "stiffness": 3.0, "initial_v": -0.5},
    "link": {"stiffness": 2.0, "damping": 0.1},
}
END = 1.5
Build = Callable[..., System]


@pytest.fixture
def build(doubles: Path, springs: Path) -> Iterator[Build]:
    """Two masses and a link: `build(a, b, paces)` with the FMUs of the masses."""
    made: list[System] = []

    def make(a: str = "spring", b: str = "oscillator", paces: Mapping[str, Pace] | None = None) -> System:
        parts = []
        for name, fmu in (("a", a), ("b", b), ("link", "link")):
            path = next(folder / f"{fmu}.fmu" for folder in (springs, doubles) if (folder / f"{fmu}.fmu").is_file())
            parts.append(Component(path, name))
            parts[-1].set_all(PARTS[name])
        made.append(System(parts, wires(LINKED), paces))
        return made[-1]

    yield make
    for system in made:
        system.close()


def run(system: System, scheme: Scheme, steps: int) -> np.ndarray:
    """(x_a, x_b, v_a, v_b) at END; every step must converge."""
    system.initialize()
    scheme.reset(system)
    for _ in range(steps):
        assert scheme.step(system, END / steps).converged
    return np.array([system[n].get(v) for v in ("x", "v") for n in ("a", "b")])


def exact() -> np.ndarray:
    """The same solved as one system."""
    a, b, link = PARTS["a"], PARTS["b"], PARTS["link"]
    inverse = np.diag([1.0 / a["mass"], 1.0 / b["mass"]])
    k, c = link["stiffness"], link["damping"]
    stiffness = np.array([[a["stiffness"] + k, -k], [-k, b["stiffness"] + k]])
    damping = np.array([[a["damping"] + c, -c], [-c, c]])
    matrix = np.block([[np.zeros((2, 2)), np.eye(2)], [-inverse @ stiffness, -inverse @ damping]])
    return expm(matrix * END) @ [a["initial_x"], 0.0, 0.0, b["initial_v"]]


def order(
    build: Build, make: Callable[[], Scheme], paces: Mapping[str, Pace], b: str = "oscillator"
) -> tuple[float, list[float]]:
    """Slope of log error over log dt, and the errors, over three halvings."""
    errors = [float(np.linalg.norm(run(build("spring", b, paces), make(), n) - exact())) for n in (40, 80, 160, 320)]
    return float(-np.polyfit(np.arange(4) * np.log(2.0), np.log(errors), 1)[0]), errors


def gauss_seidel() -> Scheme:
    return GaussSeidel(1)


def implicit() -> Scheme:
    return Implicit(1, Criteria(1e-11, max_iterations=60))


# the FMU in C


@pytest.mark.parametrize("make", [gauss_seidel, implicit])
@pytest.mark.parametrize(("waveform", "expected"), [("hold", 1.0), ("linear", 2.0), ("quadratic", 2.0)])
def test_a_foreign_fmu_beside_ours(build: Build, make: Callable[[], Scheme], waveform: str, expected: float) -> None:
    """Order 1 with the force held, 2 where it moves: the other mass takes it linearly, which limits the quadratic one.

    0.15: what an error's next order leaves of the slope over these steps."""
    found, errors = order(build, make, {"a": Pace(1, waveform)})
    assert found == pytest.approx(expected, abs=0.15), errors


def test_quadratic_forces_all_round_have_order_3(build: Build) -> None:
    """Two masses that both follow the parabola: its error in a step is of third order (the first step's, linear, is local)."""
    paces = {"a": Pace(1, "quadratic"), "b": Pace(1, "quadratic")}
    found, errors = order(build, lambda: Implicit(2, Criteria(1e-12, max_iterations=60)), paces, "spring")
    assert found == pytest.approx(3.0, abs=0.15), errors


def test_implicit_refuses_one_that_cannot_rewind(build: Build) -> None:
    system = build("stubborn")
    system.initialize()
    with pytest.raises(AeroSloshError) as caught:
        implicit().reset(system)
    assert "'a' cannot rewind" in caught.value.what and "stubborn.fmu" in caught.value.where
    assert 'scheme = "gauss-seidel"' in caught.value.remedy
    assert not system["a"].can_serialize
    # 320 steps of order 2: as far from the solution as the one that can rewind, to the bit
    paces = {"a": Pace(1, "linear")}
    runs = [run(build(name, paces=paces), gauss_seidel(), 320) for name in ("stubborn", "spring")]
    assert (runs[0] == runs[1]).all() and np.max(np.abs(runs[0] - exact())) < 1e-3


@pytest.mark.parametrize("make", [gauss_seidel, implicit, lambda: Jacobi(1)])
def test_a_foreign_state_in_bytes(build: Build, make: Callable[[], Scheme]) -> None:
    """Serialised after 7 steps and taken back by another instance: the next steps are the same to the bit."""
    paces = {"a": Pace(2, "quadratic"), "b": Pace(3, "linear")}
    ends = []
    data: dict[str, tuple[bytes, float, int]] = {}
    for again in (False, True):
        system, scheme = build(paces=paces), make()
        system.initialize()
        scheme.reset(system)
        if not again:
            for _ in range(7):
                scheme.step(system, 0.05)
            data = {c.name: (c.serialized(), c.time, c.steps) for c in system.components}
            memory, strides = scheme.state(), [s.state() for s in system.strides]
        else:
            for component in system.components:
                component.restore(*data[component.name])
            for stride, state in zip(system.strides, strides, strict=True):
                stride.restore(state)
            system.collect()
            scheme.restore(memory)
        for _ in range(5):
            scheme.step(system, 0.05)
        ends.append(system.values.copy())
    assert (ends[0] == ends[1]).all()


def test_a_foreign_fmu_s_own_words(springs: Path) -> None:
    """A failure names the component, the call and what the FMU's log said; there is no variable `error` to ask."""
    spring = Component(springs / "spring.fmu", "spring")
    spring.set("mass", -1.0)
    spring.enter_initialization()
    with pytest.raises(ComponentError) as caught:
        spring.exit_initialization()
    assert "'spring' failed" in caught.value.what and "ExitInitializationMode" in caught.value.where
    assert "mass must be above 0" in caught.value.traceback
    spring.close()


def test_a_damaged_state_is_refused(springs: Path) -> None:
    spring = Component(springs / "spring.fmu", "spring")
    spring.initialize()
    data = spring.serialized()
    with pytest.raises(ComponentError, match="'spring' failed"):
        spring.restore(data[:-1], 0.0, 0)
    spring.restore(data, 0.0, 0)
    spring.close()


def test_nothing_named_in_the_structure_may_depend_on_every_input(build: Build) -> None:
    """FMI 2.0, section 2.2.8: an output without a list of dependencies depends on all inputs; the loop is seen."""
    loops = [sorted(loop) for loop in build("spring", "spring").loops]
    assert any({"a.a", "link.a_a", "link.force_a", "a.force"} <= set(loop) for loop in loops), loops


# the course of an input in a step


def parabola(t: float | np.ndarray) -> np.ndarray:
    return np.asarray(1.0 - 3.0 * t + 4.0 * t**2)


def forced(component: Component, pace: Pace, times: np.ndarray, force: Callable[[Any], np.ndarray]) -> np.ndarray:
    """(x, v) at the last of `times` of an oscillator under `force`, known at `times`."""
    place = component.input_index["force"]
    component.set_all({"mass": 0.7, "stiffness": 5.0, "initial_x": 0.3})
    component.set("force", float(force(times[0])))
    component.initialize(float(times[0]))
    stride = Stride(component, pace)
    for begin, end in itertools.pairwise(times):
        component.inputs.values[place] = force(begin)
        stride.begin(component.inputs.values, float(end - begin))
        component.inputs.values[place] = force(end)
        stride.step(float(end - begin))
    assert component.time == pytest.approx(times[-1], rel=1e-14)
    return np.array([component.get("x"), component.get("v")])


def polynomial_answer(start: float, end: float) -> np.ndarray:
    """(x, v) at `end` of the oscillator of `forced` under `parabola`."""
    # x, v, force, its slope, its bend
    matrix = np.zeros((5, 5))
    matrix[0, 1] = matrix[2, 3] = matrix[3, 4] = 1.0
    matrix[1, 0], matrix[1, 2] = -5.0 / 0.7, 1.0 / 0.7
    return (expm(matrix * (end - start)) @ [0.3, 0.0, float(parabola(start)), -3.0 + 8.0 * start, 8.0])[:2]


UNEVEN = np.array([-0.05, 0.0, 0.02, 0.09, 0.1, 0.19, 0.2])


@pytest.mark.parametrize("substeps", [1, 3])
def test_the_quadratic_course_is_the_parabola_at_uneven_steps(springs: Path, substeps: int) -> None:
    """Steps of 0.01 to 0.09: from the second on the course through three values is the force itself.

    1e-10: the Runge-Kutta steps' error, (omega h)^4 with h = 1.8e-3 and omega = 2.7, over 120."""
    component = Component(springs / "spring.fmu", "spring")
    first = Component(springs / "spring.fmu", "first")
    found = forced(component, Pace(substeps, "quadratic"), UNEVEN, parabola)
    # the first step is linear: start where the parabola does by taking it out of both
    linear = forced(first, Pace(substeps, "linear"), UNEVEN[:2], parabola)
    gap = linear - polynomial_answer(UNEVEN[0], UNEVEN[1])
    wave = np.sqrt(5.0 / 0.7) * (UNEVEN[-1] - UNEVEN[1])
    turn = np.array([[np.cos(wave), np.sin(wave) / np.sqrt(5.0 / 0.7)], [-np.sqrt(5.0 / 0.7) * np.sin(wave), np.cos(wave)]])
    assert np.max(np.abs(found - polynomial_answer(UNEVEN[0], UNEVEN[-1]) - turn @ gap)) < 1e-10
    assert np.max(np.abs(gap)) > 1e-6  # or the first step would prove nothing
    component.close()
    first.close()


@pytest.mark.parametrize(("waveform", "expected"), [("hold", 1.0), ("linear", 2.0), ("quadratic", 2.0)])
def test_order_of_a_waveform_over_the_communication_step(doubles: Path, waveform: str, expected: float) -> None:
    """4 substeps of an FMU that runs linearly itself, force cos 3t, steps uneven by a third: the error over the step halved.

    hold reaches the end value in the first substep. Quadratic: 2, since the FMU's own lines between substeps err by a
    sixteenth of the linear course's error; it must be well below that."""
    errors = {}
    for name in {waveform, "linear"}:
        errors[name] = []
        for n in (10, 20, 40, 80):
            even = np.linspace(0.0, 2.0, n + 1)
            times = even + 0.3 * (2.0 / n) * np.sin(np.arange(n + 1)) * (even > 0.0) * (even < 2.0)
            component = Component(doubles / "oscillator.fmu", "o")
            found = forced(component, Pace(4, name), times, lambda t: np.cos(3.0 * np.asarray(t)))
            component.close()
            w, k, m = 3.0, 5.0, 0.7
            A, W = 1.0 / (k - m * w**2), np.sqrt(k / m)
            x = A * np.cos(w * 2.0) + (0.3 - A) * np.cos(W * 2.0)
            v = -A * w * np.sin(w * 2.0) - (0.3 - A) * W * np.sin(W * 2.0)
            errors[name].append(float(np.linalg.norm(found - [x, v])))
    slope = float(-np.polyfit(np.arange(4) * np.log(2.0), np.log(errors[waveform]), 1)[0])
    if waveform == "quadratic":  # between the 3 of the course and the 2 of the FMU's lines
        assert expected - 0.1 < slope < 3.2, errors
        assert errors["quadratic"][-1] < 0.15 * errors["linear"][-1], errors
    else:
        assert slope == pytest.approx(expected, abs=0.2), errors


@pytest.mark.parametrize("make", [gauss_seidel, implicit])
@pytest.mark.parametrize(("waveform", "expected"), [("hold", 1.0), ("linear", 2.0)])
def test_order_of_coupling_with_substeps(build: Build, make: Callable[[], Scheme], waveform: str, expected: float) -> None:
    """The oscillator in 3 substeps, the spring in 2: the exchange keeps the order of the coarser waveform.

    0.2: hold's first-order errors of two components with opposite signs leave more of the second order in the slope."""
    found, errors = order(build, make, {"a": Pace(2, waveform), "b": Pace(3, waveform)})
    assert found == pytest.approx(expected, abs=0.2), errors


@pytest.mark.parametrize("waveform", ["hold", "linear", "quadratic"])
@pytest.mark.parametrize("first", ["spring", "oscillator"])
def test_rewound_substeps_leave_no_trace(build: Build, waveform: str, first: str) -> None:
    """A step gone with other inputs, rewound and gone again: the same bits as gone once."""
    ends = []
    for stray in (False, True):
        system = build(first, paces={"a": Pace(3, waveform), "b": Pace(2, waveform)})
        system.initialize()
        scheme = GaussSeidel(1)
        scheme.reset(system)
        for k in range(6):
            if stray and k == 3:
                saved = [c.save() for c in system.components]
                system.begin_step(0.05)
                memory = [s.state() for s in system.strides]
                for factor in (2.0, -1.0):
                    system.one_pass(factor * system.wire_values(), 0.05)
                    for i, (component, state) in enumerate(zip(system.components, saved, strict=True)):
                        component.rewind(state)
                        system.take(i)
                system.one_pass(scheme.predictor.carried(system, 0.05), 0.05)
                scheme.predictor.push(system, 0.05)
                for component, state in zip(system.components, saved, strict=True):
                    component.free(state)
                assert all(
                    (x[key] == y[key]).all()
                    for x, s in zip(memory, system.strides, strict=True)
                    for y in [s.state()]
                    for key in x
                )
            else:
                scheme.step(system, 0.05)
        ends.append(system.values.copy())
    assert (ends[0] == ends[1]).all()


def test_substeps_are_equal_to_the_bit(doubles: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """An FMU keeps what it computed for a step size: sizes that differ by rounding would cost it that each time."""
    component = Component(doubles / "oscillator.fmu", "o")
    component.initialize()
    sizes = set()
    step = component.step

    def watched(dt: float, *slopes: Any) -> None:
        sizes.add(dt)
        step(dt, *slopes)

    monkeypatch.setattr(component, "step", watched)
    stride = Stride(component, Pace(7, "linear"))
    for _ in range(50):
        stride.begin(component.inputs.values, 0.013)
        stride.step(0.013)
    assert sizes == {0.013 / 7} and component.steps == 350
    assert component.time == sum([0.013] * 50)  # the master's own clock, step by step
    component.close()


# what is refused


@pytest.mark.parametrize(
    ("settings", "says"),
    [
        ({"substeps": {"c": 2}}, ["coupling.substeps: there is no component 'c'", "components are: a, b, link"]),
        ({"waveform": {"A": "hold"}}, ["coupling.waveform: there is no component 'A'", "components are: a, b, link"]),
        ({"waveform": {"b": "linear"}}, ["'b' takes its inputs once a step", "oscillator.fmu", "substeps above 1"]),
        ({"waveform": {"b": "quadratic"}, "substeps": {"b": 1}}, ["'b' takes its inputs once a step"]),
        ({"order": ["a", "b"]}, ["coupling.order", "name each once: a, b, link"]),
        ({"order": ["a", "b", "link", "a"]}, ["coupling.order", "name each once"]),
        ({"order": ["a", "b", "links"]}, ["coupling.order", "name each once"]),
    ],
)
def test_settings_that_fit_no_component(build: Build, settings: dict[str, Any], says: list[str]) -> None:
    system = build()
    with pytest.raises(AeroSloshError) as caught:
        schemes.assemble(system.components, system.wires, Coupling(**settings), {})
    for part in (*says, "remedy"):
        assert part in str(caught.value), str(caught.value)


def test_substeps_without_a_waveform_run_linearly(build: Build) -> None:
    system = build()
    found = schemes.assemble(system.components, system.wires, Coupling(substeps={"b": 2}, order=["b", "link", "a"]), {})
    assert [c.name for c in found.components] == ["b", "link", "a"]
    assert [s.pace for s in found.strides] == [Pace(2, "linear"), Pace(), Pace()]
