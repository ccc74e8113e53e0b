"""What only pythonfmu's binary could guard, tried in a process of its own: `python probes.py <probe> <unzip folder>`.

Each prints what came of it; a signal ends the process. `test_probes.py` holds what fmus/kit/README.md says of them, less those
that read memory which is freed or not theirs: these end in a signal mostly, not always.
"""

from __future__ import annotations

import ctypes as c
import os
import sys
from pathlib import Path
from typing import Any

import raw
from cheap import STEP, march, started
from fmpy.fmi2 import fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from raw import CO_SIMULATION, Raw, library


def instantiate(folder: str, **changes: Any) -> Any:
    """fmi2Instantiate with an argument changed: the component, or None."""
    good = Raw(folder)
    arguments = {
        "name": b"probe", "type": CO_SIMULATION, "guid": good.description.guid.encode(),
        "resources": (Path(folder) / "resources").as_uri().encode(), "callbacks": c.byref(good.callbacks),
        "visible": 0, "logging": 1,
    }  # fmt: skip
    return library(folder).fmi2Instantiate(*{**arguments, **changes}.values())


def wrong_guid(folder: str) -> Any:
    return instantiate(folder, guid=b"{no such guid}") is not None


def model_exchange(folder: str) -> Any:
    return instantiate(folder, type=0) is not None


def null_resources(folder: str) -> Any:
    return instantiate(folder, resources=None) is not None


def no_such_resources(folder: str) -> Any:
    return instantiate(folder, resources=b"file:///no/such/folder") is not None


def null_name(folder: str) -> Any:
    return instantiate(folder, name=None) is not None


def name_not_utf8(folder: str) -> Any:
    return instantiate(folder, name=b"caf\xe9") is not None


def null_callbacks(folder: str) -> Any:
    return instantiate(folder, callbacks=None, logging=0) is not None


def null_logger(folder: str) -> Any:
    callbacks = fmi2CallbackFunctions()
    component = instantiate(folder, callbacks=c.byref(callbacks))
    return library(folder).fmi2DoStep(c.c_void_p(component), c.c_double(0.0), c.c_double(STEP), 1)


def null_logger_without_logging(folder: str) -> Any:
    callbacks = fmi2CallbackFunctions()
    component = instantiate(folder, callbacks=c.byref(callbacks), logging=0)
    return library(folder).fmi2DoStep(c.c_void_p(component), c.c_double(0.0), c.c_double(STEP), 1)


def callbacks_gone(folder: str) -> Any:
    """The standard lets the callbacks' struct live as long as the instance: a host that drops it."""
    callbacks = fmi2CallbackFunctions()
    callbacks.logger = fmi2CallbackLoggerTYPE(raw._note)
    component = instantiate(folder, callbacks=c.byref(callbacks))
    c.memset(c.byref(callbacks), 0, c.sizeof(callbacks))
    return library(folder).fmi2DoStep(c.c_void_p(component), c.c_double(0.0), c.c_double(STEP), 1)


def null_component(folder: str) -> Any:
    one = Raw(folder)
    one.component = c.c_void_p()
    return one.get("Real", [0])


def free_null_component(folder: str) -> Any:
    one = Raw(folder)
    one.lib.fmi2FreeInstance(None)
    return "nothing"


def free_twice(folder: str) -> Any:
    one = started(folder)
    one.free()
    one.free()
    return "nothing"


def use_after_free(folder: str) -> Any:
    one = started(folder)
    one.free()
    return one.step(0.0, STEP)


def null_pointers_with_a_count(folder: str) -> Any:
    return started(folder).call("GetReal", None, c.c_size_t(1), None)


def set_null_state(folder: str) -> Any:
    one = started(folder)
    status = one.take(c.c_void_p())
    return status, one.step(0.0, STEP)


def free_null_state(folder: str) -> Any:
    return started(folder).drop(c.c_void_p())


def freed_state_is_null(folder: str) -> Any:
    one = started(folder)
    state = one.state()
    one.drop(state)
    return state.value is None


def free_state_twice(folder: str) -> Any:
    one = started(folder)
    state = one.state()
    copy = c.c_void_p(state.value)
    status = one.drop(state), one.drop(copy)
    march(one, 0, 2)
    return status


def set_freed_state(folder: str) -> Any:
    one = started(folder)
    state = one.state()
    copy = c.c_void_p(state.value)
    one.drop(state)
    return one.take(copy), one.failed


def take_into_a_state(folder: str) -> Any:
    """fmi2GetFMUstate with a state at hand: the standard wants it overwritten or freed; whether the pointer stays the same."""
    one = started(folder)
    state = one.state()
    before = state.value
    one.call("GetFMUstate", c.byref(state))
    return state.value == before


def serialise_into_too_little(folder: str) -> Any:
    one = started(folder)
    buffer = (c.c_char * 10)()
    return one.call("SerializeFMUstate", one.state(), buffer, c.c_size_t(10)), buffer.raw == b"aeroslosh "


def serialise_into_too_much(folder: str) -> Any:
    one = started(folder)
    size = 4_000_000
    buffer = (c.c_char * size)()
    return one.call("SerializeFMUstate", one.state(), buffer, c.c_size_t(size))


def null_category(folder: str) -> Any:
    return started(folder).call("SetDebugLogging", 1, c.c_size_t(1), (c.c_char_p * 1)(None))


def ordinary_exit(folder: str) -> Any:
    march(started(folder), 0, 2)
    print("done", flush=True)
    sys.exit(0)


if __name__ == "__main__":
    print(globals()[sys.argv[1]](sys.argv[2]), flush=True)
    os._exit(0)
