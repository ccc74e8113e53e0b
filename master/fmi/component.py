"""One FMU instance: load, set, step, get, save, rewind, its log and its cost. Works with any FMI 2.0
co-simulation FMU.

Real inputs and outputs travel through preallocated ctypes buffers seen as numpy arrays (`inputs`,
`outputs`): one FMI call each way, no allocation per step. FMUs of this product also have the outputs
`failed` and `error`; they are read after a failure when present.
"""

from __future__ import annotations

import ctypes
import time as clock
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
import numpy as np
from fmpy import fmi2
from fmpy.fmi1 import FMICallException

from ..base import interrupts, settings
from ..base.errors import AeroSloshError, ComponentError
from . import kernels, unpack
from . import log as fmi_log
from .values import fitted

STATUS = {0: "OK", 1: "warning", 2: "discarded", 3: "error", 4: "fatal", 5: "pending"}
KINDS: dict[str, Any] = {
    "Real": ctypes.c_double,
    "Integer": ctypes.c_int,
    "Enumeration": ctypes.c_int,
    "Boolean": ctypes.c_int,
}


class Saved(NamedTuple):
    """A saved state of one instance: the FMU's own, its time [s] and the steps done."""

    state: Any
    time: float
    steps: int


class Group:
    """Variables of one type that travel together; `values` is a numpy view (float64 or int32) of the C buffer."""

    def __init__(self, component: Component, names: Sequence[str], kind: str) -> None:
        self.names = list(names)
        n = max(1, len(self.names))  # ctypes arrays of length 0 have no numpy view
        self._count = len(self.names)
        self._component = component
        self._references = (ctypes.c_uint * n)(*(component.variables[name].valueReference for name in self.names))
        self._buffer = (KINDS[kind] * n)()
        self.values = np.ctypeslib.as_array(self._buffer)[: self._count]
        suffix = "Integer" if kind == "Enumeration" else kind
        # the library's own functions (FMPy has declared their types): its logging wrapper costs as much as the call
        self._getter, self._setter = (getattr(component.fmu.dll, f"fmi2{what}{suffix}") for what in ("Get", "Set"))

    def get(self) -> None:
        """Read the FMU's values into `values`."""
        self._call(self._getter)

    def set(self) -> None:
        """Write `values` to the FMU."""
        self._call(self._setter)

    def _call(self, function: Any) -> None:
        """`Component.calling` written out: this runs several times a step."""
        if not self._count:
            return
        component, begin = self._component, clock.perf_counter()
        status = function(component.fmu.component, self._references, self._count, self._buffer)
        if interrupts.pending is not None:
            interrupts.check()
        if status > fmi2.fmi2Warning:
            name = function.__name__
            raise component.failure(FMICallException(function=name, status=status), name)
        spent = clock.perf_counter() - begin
        component.wall += spent
        component.cpu += spent


