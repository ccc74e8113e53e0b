"""A hypothesis state machine over one FMU: `python machine.py <unzip folder> <examples> <calls an example> <seed or ->`.

Any call in any mode with good and bad values. The model knows the mode, what was refused, whether it failed, and all that led to
the present moment; at the end an instance that only does the allowed part of it must stand at the same numbers, to the bit.
Every call is printed before it is made ("example" begins a new one), so that the last ones are known where a signal ends the
process.
"""

from __future__ import annotations

import faulthandler
import gc
import math
import os
import sys
import traceback
import warnings
from dataclasses import dataclass, field, replace
from typing import Any

from cases_values import bounds, settable, start_of
from cheap import PARAMETERS, STEP
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule, run_state_machine_as_test
from raw import DISCARD, ERROR, OK, Raw, bits, kind

FOLDER = sys.argv[1] if len(sys.argv) > 1 else ""
# what makes a run slow, or reads and writes files
KEPT = ("cells_around", "cells_normal", "cells_x", "cells_y", "max_subiterations", "max_step", "cfl", "tolerance", "airfoil",
        "network", "field_folder", "section_file", "farfield_chords", "write_fields")  # fmt: skip
KIT = ("asked ", "stop time", "value reference", "this state", "refused", " is fixed")  # words of what the kit refuses
SMALL = st.floats(-0.05, 0.05)
NUMBERS = st.one_of(SMALL, SMALL, SMALL, st.sampled_from([0.0, 1e-300, 1e6, -1e15, 1e308]), st.floats(width=64))


@dataclass(frozen=True)
class Model:
    """What an instance must be like.

    values: parameters and inputs as applied. past: (values at the start, then inputs and size of each step). shown: outputs, if
    they are known.
    """

    mode: str = "created"
    time: float = 0.0
    failed: bool = False
    refused: frozenset[str] = frozenset()
    values: dict[str, Any] = field(default_factory=dict)
    past: tuple[Any, ...] = ()
    shown: str = ""


