"""Build FMUs: `python -m aeroslosh.fmus.build [--out dist/fmus] [component ...]`.

A component is a folder of `fmus/` with a `fmu.py` that holds one subclass of `Slave`. Its FMU holds

    modelDescription.xml
    binaries/linux64/<component>.so                   the library, native/fmi2.c
    resources/<component>_<hash>/                     the sources, laid out as in fmus/: kit/, <component>/ …
    resources/<component>_<hash>_slave.py             generated from SCRIPT, holds the one leaf class
    resources/slavemodule.txt, guid.txt               the name of that script, and the FMU's GUID, for the library
    resources/find_python.py                          what the library asks a Python to run
    resources/python.txt                              where it is installed (see `install`): a Python that has the packages
    resources/pythonfmu/                              pythonfmu itself, embedded
    resources/requirements.txt                        the packages this FMU imports
    documentation/                                    index.html, README, reference result, licences
    model.png                                         icon

The hash of the content in the names lets several FMUs, and two versions of one, live in one Python process.
The same sources build the same bytes. Every FMU is described, and checked after it is built, in a process of
its own.
"""

from __future__ import annotations

import argparse
import importlib.metadata
import inspect
import os
import re
import subprocess
import sys
import tempfile
import tomllib
import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pythonfmu

from ..kit import native, sources
from . import page

ROOT = Path(__file__).resolve().parents[1]  # fmus/
PYTHONFMU = Path(inspect.getfile(pythonfmu)).parent
EPOCH = (1980, 1, 1, 0, 0, 0)

# Imported once in a process for all instances and all copies of one version. An import that fails must say what to do.
SCRIPT = """\
import os, sys

_resources = os.path.dirname(os.path.abspath(__file__))
try:
    from {package}.{component}.fmu import {face} as _Face
except ImportError as _error:
    raise ImportError(
        f"this FMU cannot start in the Python of {{sys.prefix}}: {{_error}}. Remedy: set AEROSLOSH_PYTHON to the python3 that "
        "has its packages, or where the host itself is a Python program: python3 -m pip install -r "
        f"'{{_resources}}/requirements.txt'"
    ) from _error


class {component}(_Face):
    __doc__ = _Face.__doc__
    version = "{version}"
    content_hash = "{hash}"


SLAVE = {component}
"""

DESCRIBE = """
import sys
sys.path.insert(0, sys.argv[1])
from xml.etree.ElementTree import tostring
module = __import__(sys.argv[2])
slave = getattr(module, sys.argv[3])(instance_name=sys.argv[3], resources=sys.argv[1], visible=False)
sys.stdout.buffer.write(tostring(slave.to_xml(), encoding="UTF-8", xml_declaration=True))
"""

CHECK = """
import sys, tempfile
import fmpy
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu
problems = validate_fmu(sys.argv[1])
with tempfile.TemporaryDirectory(prefix="fmu_") as folder:
    fmpy.extract(sys.argv[1], folder)
    description = fmpy.read_model_description(folder)
    fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="check",
                    modelIdentifier=description.coSimulation.modelIdentifier)
    fmu.instantiate(loggingOn=True)
    for v in description.modelVariables:
        if v.type == "Real" and v.causality == "parameter":
            value = fmu.getReal([v.valueReference])[0]
            if value != float(v.start):
                problems.append(f"parameter {v.name} starts at {value}, not at {v.start}")
        if v.name == "error" and fmu.getString([v.valueReference])[0]:
            problems.append(fmu.getString([v.valueReference])[0].decode())
    fmu.freeInstance()
print(*problems, sep="\\n", flush=True)
sys.exit(1 if problems else 0)
"""


class BuildError(RuntimeError):
    """An FMU that could not be built or did not pass its check."""


def components(root: Path = ROOT) -> dict[str, Path]:
    """Return the folders below `root` that hold a face, by name."""
    return {path.parent.name: path.parent for path in sorted(root.glob("*/fmu.py"))}


