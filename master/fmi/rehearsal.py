"""Compile what an FMU of this project needs, in several processes, before it is needed:
`python -m aeroslosh.master.fmi.rehearsal JSON CORES`, JSON being a list of [folder of an unzipped FMU, parameters].

A rehearsal runs the FMU's face through its start and one step with kernels that compute nothing: which are called with what types
is known then, within a second. Kernels that a start and a first step do not call are met where the face has a method `rehearse`
that calls them. What is not in the cache is compiled by as many processes as there are cores, what takes longest first, and lies
in the cache for whoever runs the FMU. What a rehearsal does not meet is compiled when it is called, as ever.

Prints a line "KERNELS SECONDS": how many are missing and how long that will take, about; then compiles."""

from __future__ import annotations

import contextlib
import gc
import importlib
import json
import os
import select
import signal
import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher
from numba.core.types import Omitted

PER_OPERATION = 1.2e-3  # seconds of compilation an operation of Python's takes on a desktop; and at least:
LEAST = 0.2


@dataclass(eq=False)
class Kernel:
    """A kernel that the face calls, with a set of argument types."""

    dispatcher: Any
    types: tuple[Any, ...]

    @property
    def seconds(self) -> float:
        """What its compilation takes, about, with those of its callees."""
        return sum(max(LEAST, PER_OPERATION * _operations(one.py_func)) for one in _reach(self.dispatcher, {}).values())

    def cached(self) -> bool:
        """Whether the cache has it."""
        cache = self.dispatcher._cache
        key = cache._index_key(self.types, self.dispatcher.targetctx.codegen())
        return key in cache._cache_file._load_index()


class Rehearsal:
    """Kernels in the order in which they were first called."""

    def __init__(self) -> None:
        self.kernels: dict[tuple[int, tuple[Any, ...]], Kernel] = {}
        self._inside = False  # one is run as Python: what it calls is none that the face calls

    def called(self, dispatcher: Any, arguments: tuple[Any, ...]) -> Any:
        """Note a call. Returns what the kernel may have returned; where nothing can stand for that it is run as Python."""
        function, inside = dispatcher.py_func, self._inside
        if not inside:
            defaults = function.__defaults__ or ()
            left = defaults[len(defaults) + len(arguments) - function.__code__.co_argcount :]
            types = (*map(dispatcher.typeof_pyval, arguments), *map(Omitted, left))
            self.kernels.setdefault((id(dispatcher), types), Kernel(dispatcher, types))
        returned = _nothing(str(function.__annotations__.get("return", "None")))
        if not inside and returned is not NotImplemented:
            return returned
        self._inside = True
        try:
            return function(*arguments)
        finally:
            self._inside = inside


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
        place[name] = _Stub(dispatcher, found)
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
            if hasattr(slave, "rehearse"):
                slave.rehearse()
    finally:
        for place, name, dispatcher in stubs:
            place[name] = dispatcher
    return list(found.kernels.values())


def compile_all(kernels: list[Kernel], cores: int) -> None:
    """Compile them into the cache by `cores` processes."""
    gc.freeze()
    todo, at_work = list(range(len(kernels))), dict[int, _Worker]()
    workers = [_Worker(kernels) for _ in range(min(cores, len(kernels)))]
    for worker in workers:
        worker.give(todo.pop(0))
        at_work[worker.answers] = worker
    while at_work:
        for heard in select.select(list(at_work), [], [])[0]:
            if os.read(heard, 1) and todo:
                at_work[heard].give(todo.pop(0))
            else:
                del at_work[heard]
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


def _reach(dispatcher: Any, found: dict[int, Any]) -> dict[int, Any]:
    """A kernel, its callees, theirs and so on, by identity."""
    if id(dispatcher) not in found:
        found[id(dispatcher)] = dispatcher
        values = dispatcher.py_func.__globals__
        for name in set(_called_names(dispatcher.py_func)):
            if isinstance(values.get(name), Dispatcher):
                _reach(values[name], found)
    return found


def _operations(function: Callable[..., Any]) -> int:
    """Operations of Python's in a function."""
    return len(function.__code__.co_code) // 2


def _called_names(function: Callable[..., Any]) -> list[str]:
    """Names of globals, as often as they are read."""
    import dis

    return [i.argval for i in dis.get_instructions(function) if i.opname == "LOAD_GLOBAL"]


def _nothing(annotation: str) -> Any:
    """A value of a return annotation: zero, or a tuple of them."""
    name, _, inner = annotation.partition("[")
    if name == "tuple":
        return tuple(_nothing(part.strip()) for part in inner.rstrip("]").split(","))
    return {"float": 0.0, "int": 0, "bool": False, "None": None}.get(name, NotImplemented)


def main() -> None:
    """Rehearse, say what is missing, compile it."""
    warnings.simplefilter("ignore")
    asked, cores = json.loads(sys.argv[1]), int(sys.argv[2])
    kernels = [kernel for folder, parameters in asked for kernel in rehearse(Path(folder), parameters)]
    missing = sorted((kernel for kernel in kernels if not kernel.cached()), key=lambda kernel: -kernel.seconds)
    times = [kernel.seconds for kernel in missing]
    print(len(missing), round(max([sum(times) / cores, *times, 0.0])), flush=True)
    if missing:
        compile_all(missing, cores)
    os._exit(0)


if __name__ == "__main__":
    main()
