"""The command `aeroslosh` (its commands are the modules of `master.commands`)."""

from __future__ import annotations

import argparse
import os
import sys
import traceback
from collections.abc import Sequence

from master.commands import COMMANDS
from master.commands.common import show
from master.errors import AeroSloshError, ExitCode


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and end the process with the exit code of `errors.ExitCode`.

    `os._exit`: pythonfmu's wrapper releases its interpreter state twice at a normal exit, which can abort."""
    code: int = ExitCode.OK
    try:
        code = run(arguments)
    except SystemExit as stop:  # argparse: 0 after --help, 2 after a bad command line
        code = stop.code if isinstance(stop.code, int) else ExitCode.INPUT
    except AeroSloshError as error:
        show(error)
        code = error.code
    except KeyboardInterrupt:
        print("\naeroslosh: interrupted; the unfinished run folder was removed", file=sys.stderr)
        code = ExitCode.INTERRUPTED
    except BrokenPipeError:  # the reader of our output went away
        code = ExitCode.INPUT
        sys.stdout = open(os.devnull, "w")  # noqa: SIM115
    except Exception:  # a fault of ours: say so, with everything needed to report it
        traceback.print_exc()
        print("aeroslosh: internal error (above); please report it with the case file", file=sys.stderr)
        code = ExitCode.INTERNAL
    for stream in (sys.stdout, sys.stderr):
        try:
            stream.flush()
        except OSError:
            code = code or ExitCode.INPUT
    os._exit(int(code))


def run(arguments: Sequence[str] | None = None) -> int:
    """Parse, run, report; returns the exit code."""
    options = parser().parse_args(arguments)
    return options.execute(options)


def parser() -> argparse.ArgumentParser:
    """The command line."""
    top = argparse.ArgumentParser(
        prog="aeroslosh",
        description="Aeroelastic flutter by co-simulation of FMUs.",
        epilog="exit codes: 0 ok, 1 compare: different, 2 bad input, 3 a component failed, 4 no verdict or tolerance not met, "
        "5 sweep incomplete, 70 internal error, 130 interrupted",
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for command in COMMANDS:
        command.register(commands)
    return top


if __name__ == "__main__":
    main()
