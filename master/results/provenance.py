"""What is needed to repeat a number: versions, hashes, command, machine."""

from __future__ import annotations

import datetime
import functools
import hashlib
import platform
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

PACKAGES = ("aeroslosh", "numpy", "scipy", "numba", "fmpy", "pythonfmu")


def provenance(fmus: dict[str, str]) -> dict[str, Any]:
    """What is needed to repeat a number. `fmus`: component name → SHA-256."""
    versions = {}
    for package in PACKAGES:
        try:
            versions[package] = metadata.version(package)
        except metadata.PackageNotFoundError:
            versions[package] = "unknown"
    return {
        "versions": versions | {"python": platform.python_version()},
        "master_sha256": source_hash(),
        "fmu_sha256": fmus,
        "command": " ".join(sys.argv),
        "date": datetime.datetime.now(datetime.UTC).isoformat(timespec="seconds"),
        "host": platform.node(),
        "cpu": _cpu(),
    }


@functools.cache
def source_hash() -> str:
    """SHA-256 over the master's own source files: between two releases the version alone does not tell what ran."""
    digest = hashlib.sha256()
    root = Path(__file__).resolve().parents[1]
    for path in sorted(root.rglob("*.py")):
        digest.update(path.relative_to(root).as_posix().encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()


def _cpu() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        return next(line.split(":", 1)[1].strip() for line in lines if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or platform.machine()
