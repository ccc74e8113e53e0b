"""What only the library can guard, one probe after another: `python probes.py <unzip folder> <probe>...`.

Each prints what came of it; a signal would end the process in the middle. `test_probes.py` holds the answers that
fmus/kit/README.md tells of.
"""

from __future__ import annotations

import ctypes as c
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
    return {
        *(one.get(type_, [0])[0] for type_ in raw.TYPES), one.setup(), one.enter(), one.leave(), one.step(0.0, STEP), one.reset(),
        one.terminate(), one.call("GetFMUstate", c.byref(c.c_void_p())), one.take(c.c_void_p(1)), one.call("CancelStep"),
    }  # fmt: skip


def anything_as_component(folder: str) -> Any:
    """Addresses of something, of nothing, and what looks like an instance that was never made."""
    one, real = started(folder), started(folder).component.value or 0
    answers = set()
    for value in (1, 8, id(one), 2**47, 2**63, 2**63 + 1, 2**64 - 1, real + 1, real + 2**32, real ^ 2**40):
        one.component = c.c_void_p(value)
        answers |= {one.step(0.0, STEP), one.get("Real", [0])[0], one.drop(c.c_void_p(value))}
    return answers


def other_library(folder: str) -> Any:
    """An instance and a state of another copy of the library."""
    import shutil
    import tempfile

    with tempfile.TemporaryDirectory() as place:
        other = shutil.copytree(folder, Path(place) / "copy")
        one, two = started(folder), started(str(other))
        state = two.state()
        answers = one.take(state), one.drop(state)
        one.component = two.component
        return *answers, one.step(0.0, STEP), two.step(0.0, STEP)


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
    answers = set()
    for kind in raw.TYPES:
        for what in ("Get", "Set"):
            one, numbers = started(folder), (c.c_uint * 1)(0)
            answers |= {one.call(f"{what}{kind}", references, c.c_size_t(1), None) for references in (None, numbers)}
            one.assert_failed("null pointers")
    return answers


def more_values_than_variables(folder: str) -> Any:
    one, numbers, values = started(folder), (c.c_uint * 1)(0), (c.c_double * 1)()
    return {one.call("GetReal", numbers, c.c_size_t(n), values) for n in (1000, 2**31, 2**63, 2**64 - 1)}


def null_results(folder: str) -> Any:
    """Null where an answer or a state is to be written."""
    one = started(folder)
    state, n = one.state(), c.c_size_t(10)
    answers = [one.call("GetFMUstate", None), one.call("SerializedFMUstateSize", state, None)]
    answers += [one.call("SerializeFMUstate", state, None, n), one.call("DeSerializeFMUstate", None, n, c.byref(state))]
    answers += [one.call("DeSerializeFMUstate", b"x" * 10, n, None), one.call("GetRealStatus", 2, None)]
    answers += [one.call("GetBooleanStatus", 3, None)]
    return answers, one.failed


def step_within_a_message(folder: str) -> Any:
    """The host's logger calls the instance that is speaking: it is no longer in its call."""
    answers: list[Any] = []
    one = started(folder)
    note = raw._note

    def logger(*words: Any) -> None:
        note(*words)
        if not answers:
            answers.append(None)
            answers[0] = one["error"] != ""

    one.free()
    one.callbacks.logger = fmi2CallbackLoggerTYPE(logger)
    uri = (Path(folder) / "resources").as_uri().encode()
    one.component = c.c_void_p(
        one.lib.fmi2Instantiate(one.name, CO_SIMULATION, one.description.guid.encode(), uri, c.byref(one.callbacks), 0, 1)
    )
    return one.step(0.0, STEP), answers


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


def free_state_by_value(folder: str) -> Any:
    """What some hosts do: the state itself where its address is wanted."""
    one = started(folder)
    state = one.state()
    return one.call("FreeFMUstate", state), one.call("FreeFMUstate", state), one.take(state)


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


def exit_of_a_fork(folder: str) -> Any:
    """A child that does not exec goes on with the instance and ends as processes do."""
    import os
    import warnings

    warnings.simplefilter("ignore")  # of threads and fork: there is one thread
    one = started(folder)
    march(one, 0, 2)
    state = one.state()
    wanted = march(one, 2, 2)
    one.take(state)
    sys.stdout.flush()
    child = os.fork()
    if child == 0:
        sys.exit(7 if march(one, 2, 2) == wanted else 8)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), march(one, 2, 2) == wanted


def ordinary_exit(folder: str) -> Any:
    """Of the whole process: its exit code is looked at."""
    march(started(folder), 0, 2)
    return "done"


if __name__ == "__main__":
    for probe in sys.argv[2:]:
        print(f"{probe}: {globals()[probe](sys.argv[1])}", flush=True)
    sys.exit(0)
