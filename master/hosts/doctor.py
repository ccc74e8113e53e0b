"""What `aeroslosh doctor` looks at: this Python, libpython, packages, platform, folders, and each FMU (see `selftest`)."""

from __future__ import annotations

import importlib.metadata
import os
import platform
import re
import shutil
import sys
import tempfile
import zipfile
from collections.abc import Callable, Iterable
from pathlib import Path

from ..base.errors import AeroSloshError
from ..fmi import unpack
from . import hosting
from .finding import Finding, ok, problem, warning

GLIBC = (2, 17)  # what the FMUs' library is compiled for
LITTLE = 200e6  # bytes free on a disk below which a folder is worth a warning
REQUIREMENT = re.compile(r"[A-Za-z0-9][\w.-]*\s*(\[[^\]]*\])?\s*([<>=!~;].*)?")  # a name, and perhaps versions


def python() -> list[Finding]:
    """The interpreter that runs this, and whether a host would find the same one."""
    version, virtual = platform.python_version(), sys.prefix != sys.base_prefix
    text = f"{version}, {sys.executable}" + (f" (virtual environment {sys.prefix})" if virtual else " (no virtual environment)")
    found = [ok("python", text, version=version, executable=sys.executable, prefix=sys.prefix, virtual=virtual)]
    if home := os.environ.get("PYTHONHOME"):
        remedy = "unset PYTHONHOME (aeroslosh-launch does): it leads a host's interpreter past the virtual environment"
        found.append(warning("python", f"PYTHONHOME is set to {home}", remedy))
    first = hosting.bin_folder() / "python3"
    if os.name == "posix" and not first.exists():
        remedy = "make a virtual environment with this Python: a host takes the first python3 on PATH"
        found.append(warning("python", f"there is no python3 beside {sys.executable}", remedy))
    elif os.name == "posix" and first.resolve() != Path(sys.executable).resolve():
        remedy = "make a virtual environment with this Python: a host would take that python3 for it"
        found.append(warning("python", f"{first} is another Python than {sys.executable}", remedy))
    return found


def libpython() -> list[Finding]:
    """The shared library that a host which is no Python program takes into its process."""
    library = hosting.libpython()
    if library is None:
        text = "no shared library of this Python: hosts that are no Python programs cannot run the FMUs; Python hosts can"
        return [warning("libpython", text, hosting.missing_libpython(), library=None, line=None)]
    if reason := hosting.unloadable(library):
        return [warning("libpython", reason, hosting.MOVE, library=str(library), line=None)]
    line = hosting.line(library)
    return [
        ok("libpython", str(library), library=str(library)),
        ok("other hosts", f"need nothing; a host whose FMU finds no Python: aeroslosh-launch HOST ARGS, or: {line}", line=line),
    ]


def system() -> list[Finding]:
    """Whether the FMUs' binaries fit this machine."""
    name, machine, (libc, version) = platform.system(), platform.machine(), platform.libc_ver()
    cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    text = f"{name} {machine}, {libc or 'libc'} {version or '?'}, {cores} cores for this process"
    values = {"system": name, "machine": machine, "libc": f"{libc} {version}".strip(), "cores": cores}
    if name == "Linux" and machine == "x86_64":
        if libc == "glibc" and tuple(int(n) for n in re.findall(r"\d+", version)[:2]) >= GLIBC:
            return [ok("platform", text, **values)]
        remedy = f"use a distribution with glibc {GLIBC[0]}.{GLIBC[1]} or newer (any of the last ten years; not Alpine)"
        return [problem("platform", text, remedy, **values)]
    return [problem("platform", text, "the FMUs hold a library for linux64 alone: use Linux on x86-64", **values)]


def folders() -> list[Finding]:
    """Folders that must be writable."""
    found = []
    temporary = tempfile.gettempdir()
    places: list[tuple[str, Callable[[], Path]]] = [
        ("temporary", lambda: Path(temporary)),
        ("unzipped FMUs", unpack.cache_root),
        ("working", Path.cwd),
    ]
    for what, place in places:
        try:
            folder = place()
            tempfile.TemporaryFile(dir=folder).close()
        except (OSError, AeroSloshError) as error:
            said = error.what if isinstance(error, AeroSloshError) else f"{error.strerror}: {error.filename or ''}"
            remedy = {"temporary": "set TMPDIR", "unzipped FMUs": "set XDG_CACHE_HOME"}.get(what, "change to")
            level = warning if what == "working" else problem
            found.append(
                level("folders", f"the {what} folder cannot be written ({said})", f"{remedy} a folder that can be written")
            )
            continue
        free = shutil.disk_usage(folder).free
        text = f"{what}: {folder} (writable, {free / 1e9:.1f} GB free)"
        found.append(ok("folders", text) if free > LITTLE else warning("folders", text, "free space on that disk"))
    return found


