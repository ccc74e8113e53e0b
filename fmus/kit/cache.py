"""Kernels compiled once for all copies of the same sources: a content-addressed numba cache.

    from ..kit.cache import jit

    @jit
    def flux(...): ...

numba keeps compiled code beside the source file or under a hash of its path, so an FMU that a tool unzips to
a new folder compiles again each time. Here the folder is `<user cache>/aeroslosh/<hash of the sources>/` and
the module takes a name made of that hash (numba stores the name of the module with the code): any unzip
folder, any version of the FMU with the same kernels and the source tree share one compilation.

Rules for kernel modules: module level only, all globals constant, no data but what lies in the component's
folder, imports of the package relative. This leans on private parts of numba (written against 0.68); where they
have changed, numba's ordinary cache lies in that folder instead; where the folder cannot be written, nothing is
kept: numba's ordinary place knows a kernel by its own file alone, and would keep it when a constant that it
imports has changed. Processes may race: files are replaced atomically, data files have names of their own, and an
index is read and rewritten under a lock, so at worst a function is compiled twice.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import inspect
import os
import sys
import uuid
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numba

from . import sources

ROOT = Path(__file__).resolve().parents[1]  # the package root: fmus/, or resources/<component>_<hash>/
SETTINGS: Any = numba.config  # its attributes are made from the environment
DEFAULTS: dict[str, Any] = {"error_model": "numpy", "nogil": True}


def jit(function: Callable[..., Any] | None = None, /, **options: Any) -> Any:
    """Compile `function` in nopython mode with the content-addressed cache.

    `options` go to `numba.njit` (`fastmath`, `parallel`, `inline`, ...); the defaults are
    `error_model="numpy"` (no check for division by zero) and `nogil=True`. Use as `@jit` or
    `@jit(fastmath=True)`.
    """
    if function is None:
        return functools.partial(jit, **options)
    settings = {**DEFAULTS, **options}
    try:
        cache, compiler = _cache_class()(function), _compiler_class()
    except Exception:  # another numba, a folder that cannot be written, a file from elsewhere
        return _ordinary(function, settings)
    _name_by_content(function)
    dispatcher = numba.njit(pipeline_class=compiler, **settings)(function)
    dispatcher._cache = cache
    return dispatcher


def cache_root() -> Path:
    """Return the folder of this project in the user's cache."""
    if os.name == "nt":
        base = os.environ.get("LOCALAPPDATA") or str(Path.home() / "AppData" / "Local")
    else:
        base = os.environ.get("XDG_CACHE_HOME") or str(Path.home() / ".cache")
    return Path(base) / "aeroslosh"


def _ordinary(function: Callable[..., Any], settings: dict[str, Any]) -> Any:
    """Compile with numba's own cache in the folder of the content; without any cache where that cannot be had."""
    before = SETTINGS.CACHE_DIR
    try:
        folder = cache_root() / _place(inspect.getfile(function))[0]
        folder.mkdir(parents=True, exist_ok=True)
        SETTINGS.CACHE_DIR = str(folder)
        return numba.njit(cache=True, **settings)(function)
    except Exception:
        return numba.njit(**settings)(function)
    finally:
        SETTINGS.CACHE_DIR = before


@functools.cache
def _hashes(folder: str) -> tuple[frozenset[Path], str, str]:
    """The files that a component's face reaches, the hash for kernels in these, and for those in others."""
    home = ROOT / folder
    reached = frozenset(sources.component_files(home, ROOT).values())
    left = next((path for path in home.rglob("*.py") if path not in reached), None)
    own = sources.kernel_hash(home, ROOT)
    return reached, own, own if left is None else sources.kernel_hash(home, ROOT, left)


def _place(file: str) -> tuple[str, str]:
    """Return the hash of the sources that `file` belongs to and its path below the package root.

    Raises:
        ValueError: the file is not in this package.
    """
    path = Path(file).resolve()
    inside = path.relative_to(ROOT)
    reached, own, others = _hashes(inside.parts[0])
    return own if path in reached else others, inside.with_suffix("").as_posix()


def _name_by_content(function: Callable[..., Any]) -> None:
    """Give the module of `function` a name made of its content, under which numba finds it again.

    numba writes the name of the function's module into the cached code and imports it when it reads it back.
    """
    values = getattr(function, "__globals__", {})
    if values.get("__name__") == "__main__":
        return
    digest, place = _place(inspect.getfile(function))
    name = f"aeroslosh_{digest}.{place.replace('/', '.')}"
    module = sys.modules.get(values["__name__"])
    if module is not None:
        sys.modules.setdefault(name, module)
        values["__name__"] = name
    function.__module__ = name


