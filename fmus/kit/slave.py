"""The base class of every FMU: declared variables, guarded callbacks, one way to fail, exact state.

A face subclasses `Slave`, lists its `variables` and writes a few short methods:

    class Structure(Slave):
        '''One line that becomes the description of the model.'''
        variables = (parameter("mass", 57.73, "kg/m", "Mass per span", min=1e-9), *wing_load_inputs(), ...)

        def prepare(self): ...                 # from parameters only: mesh, matrices (optional)
        def initialize(self): ...              # from parameters and inputs, set the outputs at the start time
        def step(self, time, step_size): ...   # inputs are values at time + step_size; set the outputs there
        def save(self): return {"y": self.y}   # by reference: never modify these arrays in place
        def restore(self, snapshot): self.y = snapshot["y"]

Failure. No exception leaves a callback: the call returns fmi2Error, the traceback goes to the FMI log, the Boolean output
`failed` becomes true, the String output `error` holds the message in one line, Real outputs become NaN and every later
`fmi2DoStep` returns fmi2Error with the same message. A value that is refused (not finite, outside its range) returns fmi2Discard
from its fmi2Set, is not applied and fails the same way until a valid value is set; any other failure, also a call that the
standard forbids in the present mode, lasts until a good state is restored or the instance is reset.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, ClassVar
from xml.etree.ElementTree import Element

from pythonfmu import Fmi2Slave

from . import clock, xml
from .binary import ByReference, remember, taker
from .failure import ERROR, FAILURE_OUTPUTS, OK, Failing, StepError, guarded, printable, quiet
from .prediction import SUFFIX, Extrapolator
from .state import State, check
from .variables import UNSET, Value, Variable

CREATED, INITIALIZING, RUNNING, TERMINATED = "created", "initializing", "running", "terminated"
_WAY = {
    CREATED: "enter initialisation mode first",
    INITIALIZING: "leave initialisation mode first",
    RUNNING: "step, or reset this instance to start anew",
    TERMINATED: "reset this instance to start anew, or restore a state",
}
"""What is to be done next in a mode, for a host that asked for something else."""


class Slave(Failing, Fmi2Slave):
    """Guarded co-simulation slave; see the module's text. Subclasses define no `__init__`."""

    variables: ClassVar[tuple[Variable, ...]] = ()
    version: ClassVar[str] = "0"  # the build sets these two
    content_hash: ClassVar[str] = ""  # "" where the face runs from the source tree
    stop_time: ClassVar[float] = 1.0  # default experiment [s]
    step_size: ClassVar[float] = 1e-3  # default experiment [s]
    # of the default experiment, for tools that want one; the components' own parameters say how exact they are
    experiment_tolerance: ClassVar[float] = 1e-4

    # -- what a component writes --

    def prepare(self) -> None:
        """Build what depends on parameters alone (mesh, matrices).

        Called before `initialize`, and before `restore` where the instance was not prepared for the restored
        parameters (a restart in a new process); not again while the parameters stay the same.
        """

    def initialize(self) -> None:
        """Set up the run from parameters and inputs at `self.time`. May be called again before the first
        step.
        """

    def step(self, time: float, step_size: float) -> None:
        """Advance from `time` by `step_size` [s]; inputs are values at the end of the step."""
        raise NotImplementedError

    def save(self) -> dict[str, Any]:
        """Return, by reference, every array and scalar the next step reads and no variable holds."""
        return {}

    def restore(self, snapshot: dict[str, Any]) -> None:
        """Take back what `save` returned; the arrays must stay unmodified."""

    def finish(self) -> None:
        """Release what the run holds (called at terminate)."""

    # -- set-up --

    def __init_subclass__(cls, **kwargs: Any) -> None:
        super().__init_subclass__(**kwargs)
        names = [variable.name for variable in (*cls.variables, *FAILURE_OUTPUTS)]
        if twice := {name for name in names if names.count(name) > 1}:
            raise TypeError(f"{cls.__name__}: variables declared twice: {', '.join(sorted(twice))}")
        if taken := {name for name in names if hasattr(Slave, name)}:
            raise TypeError(f"{cls.__name__}: names taken by the base class: {', '.join(sorted(taken))}")

    def __init__(self, **kwargs: Any) -> None:
        super().__init__(**kwargs)
        self.modelName = type(self).__name__
        self.time = 0.0
        self.declared: tuple[Variable, ...] = (*self.variables, *FAILURE_OUTPUTS)
        self._mode = CREATED
        self._stop_time = math.inf  # of this instance's experiment, no part of a state: a restart may go further
        self._last = 0.0  # the step before [s]
        self._stale = True  # a variable was set since `initialize` ran
        # fixed parameters, in order
        self._fixed = {v.name: None for v in self.variables if v.causality == "parameter" and not v.tunable}
        self._prepared: tuple[Value, ...] | None = None  # the parameters that `prepare` ran for
        self._references = {name: ByReference(name) for name in UNSET}
        # what a step goes through, ready made: Real inputs with their ranges, names by reference, Real outputs
        self._ranges: dict[int, tuple[str, float, float]] = {}
        self._names = {name: ByReference(name) for name in UNSET}
        self._results: list[str] = []
        # of Reals, by references: what takes their values out of the instance, and names and ranges of what is set
        self._takers: dict[tuple[int, ...], Callable[[dict[str, Any]], tuple[Any, ...]]] = {}
        self._plans: dict[tuple[int, ...], list[tuple[str, float, float]]] = {}
        # the variable that switches the prediction of inputs on, and what foretells them
        self._switch = next((variable.name for variable in self.variables if variable.name.endswith(SUFFIX)), "")
        self._ahead: Extrapolator | None = None
        for reference, variable in enumerate(self.declared):
            if variable.name in self.__dict__:
                raise TypeError(f"{self.modelName}: variable name '{variable.name}' is taken by the base class")
            self._references[variable.type][reference] = variable
            self._names[variable.type][reference] = variable.name
            if variable.type == "Real" and variable.causality == "input":
                self._ranges[reference] = (variable.name, variable.low, variable.high)
            elif variable.type == "Real" and variable.causality == "output":
                self._results.append(variable.name)
            setattr(self, variable.name, UNSET[variable.type] if variable.start is None else variable.start)
            # not through register_variable, whose getters hold the instance: it would live until the garbage collector comes
            self.vars[reference] = variable
        self._all_results = taker(self._results)

    @property
    def folder(self) -> Path:
        """The component's folder with its data files, in this instance's own resources.

        `__file__` is not good enough: the code of a second instance comes from the first one's unzip folder,
        which may be gone.
        """
        source = Path(inspect.getfile(_face(type(self)))).parent
        if self.resources:
            inside = Path(self.resources) / source.parent.name / source.name
            if inside.is_dir():
                return inside
        return source

    def to_xml(self, model_options: dict[str, str] | None = None) -> Element:
        """Return the model description (see `xml`)."""
        text = " ".join(inspect.cleandoc(_face(type(self)).__doc__ or "").split("\n\n")[0].split())
        model = xml.Model(
            self.modelName, text, type(self).version, self.content_hash, self.stop_time, self.step_size, self.experiment_tolerance
        )
        return xml.describe(model, self.declared, self.log_categories)

    # -- life cycle --

    @quiet
    def setup_experiment(self, start_time: float, stop_time: float | None = None, tolerance: float | None = None) -> int:
        """Note the start time and, if given, the stop time [s]."""
        self._expect(CREATED, "set up an experiment")
        clock.check_experiment(start_time, stop_time)
        self.time = float(start_time)
        self._stop_time = math.inf if stop_time is None else float(stop_time)
        return self._standing

    @quiet
    def enter_initialization_mode(self) -> int:
        """Allow `initialize` to run, as soon as an output is asked for or initialisation ends."""
        self._expect(CREATED, "enter initialisation mode")
        self._mode, self._stale = INITIALIZING, True
        return self._standing

    @quiet
    def exit_initialization_mode(self) -> int:
        """Run `initialize` unless it ran for these values already; parameters are fixed from here on."""
        self._expect(INITIALIZING, "leave initialisation mode")
        if self._refused:
            raise StepError(f"not initialised, a value was refused: {' '.join(self._refused.values())}")
        self._initialize()
        self._ahead = Extrapolator(self._inputs()) if self._switch and getattr(self, self._switch) else None
        self._mode = RUNNING
        return self._standing

    @property
    def _standing(self) -> int:
        """The status of a call that did its own work: fmi2Error where the instance has failed before."""
        return ERROR if self._failure else OK

    def _expect(self, mode: str, wish: str) -> None:
        if self._mode != mode:
            raise StepError(f"asked to {wish} while {self._mode}. Remedy: {_WAY[self._mode]}")

    def _initialize(self) -> None:
        if self._stale and not self.message:
            self._stale = False
            self._prepare()
            self.initialize()
            self._check_outputs()

    @quiet
    def do_step(self, current_time: float, step_size: float) -> int:
        """Advance by one communication step [s]; True (fmi2OK), or fmi2Error where the instance has failed."""
        if self._failure or self._refused:
            self.report(f"step refused at t = {current_time!r} s: {self.message}")
            return ERROR
        if self._mode != RUNNING:
            self._expect(RUNNING, "step")
        current_time, step_size, end = clock.step(self.time, self._last, self._stop_time, current_time, step_size)
        self._last = step_size
        if self._ahead is None:
            self.step(current_time, step_size)
        else:
            self._step_ahead(self._ahead, current_time, step_size)
        self.time = end
        self._check_outputs()
        return True

    def _step_ahead(self, ahead: Extrapolator, time: float, step_size: float) -> None:
        """Step with foretold inputs; a host reads back those that it set."""
        given, ranges = self._inputs(), self._ranges.values()
        try:
            for (name, low, high), value in zip(ranges, ahead.next(given, step_size), strict=True):
                if not low <= value <= high:
                    raise StepError(
                        f"input '{name}' foretold as {value} is out of its range. Remedy: smaller steps, or {self._switch} = 0"
                    )
                self.__dict__[name] = value
            self.step(time, step_size)
        finally:
            self.__dict__.update((name, value) for (name, _, _), value in zip(ranges, given, strict=True))

    def _inputs(self) -> list[float]:
        values = self.__dict__
        return [values[name] for name, _, _ in self._ranges.values()]

    def _prepare(self) -> None:
        values = self.__dict__
        parameters = tuple(values[name] for name in self._fixed)
        if parameters != self._prepared:
            self._prepared = None
            self.prepare()
            self._prepared = parameters

    def _check_outputs(self) -> None:
        values = self.__dict__
        if math.isfinite(sum(self._all_results(values))):
            return  # all are; where all are and their sum is not, each is looked at
        for name in self._results:
            if not math.isfinite(values[name]):
                raise StepError(
                    f"output '{name}' = {values[name]} at t = {self.time!r} s. "
                    "Remedy: reduce the step size; look at the inputs for a diverged value"
                )

    @quiet
    def terminate(self) -> int:
        """End the run; outputs stay as they are. Allowed always: a host that gives up says so."""
        ran, self._mode = self._mode in (INITIALIZING, RUNNING), TERMINATED
        if ran:
            self.finish()
        return OK

    # -- variables --

    @quiet
    def _initialize_for(self, asked: list[Variable]) -> int:
        """Run `initialize` where an output is asked for during initialisation."""
        if any(variable.causality == "output" and variable not in FAILURE_OUTPUTS for variable in asked):
            self._initialize()
        return OK

    def _get(self, type_: str, vrs: Sequence[int], convert: Callable[[Any], Any]) -> Sequence[Any]:
        """The values; a failure on the way stands behind them, as the status of this call."""
        declared, values = self._references[type_], self.__dict__
        if self._mode == RUNNING and not self._failure and not self._refused:
            names = self._names[type_]
            return [convert(values[names[vr]]) for vr in vrs]
        status = OK
        if self._mode == INITIALIZING and self._stale:
            status = self._initialize_for([declared[vr] for vr in vrs])
        message = self.message
        result = []
        for vr in vrs:
            variable = declared[vr]
            value = values[variable.name]
            if message and variable.causality == "output":
                value = {"failed": True, "error": message}.get(variable.name, UNSET[type_])
            result.append(convert(value))
        return result if status == OK else [*result, status]

    @guarded(lambda vrs: [math.nan] * len(vrs) + [ERROR])
    def get_real(self, vrs: Sequence[int]) -> Sequence[float]:
        """Return Reals by value reference; NaN for outputs of a failed instance."""
        if self._mode == RUNNING and not self._failure and not self._refused and type(vrs) is tuple:
            take = self._takers.get(vrs)
            if take is None:
                names = self._names["Real"]
                take = remember(self._takers, vrs, taker([names[vr] for vr in vrs]))
            return take(self.__dict__)
        return self._get("Real", vrs, float)

    @guarded(lambda vrs: [0] * len(vrs) + [ERROR])
    def get_integer(self, vrs: Sequence[int]) -> Sequence[int]:
        """Return Integers by value reference."""
        return self._get("Integer", vrs, int)

    @guarded(lambda vrs: [False] * len(vrs) + [ERROR])
    def get_boolean(self, vrs: Sequence[int]) -> Sequence[bool]:
        """Return Booleans by value reference."""
        return self._get("Boolean", vrs, bool)

    @guarded(lambda vrs: [""] * len(vrs) + [ERROR])
    def get_string(self, vrs: Sequence[int]) -> Sequence[str]:
        """Return Strings by value reference."""
        return self._get("String", vrs, lambda value: printable(str(value)))

    def _set(self, type_: str, vrs: Sequence[int], new: Sequence[Value]) -> int:
        """Set what can be set; the worst status of all values."""
        declared, values, worst = self._references[type_], self.__dict__, OK
        for vr, value in zip(vrs, new, strict=True):
            variable = declared[vr]
            name = variable.name
            forbidden = ""
            if variable.causality == "output":
                forbidden = f"output '{name}' cannot be set. Remedy: set parameters and inputs only"
            elif self._mode == TERMINATED:
                forbidden = f"{variable.causality} '{name}' set while terminated. Remedy: {_WAY[TERMINATED]}"
            problem = variable.problem(value)
            if not forbidden and not problem and name in self._fixed and self._mode == RUNNING and value != values[name]:
                forbidden = f"parameter '{name}' is fixed. Remedy: set it before initialisation ends"
            if forbidden:
                worst = self.refuse(name, forbidden, ERROR)
            elif problem:
                worst = max(worst, self.refuse(name, problem))
            else:
                values[name] = value
                self._refused.pop(name, None)
        self._stale = True
        return worst

    @quiet
    def set_real(self, vrs: Sequence[int], values: Sequence[float]) -> int:
        """Set Reals by value reference; a value that is refused is not applied (see the module's text)."""
        if self._mode == RUNNING and not self._refused and type(vrs) is tuple:
            own, plan = self.__dict__, self._plans.get(vrs)
            if plan is None:
                plan = remember(self._plans, vrs, [self._ranges.get(vr, ("", 1.0, 0.0)) for vr in vrs])
            for (name, low, high), value in zip(plan, values):  # noqa: B905  as many as there are references, by the library
                if not low <= value <= high:  # not an input, not a number, out of range: the long way
                    break
                own[name] = value
            else:
                self._stale = True
                return OK
        return self._set("Real", vrs, values)

    @quiet
    def set_integer(self, vrs: Sequence[int], values: Sequence[int]) -> int:
        """Set Integers and enumerations by value reference."""
        return self._set("Integer", vrs, values)

    @quiet
    def set_boolean(self, vrs: Sequence[int], values: Sequence[bool]) -> int:
        """Set Booleans by value reference."""
        return self._set("Boolean", vrs, [bool(value) for value in values])

    @quiet
    def set_string(self, vrs: Sequence[int], values: Sequence[Any]) -> int:
        """Set Strings by value reference; a null pointer comes as None, what is not UTF-8 as bytes."""
        if any(isinstance(value, bytes) for value in values):
            raise StepError("a string that was set is not encoded in UTF-8. Remedy: encode strings in UTF-8")
        return self._set("String", vrs, values)

    # -- state --

    def _get_fmu_state(self) -> State | None:
        try:
            values = self.__dict__
            internals = {
                "time": self.time,
                "last": self._last,
                "mode": self._mode,
                "failure": self._failure,
                "refused": dict(self._refused),
                "ahead": self._ahead.save() if self._ahead else None,
            }
            return State(
                type(self).__name__,
                self.content_hash,
                {variable.name: values[variable.name] for variable in self.declared},
                internals,
                dict(self.save()) if self._mode == RUNNING and not self._failure else {},
            )
        except BaseException as exception:
            self.fail("get state", exception)
            return None

    @quiet
    def _set_fmu_state(self, state: State) -> int:
        if not hasattr(state, "content_hash"):
            raise StepError("this is no state of an aeroslosh FMU. Remedy: give each FMU its own state")
        if state.problem:
            raise StepError(f"this state cannot be restored: {state.problem}")
        check(state.component, state.content_hash, type(self).__name__, self.content_hash)
        self.__dict__.update(state.values)
        inner = state.internals
        self.time, self._last, self._mode, self._stale = inner["time"], inner["last"], inner["mode"], True
        self._failure, self._refused = inner["failure"], dict(inner["refused"])
        self._ahead = Extrapolator.restore(inner["ahead"]) if inner["ahead"] else None
        if self._mode == RUNNING and not self._failure:
            self._prepare()
            self.restore(state.snapshot)
        return OK

    @classmethod
    def _fmu_state_to_bytes(cls, state: State) -> bytes:
        try:
            return state.to_bytes()
        except BaseException as exception:  # written as a state that says so when it is restored
            return State(cls.__name__, cls.content_hash, problem=f"not serialised: {exception}").to_bytes()

    @classmethod
    def _fmu_state_from_bytes(cls, data: bytes) -> State:
        try:
            return State.from_bytes(bytes(data), cls.__name__, cls.content_hash)
        except BaseException as exception:
            return State(cls.__name__, cls.content_hash, problem=str(exception) or type(exception).__name__)


def _face(cls: type) -> type:
    """Return the class that a component wrote, below the leaf that the build generates."""
    return next(base for base in cls.__mro__ if "variables" in vars(base))
