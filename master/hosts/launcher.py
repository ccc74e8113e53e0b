"""`aeroslosh-launch HOST ARGUMENTS...`: start any program with what our FMUs need of a process that is not Python.

The program takes this process's place (exec), so its exit code and the signals it gets and dies of are its own. Imports
the standard library only: starting it costs what starting Python costs.
"""

from __future__ import annotations

import contextlib
import os
import shutil
import sys
from collections.abc import Sequence
from typing import NoReturn

from . import hosting

USE = """use: aeroslosh-launch HOST ARGUMENTS...

Starts HOST, any program that runs FMUs, with libpython in the process and this Python first on PATH: what FMUs written in
Python need of a host that is not Python itself. Python hosts (FMPy, libcosimpy) need nothing of it.

exit codes: HOST's own; 2 no HOST given or this Python has no libpython, 126 HOST cannot be run, 127 there is no HOST
"""


def main(arguments: Sequence[str] | None = None) -> NoReturn:
    """Replace this process by the program named in `arguments` (default: the command line's)."""
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words and words[0] in ("-h", "--help"):
        print(USE, end="")
        sys.exit(0)
    if words and words[0] == "--":
        del words[0]
    if not words:
        _stop("No program to start", "aeroslosh-launch HOST ARGUMENTS...", 2)
    if words[0].startswith("-"):
        _stop(f"There is no option {words[0]}", "aeroslosh-launch HOST ARGUMENTS...: the options are HOST's", 2)
    library = hosting.libpython()
    if library is None:
        _stop(f"The Python {sys.executable} has no shared libpython on disk", hosting.missing_libpython(), 2)
    if reason := hosting.unloadable(library):
        _stop(reason, hosting.MOVE, 2)
    program = shutil.which(words[0])
    if program is None:
        there = os.path.exists(words[0]) and not os.path.isdir(words[0])
        if there:
            _stop(f"{words[0]} is not executable", f"chmod +x {words[0]}", 126)
        _stop(f"There is no program {words[0]}", "give the path of an executable file, or put its folder on PATH", 127)
    try:
        os.execve(program, words, hosting.environment(library, _given()))
    except OSError as error:
        _stop(
            f"{program} cannot be run: {error.strerror}", "give a program for this machine; a script needs a first line #!", 126
        )


def _given() -> dict[str, str]:
    """The environment this process was started with: importing the package `master` has since set a thread count of its own."""
    result = dict(os.environ)
    with contextlib.suppress(OSError):
        with open("/proc/self/environ", "rb") as stream:
            names = {os.fsdecode(entry.partition(b"=")[0]) for entry in stream.read().split(b"\0")}
        result = {name: value for name, value in result.items() if name in names}
    return result


def _stop(what: str, remedy: str, code: int) -> NoReturn:
    print(f"aeroslosh-launch: {what}\n  remedy: {remedy}", file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
