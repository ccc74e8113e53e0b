"""Compile the FMUs' shared library: `python -m fmus.kit.native.compile`, after every change of fmi2.c.

The library is kept with its source, so that a build of FMUs needs no compiler; `linux64/built.json` holds the hashes of both.
zig (the wheel `ziglang`, among the development packages) compiles C for an old glibc on any machine, the same bytes each time.
Only Linux on x86-64 is compiled, for only that was run.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import json
import subprocess
import sys
import tempfile
from pathlib import Path

from . import HERE, LIBRARY, RECORD, SOURCE

TARGET = "x86_64-linux-gnu.2.17"
OPTIONS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-fPIC", "-shared", "-fvisibility=hidden", "-Wl,-z,nodelete", "-s")
LIBRARIES = ("-ldl", "-lpthread")


def sha256(path: Path) -> str:
    """Of the file's content, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def compile_to(target: Path) -> None:
    """Write the library to `target`. Raises CalledProcessError where the compiler does not take the source."""
    command = [sys.executable, "-m", "ziglang", "cc", "-target", TARGET, *OPTIONS, "-o", str(target), SOURCE.name, *LIBRARIES]
    subprocess.run(command, cwd=HERE, check=True)  # the source by its bare name: no path of this machine goes into the library


def main() -> int:
    """Compile, and write the record; returns the exit code."""
    LIBRARY.parent.mkdir(exist_ok=True)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / LIBRARY.name
        compile_to(made)
        LIBRARY.write_bytes(made.read_bytes())
    compiler = f"ziglang {importlib.metadata.version('ziglang')}"
    record = {"source": sha256(SOURCE), "library": sha256(LIBRARY), "compiler": compiler, "target": TARGET, "options": OPTIONS}
    RECORD.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    print(LIBRARY)
    return 0


if __name__ == "__main__":
    sys.exit(main())
