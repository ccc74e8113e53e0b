"""An FMU as a host in C sees it: the functions of the library with raw arguments, and the status of each call.

FMPy's wrappers raise where a status is not OK and fill in arguments; here nothing is refused on the way.
"""

from __future__ import annotations

import ctypes as c
import math
import struct
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import Any

import fmpy
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
CO_SIMULATION = 1
TYPES = {"Real": c.c_double, "Integer": c.c_int, "Boolean": c.c_int, "String": c.c_char_p}
LOG: list[tuple[str, int, str, str]] = []  # instance, status, category, text: all that any instance said


@cache
def description(folder: str) -> Any:
    """The model description of an unzipped FMU."""
    return fmpy.read_model_description(folder)


@cache
def library(folder: str) -> c.CDLL:
    """The loaded library of an unzipped FMU."""
    name = description(folder).coSimulation.modelIdentifier
    lib = c.CDLL(str(Path(folder) / "binaries" / fmpy.platform / f"{name}{fmpy.sharedLibraryExtension}"))
    lib.fmi2Instantiate.restype = c.c_void_p
    lib.fmi2GetVersion.restype = lib.fmi2GetTypesPlatform.restype = c.c_char_p
    lib.fmi2FreeInstance.restype = None
    return lib


def kind(variable: Any) -> str:
    """The FMI type of the functions that get and set a variable."""
    return "Integer" if variable.type == "Enumeration" else str(variable.type)


def bits(values: Sequence[float]) -> str:
    """The numbers as hexadecimal text, exact to the bit."""
    return struct.pack(f"<{len(values)}d", *values).hex()