class Contract(RuleBasedStateMachine):
    """One instance, its model, and states that were taken from it."""

    def __init__(self) -> None:
        super().__init__()
        print("example", flush=True)
        self.one = Raw(FOLDER, "fuzzed")
        self.one.call("SetDebugLogging", 0, 0, None)
        self.variables = {v.name: v for v in settable(self.one)}
        self.inputs = [v.name for v in self.one.named("input")]
        self.open = sorted(set(self.variables) - set(KEPT))
        self.cheap = PARAMETERS[self.one.description.modelName]
        self.fresh = Model(values={name: start_of(v) for name, v in self.variables.items()})
        self.model = self.fresh
        self.stop = math.inf  # belongs to the instance, not to its states
        self.restored = False  # whether a state was set and no step compared since
        self.states: list[tuple[Any, bytes, Model]] = []
        for name, value in self.cheap.items():
            self._set(name, value)

    def _change(self, **changes: Any) -> None:
        self.model = replace(self.model, **changes)

    def _set(self, name: str, value: Any) -> None:
        print(f"set {name} = {value!r}", flush=True)
        status = self.one.put(name, value)
        model, variable = self.model, self.variables[name]
        low, high = bounds(variable) if kind(variable) in ("Real", "Integer") else (0, 0)
        bad = kind(variable) in ("Real", "Integer") and not (low <= value <= high and math.isfinite(value))
        fixed = variable.causality == "parameter" and model.mode == "running" and value != model.values[name]
        forbidden = (fixed and not bad) or model.mode == "terminated"
        assert status == (ERROR if forbidden else DISCARD if bad else OK)
        if bad or forbidden:
            self._change(refused=model.refused | {name})
        else:
            self._change(refused=model.refused - {name}, values={**model.values, name: value})

    def _must_fail(self) -> None:
        self._change(failed=True)

    def _may_fail(self) -> None:
        """After a call that may fail inside the component, but not for what the kit refuses."""
        if self.one.failed:
            error = self.one["error"]
            assert not any(words in error for words in KIT), error
            self._must_fail()

    @initialize(running=st.sampled_from([True, True, True, False]), share=SMALL)
    def begin(self, running: bool, share: float) -> None:
        """Most runs begin where there is something to lose: with states to go back to."""
        if running:
            self.recover(share, 0)
            self.take_state()
            self.march([0.03, -0.02], STEP, True)

    @rule(share=SMALL, choice=st.integers(0, 4))
    def recover(self, share: float, choice: int) -> None:
        """A state in which all was well, or a new start, and a step with small inputs."""
        well = [k for k, (_, _, m) in enumerate(self.states) if m.mode == "running" and not m.failed and not m.refused]
        if well:
            self._restore(well[choice % len(well)], choice % 2 == 0)
        else:
            self.reset()
            self.enter()
            self.leave()
        self._move(share)
        self.step(STEP, True)

    def _move(self, share: float) -> None:
        for name in self.inputs:
            if name in self.open:
                self._set(name, share)

    @precondition(lambda self: self.model.mode == "running" and not self.model.failed and not self.model.refused)
    @rule(values=st.lists(SMALL, min_size=1, max_size=5), size=st.sampled_from([STEP, STEP, 2 * STEP]), keep=st.booleans())
    def march(self, values: list[float], size: float, keep: bool) -> None:
        """Good steps, and the state after them."""
        for value in values:
            self._move(value)
            self.step(size, False)
        if keep and len(self.states) < 5:
            self.take_state()

    # -- values --

    @rule(data=st.data())
    def set_input(self, data: st.DataObject) -> None:
        """Any number, most of them small."""
        name = data.draw(st.sampled_from([n for n in self.inputs if n in self.open]))
        self._set(name, data.draw(NUMBERS))

    @rule(data=st.data(), factor=st.floats(0.5, 2.0))
    def set_parameter(self, data: st.DataObject, factor: float) -> None:
        """Near its start value; late ones are refused."""
        name = data.draw(st.sampled_from([n for n in self.open if n not in self.inputs]))
        variable, start = self.variables[name], self.cheap.get(name, start_of(self.variables[name]))
        if kind(variable) == "Boolean":
            self._set(name, data.draw(st.sampled_from([0, 1])))
        elif kind(variable) == "Integer":
            self._set(name, data.draw(st.sampled_from([-1, 0, 1, start, 10**6])))
        elif kind(variable) == "String":
            self._set(name, data.draw(st.sampled_from(["", start, "x=0.1", "nonsense"])))
        else:
            self._set(name, start * factor if start else data.draw(st.sampled_from([0.0, 0.01, -0.01])))

    @rule(data=st.data())
    def set_what_is_refused(self, data: st.DataObject) -> None:
        """Not finite, or outside the range; then a good value or not."""
        name = data.draw(st.sampled_from([n for n in self.open if kind(self.variables[n]) == "Real"]))
        low, high = bounds(self.variables[name])
        self._set(name, data.draw(st.sampled_from([math.nan, math.inf, math.nextafter(low, -math.inf), 1.001 * high])))
        if data.draw(st.booleans()) and self.model.mode != "terminated":
            self._set(name, self.model.values[name])

    @rule(
        reference=st.integers(500, 2**32 - 1), type_=st.sampled_from(["Real", "Integer", "Boolean", "String"]), get=st.booleans()
    )
    def use_unknown_reference(self, reference: int, type_: str, get: bool) -> None:
        """Fails until a state or a reset."""
        print(f"unknown {reference} {type_} {get}", flush=True)
        if get:
            status, _ = self.one.get(type_, [reference])
        else:
            status = self.one.set(type_, [reference], [{"Real": 0.5, "String": b"\xff"}.get(type_, 1)])
        assert status == ERROR
        self._must_fail()

    @rule()
    def get_everything(self) -> None:
        """May run the initialisation."""
        print("get all", flush=True)
        for name in self.variables:
            assert self.one[name] == self.model.values[name], name
        self.one.outputs()
        if self.model.mode == "initializing" and not self.model.refused and not self.model.failed:
            self._may_fail()

    # -- life --

    @rule(start=st.sampled_from([0.0, 1024.0, -4.0]), steps=st.sampled_from([None, 0, 2, 1000]))
    def set_up_experiment(self, start: float, steps: int | None) -> None:
        """Allowed before initialisation mode."""
        stop = None if steps is None else start + 1.5 * steps * STEP
        print(f"set up {start} {stop}", flush=True)
        good = self.model.mode == "created" and not self.model.failed
        assert self.one.setup(start, stop) == (OK if good else ERROR)
        if self.model.mode == "created":
            self._change(time=start)
            self.stop = math.inf if stop is None else stop
        else:
            self._must_fail()

    @rule()
    def enter(self) -> None:
        """Allowed once."""
        print("enter", flush=True)
        assert self.one.enter() == (OK if self.model.mode == "created" and not self.model.failed else ERROR)
        if self.model.mode == "created":
            self._change(mode="initializing")
        else:
            self._must_fail()

    @rule()
    def leave(self) -> None:
        """Allowed after `enter`, and where nothing was refused."""
        print("leave", flush=True)
        status = self.one.leave()
        if self.model.mode == "initializing" and not self.model.refused:
            if self.model.failed:
                assert status == ERROR
                self._change(mode="running")
            else:
                self._may_fail()
                assert status == (ERROR if self.model.failed else OK)
                if not self.model.failed:
                    self._change(mode="running", past=(dict(self.model.values),), shown=bits(self.one.outputs()))
        else:
            assert status == ERROR
            self._must_fail()

    @rule(size=st.sampled_from([STEP, STEP, 0.5 * STEP, 3 * STEP]), before=st.booleans())
    def step(self, size: float, before: bool) -> None:
        """OK, or an error, and then failed."""
        print(f"step {self.model.time} {size}", flush=True)
        model = self.model
        status = self.one.step(model.time, size, before)
        end = model.time + size
        if model.failed or model.refused:
            assert status == ERROR
        elif model.mode != "running" or end > self.stop + 0.1 * STEP:
            assert status == ERROR
            self._must_fail()
        elif status == OK:
            used = tuple((name, model.values[name]) for name in self.inputs)
            self._change(time=end, past=(*model.past, (used, size)), shown=bits(self.one.outputs()))
            if self.restored:
                self._replay()
        else:
            assert status == ERROR and self.one.failed
            self._may_fail()

    @rule(
        size=st.sampled_from([0.0, -STEP, math.nan, math.inf, -math.inf, 5e-324, STEP]),
        shift=st.sampled_from([1.0, -0.5, math.nan, math.inf]),
    )
    def step_of_no_use(self, size: float, shift: float) -> None:
        """A bad size, or a good one from another time."""
        print(f"bad step {self.model.time} + {shift} {size}", flush=True)
        assert self.one.step(self.model.time + (shift if size == STEP else 0.0), size) == ERROR
        if not self.model.refused and not self.model.failed:
            self._must_fail()

    @rule()
    def terminate(self) -> None:
        """Allowed always: a host that gives up says so."""
        print("terminate", flush=True)
        assert self.one.terminate() == OK
        self._change(mode="terminated")

    @rule()
    def reset(self) -> None:
        """As fresh."""
        print("reset", flush=True)
        assert self.one.reset() == OK
        self.model, self.stop = self.fresh, math.inf
        for name, value in self.cheap.items():
            self._set(name, value)

    # -- states --

    @precondition(lambda self: len(self.states) < 5)
    @rule()
    def take_state(self) -> None:
        """In any mode, also a failed one."""
        print("take state", flush=True)
        state = self.one.state()
        self.states.append((state, self.one.pack(state), self.model))

    @precondition(lambda self: self.states)
    @rule(data=st.data(), packed=st.booleans())
    def set_state(self, data: st.DataObject, packed: bool) -> None:
        """Back to any of them."""
        self._restore(data.draw(st.integers(0, len(self.states) - 1)), packed)

    def _restore(self, k: int, packed: bool) -> None:
        print(f"set state {k} {packed}", flush=True)
        state, data_, model = self.states[k]
        assert self.one.take(self.one.unpack(data_) if packed else state) == OK
        self.model, self.restored = model, True

    @precondition(lambda self: self.states)
    @rule(data=st.data())
    def set_damaged_state(self, data: st.DataObject) -> None:
        """A flipped bit, or the end missing."""
        packed = data.draw(st.sampled_from(self.states))[1]
        place = data.draw(st.integers(0, len(packed) - 1))
        cut = data.draw(st.booleans())
        print(f"damaged state {place} {cut}", flush=True)
        damaged = packed[:place] if cut else packed[:place] + bytes([packed[place] ^ 4]) + packed[place + 1 :]
        assert self.one.take(self.one.unpack(damaged)) == ERROR
        self._must_fail()

    @precondition(lambda self: self.states)
    @rule()
    def free_state(self) -> None:
        """The oldest."""
        print("free state", flush=True)
        assert self.one.drop(self.states.pop(0)[0]) == OK

    @rule()
    def another_instance(self) -> None:
        """The states go on in a new one, as in a restart."""
        print("free, instantiate", flush=True)
        packed = [(data, model) for _, data, model in self.states]
        for state, _, _ in self.states:
            self.one.drop(state)
        self.one.free()
        gc.collect(0)
        self.one = Raw(FOLDER, "another", logging=False)
        self.states = [(self.one.unpack(data), data, model) for data, model in packed]
        self.model, self.stop = self.fresh, math.inf
        for name, value in self.cheap.items():
            self._set(name, value)

    # -- what holds always --

    @invariant()
    def holds(self) -> None:
        """Failed or not as foreseen; outputs are those of the last good step, or NaN."""
        if self.model.failed or self.model.refused:
            self.one.assert_failed()
        else:
            self.one.assert_well()
            if self.model.shown and self.model.mode in ("running", "terminated"):
                assert bits(self.one.outputs()) == self.model.shown

    def _replay(self) -> None:
        """An instance that does only what was allowed stands at the same numbers."""
        print("replay", flush=True)
        self.restored = False
        calm = Raw(FOLDER, "calm", logging=False)
        start, *steps = self.model.past
        for name, value in start.items():
            calm[name] = value
        assert (calm.setup(), calm.enter(), calm.leave()) == (OK, OK, OK)
        time = 0.0
        for used, size in steps:
            for name, value in used:
                calm[name] = value
            assert calm.step(time, size) == OK, calm["error"]
            time += size
        assert bits(calm.outputs()) == self.model.shown
        calm.free()

    def teardown(self) -> None:
        """Also the end is compared."""
        if self.model.past and self.model.shown:
            self._replay()
        for state, _, _ in self.states:
            self.one.drop(state)
        self.one.free()


def main(examples: int, calls: int, seed_: str) -> None:
    """Run the machine; raises what it found."""
    faulthandler.enable()
    warnings.simplefilter("ignore")
    chosen = settings(
        max_examples=examples, stateful_step_count=calls, deadline=None, database=None, derandomize=seed_ == "-",
        suppress_health_check=list(HealthCheck), phases=(Phase.generate, Phase.shrink),
    )  # fmt: skip
    machine = Contract if seed_ == "-" else seed(int(seed_))(Contract)
    run_state_machine_as_test(machine, settings=chosen)


if __name__ == "__main__":
    code = 0
    try:
        main(int(sys.argv[2]), int(sys.argv[3]), sys.argv[4])
    except BaseException:
        traceback.print_exc()
        code = 1
    sys.stdout.flush()
    sys.stderr.flush()
    os._exit(code)
