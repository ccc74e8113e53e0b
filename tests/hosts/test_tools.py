"""Each FMU alone in other people's tools: the same numbers as direct FMI calls, to the bit.

These tools set the inputs of the start of a step where our FMUs mean those of its end: `direct_start` does as they do.
"""

from __future__ import annotations

import importlib.util
import inspect
import os
import shutil
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import pythonfmu
from host_jobs import JOBS, job

ENUMERATIONS = {"limit"}  # libcosim 0.0.6 does not list them, ecospy 0.7.2 does not set them (and says nothing)
LIBRARIES = {"LD_LIBRARY_PATH": f"{sys.prefix}/lib"}  # where pip puts libtbb.so.12, which ecospy loads


def need(module: str) -> None:
    """Skip where a tool is not installed."""
    if importlib.util.find_spec(module) is None:
        pytest.skip(f"{module} is not installed: pip install 'aeroslosh[dev]'")


def plain(name: str, fmu: str) -> dict[str, Any]:
    """The job without enumerations."""
    whole = job(name, fmu)
    return whole | {"parameters": {key: value for key, value in whole["parameters"].items() if key not in ENUMERATIONS}}


@pytest.mark.parametrize("name", JOBS)
def test_fmpy(name: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]) -> None:
    """simulate_fmu with a table of inputs and start values."""
    work = job(name, str(fmu(name)))
    found = tool("fmpy", work)
    assert found == tool("direct_start", work)
    assert len({row[0] for row in found}) > 5, "the job moves nothing"


@pytest.mark.parametrize("name", JOBS)
def test_pythonfmus_own_binary(
    name: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]], tmp_path: Path
) -> None:
    """The same sources behind pythonfmu's library give the same numbers: ours changes none of them."""
    binary = Path(inspect.getfile(pythonfmu)).parent / "resources" / "binaries" / "linux64" / "libpythonfmu-export.so"
    pin = "import ctypes\nctypes.pythonapi.Py_IncRef(ctypes.py_object(globals()))\n"  # it drops a reference of them
    other = tmp_path / f"{name}.fmu"
    with zipfile.ZipFile(fmu(name)) as old, zipfile.ZipFile(other, "w") as new:
        for member in old.namelist():
            data = old.read(member)
            if member.endswith(".so"):
                data = binary.read_bytes()
            elif member.endswith("_slave.py"):
                data = (pin + data.decode().replace(f"SLAVE = {name}\n", "")).encode()
            new.writestr(member, data)
    assert tool("direct_end", job(name, str(other))) == tool("direct_end", job(name, str(fmu(name))))


@pytest.mark.parametrize("name", JOBS)
def test_libcosim(name: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]) -> None:
    """A fixed-step execution: initial values, an override of the inputs, an observer."""
    need("libcosimpy")
    work = plain(name, str(fmu(name)))
    assert tool("libcosim", work) == tool("direct_start", work)


@pytest.mark.parametrize("name", JOBS)
def test_ecos(name: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]) -> None:
    """A simulation structure with a parameter set, in this process."""
    need("ecospy")
    work = plain(name, str(fmu(name)))
    assert tool("ecos", work, **LIBRARIES) == tool("direct_start", work)


@pytest.fixture(scope="session")
def proxy(tmp_path_factory: pytest.TempPathFactory) -> str:
    """PATH on which ecospy finds its proxyfmu: pip installs it without the right to run it."""
    need("ecospy")
    found = importlib.util.find_spec("ecospy")
    assert found is not None and found.origin is not None
    folder = tmp_path_factory.mktemp("proxy")
    program = folder / "proxyfmu"
    shutil.copy(Path(found.origin).parent / "binaries" / "proxyfmu", program)
    program.chmod(0o755)
    return f"{folder}:{os.environ['PATH']}"


@pytest.mark.parametrize("name", JOBS)
def test_proxyfmu(name: str, proxy: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]) -> None:
    """An FMU in ecos' own process, which is no Python."""
    work = plain(name, str(fmu(name)))
    found = tool("ecos", work | {"prefix": "proxyfmu://localhost?file="}, PATH=proxy, **LIBRARIES)
    assert found == tool("direct_start", work)


def test_proxyfmu_with_the_launcher(
    proxy: str, launch: list[str], fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]
) -> None:
    """The way of before still works: the library takes the Python that is in the process."""
    work = plain("structure", str(fmu("structure")))
    found = tool("ecos", work | {"prefix": "proxyfmu://localhost?file="}, *launch, PATH=proxy, **LIBRARIES)
    assert found == tool("direct_start", work)


@pytest.mark.parametrize("which", ["fmpy", "libcosim", "ecos"])
def test_relative_path_with_spaces(
    which: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]], tmp_path: Path
) -> None:
    """From another working folder, in a folder with spaces, named from there."""
    need({"fmpy": "fmpy", "libcosim": "libcosimpy", "ecos": "ecospy"}[which])
    folder = tmp_path / "my models"
    (folder / "a wing").mkdir(parents=True)
    shutil.copy(fmu("structure"), folder / "a wing" / "the wing.fmu")
    expected = tool("direct_start", plain("structure", str(fmu("structure"))))
    assert tool(which, plain("structure", "a wing/the wing.fmu"), cwd=folder, **LIBRARIES) == expected


@pytest.mark.parametrize("which", ["direct_start", "fmpy", "libcosim", "ecos"])
@pytest.mark.parametrize("name", ["structure", "slosh_vof"])
def test_ordinary_end(name: str, which: str, fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]) -> None:
    """A tool's Python process that ends as Python processes do: exit code 0 (`tool` asserts it), the numbers are there."""
    need({"libcosim": "libcosimpy", "ecos": "ecospy"}.get(which, "fmpy"))
    work = plain(name, str(fmu(name)))
    assert tool(which, work | {"end": "ordinary"}, **LIBRARIES) == tool("direct_start", work)