def build(folder: Path, out: Path, *, check: bool = True, root: Path = ROOT) -> Path:
    """Build `<out>/<component>.fmu` of the component in `folder` and return its path.

    Raises:
        BuildError: the face cannot be imported or described, or the FMU does not pass its check.
    """
    component = folder.name
    files = sources.component_files(folder, root)
    digest = sources.content_hash(files)
    package = f"{component}_{digest}"
    script = f"{package}_slave"
    entries: dict[str, bytes] = {f"resources/{package}/{name}": path.read_bytes() for name, path in files.items()}
    entries[f"resources/{script}.py"] = script_text(folder, digest, root)
    entries["resources/slavemodule.txt"] = script.encode()
    entries["resources/requirements.txt"] = _requirements(files, component, root).encode()
    entries.update({f"resources/pythonfmu/{path.name}": path.read_bytes() for path in PYTHONFMU.glob("*.py")})
    entries[f"binaries/linux64/{component}.so"] = native.LIBRARY.read_bytes()
    entries["resources/find_python.py"] = native.ASKED.read_bytes()
    entries["modelDescription.xml"] = _describe(entries, script, component)
    description = ElementTree.fromstring(entries["modelDescription.xml"])
    entries["resources/guid.txt"] = description.attrib["guid"].encode()
    entries.update(_documentation(folder, root, description))

    out.mkdir(parents=True, exist_ok=True)
    target = out / f"{component}.fmu"
    handle, name = tempfile.mkstemp(prefix=f".{component}_", suffix=".fmu", dir=out)
    os.close(handle)
    temporary = Path(name)
    try:
        _write_zip(temporary, entries)
        if check:
            _check(temporary, component)
        temporary.chmod(0o644)
        os.replace(temporary, target)
    finally:
        temporary.unlink(missing_ok=True)
    return target


def install(fmu: Path, python: Path) -> None:
    """Write into `fmu` the path of the `python` that it takes on this machine, where the host is no Python program itself.

    It stands in resources/python.txt, goes with the file, and is passed over where there is no such path; what `build` writes has
    none, and the same bytes everywhere. Replaces the file whole or not at all.
    """
    handle, name = tempfile.mkstemp(prefix=f".{fmu.stem}_", suffix=".fmu", dir=fmu.parent)
    os.close(handle)
    try:
        with zipfile.ZipFile(fmu) as archive:
            entries = {info.filename: archive.read(info) for info in archive.infolist()}
        _write_zip(Path(name), entries | {"resources/python.txt": os.fsencode(python) + b"\n"})
        Path(name).chmod(0o644)
        os.replace(name, fmu)
    finally:
        Path(name).unlink(missing_ok=True)


def script_text(folder: Path, digest: str, root: Path = ROOT) -> bytes:
    """Return the script that pythonfmu runs, for the component in `folder` whose sources have the hash `digest`."""
    values = {"package": f"{folder.name}_{digest}", "component": folder.name, "hash": digest}
    return SCRIPT.format(**values, face=face_name(folder), version=_version(root)).encode()


def face_name(folder: Path) -> str:
    """Return the name of the one class in `fmu.py` that has `variables`."""
    text = (folder / "fmu.py").read_text(encoding="utf-8")
    names = re.findall(r"^class (\w+)\([^)]*Slave\b[^)]*\):", text, flags=re.MULTILINE)
    if len(names) != 1:
        raise BuildError(
            f"{folder / 'fmu.py'}: {len(names)} subclasses of Slave found ({', '.join(names)}). Remedy: "
            "write exactly one `class X(Slave):`"
        )
    return str(names[0])


def _describe(entries: dict[str, bytes], script: str, component: str) -> bytes:
    """Return modelDescription.xml, made from the staged files in a process of its own."""
    with tempfile.TemporaryDirectory(prefix="fmu_") as stage:
        for name, data in entries.items():
            if name.startswith("resources/"):
                path = Path(stage) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(data)
        return _python(
            DESCRIBE,
            f"{component}: the face cannot be described",
            str(Path(stage) / "resources"),
            script,
            component,
        )


def _check(fmu: Path, component: str) -> None:
    _python(CHECK, f"{component}: the FMU did not pass its check", str(fmu))


def _python(code: str, what: str, *arguments: str) -> bytes:
    """Run `code` in a fresh Python outside the source tree; raise BuildError with its output if it fails."""
    with tempfile.TemporaryDirectory(prefix="fmu_") as elsewhere:
        done = subprocess.run([sys.executable, "-c", code, *arguments], capture_output=True, cwd=elsewhere)
    if done.returncode != 0:
        said = (done.stdout + done.stderr).decode(errors="replace").strip()
        raise BuildError(f"{what} (exit code {done.returncode}):\n{said}")
    return done.stdout


