"""Which files belong to a component, and what its hash depends on."""

from __future__ import annotations

import ast
import re
import shutil
from pathlib import Path

import pytest

from aeroslosh.fmus.build.archive import ROOT, BuildError, components, face_name
from aeroslosh.fmus.kit import sources


@pytest.fixture
def tree(tmp_path: Path) -> Path:
    """A small package: component `a` uses `tank` and kit's cache, which uses kit's sources."""
    for name, text in {
        "__init__.py": "",
        "kit/__init__.py": "",
        "kit/slave.py": "from . import xml\n",
        "kit/xml.py": "import math\n",
        "kit/cache.py": "import numba\nfrom .sources import x\n",
        "kit/sources.py": "",
        "kit/build.py": "",
        "kit/unused.py": "",
        "tank/__init__.py": "",
        "tank/liquid.py": "import scipy.linalg\n",
        "a/__init__.py": "",
        "a/fmu.py": "from ..kit.slave import Slave\nfrom .deep.kernel import f\nclass A(Slave): ...\n",
        "a/deep/kernel.py": "from ...kit.cache import jit\nfrom ...tank.liquid import f\nimport numpy\n",
        "a/weights.csv": "1\n",
        "a/README.md": "text",
        "a/__pycache__/fmu.cpython-311.pyc": "x",
        "b/fmu.py": "from ..kit.slave import Slave\nclass B(Slave):\n    pass\n",
    }.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


def test_files_are_the_component_what_it_shares_and_what_it_needs_of_kit(tree: Path) -> None:
    assert set(sources.component_files(tree / "a", tree)) == {
        *("__init__.py", "kit/__init__.py", "kit/slave.py", "kit/xml.py", "kit/cache.py", "kit/sources.py"),
        *("tank/__init__.py", "tank/liquid.py"),
        *("a/__init__.py", "a/fmu.py", "a/deep/kernel.py", "a/weights.csv"),
    }
    assert set(sources.component_files(tree / "b", tree)) == {
        *("__init__.py", "kit/__init__.py", "kit/slave.py", "kit/xml.py", "b/fmu.py")
    }
    assert sources.imported_packages(sources.component_files(tree / "a", tree)) == {*("math", "numba", "scipy", "numpy")}
    assert set(components(tree)) == {"a", "b"}


@pytest.mark.parametrize(
    ("changed", "fmu", "kernels"),
    [
        ("a/deep/kernel.py", True, True),
        ("a/weights.csv", True, True),
        ("tank/liquid.py", True, True),
        ("kit/cache.py", True, True),
        ("kit/sources.py", True, True),  # kit's cache imports it
        ("kit/slave.py", True, False),
        ("a/fmu.py", True, False),
        ("kit/build.py", False, False),
        ("a/README.md", False, False),
        ("b/fmu.py", False, False),
    ],
)
def test_hashes_follow_the_content(tree: Path, changed: str, fmu: bool, kernels: bool) -> None:
    def hashes() -> tuple[str, str]:
        files = sources.component_files(tree / "a", tree)
        return sources.content_hash(files), sources.kernel_hash(tree / "a", tree)

    before = hashes()
    with (tree / changed).open("a") as file:
        file.write("\n# changed\n")
    after = hashes()
    assert (before[0] != after[0], before[1] != after[1]) == (fmu, kernels)


def test_every_form_of_import_is_followed(tree: Path) -> None:
    for name, text in {
        "a/fmu.py": "from ..kit.slave import Slave\nfrom .deep import kernel\nfrom . import deeper\nclass A(Slave): ...\n",
        "a/deep/__init__.py": "",
        "a/deep/kernel.py": "from ...kit import cache\nfrom ... import tank\nfrom .more.constants import x\nfrom .. import other",
        "a/deep/more/__init__.py": "from . import aside\n",
        "a/deep/more/aside.py": "",
        "a/deep/more/constants.py": "",
        "a/deeper/__init__.py": "def f():\n    from .late import y\n",
        "a/deeper/late.py": "",
        "a/other.py": "",
        "a/training.py": "from .other import z\n",
    }.items():
        (tree / name).parent.mkdir(parents=True, exist_ok=True)
        (tree / name).write_text(f"{text}\n")
    found = set(sources.component_files(tree / "a", tree))
    assert {name for name in found if name.startswith("a/")} == {
        *("a/__init__.py", "a/fmu.py", "a/weights.csv", "a/other.py", "a/deep/__init__.py", "a/deep/kernel.py"),
        *("a/deep/more/__init__.py", "a/deep/more/aside.py", "a/deep/more/constants.py"),
        *("a/deeper/__init__.py", "a/deeper/late.py"),
    }
    assert {"tank/liquid.py", "tank/__init__.py", "kit/cache.py"} <= found


