"""Compile what an FMU of this project needs, in several processes, before it is needed:
`python -m aeroslosh.master.fmi.rehearsal FOLDER PARAMETERS CORES`.

A rehearsal runs the FMU's face through its start and one step with kernels that compute nothing: which are called with what types
is known then, within a second. A kernel that calls others is run as Python until those are known. What is not in the
cache is compiled by as many processes as there are cores, callees before callers, and lies in the cache for whoever runs the FMU.
What a rehearsal does not meet is compiled when it is called, as ever.

Prints a line "KERNELS SECONDS": how many are missing and how long that will take, about; then compiles."""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import math
import os
import select
import signal
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

CALLS = 40  # calls by which a kernel run as Python is known well enough
DEEPEST = 12
PER_OPERATION = 1e-3  # seconds of compilation an operation of Python's, all inlined, takes on a desktop; and at least:
LEAST = 0.1


class _Known(Exception):
    """A kernel run as Python has called others often enough."""


@dataclass(eq=False)
class Kernel:
    """A kernel for one set of argument types; `calls` are those that it was seen to call."""

    dispatcher: Any
    types: tuple[Any, ...]
    calls: set[Kernel] = field(default_factory=set)

    @property
    def seconds(self) -> float:
        """What its compilation takes, about."""
        return max(LEAST, PER_OPERATION * _operations(self.dispatcher.py_func))

    def cached(self) -> bool:
        """Whether the cache has it."""
        cache = self.dispatcher._cache
        key = cache._index_key(self.types, self.dispatcher.targetctx.codegen())
        return key in cache._cache_file._load_index()


class Rehearsal:
    """Kernels in the order in which they were first called."""

    def __init__(self) -> None:
        self.kernels: dict[tuple[int, tuple[Any, ...]], Kernel] = {}
        self._inside: list[Kernel] = []
        self._left: list[float] = []  # calls that each kernel run as Python has left
        self._whole = 0  # kernels at work that are run as Python to their end: nothing stands for what they return

    def called(self, dispatcher: Any, arguments: tuple[Any, ...]) -> Any:
        """Note a call. Returns what the kernel may have returned. Raises _Known."""
        types = tuple(dispatcher.typeof_pyval(value) for value in arguments)
        kernel = self.kernels.setdefault((id(dispatcher), types), Kernel(dispatcher, types))
        if self._inside:
            self._inside[-1].calls.add(kernel)
            self._left[-1] -= 1
            if self._left[-1] < 0:
                raise _Known
        function = dispatcher.py_func
        returned = _nothing(str(function.__annotations__.get("return", "None")))
        whole = bool(self._whole) or returned is NotImplemented
        if whole or (_calls_kernels(function) and kernel not in self._inside and len(self._inside) < DEEPEST):
            self._whole += whole
            self._inside.append(kernel)
            self._left.append(math.inf if whole else CALLS)
            try:
                return function(*arguments)
            except Exception:  # its callees returned nothing that makes sense
                pass
            finally:
                self._whole -= whole
                self._inside.pop()
                self._left.pop()
        return returned


class _Stub:
    """Stands for a kernel in the modules while the face is run."""

    def __init__(self, dispatcher: Any, rehearsal: Rehearsal) -> None:
        self._dispatcher, self._rehearsal = dispatcher, rehearsal

    def __call__(self, *arguments: Any) -> Any:
        return self._rehearsal.called(self._dispatcher, arguments)


def rehearse(folder: Path, parameters: dict[str, Any]) -> list[Kernel]:
    """The kernels that the FMU unzipped to `folder` calls, started with `parameters`, and in a step of its default size."""
    resources = folder / "resources"
    sys.path.insert(0, str(resources))
    script = importlib.import_module((resources / "slavemodule.txt").read_text(encoding="utf-8").strip())
    found, stubs = Rehearsal(), list[tuple[dict[str, Any], str, Any]]()
    for module in list(sys.modules.values()):
        file = getattr(module, "__file__", None)
        if file and Path(file).is_relative_to(resources):
            stubs += [(vars(module), name, value) for name, value in vars(module).items() if isinstance(value, Dispatcher)]
    for place, name, dispatcher in stubs:
        place[name] = dispatcher if _inlined(dispatcher) else _Stub(dispatcher, found)
    try:
        with contextlib.suppress(Exception), np.errstate(all="ignore"):
            slave = script.SLAVE(instance_name="rehearsal", resources=str(resources))
            small = {v.name: v.min for v in slave.variables if v.name.startswith("cells_") and v.min is not None}
            for name, value in (parameters | small).items():
                setattr(slave, name, value)
            slave.setup_experiment(0.0)
            slave.enter_initialization_mode()
            slave.exit_initialization_mode()
            slave.do_step(0.0, type(slave).step_size)
    finally:
        for place, name, dispatcher in stubs:
            place[name] = dispatcher
    return list(found.kernels.values())


