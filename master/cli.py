"""The command `aeroslosh` (its commands are the modules of `commands`)."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
import traceback
from collections.abc import Sequence
from pathlib import Path

from .base import disk, interrupts, notices, streams
from .base.errors import AeroSloshError, ExitCode, show
from .commands import HELP


def main(arguments: Sequence[str] | None = None) -> None:
    """Run and end the process with the exit code of `errors.ExitCode`.

    `os._exit`: pythonfmu's wrapper releases its interpreter state twice at a normal exit, which can abort."""
    # before numpy is loaded: the matrices of a damping fit are tiny, threads would only burn CPU beside the march
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    streams.guard()
    interrupts.install()
    code = _told(arguments)
    try:
        sys.stdout.flush()
    except AeroSloshError as error:
        show(error)
        code = code or error.code
    sys.stderr.flush()
    os._exit(int(code))


def run(arguments: Sequence[str] | None = None) -> int:
    """Parse, run, report; returns the exit code."""
    words = sys.argv[1:] if arguments is None else list(arguments)
    options = parser(next((word for word in words if word in HELP), "")).parse_args(words)
    _check_names(options)
    quiet = getattr(options, "quiet", False) or getattr(options, "json", False)
    with notices.to(lambda text: None if quiet else print(text, file=sys.stderr, flush=True)):
        return options.execute(options)


def parser(command: str = "") -> argparse.ArgumentParser:
    """The command line with all words of `command`; of the other commands the names, which is quick: their modules are not
    loaded."""
    top = argparse.ArgumentParser(
        prog="aeroslosh",
        description="Aeroelastic flutter by co-simulation of FMUs.",
        epilog="exit codes: 0 ok, 1 compare: different, 2 bad input, 3 a component failed, 4 no verdict or tolerance not met, "
        "5 incomplete (full disk, cluster gone), 70 internal error, 130 interrupted, 143 terminated",
    )
    top.add_argument("--version", action=_Version, nargs=0, help="say the version")
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for name, text in HELP.items():
        if name == command:
            importlib.import_module(f".commands.{name}", __package__).register(commands)
        else:
            commands.add_parser(name, help=text)
    return top


class _Version(argparse.Action):
    """Says the version; the metadata are read only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> None:
        from importlib import metadata

        print(f"aeroslosh {metadata.version('aeroslosh')} (Python {sys.version.split()[0]})")
        parser.exit()


def _told(arguments: Sequence[str] | None) -> int:
    """The exit code of a command; whatever ends it is said."""
    try:
        return run(arguments)
    except SystemExit as stop:  # argparse: 0 after --help, 2 after a bad command line
        return stop.code if isinstance(stop.code, int) else ExitCode.INPUT
    except AeroSloshError as error:
        show(error)
        return error.code
    except KeyboardInterrupt as stop:
        said = "; ".join(["interrupted", *getattr(stop, "__notes__", [])])
        print(f"\naeroslosh: {said}", file=sys.stderr)
        return getattr(stop, "code", ExitCode.INTERRUPTED)
    except OSError as error:
        if disk.of_disk(error):
            show(failure := disk.explained(error, error.filename or "a file that was written"))
            return failure.code
        return _fault()
    except Exception:
        return _fault()


def _fault() -> int:
    """A fault of ours: say so, with everything needed to report it."""
    traceback.print_exc()
    print("aeroslosh: internal error (above); please report it with the case file", file=sys.stderr)
    return ExitCode.INTERNAL


def _check_names(options: argparse.Namespace) -> None:
    """Refuse words and folders that are no UTF-8: FMUs, result files and JSON hold UTF-8 alone. Raises AeroSloshError."""
    given = {name: value if isinstance(value, list) else [value] for name, value in vars(options).items()}
    words = [(f"--{name}", str(word)) for name, values in given.items() for word in values if isinstance(word, (str, Path))]
    try:
        words.append(("the working directory", str(Path.cwd())))
    except OSError as error:
        raise AeroSloshError(f"The working directory is gone: {error.strerror}", remedy="change to another") from None
    for where, word in words:
        try:
            word.encode()
        except UnicodeEncodeError:
            seen = os.fsencode(word).decode("utf-8", "backslashreplace")
            remedy = "rename it, or call it by a link whose name is"
            raise AeroSloshError(f"A name is no UTF-8 text: {seen}", where, remedy) from None


if __name__ == "__main__":
    main()