def jitted(root: Path) -> list[Path]:
    """Modules that hold kernels."""
    word = re.compile(r"^from \.+kit\.(cache|compiled) import .*\b(jit|inline)\b", re.MULTILINE)
    return [path for path in sorted(root.glob("*/*.py")) if word.search(path.read_text())]


def readable(path: Path, root: Path) -> set[Path]:
    """All modules that `path` imports, directly or through others: found here by Python's own rules, one name at a time."""
    found: set[Path] = set()
    todo = [path]
    while todo:
        here = todo.pop()
        if here in found:
            continue
        found.add(here)
        for node in ast.walk(ast.parse(here.read_text())):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = here.parents[node.level - 1].joinpath(*(node.module or "").split("."))
                names = [base.with_suffix(".py"), *(base / f"{alias.name}.py" for alias in node.names)]
                todo += [name for name in names if name.is_file()]
    return found


def test_a_constant_changed_anywhere_a_kernel_reads_changes_its_key(tmp_path: Path) -> None:
    """The product's own sources, in a copy: one constant more in one module at a time."""
    root = tmp_path / "fmus"
    shutil.copytree(ROOT, root, ignore=shutil.ignore_patterns("__pycache__", "*.svg", "reference"))
    kernels = jitted(root)
    assert {path.parent.name for path in kernels} >= {"aero", "slosh_rbf", "slosh_vof", "tank"}

    def keys(homes: set[Path]) -> dict[Path, str]:
        return {home: sources.kernel_hash(home, root) for home in homes}

    readers: dict[Path, set[Path]] = {}  # module → folders of the kernels that can read it
    for kernel in kernels:
        for module in readable(kernel, root):
            readers.setdefault(module, set()).add(kernel.parent)
    for face in root.glob("*/fmu.py"):  # and every module of a component that computes
        for module in readable(face, root) - {face}:
            if module.parent.name != "kit":
                readers.setdefault(module, set()).update({module.parent, face.parent})
    assert {"tank/motion.py", "tank/liquid.py", "kit/compiled.py", "kit/cache.py", "aero/flux.py", "structure/section.py"} <= {
        module.relative_to(root).as_posix() for module in readers
    }
    before = keys(set().union(*readers.values()))
    for module, homes in sorted(readers.items()):
        text = module.read_text()
        module.write_text(f"{text}\nONE_MORE = 1.0\n")
        assert all(key != before[home] for home, key in keys(homes).items()), module
        module.write_text(text)
    assert keys(set(before)) == before


def test_a_kernel_that_no_face_reaches_has_its_own_sources_in_its_key(tree: Path) -> None:
    training = tree / "a" / "training.py"
    training.write_text("from ..kit.cache import jit\n")
    before = sources.kernel_hash(tree / "a", tree, training)
    training.write_text("from ..kit.cache import jit\nFACTOR = 2.0\n")
    assert sources.kernel_hash(tree / "a", tree, training) != before
    assert sources.kernel_hash(tree / "a", tree) == sources.kernel_hash(tree / "a", tree, tree / "a" / "deep" / "kernel.py")


def test_a_face_file_holds_one_class(tree: Path) -> None:
    assert face_name(tree / "a") == "A"
    (tree / "b" / "fmu.py").write_text("class B(Slave):\n    pass\nclass C(Slave):\n    pass\n")
    with pytest.raises(BuildError, match=r"2 subclasses of Slave found \(B, C\)"):
        face_name(tree / "b")
