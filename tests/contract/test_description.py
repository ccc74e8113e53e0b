"""What modelDescription.xml of each FMU promises, as FMPy reads it."""

from __future__ import annotations

import json
import math
import subprocess
import sys
from pathlib import Path
from typing import Any

import fmpy
import pytest

HERE = Path(__file__).resolve().parent
COMPONENTS = ("structure", "aero", "slosh_vof", "slosh_ems", "slosh_rbf")


@pytest.fixture(params=COMPONENTS)
def description(request: pytest.FixtureRequest, folders: dict[str, str]) -> Any:
    """The description of each FMU in turn."""
    return fmpy.read_model_description(folders[request.param])


def test_every_variable_says_what_it_is(description: Any) -> None:
    units = {unit.name for unit in description.unitDefinitions}
    names = [v.name for v in description.modelVariables]
    assert len(set(names)) == len(names)
    assert [v.valueReference for v in description.modelVariables] == list(range(len(names)))
    for v in description.modelVariables:
        assert len(v.description or "") > 3, v.name
        assert not v.description.endswith("."), v.name
        if v.type == "Real":
            assert v.unit in units, v.name
        if v.type == "Enumeration":
            assert v.declaredType.items and all(item.description for item in v.declaredType.items), v.name


def test_causality_variability_and_starts_belong_together(description: Any) -> None:
    for v in description.modelVariables:
        if v.causality == "parameter":
            assert (v.initial, v.variability) in (("exact", "fixed"), ("exact", "tunable")), v.name
        elif v.causality == "input":
            assert v.variability == ("continuous" if v.type == "Real" else "discrete"), v.name
        else:
            assert (v.causality, v.initial) == ("output", "calculated"), v.name
        assert (v.start is None) == (v.causality == "output"), v.name


def test_starts_lie_within_their_ranges(description: Any) -> None:
    for v in description.modelVariables:
        if v.type not in ("Real", "Integer"):
            continue
        convert = float if v.type == "Real" else int
        low = -math.inf if v.min is None else convert(v.min)
        high = math.inf if v.max is None else convert(v.max)
        assert low < high, v.name
        if v.start is not None:
            assert math.isfinite(convert(v.start)) and low <= convert(v.start) <= high, v.name
            assert v.type != "Real" or repr(float(v.start)) == v.start, f"{v.name}: {v.start} is not exact"


def test_outputs_have_their_dependencies(description: Any) -> None:
    outputs = [v.name for v in description.modelVariables if v.causality == "output"]
    inputs = {v.name for v in description.modelVariables if v.causality == "input"}
    for unknowns, knowns in ((description.outputs, inputs), (description.initialUnknowns, inputs | parameters(description))):
        assert [u.variable.name for u in unknowns] == outputs
        for u in unknowns:
            assert u.dependencies is not None, u.variable.name
            assert {v.name for v in u.dependencies} <= knowns, u.variable.name


def parameters(description: Any) -> set[str]:
    """Their names."""
    return {v.name for v in description.modelVariables if v.causality == "parameter"}


@pytest.mark.parametrize("component", COMPONENTS)
def test_dependencies_are_what_moves(component: str, folders: dict[str, str]) -> None:
    """Each parameter and input is changed, each output looked at: what moves it is declared, and what is declared moves it."""
    command = [sys.executable, str(HERE / "influence.py"), folders[component]]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout)
    described = fmpy.read_model_description(folders[component])
    for unknowns, moves in ((described.outputs, seen["stepping"]), (described.initialUnknowns, seen["initially"])):
        for unknown in unknowns:
            name, type_ = unknown.variable.name, unknown.variable.type
            declared = {v.name for v in unknown.dependencies}
            found = moves.get(name, {})
            assert {known for known, how in found.items() if how == "clearly"} <= declared, name
            # a count or a truth need not change at the few points that are tried
            assert type_ != "Real" or declared <= set(found), f"{name}: declared, but nothing moves: {declared - set(found)}"


def test_nothing_is_claimed_that_the_library_cannot_do(description: Any) -> None:
    simulation = description.coSimulation
    assert description.fmiVersion == "2.0"
    assert simulation.canGetAndSetFMUstate and simulation.canSerializeFMUstate
    assert not simulation.needsExecutionTool
    assert simulation.canHandleVariableCommunicationStepSize
    assert not simulation.canBeInstantiatedOnlyOncePerProcess
    assert not simulation.canInterpolateInputs and not simulation.maxOutputDerivativeOrder
    assert not simulation.canRunAsynchronuously and not simulation.providesDirectionalDerivative
    experiment = description.defaultExperiment
    assert 0.0 < float(experiment.tolerance) < 1.0
    assert 0.0 < float(experiment.stepSize) < float(experiment.stopTime)
    assert {v.name for v in description.modelVariables} >= {"failed", "error"}
