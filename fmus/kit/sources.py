"""Which files belong to a component, and the hash of their content.

A component is the folder `fmus/<name>/` with a `fmu.py`. To it belong the modules of its own folder that `fmu.py` reaches (not
those that only train or document it) and its data files, the shared folders it imports (`from ..tank.x import y`) and the
modules of `kit` it reaches. The same functions work in the source
tree and inside an FMU, where the files lie in the same layout: same content, same hash.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from pathlib import Path

KIT = "kit"
BUILD_ONLY = {"build.py", "page.py", "readme.py"}
DOCUMENTATION = {".md"}
REFERENCE = "reference"  # folder with the reference result
ICON = "icon.png"
SKIP = {"__pycache__", REFERENCE, ICON}  # documentation, like READMEs: no part of what is computed


def component_files(folder: Path, root: Path) -> dict[str, Path]:
    """Return the files of the component in `folder`, by their path below the package root ("aero/fmu.py").

    Args:
        folder: the component's folder; elsewhere than `root` for a test component.
        root: the package root, which holds `kit` and the shared folders.
    """
    files = {"__init__.py": root / "__init__.py"}
    folders, todo = {folder.name: folder}, [folder]
    kit: set[str] = set()
    while todo:
        here = todo.pop()
        unused = _unreached(here) if here == folder else set()
        for path in _files(here):
            if path in unused:
                continue
            files[f"{here.name}/{path.relative_to(here).as_posix()}"] = path
            for name in _sibling_imports(path, here):
                first, _, module = name.partition(".")
                if first == KIT:
                    kit.add(module)
                elif first not in folders and (root / first).is_dir():
                    folders[first] = root / first
                    todo.append(root / first)
    files.update({f"{KIT}/{path.name}": path for path in _kit_files(root / KIT, kit)})
    return dict(sorted(files.items()))


def content_hash(files: dict[str, Path]) -> str:
    """Return 12 hexadecimal digits that name the content of `files`."""
    total = hashlib.sha256()
    for name, path in sorted(files.items()):
        total.update(f"{name}\0{hashlib.sha256(path.read_bytes()).hexdigest()}\n".encode())
    return total.hexdigest()[:12]


def kernel_hash(folder: Path, root: Path) -> str:
    """Return the hash of what decides compiled code in `folder`: all its files less the face, and kit's
    cache.
    """
    files = {
        name: path
        for name, path in component_files(folder, root).items()
        if not name.endswith("/fmu.py") and (not name.startswith(f"{KIT}/") or name == f"{KIT}/cache.py")
    }
    return content_hash(files)


def imported_packages(files: dict[str, Path]) -> set[str]:
    """Return the top-level names of the packages that `files` import absolutely."""
    found: set[str] = set()
    for path in files.values():
        if path.suffix != ".py":
            continue
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                found |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                found.add(node.module.partition(".")[0])
    return found


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


def _unreached(folder: Path) -> set[Path]:
    """The modules in a component's folder that its face does not import, directly or through others."""
    modules = {path for path in _files(folder) if path.suffix == ".py"}
    reached, todo = {folder / "__init__.py"}, [folder / "fmu.py"]
    while todo:
        path = todo.pop()
        if path in reached or path not in modules:
            continue
        reached.add(path)
        level = len(path.relative_to(folder).parts)  # the level that means the component's folder
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
            if isinstance(node, ast.ImportFrom) and 0 < node.level <= level:
                here = path.parents[node.level - 1]
                names = [node.module] if node.module else [alias.name for alias in node.names]
                todo += [here / f"{name.replace('.', '/')}.py" for name in names]
                todo += [here / name.replace(".", "/") / "__init__.py" for name in names]
    return modules - reached


def _sibling_imports(path: Path, folder: Path) -> Iterator[str]:
    """Yield "first.module" for each relative import of `path` that leads out of `folder`."""
    if path.suffix != ".py":
        return
    up = len(path.relative_to(folder).parts) + 1  # the level that means the package root
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"), filename=str(path))):
        if isinstance(node, ast.ImportFrom) and node.level == up:
            if node.module and "." in node.module:
                yield node.module
            for alias in node.names:
                yield f"{node.module}.{alias.name}" if node.module else alias.name


def _kit_files(kit: Path, modules: set[str]) -> list[Path]:
    """Return the files of kit that `modules` need, themselves included."""
    found, todo = {kit / "__init__.py"}, {module.partition(".")[0] for module in modules}
    while todo:
        path = kit / f"{todo.pop()}.py"
        if path in found or not path.is_file() or path.name in BUILD_ONLY:
            continue
        found.add(path)
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == 1:
                todo |= {node.module} if node.module else {alias.name for alias in node.names}
    return sorted(found)