class Component:
    """An instance of the FMU at `path` called `name` (a word without dots).

    variables       name → FMPy model variable (causality, unit, type, start)
    inputs, outputs groups of all Real inputs and outputs (`input_index[name]` is the position)
    whole, truth    groups of all Integer (and enumeration) and all Boolean outputs; read them with
                    `.get()` when needed
    given           name → value of everything set one by one before this instance was initialised
    cpu, wall       seconds spent inside its FMI calls
    Raises AeroSloshError for a file that is no usable FMU, ComponentError when a call fails."""

    def __init__(self, path: Path, name: str, log_lines: int = 2000) -> None:
        self.path, self.name = path, name
        self.folder, self.sha256 = unpack.unzip(path)
        try:
            self.description = fmpy.read_model_description(str(self.folder), validate=False)
        except Exception as error:  # FMPy raises bare Exceptions here
            raise AeroSloshError(f"{path.name} cannot be read: {error}", str(path), "give an FMI 2.0 FMU") from None
        simulation = self.description.coSimulation
        if not str(self.description.fmiVersion).startswith("2") or simulation is None:
            raise AeroSloshError(
                f"{path.name} is not an FMI 2.0 co-simulation FMU (version {self.description.fmiVersion})",
                str(path),
                "export it for FMI 2.0 co-simulation",
            )
        self.variables: dict[str, Any] = {v.name: v for v in self.description.modelVariables}
        self.can_rewind = bool(simulation.canGetAndSetFMUstate)
        self.can_serialize = self.can_rewind and bool(simulation.canSerializeFMUstate)
        self.can_interpolate = bool(simulation.canInterpolateInputs)
        self._final = fmi2.fmi2True  # noSetFMUStatePriorToCurrentPoint: no step will be repeated
        self.cpu = self.wall = self.time = 0.0
        self.steps = 0
        self.messages: deque[tuple[int, str]] = deque(maxlen=log_lines)
        self.state = "created"
        try:
            self.fmu = fmi2.FMU2Slave(
                guid=self.description.guid,
                unzipDirectory=str(self.folder),
                modelIdentifier=simulation.modelIdentifier,
                instanceName=fmi_log.register(name, self),
            )
        except Exception as error:
            raise AeroSloshError(
                f"The binary of {path.name} cannot be loaded: {error}",
                str(self.folder),
                "its binaries must fit this machine (`fmpy info` lists the platforms)",
            ) from None
        self._do_step = self.fmu.dll.fmi2DoStep
        self._instantiate()
        reals = {
            c: [v.name for v in self.variables.values() if v.type == "Real" and v.causality == c] for c in ("input", "output")
        }
        self.inputs = Group(self, reals["input"], "Real")
        self.outputs = Group(self, reals["output"], "Real")
        self.input_index = {n: i for i, n in enumerate(reals["input"])}
        self.output_index = {n: i for i, n in enumerate(reals["output"])}
        whole = [v.name for v in self.variables.values() if v.causality == "output" and v.type in ("Integer", "Enumeration")]
        truth = [v.name for v in self.variables.values() if v.causality == "output" and v.type == "Boolean"]
        self.whole, self.truth = Group(self, whole, "Integer"), Group(self, truth, "Boolean")

    # life

    def initialize(self, start_time: float = 0.0) -> None:
        """Enter and leave initialisation mode; parameters and initial inputs were set before."""
        self.enter_initialization(start_time)
        self.exit_initialization()

    def enter_initialization(self, start_time: float = 0.0) -> None:
        """Set up the experiment and enter initialisation mode; kernels are compiled before, where they never were."""
        kernels.prepare(self.folder, self.sha256, self.given)
        self.time = start_time
        with self.calling("fmi2EnterInitializationMode", heavy=True) as fmu:
            fmu.setupExperiment(startTime=start_time)
            fmu.enterInitializationMode()
        self.inputs.get()  # inputs left unwired keep their start values
        self.state = "initializing"

    def exit_initialization(self) -> None:
        """Leave initialisation mode; reads the initial outputs; raises when the FMU says it failed."""
        with self.calling("fmi2ExitInitializationMode", heavy=True) as fmu:
            fmu.exitInitializationMode()
        self.state = "ready"
        self.outputs.get()
        self.check("fmi2ExitInitializationMode")

    def check(self, what: str) -> None:
        """Raise ComponentError when the FMU says `failed` (this product's do) of the call `what`, which returned OK."""
        if "failed" in self.variables and self.get("failed"):
            raise self._failure("it says that it failed", what)

    def restart(self) -> None:
        """A new instance of the same FMU in place of this one (all states taken from it are void)."""
        self._free()
        self._instantiate()

    def close(self) -> None:
        """Free the instance. The library stays loaded: unloading pythonfmu's wrapper is not safe."""
        self._free()

    # values

    def check_and_set(self, variable: str, value: Any, where: str) -> None:
        """Set a parameter or a start value, if it exists and the value fits (`values.fitted`).

        Raises AeroSloshError; `where`: the key it comes from."""
        names = [n for n, v in self.variables.items() if v.causality in ("parameter", "input")]
        if variable not in names:
            remedy = settings.nearest(variable, names, f"those of {self.path.name} are")
            raise AeroSloshError(f"'{self.name}' has no parameter or input '{variable}'", where, remedy)
        self.set(variable, fitted(self.variables[variable], value, variable, where))

    def set(self, name: str, value: float | int | bool | str) -> None:
        """Set one variable of any type."""
        variable = self._variable(name)
        if self.state == "instantiated":
            self.given[name] = value
        with self.calling("fmi2Set") as fmu:
            reference = [variable.valueReference]
            if variable.type == "Real":
                fmu.setReal(reference, [float(value)])
            elif variable.type in ("Integer", "Enumeration"):
                fmu.setInteger(reference, [int(value)])
            elif variable.type == "Boolean":
                fmu.setBoolean(reference, [bool(value)])
            else:
                fmu.setString(reference, [str(value)])

    def set_all(self, values: Mapping[str, float | int | bool | str]) -> None:
        """Set many variables."""
        for name, value in values.items():
            self.set(name, value)

    def get(self, name: str) -> Any:
        """Read one variable of any type."""
        variable = self._variable(name)
        with self.calling("fmi2Get") as fmu:
            reference = [variable.valueReference]
            if variable.type == "Real":
                return fmu.getReal(reference)[0]
            if variable.type in ("Integer", "Enumeration"):
                return fmu.getInteger(reference)[0]
            if variable.type == "Boolean":
                return bool(fmu.getBoolean(reference)[0])
            return fmu.getString(reference)[0].decode("utf-8", "replace")

    # stepping

    def step(self, dt: float, first: np.ndarray | None = None, second: np.ndarray | None = None) -> None:
        """Write `inputs`, advance from `time` by `dt` [s], read `outputs`. Raises ComponentError.

        `first`, `second`: time derivatives [1/s, 1/s²] of the inputs at the start of the step. Shape: (n_inputs,)."""
        self.inputs.set()
        if first is not None:  # after the values: an FMU may take a new value for the end of an old slope
            self._set_input_derivatives([first] if second is None else [first, second])
        cpu, wall = clock.process_time(), clock.perf_counter()
        # the library's own function, as in `Group`
        status = self._do_step(self.fmu.component, self.time, dt, self._final)
        self.wall += clock.perf_counter() - wall
        self.cpu += clock.process_time() - cpu
        interrupts.check()
        if status > fmi2.fmi2Warning:
            raise self.failure(FMICallException(function="fmi2DoStep", status=status), "fmi2DoStep")
        self.outputs.get()
        self.time += dt
        self.steps += 1

    def save(self) -> Saved:
        """The FMU's whole state; free it with `free`."""
        if not self.can_rewind:
            raise AeroSloshError(
                f"{self.name} cannot save and restore its state (canGetAndSetFMUstate is false)",
                str(self.path),
                'use coupling.scheme = "gauss-seidel", or another export of this FMU',
            )
        self._final = fmi2.fmi2False  # from now on a step may be repeated
        with self.calling("fmi2GetFMUstate") as fmu:
            return Saved(fmu.getFMUState(), self.time, self.steps)

    def rewind(self, saved: Saved) -> None:
        """Return to a saved state (which stays valid) and read the outputs of it."""
        with self.calling("fmi2SetFMUstate") as fmu:
            fmu.setFMUState(saved.state)
        self.time, self.steps = saved.time, saved.steps
        self.outputs.get()

    def free(self, saved: Saved) -> None:
        """Free a saved state."""
        with self.calling("fmi2FreeFMUstate") as fmu:
            fmu.freeFMUState(saved.state)

    def serialized(self) -> bytes:
        """The FMU's whole state, to be restored in another process. Raises AeroSloshError when the FMU cannot."""
        if not self.can_serialize:
            raise no_serialization(self.name, self.path)
        saved = self.save()
        try:
            with self.calling("fmi2SerializeFMUstate") as fmu:
                return fmu.serializeFMUstate(saved.state)
        finally:
            self.free(saved)

    def restore(self, data: bytes, time: float, steps: int) -> None:
        """Return to a state `serialized` in another process, `time` [s] and `steps` of it, and read the outputs."""
        with self.calling("fmi2DeSerializeFMUstate") as fmu:
            saved = Saved(fmu.deSerializeFMUstate(data), time, steps)
        self.rewind(saved)
        self.free(saved)
        self.state = "ready"
        self.check("fmi2SetFMUstate")

    # inside

    def _set_input_derivatives(self, derivatives: Sequence[np.ndarray]) -> None:
        """Of all continuous Real inputs (a discrete one has none), the first one first."""
        places = [i for i, name in enumerate(self.inputs.names) if self.variables[name].variability != "discrete"]
        references = [self.variables[self.inputs.names[i]].valueReference for i in places]
        if not references:
            return
        with self.calling("fmi2SetRealInputDerivatives") as fmu:
            for order, values in enumerate(derivatives, start=1):
                fmu.setRealInputDerivatives(references, [order] * len(references), values[places].tolist())

    @contextmanager
    def calling(self, what: str, heavy: bool = False) -> Iterator[Any]:
        """Count the time of FMI calls; turn a bad status into a ComponentError with the FMU's own words.

        CPU time is asked for around `heavy` calls alone: the question costs microseconds on some systems, as
        much as a light call, whose wall time serves for both.
        """
        cpu, wall = clock.process_time() if heavy else 0.0, clock.perf_counter()
        try:
            yield self.fmu
            interrupts.check()
        except FMICallException as error:
            interrupts.check()
            raise self.failure(error, what) from None
        finally:
            spent = clock.perf_counter() - wall
            self.wall += spent
            self.cpu += clock.process_time() - cpu if heavy else spent

    def failure(self, error: FMICallException, what: str) -> ComponentError:
        """What a user sees of a call that returned a bad status."""
        return self._failure(f"{error.function} returned '{STATUS.get(error.status, error.status)}'", what)

    def _failure(self, said: str, what: str) -> ComponentError:
        """The error a user sees: the FMU's `error` line when it has one, and the messages of its log."""
        line = ""
        if "error" in self.variables and self.variables["error"].type == "String":
            try:
                raw = self.fmu.getString([self.variables["error"].valueReference])[0]
                line = raw.decode("utf-8", "replace").strip() if raw else ""
            except FMICallException:
                line = ""  # an instance too broken to answer: the log must do
        line, _, remedy = line.removeprefix(f"{self.name}: ").partition("Remedy:")  # as this product's FMUs write
        bad = [text for status, text in self.messages if status >= fmi2.fmi2Discard]
        trace = "\n".join(dict.fromkeys(bad))  # the same text may come with every later call
        return ComponentError(
            f"Component '{self.name}' failed: {line.strip() or said}",
            f"{what} at t = {self.time:.6g} s, step {self.steps + 1} ({self.path.name}; {said})",
            remedy.strip() or "the FMU's own messages are below; correct the setting they name",
            self.name,
            self.time,
            trace,
        )

    def _variable(self, name: str) -> Any:
        if name not in self.variables:
            raise AeroSloshError(
                f"{self.name} has no variable '{name}'",
                str(self.path),
                f"`fmpy info {self.path.name}` lists its variables; rebuild old FMUs with `make fmus`",
            )
        return self.variables[name]

    def _instantiate(self) -> None:
        self.messages.clear()
        self.given: dict[str, float | int | bool | str] = {}
        cpu, wall = clock.process_time(), clock.perf_counter()
        try:
            self.fmu.instantiate(callbacks=fmi_log.callbacks, loggingOn=True)
            interrupts.check()
        except Exception as error:
            interrupts.check()
            trace = "\n".join(text for _, text in self.messages)
            raise ComponentError(
                f"Component '{self.name}' cannot be instantiated: {error}",
                str(self.path),
                "run `fmpy validate` on it; rebuild with `make fmus`",
                self.name,
                0.0,
                trace,
            ) from None
        finally:
            self.cpu += clock.process_time() - cpu
            self.wall += clock.perf_counter() - wall
        self.state, self.steps, self.time = "instantiated", 0, 0.0

    def _free(self) -> None:
        if self.state not in ("created", "freed"):
            self.fmu.fmi2FreeInstance(self.fmu.component)
            self.state = "freed"


def no_serialization(name: str, path: Path) -> AeroSloshError:
    """What to say of an FMU that cannot serialise its state."""
    return AeroSloshError(
        f"{name} cannot write its state to a file (canSerializeFMUstate is false)",
        str(path),
        "run without checkpoints, or take another export of this FMU",
    )
