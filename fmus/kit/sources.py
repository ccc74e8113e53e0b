"""Which files belong to a component, and the hash of their content.

A component is the folder `fmus/<name>/` with a `fmu.py`. To it belong the modules of its own folder that `fmu.py` reaches (not
those that only train or document it) and its data files, the shared folders it imports (`from ..tank.x import y`) and the
modules of `kit` it reaches. The same functions work in the source
tree and inside an FMU, where the files lie in the same layout: same content, same hash.
"""

from __future__ import annotations

import ast
import functools
import hashlib
from collections.abc import Iterable, Iterator
from pathlib import Path

KIT = "kit"
FACE = "fmu.py"
DOCUMENTATION = {".md"}
REFERENCE = "reference"  # folder with the reference result
ICON = "icon.png"
SKIP = {"__pycache__", REFERENCE, ICON}  # documentation, like READMEs: no part of what is computed


def component_files(folder: Path, root: Path) -> dict[str, Path]:
    """Return the files of the component in `folder`, by their path below the package root ("aero/fmu.py").

    Args:
        folder: the component's folder, or a shared one, of which all modules count; elsewhere than `root` for a test component.
        root: the package root, which holds `kit` and the shared folders.
    """
    face = folder / FACE
    return _reached([face] if face.is_file() else _modules(folder), folder, root)


def content_hash(files: dict[str, Path]) -> str:
    """Return 12 hexadecimal digits that name the content of `files`."""
    total = hashlib.sha256()
    for name, path in sorted(files.items()):
        total.update(f"{name}\0{hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()[:12]


def kernel_hash(folder: Path, root: Path, module: Path | None = None) -> str:
    """Return the hash of all that code compiled in `folder` can read: the component's files less its face, the shared folders
    and, of kit, what their modules import.

    A `module` that its face does not reach (one that trains or measures) may read every module of the folder.
    """
    found = component_files(folder, root)
    own = [path for path in found.values() if path.suffix == ".py" and path.parent != root / KIT and path != folder / FACE]
    if module is not None and module not in found.values():
        own += [path for path in _modules(folder) if path != folder / FACE]
    return content_hash(_reached([*own, root / KIT / "cache.py"], folder, root))


def imported_packages(files: dict[str, Path]) -> set[str]:
    """Return the top-level names of the packages that `files` import absolutely."""
    found: set[str] = set()
    for path in files.values():
        if path.suffix != ".py":
            continue
        for level, module, names in _statements(path.read_text(encoding="utf-8")):
            if level == 0:
                found |= {name.partition(".")[0] for name in ([module] if module else names)}
    return found


def _reached(modules: Iterable[Path], folder: Path, root: Path) -> dict[str, Path]:
    """The files that `modules` of `folder` need, themselves included, by their path below the package root.

    Of `folder` and of kit: the modules that are imported, directly or through others; of a folder's data all; shared folders
    whole.
    """
    found: dict[str, Path] = {}
    todo = [root / "__init__.py", folder / "__init__.py", *modules]
    whole = {folder}
    todo += [path for path in _files(folder) if path.suffix != ".py"]
    while todo:
        path = todo.pop()
        home = folder if path.is_relative_to(folder) else root / path.relative_to(root).parts[0]
        name = f"{home.name}/{path.relative_to(home).as_posix()}" if home != path else path.name
        if name in found or not path.is_file():
            continue
        found[name] = path
        if home not in (root / KIT, path) and home not in whole:
            whole.add(home)
            todo += _files(home)
        if path.suffix == ".py":
            todo += _imports(path, home if home != path else root, root)
    return dict(sorted(found.items()))


def _imports(path: Path, home: Path, root: Path) -> Iterator[Path]:
    """Where the modules may lie that `path`, a file of the folder `home`, imports relatively; not all of them are there."""
    depth = len(path.relative_to(home).parts)  # the level that means `home`
    for level, module, names in _statements(path.read_text(encoding="utf-8")):
        if not 0 < level <= depth + 1:
            continue
        base = path.parents[level - 1] if level <= depth else root
        words = module.split(".") if module else []
        for place in [words, *([*words, name] for name in names)]:
            if not place:
                continue
            for stop in range(1, len(place) + 1):  # importing a.b runs the packages on the way too
                yield base.joinpath(*place[:stop], "__init__.py")
            yield base.joinpath(*place).with_suffix(".py")


@functools.lru_cache(maxsize=256)
def _statements(text: str) -> list[tuple[int, str, list[str]]]:
    """The imports in a module's text: level (0: absolute), the module named after `from` ("" without), the names imported."""
    nodes = list(ast.walk(ast.parse(text)))
    found = [(0, "", [alias.name for alias in node.names]) for node in nodes if isinstance(node, ast.Import)]
    return found + [
        (node.level, node.module or "", [alias.name for alias in node.names])
        for node in nodes
        if isinstance(node, ast.ImportFrom)
    ]


def _modules(folder: Path) -> list[Path]:
    return [path for path in _files(folder) if path.suffix == ".py"]


def _files(folder: Path) -> Iterator[Path]:
    for path in sorted(folder.rglob("*")):
        inside = path.relative_to(folder).parts
        if (
            path.is_file()
            and not SKIP & set(inside)
            and path.suffix not in DOCUMENTATION
            and not any(part.startswith(".") for part in inside)
        ):
            yield path