def compile_cache_root() -> Path:
    """Where compiled kernels lie: `fmus.kit.cache.cache_root`, which is not imported since that needs a second and numba."""
    if os.name == "nt":
        return Path(os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")) / "aeroslosh"
    return Path(os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")) / "aeroslosh"


def compile_cache() -> list[Finding]:
    """The folder of compiled kernels: writable, its size."""
    root = compile_cache_root()
    files = [file for file in root.glob("*/*") if file.suffix in (".nbi", ".nbc")]
    size = sum(file.stat().st_size for file in files)
    entries = sum(file.suffix == ".nbc" for file in files)
    values = {"folder": str(root), "entries": entries, "bytes": size}
    try:
        root.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=root).close()
    except OSError as error:
        text = f"{root} cannot be written ({error.strerror}): the FMUs compile anew in each process, which takes a minute"
        return [warning("compiled", text, "make it writable, or set XDG_CACHE_HOME to a folder that is", **values)]
    return [ok("compiled", f"{root}: {entries} compiled functions, {size / 1e6:.1f} MB (may be removed at any time)", **values)]


def packages(fmus: Iterable[Path], told: bool = False) -> list[Finding]:
    """What each FMU asks for in resources/requirements.txt, against what is installed.

    `told`: a file that cannot be read is told elsewhere."""
    asked: dict[str, dict[str, list[str]]] = {}  # package → range → FMUs
    found = []
    for fmu in fmus:
        try:
            with zipfile.ZipFile(fmu) as archive:
                lines = archive.read("resources/requirements.txt").decode("utf-8", "replace").splitlines()
        except KeyError:
            continue  # an FMU of another make
        except (OSError, zipfile.BadZipFile) as error:
            if not told:
                found.append(problem(fmu.stem, f"{fmu} cannot be read: {error}", "build it again with `make fmus`"))
            continue
        for line in (line.partition("#")[0].strip() for line in lines):
            if not REQUIREMENT.fullmatch(line):
                continue  # an address, another file, an option: pip's business
            name = re.split(r"[^\w.-]", line, maxsplit=1)[0]
            asked.setdefault(name, {}).setdefault(line[len(name) :].strip(), []).append(fmu.stem)
    for name in sorted(asked):
        try:
            version = importlib.metadata.version(name)
        except importlib.metadata.PackageNotFoundError:
            everyone = ", ".join(sorted({fmu for fmus in asked[name].values() for fmu in fmus}))
            remedy = f"{sys.executable} -m pip install '{name}{next(iter(asked[name]))}'"
            found.append(problem("packages", f"{name} is missing; asked for by {everyone}", remedy, package=name, version=None))
            continue
        for wanted, who in asked[name].items():
            text = f"{name} {version} (asked for: {wanted or 'any'} by {', '.join(who)})"
            if allows(wanted, version):
                found.append(ok("packages", text, package=name, version=version))
            else:
                remedy = f"{sys.executable} -m pip install '{name}{wanted}'"
                found.append(problem("packages", text, remedy, package=name, version=version))
    return found


def allows(wanted: str, version: str) -> bool:
    """Tell whether a version lies in a range such as ">=2.0,<3"; a pre-release counts as its release."""
    have = _numbers(version)
    for clause in filter(None, (part.strip() for part in wanted.split(","))):
        match = re.fullmatch(r"(>=|<=|==|!=|~=|>|<)\s*([\w.*]+)", clause)
        if match is None:
            return True  # a marker or something else: pip's business
        sign, limit = match[1], _numbers(match[2])
        size = max(len(have), len(limit))
        a, b = have + [0] * (size - len(have)), limit + [0] * (size - len(limit))
        starts = have[: len(limit)] == limit
        same = starts if match[2].endswith("*") else a == b
        good = {
            ">=": a >= b,
            "<=": a <= b,
            ">": a > b,
            "<": a < b,
            "==": same,
            "!=": not same,
            "~=": a >= b and have[: len(limit) - 1] == limit[:-1],
        }
        if not good[sign]:
            return False
    return True


def _numbers(version: str) -> list[int]:
    numbers = []
    for part in version.partition("+")[0].split("."):
        match = re.match(r"\d+", part)
        if match is None:
            break
        numbers.append(int(match[0]))
        if match[0] != part:  # 1rc2
            break
    return numbers
