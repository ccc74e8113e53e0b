"""`aeroslosh doctor`: is everything here that the FMUs need, in this program and in others?"""

from __future__ import annotations

import argparse
import json
import sys
from pathlib import Path
from typing import Any

from ..base import files
from ..base.errors import AeroSloshError, ExitCode
from ..fmi import installed
from ..hosts import doctor, finding, hosting, selftest
from ..hosts.finding import Finding
from . import HELP


def register(commands: Any) -> None:
    """The command line."""
    sub = commands.add_parser(
        "doctor",
        help=HELP["doctor"],
        description="Checks Python, libpython, packages, platform and folders, and each FMU in a process of its own: load, a few "
        "steps, a second instance, its state. Prints the environment for programs that are not Python.",
        epilog="exit codes: 0 nothing worse than warnings, 2 something is missing or wrong here, 3 an FMU failed its self-test",
    )
    sub.add_argument("--fmus", type=Path, metavar="PATH", default=installed.folder(), help="a folder of FMUs, or one FMU")
    sub.add_argument("--no-self-test", action="store_true", help="do not run the FMUs")
    sub.add_argument("--script", type=Path, metavar="FILE", help="only write a shell script that starts other programs")
    sub.add_argument("--json", action="store_true", help="JSON on standard output, nothing else")
    sub.set_defaults(execute=execute)


def execute(options: argparse.Namespace) -> int:
    """All findings, as they come."""
    if options.script is not None:
        return _write_script(options)
    installed.ensure(options.fmus)
    fmus = [options.fmus] if options.fmus.is_file() else sorted(options.fmus.glob("*.fmu"))
    found: list[Finding] = []

    def add(more: list[Finding]) -> None:
        found.extend(more)
        if not options.json and more:
            print(finding.table(more), flush=True)

    for look in (doctor.python, doctor.libpython, doctor.system, doctor.folders, doctor.compile_cache):
        add(look())
    add(doctor.packages(fmus, told=not options.no_self_test))
    if not fmus:
        remedy = "build them with `make fmus`, or give --fmus PATH"
        add([finding.problem("FMUs", f"there are no FMUs in {options.fmus}", remedy)])
    tested: list[Finding] = []
    for fmu in [] if options.no_self_test else fmus:
        rows = selftest.findings(fmu)
        tested += rows
        add(rows)
    code = ExitCode.COMPONENT if finding.worst(tested) == "problem" else ExitCode.OK
    if code == ExitCode.OK and finding.worst(found) == "problem":
        code = ExitCode.INPUT
    if options.json:
        lines = [row.values["line"] for row in found if row.values.get("line")]
        result = {"level": finding.worst(found), "environment_line": lines[0] if lines else None}
        print(json.dumps(result | {"findings": [row.data() for row in found]}))
    else:
        counts = {level: sum(row.level == level for row in found) for level in finding.LEVELS}
        print(", ".join(f"{count} {level}{'' if count == 1 else 's'}" for level, count in counts.items() if level != "ok"))
    return code


def _write_script(options: argparse.Namespace) -> int:
    """The launcher as a shell script."""
    library = hosting.libpython()
    if library is None:
        raise AeroSloshError(f"The Python {sys.executable} has no shared libpython", "libpython", hosting.missing_libpython())
    if reason := hosting.unloadable(library):
        raise AeroSloshError(reason, str(library), hosting.MOVE)
    try:
        files.write(options.script, hosting.script(library).encode())
        options.script.chmod(0o755)
    except OSError as error:
        raise AeroSloshError(
            f"The script cannot be written: {error.strerror}", str(options.script), "name a file in a folder that can be written"
        ) from None
    print(json.dumps({"file": str(options.script)}) if options.json else options.script)
    return ExitCode.OK
