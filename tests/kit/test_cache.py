"""The compile cache: shared by source tree and unzip folders, safe in races, never in the way."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from aeroslosh.fmus.build import archive
from support.paths import COMPONENTS

KERNELS = COMPONENTS / "kernels"
RUN = """
import sys
sys.path.insert(0, sys.argv[1])
import numpy as np
from {package}.kernels import sums
{before}
value = sums.scaled_sum(np.ones(10, dtype=sys.argv[2]))
stats = getattr(sums.scaled_sum, "stats", None)
hits, misses = (sum(stats.cache_hits.values()), sum(stats.cache_misses.values())) if stats else (0, 0)
print(value, hits, misses)
"""


def copy(folder: Path, package: str, kernel_edit: str = "") -> Path:
    """Lay out kit and the kernels as package `package` in `folder`, as a source tree or an FMU does."""
    root = folder / package
    root.mkdir(parents=True)
    (root / "__init__.py").touch()
    shutil.copytree(archive.ROOT / "kit", root / "kit", ignore=shutil.ignore_patterns("__pycache__"))
    shutil.copytree(KERNELS, root / "kernels", ignore=shutil.ignore_patterns("__pycache__"))
    with (root / "kernels" / "sums.py").open("a") as file:
        file.write(kernel_edit)
    return folder


def start(
    folder: Path, package: str, cache: Path, *, kind: str = "f8", before: str = "", **environment: str
) -> subprocess.Popen[str]:
    """Run the kernel in a process of its own."""
    env = {**os.environ, "XDG_CACHE_HOME": str(cache), "LOCALAPPDATA": str(cache), **environment}
    code = RUN.format(package=package, before=before)
    command = [sys.executable, "-c", code, str(folder), kind]
    return subprocess.Popen(command, env=env, text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


def result(process: subprocess.Popen[str]) -> tuple[float, int, int]:
    """Return the value, cache hits and misses that `process` printed."""
    out, err = process.communicate(timeout=300)
    assert process.returncode == 0, err
    value, hits, misses = out.split()
    return float(value), int(hits), int(misses)


def test_folders_and_package_names_share_one_compilation_until_a_kernel_changes(tmp_path: Path) -> None:
    cache = tmp_path / "cache"
    tree = copy(tmp_path / "tree", "sources")
    assert result(start(tree, "sources", cache)) == (20.0, 0, 1)
    assert result(start(copy(tmp_path / "one", "x_1"), "x_1", cache)) == (20.0, 1, 0)
    shutil.rmtree(tree)  # the code that compiled it may be gone
    assert result(start(copy(tmp_path / "two", "x_2"), "x_2", cache)) == (20.0, 1, 0)
    edited = copy(tmp_path / "three", "x_3", "\n# edited\n")
    assert result(start(edited, "x_3", cache)) == (20.0, 0, 1)


SHARED = """
from {kit} import jit
from .constants import FACTOR

@jit
def scaled_sum(values):
    return FACTOR * values.sum()
"""
NO_LOCATOR = (
    "from numba.core import caching; del caching._CacheLocator\n"
    "from sources.kit import cache; cache._cache_class.cache_clear()\n"
    "import importlib; importlib.reload(sums)"
)


@pytest.mark.parametrize("before", ["", NO_LOCATOR], ids=["own cache", "another numba"])
def test_a_constant_of_another_module_is_never_stale(tmp_path: Path, before: str) -> None:
    """Kernels of a shared folder, which has no face; the constant lies beside them, the compiler's options in kit."""
    cache, tree = tmp_path / "cache", copy(tmp_path / "tree", "sources")
    root, shared = tree / "sources", tree / "sources" / "kernels"
    (shared / "fmu.py").unlink()
    (shared / "sums.py").write_text(SHARED.format(kit="..kit.compiled"))
    (shared / "constants.py").write_text("FACTOR = 2.0\n")
    assert result(start(tree, "sources", cache, before=before))[0] == 20.0
    if not before:
        assert result(start(tree, "sources", cache)) == (20.0, 1, 0)
    (shared / "constants.py").write_text("FACTOR = 3.0\n")
    assert result(start(tree, "sources", cache, before=before))[0] == 30.0
    if not before:
        with (root / "kit" / "compiled.py").open("a") as file:
            file.write("\n_FAST.clear()\n")
        assert result(start(tree, "sources", cache)) == (30.0, 0, 1)


def test_racing_processes_get_their_own_code_and_all_keep_it(tmp_path: Path) -> None:
    tree, cache = copy(tmp_path / "tree", "sources"), tmp_path / "cache"
    kinds = ["f8", "f4", "i8"]
    for _ in range(2):
        racing = [start(tree, "sources", cache, kind=kind) for kind in kinds]
        assert [result(process)[0] for process in racing] == [20.0] * 3
        assert [result(start(tree, "sources", cache, kind=kind)) for kind in kinds] == [(20.0, 1, 0)] * 3  # all of it was kept


def test_a_cache_that_cannot_take_more_ends_nothing(tmp_path: Path) -> None:
    """As on a full disk: no file may grow."""
    tree = copy(tmp_path / "tree", "sources")
    limit = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))"
    assert result(start(tree, "sources", tmp_path / "cache", before=limit))[0] == 20.0
    assert result(start(tree, "sources", tmp_path / "cache")) == (20.0, 0, 1)


@pytest.mark.parametrize(
    ("environment", "before"),
    [
        ({"XDG_CACHE_HOME": "/dev/null/no", "LOCALAPPDATA": "/dev/null/no"}, ""),
        ({"NUMBA_DISABLE_JIT": "1"}, ""),
        ({}, NO_LOCATOR),
    ],
    ids=["folder cannot be written", "no compilation", "another numba"],
)
def test_without_its_cache_the_kernel_still_runs(tmp_path: Path, environment: dict[str, str], before: str) -> None:
    tree = copy(tmp_path / "tree", "sources")
    process = start(tree, "sources", tmp_path / "cache", before=before, **environment)
    assert result(process)[0] == 20.0