class Raw:
    """One instance. Methods return the status of the call, or (status, answer)."""

    def __init__(self, folder: str, name: str | bytes = "raw", *, logging: bool = True, guid: bytes | None = None) -> None:
        self.folder = folder
        self.lib, self.description = library(folder), description(folder)
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.callbacks = fmi2CallbackFunctions()
        self.callbacks.logger = fmi2CallbackLoggerTYPE(_note)
        self.callbacks.allocateMemory = fmpy.fmi2.defaultCallbacks.allocateMemory
        self.callbacks.freeMemory = fmpy.fmi2.defaultCallbacks.freeMemory
        uri = (Path(folder) / "resources").as_uri().encode()
        self.name = name if isinstance(name, bytes) else name.encode()
        self.component = c.c_void_p(
            self.lib.fmi2Instantiate(
                self.name, CO_SIMULATION, guid or self.description.guid.encode(), uri, c.byref(self.callbacks), 0, int(logging)
            )
        )
        assert self.component.value, f"not instantiated: {LOG[-1:]}"

    def call(self, function: str, *arguments: Any) -> int:
        """Call any FMI function by the end of its name."""
        return int(getattr(self.lib, f"fmi2{function}")(self.component, *arguments))

    # -- life --

    def setup(self, start: float = 0.0, stop: float | None = None, tolerance: float | None = None) -> int:
        """fmi2SetupExperiment"""
        return self.call(
            "SetupExperiment", int(tolerance is not None), c.c_double(tolerance or 0.0), c.c_double(start), int(stop is not None),
            c.c_double(stop or 0.0),
        )  # fmt: skip

    def enter(self) -> int:
        """fmi2EnterInitializationMode"""
        return self.call("EnterInitializationMode")

    def leave(self) -> int:
        """fmi2ExitInitializationMode"""
        return self.call("ExitInitializationMode")

    def step(self, time: float, step_size: float, no_set_before: bool = True) -> int:
        """fmi2DoStep"""
        return self.call("DoStep", c.c_double(time), c.c_double(step_size), int(no_set_before))

    def terminate(self) -> int:
        """fmi2Terminate"""
        return self.call("Terminate")

    def reset(self) -> int:
        """fmi2Reset"""
        return self.call("Reset")

    def free(self) -> None:
        """fmi2FreeInstance"""
        self.lib.fmi2FreeInstance(self.component)

    # -- values --

    def get(self, type_: str, references: Sequence[int]) -> tuple[int, list[Any]]:
        """fmi2Get<type>; strings as bytes. The buffer holds -12345 (strings: null) before."""
        n = len(references)
        values = (TYPES[type_] * n)(*([None if type_ == "String" else -12345] * n))
        status = self.call(f"Get{type_}", (c.c_uint * n)(*references), c.c_size_t(n), values)
        return status, list(values)

    def set(self, type_: str, references: Sequence[int], values: Sequence[Any]) -> int:
        """fmi2Set<type>; strings as bytes, None for a null pointer."""
        n = len(references)
        return self.call(f"Set{type_}", (c.c_uint * n)(*references), c.c_size_t(n), (TYPES[type_] * n)(*values))

    def __getitem__(self, name: str) -> Any:
        variable = self.variables[name]
        status, (value,) = self.get(kind(variable), [variable.valueReference])
        assert status == OK, f"get {name}: status {status}"
        return value.decode() if isinstance(value, bytes) else value

    def put(self, name: str, value: Any) -> int:
        """Set one variable; the status."""
        variable = self.variables[name]
        return self.set(kind(variable), [variable.valueReference], [value.encode() if isinstance(value, str) else value])

    def __setitem__(self, name: str, value: Any) -> None:
        status = self.put(name, value)
        assert status == OK, f"set {name}: status {status}"

    def outputs(self) -> list[float]:
        """All Real outputs."""
        return list(self.get("Real", [v.valueReference for v in self.named("output", "Real")])[1])

    def named(self, causality: str, type_: str | None = None) -> list[Any]:
        """Variables of a causality, of one type if given."""
        return [v for v in self.variables.values() if v.causality == causality and type_ in (None, kind(v))]

    # -- state --

    def state(self) -> c.c_void_p:
        """fmi2GetFMUstate"""
        held = c.c_void_p()
        assert self.call("GetFMUstate", c.byref(held)) == OK and held.value
        return held

    def take(self, state: c.c_void_p) -> int:
        """fmi2SetFMUstate"""
        return self.call("SetFMUstate", state)

    def drop(self, state: c.c_void_p) -> int:
        """fmi2FreeFMUstate"""
        return self.call("FreeFMUstate", c.byref(state))

    def pack(self, state: c.c_void_p) -> bytes:
        """fmi2SerializeFMUstate"""
        size = c.c_size_t()
        assert self.call("SerializedFMUstateSize", state, c.byref(size)) == OK
        buffer = (c.c_char * size.value)()
        assert self.call("SerializeFMUstate", state, buffer, size) == OK
        return buffer.raw

    def unpack(self, data: bytes) -> c.c_void_p:
        """fmi2DeSerializeFMUstate"""
        held = c.c_void_p()
        buffer = (c.c_char * max(1, len(data))).from_buffer_copy(data or b"\0")
        assert self.call("DeSerializeFMUstate", buffer, c.c_size_t(len(data)), c.byref(held)) == OK and held.value
        return held

    # -- the model of a failure --

    @property
    def failed(self) -> bool:
        """What the Boolean output `failed` says."""
        return bool(self["failed"])

    def assert_failed(self, *words: str) -> None:
        """It says what and the remedy in one line, its Reals are NaN and it does not step."""
        error = self["error"]
        assert self.failed and error, f"not failed: {error!r}"
        assert "\n" not in error and "Remedy: " in error, error
        for word in words:
            assert word in error, f"{word!r} is not in: {error}"
        numbers = self.outputs()
        assert all(math.isnan(value) for value in numbers), numbers

    def assert_well(self) -> None:
        """It has not failed."""
        assert not self.failed and self["error"] == "", self["error"]


def _note(_environment: int, instance: bytes, status: int, category: bytes | None, text: bytes) -> None:
    LOG.append((instance.decode(errors="replace"), status, (category or b"").decode(), text.decode(errors="replace")))