def argument(cls: type) -> type:
    """Let a NamedTuple defined in a kernel module be an argument of its kernels.

    numba writes the class of such an argument by the name of its module into the cache: it must be the one
    made of the content, since every FMU has a package of its own.
    """
    with contextlib.suppress(ValueError, TypeError, OSError):  # a class from elsewhere keeps its name
        digest, place = _place(inspect.getfile(sys.modules[cls.__module__]))
        name = f"aeroslosh_{digest}_{place.replace('/', '_')}"  # no dots: pickle imports what stands before the first
        sys.modules.setdefault(name, sys.modules[cls.__module__])
        cls.__module__ = name
    return cls


@contextlib.contextmanager
def _locked(path: Path) -> Iterator[None]:
    """No other process in here for `path`, a file, where the system has such locks."""
    with contextlib.ExitStack() as held:
        with contextlib.suppress(ImportError, OSError):  # no Unix; a file system without locks
            import fcntl

            file = held.enter_context(path.open("a"))
            fcntl.flock(file, fcntl.LOCK_EX)  # let go of when the file is closed
        yield


@functools.cache
def _compiler_class() -> type:
    """Return numba's compiler, which makes kernels that share no function with others."""
    from llvmlite.binding import Linkage
    from numba.core import codegen, compiler

    class SelfContained(codegen.JITCodeLibrary):
        """numba's own, whose copies of callees are seen from nowhere else.

        As numba leaves them, a callee that was not inlined is a weak symbol, which the linker takes from whichever kernel with
        a copy this process met first. Copies are optimised, and round, with the kernel they lie in: a process that compiled
        would compute otherwise than one that reads the cache."""

        def _optimize_final_module(self) -> None:
            super()._optimize_final_module()
            for function in self._final_module.functions:
                if not function.is_declaration and function.linkage == Linkage.linkonce_odr:
                    function.linkage = Linkage.internal

    class Compiler(compiler.Compiler):
        """numba's own, into such a library."""

        def define_pipelines(self) -> Any:
            library = self.state.targetctx.codegen().create_library(self.state.func_id.func_qualname)
            library.enable_object_caching()
            if type(library) is codegen.JITCodeLibrary:
                library.__class__ = SelfContained
            self.state.library = library
            return super().define_pipelines()

    return Compiler


@functools.cache
def _cache_class() -> type:
    """Return numba's cache of functions, in our folder."""
    from numba.core import caching

    class ContentLocator(caching._CacheLocator):
        """Cache folder by content, for files of this package only."""

        def __init__(self, py_func: Any, py_file: str) -> None:
            self._py_file = py_file
            self._lineno = py_func.__code__.co_firstlineno
            self._digest, self._name = _place(py_file)

        def get_cache_path(self) -> str:
            """Return the folder."""
            return str(cache_root() / self._digest)

        def get_source_stamp(self) -> str:
            """Return what tells fresh from stale: the content."""
            return self._digest

        def get_disambiguator(self) -> str:
            """Tell functions of one name apart."""
            return f"{self._lineno}-{hashlib.sha256(self._name.encode()).hexdigest()[:8]}"

        @classmethod
        def from_function(cls, py_func: Any, py_file: str) -> ContentLocator | None:
            """Return a locator, or None where the file is not ours or the folder cannot be written."""
            try:
                locator = cls(py_func, py_file)
                locator.ensure_cache_path()
            except (OSError, ValueError):
                return None
            return locator

    class ContentCacheImpl(caching.CompileResultCacheImpl):
        """numba's own, with our locator alone: raises where that cannot be used."""

    ContentCacheImpl._locator_classes = [ContentLocator]

    class ContentCache(caching.FunctionCache):
        """numba's own, with data files that no two processes share."""

        _impl_class = ContentCacheImpl

        def __init__(self, py_func: Any) -> None:
            super().__init__(py_func)
            # numba counts data files in an index that it rewrites without a lock. Where there is no lock a name of its own
            # keeps one number from two signatures: the loser of the race compiles again.
            base = self._impl.filename_base
            self._lock = Path(self._cache_path, f"{base}.lock")
            self._cache_file._data_name_pattern = f"{base}.{{number:d}}-{uuid.uuid4().hex[:8]}.nbc"

        def load_overload(self, sig: Any, target_context: Any) -> Any:
            """Return compiled code, or None where there is none that can be read."""
            try:
                return super().load_overload(sig, target_context)
            except Exception:  # an index that cannot be read is worth a compilation, not a failed run
                self.flush()
                return None

        def save_overload(self, sig: Any, data: Any) -> None:
            """Keep compiled code; where the disk is full this process goes on with what it has compiled."""
            with contextlib.suppress(OSError), _locked(self._lock):
                super().save_overload(sig, data)

    return ContentCache
