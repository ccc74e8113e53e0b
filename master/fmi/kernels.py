"""Kernels of FMUs compiled before they are needed, once on a machine, by all its cores (module `rehearsal`).

An FMU compiles each of its kernels when it is first called, one after the other, and keeps them in the user's cache. Where this
FMU has not run before on this machine, a rehearsal finds out what it calls and fills the cache. A mark in the cache tells that
it has been tried; where anything goes wrong the FMU compiles for itself, as it would in any other tool."""

from __future__ import annotations

import contextlib
import hashlib
import json
import os
import platform
import signal
import subprocess
import sys
from collections.abc import Iterable, Mapping, Sequence
from importlib import metadata
from pathlib import Path
from typing import Any

from ..base import interrupts, notices
from ..base.cores import usable_cores
from ..base.paths import PLACE
from . import unpack

PROCESSES = 8  # at most: no kernel takes less than an eighth of all


def prepare(folder: Path, digest: str, given: Mapping[str, Any]) -> None:
    """See that the kernels of the FMU unzipped to `folder` are compiled, started with the parameters `given`; `digest`: its hash.

    Says how long it takes (`notices`) where there is something to compile."""
    _prepare([(folder, digest, given)])


def prepare_all(fmus: Iterable[Path]) -> None:
    """The same for several at once, with their start values. Raises AeroSloshError for a file that is no FMU."""
    _prepare([(*unpack.unzip(path), {}) for path in dict.fromkeys(fmus)])


def _prepare(fmus: Sequence[tuple[Path, str, Mapping[str, Any]]]) -> None:
    if os.environ.get("NUMBA_DISABLE_JIT", "0") != "0":
        return
    tried = [one for one in fmus if any((one[0] / "resources").glob("*/kit/cache.py")) and not _mark(one[1]).exists()]
    if not tried:
        return
    marks = [_mark(digest) for _, digest, _ in tried]
    try:
        marks[0].parent.mkdir(parents=True, exist_ok=True)
        _compile([(folder, given) for folder, _, given in tried])
        for mark in marks:
            mark.touch()
    except OSError:
        return  # a cache that cannot be written keeps no kernels either


def _compile(fmus: Sequence[tuple[Path, Mapping[str, Any]]]) -> None:
    asked = []
    for folder, given in fmus:  # without texts, which may name files to be written
        asked.append([str(folder), {name: value for name, value in given.items() if not isinstance(value, str)}])
    words = [sys.executable, "-m", "aeroslosh.master.fmi.rehearsal", json.dumps(asked, default=float)]
    path = os.pathsep.join([str(PLACE), *filter(None, [os.environ.get("PYTHONPATH")])])
    process = subprocess.Popen(
        [*words, str(min(usable_cores(), PROCESSES))],
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        env=os.environ | {"PYTHONPATH": path, "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"},
        start_new_session=True,  # Ctrl-C reaches this process alone, which ends all of them
        text=True,
    )
    assert process.stdout is not None
    try:
        with process.stdout as said:
            missing, seconds = map(int, said.readline().split() or ("0", "0"))
            if missing:
                notices.say(f"compiling kernels, once on this machine (about {max(1, seconds)} s)")
            process.wait()
        interrupts.check()
    except BaseException:
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
        raise


def _mark(digest: str) -> Path:
    """A file that is there where the FMU of this hash was compiled by this Python and numba for this processor."""
    base = os.environ.get("LOCALAPPDATA") if os.name == "nt" else os.environ.get("XDG_CACHE_HOME")
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
        processor = "".join(sorted({line for line in lines if line.startswith(("model name", "flags"))}))
    except OSError:
        processor = platform.processor()
    words = [digest, sys.version, metadata.version("numba"), metadata.version("llvmlite"), processor]
    words += [f"{name}={value}" for name, value in sorted(os.environ.items()) if name.startswith("NUMBA_")]
    name = hashlib.sha256("\n".join(words).encode()).hexdigest()[:16]
    return Path(base or Path.home() / ".cache") / "aeroslosh" / "compiled" / name
