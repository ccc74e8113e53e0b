"""Compile the FMUs' shared library: `python -m aeroslosh.fmus.kit.native.compile`, after every change of a .c file here.

What is compiled is kept with its source, so that a build of FMUs needs no compiler; `linux64/built.json` holds the hashes.
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

from . import HERE, LIBRARY, RECORD, SOURCE, TRIED, TRY

TARGET = "x86_64-linux-gnu.2.17"
OPTIONS = ("-std=c11", "-O2", "-Wall", "-Wextra", "-s")
SHARED = ("-fPIC", "-shared", "-fvisibility=hidden", "-Wl,-z,nodelete")
LIBRARIES = ("-ldl", "-lpthread")
MADE = {LIBRARY: (SOURCE, SHARED), TRY: (TRIED, ())}
"""Result: its source, and options of its own."""


def sha256(path: Path) -> str:
    """Of the file's content, in hexadecimal."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def compile_to(target: Path, made: Path = LIBRARY) -> None:
    """Write what `made` holds to `target`. Raises CalledProcessError where the compiler does not take the source."""
    source, more = MADE[made]
    # the source by its bare name: no path of this machine goes into the result
    words = ["-target", TARGET, *OPTIONS, *more, "-o", str(target), source.name, *LIBRARIES]
    subprocess.run([sys.executable, "-m", "ziglang", "cc", *words], cwd=HERE, check=True)


def main() -> int:
    """Compile, and write the record; returns the exit code."""
    record: dict[str, object] = {"compiler": f"ziglang {importlib.metadata.version('ziglang')}", "target": TARGET}
    for made, (source, more) in MADE.items():
        made.parent.mkdir(exist_ok=True)
        with tempfile.TemporaryDirectory() as folder:
            compile_to(Path(folder) / "made", made)
            made.write_bytes((Path(folder) / "made").read_bytes())
        record[made.name] = {"source": sha256(source), "result": sha256(made), "options": [*OPTIONS, *more]}
        print(made)
    RECORD.write_text(json.dumps(record, indent=2) + "\n", encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