def _write_zip(path: Path, entries: dict[str, bytes]) -> None:
    """Write a sorted, deflated zip with fixed dates and unix permissions."""
    with zipfile.ZipFile(path, "w") as archive:
        for name, data in sorted(entries.items()):
            info = zipfile.ZipInfo(name, EPOCH)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.create_system = 3  # unix, whatever this machine is
            info.external_attr = (0o100755 if name.startswith("binaries/") else 0o100644) << 16
            archive.writestr(info, data, compresslevel=9)


def _project(root: Path) -> dict[str, object]:
    """Version and dependencies: of the checkout, or of the installed package."""
    path = root.parent / "pyproject.toml"
    if path.is_file():
        return dict(tomllib.loads(path.read_text(encoding="utf-8"))["project"])
    try:
        own = importlib.metadata.distribution("aeroslosh")
    except importlib.metadata.PackageNotFoundError:
        return {}
    return {"version": own.version, "dependencies": [line for line in own.requires or [] if "extra ==" not in line]}


def _version(root: Path) -> str:
    return str(_project(root).get("version", "0"))


def _requirements(files: dict[str, Path], component: str, root: Path) -> str:
    """Return requirements.txt: what the files import beside the standard library, with the project's
    ranges.
    """
    declared = _project(root).get("dependencies", [])
    ranges = {re.split(r"[^\w-]", line)[0].lower(): line for line in declared} if isinstance(declared, list) else {}
    own = set(sys.stdlib_module_names) | {"pythonfmu", component}  # pythonfmu is embedded
    names = sorted(sources.imported_packages(files) - own)
    return "".join(f"{ranges.get(name.lower(), name)}\n" for name in names)


def _documentation(folder: Path, root: Path, description: ElementTree.Element) -> dict[str, bytes]:
    """Return index.html, the README it was made from, reference result, icon and licences."""
    found = {f"documentation/{path.name}": path for path in folder.glob("*.md")}
    found |= {f"documentation/{sources.REFERENCE}/{path.name}": path for path in (folder / sources.REFERENCE).glob("*.*")}
    if (icon := folder / sources.ICON).is_file():
        found["model.png"] = icon  # the name that FMI 2.0 gives it
    if (licence := _licence(root, "aeroslosh")) is not None:
        found["documentation/licenses/license.txt"] = licence
    entries = {name: path.read_bytes() for name, path in found.items()}
    if (licence := _licence(None, "pythonfmu")) is not None:
        entries["documentation/licenses/pythonfmu.txt"] = licence.read_bytes()
    text = page.index(
        entries.get("documentation/README.md", b"").decode(), description,
        icon="model.png" in entries, picture=f"documentation/{sources.REFERENCE}/picture.svg" in entries,
    )  # fmt: skip
    return {**entries, "documentation/index.html": text.encode()}


def _licence(root: Path | None, package: str) -> Path | None:
    """The text of a package's licence: beside a checkout's `root`, else of the installed package."""
    if root is not None and (root.parent / "LICENSE").is_file():
        return root.parent / "LICENSE"
    try:
        listed = importlib.metadata.files(package) or []
    except importlib.metadata.PackageNotFoundError:
        return None
    return next((Path(str(file.locate())) for file in listed if file.name == "LICENSE"), None)


def main(arguments: list[str] | None = None) -> int:
    """Build the FMUs named on the command line, all of them by default; return the exit code."""
    parser = argparse.ArgumentParser(prog="python -m aeroslosh.fmus.build", description="Build FMUs from fmus/<component>/.")
    parser.add_argument("component", nargs="*", help="names of folders in fmus/; default: all that have a fmu.py")
    parser.add_argument("--out", type=Path, default=Path("dist/fmus"), help="folder for the .fmu files")
    parser.add_argument("--portable", action="store_true", help="the same bytes on every machine: without this Python's path")
    options = parser.parse_args(arguments)
    known = components()
    failed = 0
    for name in options.component or known:
        if name not in known:
            print(f"No component '{name}'. Remedy: choose from {', '.join(known)}", file=sys.stderr)
            failed += 1
            continue
        try:
            made = build(known[name], options.out)
            if not options.portable:
                install(made, Path(os.path.abspath(sys.executable)))
            print(made, flush=True)
        except BuildError as error:
            print(error, file=sys.stderr)
            failed += 1
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
