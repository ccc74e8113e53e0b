"""Where an FMU is unzipped: once, to a plain ASCII folder named by the content's hash, shared between runs.

A plain path avoids a fault of pythonfmu's loader (it decodes `%20` alone in the resource path: `#`, `é`
or `%` end the process), a stable path keeps numba's compile cache warm, and the atomic rename lets
several processes race. What lies there is compared with the archive each time: a copy that was damaged heals.
"""

from __future__ import annotations

import contextlib
import hashlib
import marshal
import os
import re
import shutil
import tempfile
import zipfile
import zlib
from pathlib import Path

from ..base.errors import AeroSloshError

TRIES = 3  # at putting a new copy in place, while other processes do the same
_HEADER = 16  # bytes of a .pyc before its code
_PLAIN = re.compile(r"[A-Za-z0-9_./\-]+")


def sha256(path: Path) -> str:
    """The file's SHA-256 in hexadecimal."""
    digest = hashlib.sha256()
    with path.open("rb") as stream:
        while block := stream.read(1 << 20):
            digest.update(block)
    return digest.hexdigest()


def cache_root() -> Path:
    """`$XDG_CACHE_HOME/aeroslosh/fmus` when that is a plain path, else a private folder below the temporary one."""
    base = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache").absolute()
    root = base / "aeroslosh" / "fmus"
    if _PLAIN.fullmatch(str(root)):
        try:
            root.mkdir(parents=True, exist_ok=True)
            if os.access(root, os.W_OK):
                return root
        except OSError:
            pass  # a read-only home: use the temporary folder
    uid = os.getuid() if hasattr(os, "getuid") else 0
    root = Path(tempfile.gettempdir()) / f"aeroslosh-{uid}" / "fmus"
    root.mkdir(parents=True, exist_ok=True, mode=0o700)
    if hasattr(os, "getuid") and root.stat().st_uid != uid:
        raise AeroSloshError("The folder for unzipped FMUs belongs to another user", str(root), "set XDG_CACHE_HOME")
    return root


def unzip(path: Path) -> tuple[Path, str]:
    """The folder of the unzipped FMU and its hash; a copy that is not the archive's content any more is made anew.

    Raises AeroSloshError when `path` is no FMU."""
    if not path.is_file():
        raise AeroSloshError(
            f"The FMU {path.name} is missing",
            str(path),
            "build the FMUs with `make fmus`, or give --fmus DIR",
        )
    try:
        digest = sha256(path)
    except OSError as error:
        raise AeroSloshError(f"{path.name} cannot be read: {error.strerror}", str(path), "make it readable") from None
    folder = cache_root() / f"{path.stem if _PLAIN.fullmatch(path.stem) else 'fmu'}_{digest[:16]}"
    try:
        with zipfile.ZipFile(path) as archive:
            if "modelDescription.xml" not in archive.namelist():
                raise AeroSloshError(f"{path.name} holds no modelDescription.xml", str(path), "give an FMI 2.0 FMU")
            if not _whole(folder, archive):
                _fill(folder, archive)
    except (zipfile.BadZipFile, zlib.error, EOFError, NotImplementedError, RuntimeError) as error:
        what = f"{path.name} is not a zip archive, or a damaged one: {error}"
        raise AeroSloshError(what, str(path), "build it again with `make fmus`") from None
    except OSError as error:
        raise AeroSloshError(
            f"The FMU cannot be unzipped: {error.strerror}",
            str(folder),
            "free space, or set XDG_CACHE_HOME",
        ) from None
    return folder, digest


def _whole(folder: Path, archive: zipfile.ZipFile) -> bool:
    """Whether `folder` holds what the archive does, byte for byte. Python's own compiled files go where they cannot be read:
    Python would stumble over them, not make them anew."""
    if not folder.is_dir():
        return False
    for info in archive.infolist():
        try:
            if not info.is_dir() and (folder / info.filename).read_bytes() != archive.read(info):
                return False
        except OSError:
            return False
    for compiled in folder.rglob("*.pyc"):
        try:
            marshal.loads(compiled.read_bytes()[_HEADER:])
        except (ValueError, EOFError, TypeError):
            compiled.unlink(missing_ok=True)
    return True


def _fill(folder: Path, archive: zipfile.ZipFile) -> None:
    """Unzip beside `folder` and rename; a damaged copy there moves aside first, for another process may still use it."""
    part = Path(tempfile.mkdtemp(prefix=f".{folder.name}.part-", dir=folder.parent))
    try:
        archive.extractall(part)
        part.chmod(0o755)
        for attempt in range(TRIES):
            try:
                os.rename(part, folder)
                return
            except OSError:
                if _whole(folder, archive):
                    return  # another process was faster
                if attempt == TRIES - 1:
                    raise
            aside = Path(tempfile.mkdtemp(prefix=f".{folder.name}.damaged-", dir=folder.parent))
            with contextlib.suppress(FileNotFoundError):  # another process was faster
                os.rename(folder, aside)
            shutil.rmtree(aside, ignore_errors=True)
    finally:
        shutil.rmtree(part, ignore_errors=True)
