"""Which files belong to a component, and what its hash depends on."""

from __future__ import annotations

from pathlib import Path

import pytest

from fmus.kit import sources
from fmus.kit.build import BuildError, components, face_name


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


def test_a_face_file_holds_one_class(tree: Path) -> None:
    assert face_name(tree / "a") == "A"
    (tree / "b" / "fmu.py").write_text("class B(Slave):\n    pass\nclass C(Slave):\n    pass\n")
    with pytest.raises(BuildError, match=r"2 subclasses of Slave found \(B, C\)"):
        face_name(tree / "b")
