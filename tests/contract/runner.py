"""Run the `case_*` functions of a module on one FMU: `python runner.py <module> <json: component -> unzip folder> <component>`.

Prints one line a case: `>name` before it, then its name and, in JSON, what went wrong ("" if nothing). A signal ends the process
there and is seen by who started it; a case that hangs ends it with a traceback of every thread.
"""

from __future__ import annotations

import contextlib
import faulthandler
import importlib
import inspect
import json
import sys
import traceback
import warnings

import cheap

LONGEST = 60.0  # seconds a case


def main(module_name: str, folders: dict[str, str], component: str) -> None:
    """Run all cases of a module; a case with two arguments is given all folders too."""
    faulthandler.enable()
    warnings.simplefilter("ignore")  # overflow in what is refused afterwards
    module = importlib.import_module(module_name)
    compile_kernels(folders[component])
    for name, case in vars(module).items():
        if not name.startswith("case_"):
            continue
        print(f">{name}", flush=True)
        faulthandler.dump_traceback_later(LONGEST, exit=True)
        problem = ""
        try:
            case(folders[component], *([folders] if len(inspect.signature(case).parameters) == 2 else []))
        except BaseException:
            problem = traceback.format_exc()
        faulthandler.cancel_dump_traceback_later()
        print(f"{name} {json.dumps(problem)}", flush=True)


def compile_kernels(folder: str) -> None:
    """Start and step once: on a new machine kernels are compiled, for as long as it takes; no case's time limit is of that."""
    with contextlib.suppress(Exception):  # what is wrong the cases say
        one = cheap.started(folder)
        cheap.march(one, 0, 1)
        one.free()


if __name__ == "__main__":
    main(sys.argv[1], json.loads(sys.argv[2]), sys.argv[3])