def compile_all(kernels: list[Kernel], cores: int) -> None:
    """Compile them into the cache by `cores` processes, callees before callers, what takes long first."""
    todo, done, at_work = list(kernels), set[Kernel](), dict[int, Kernel]()
    gc.freeze()
    workers = [_Worker(kernels) for _ in range(min(cores, len(kernels)))]
    idle = list(workers)
    while todo or at_work:
        ready = [k for k in todo if not ((k.calls & set(kernels)) - done)] or ([] if at_work else todo[:1])
        ready.sort(key=lambda k: -_path(k, kernels))
        for kernel in ready[: len(idle)]:
            worker = idle.pop()
            todo.remove(kernel)
            worker.give(kernels.index(kernel))
            at_work[worker.answers] = kernel
        heard, _, _ = select.select(list(at_work), [], [])
        for worker in workers:
            if worker.answers in heard:
                done.add(at_work.pop(worker.answers))
                if os.read(worker.answers, 1):
                    idle.append(worker)
                elif not idle and not at_work:  # all have died
                    return
    for worker in workers:
        worker.end()


class _Worker:
    """A process, forked from this one, that compiles what it is given by its number in `kernels`."""

    def __init__(self, kernels: list[Kernel]) -> None:
        theirs, self._orders = os.pipe()
        self.answers, back = os.pipe()
        self.pid = os.fork()
        if self.pid:
            os.close(theirs)
            os.close(back)
            return
        try:
            os.close(self._orders)
            os.close(self.answers)
            gc.disable()  # numba's objects are many and none of them is garbage
            while order := os.read(theirs, 2):
                kernel = kernels[int.from_bytes(order, "little")]
                with contextlib.suppress(Exception):  # whoever needs it will hear
                    kernel.dispatcher.compile(kernel.types)
                os.write(back, b".")
        finally:
            os._exit(0)

    def end(self) -> None:
        """Have it end, wherever it is: a later worker holds the other end of its orders too."""
        os.kill(self.pid, signal.SIGKILL)
        os.waitpid(self.pid, 0)

    def give(self, number: int) -> None:
        """Have it compile a kernel."""
        os.write(self._orders, number.to_bytes(2, "little"))


def _path(kernel: Kernel, kernels: list[Kernel]) -> float:
    """Seconds from its start until everything that waits for it can be done."""
    callers = [k for k in kernels if kernel in k.calls and k is not kernel]
    return kernel.seconds + max((_path(k, kernels) for k in callers), default=0.0)


def _operations(function: Callable[..., Any]) -> int:
    """Operations of Python's in a function with those that are inlined into it."""
    code, values = function.__code__, getattr(function, "__globals__", {})
    total = len(code.co_code) // 2
    for name in _called_names(function):
        if isinstance(values.get(name), Dispatcher) and _inlined(values[name]):
            total += _operations(values[name].py_func)
    return total


def _called_names(function: Callable[..., Any]) -> list[str]:
    """Names of globals, as often as they are read."""
    import dis

    return [i.argval for i in dis.get_instructions(function) if i.opname == "LOAD_GLOBAL"]


def _calls_kernels(function: Callable[..., Any]) -> bool:
    values = function.__globals__
    return any(isinstance(values.get(name), _Stub) for name in _called_names(function))


def _inlined(dispatcher: Any) -> bool:
    return dispatcher.targetoptions.get("inline") == "always"


def _nothing(annotation: str) -> Any:
    """A value of a return annotation: zero, or a tuple of them."""
    name, _, inner = annotation.partition("[")
    if name == "tuple":
        return tuple(_nothing(part.strip()) for part in inner.rstrip("]").split(","))
    return {"float": 0.0, "int": 0, "bool": False, "None": None}.get(name, NotImplemented)


def main() -> None:
    """Rehearse, say what is missing, compile it."""
    warnings.simplefilter("ignore")
    folder, parameters, cores = Path(sys.argv[1]), json.loads(sys.argv[2]), int(sys.argv[3])
    kernels = rehearse(folder, parameters)
    missing = [kernel for kernel in kernels if not kernel.cached()]
    whole = sum(kernel.seconds for kernel in missing)
    longest = max((_path(kernel, missing) for kernel in missing), default=0.0)
    print(len(missing), round(max(whole / cores, longest)), flush=True)
    if missing:
        compile_all(missing, cores)
    os._exit(0)


if __name__ == "__main__":
    main()
