"""Where an FMU is unzipped: once, to a plain ASCII folder named by the content's hash, shared between runs.

A plain path avoids a fault of pythonfmu's loader (it decodes `%20` alone in the resource path: `#`, `é`
or `%` end the process), a stable path keeps numba's compile cache warm, and the atomic rename lets
several processes race.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
import tempfile
import zipfile
from pathlib import Path

from master.errors import AeroSloshError

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
    """The folder of the unzipped FMU and its hash. Raises AeroSloshError when `path` is no FMU."""
    if not path.is_file():
        raise AeroSloshError(
            f"The FMU {path.name} is missing",
            str(path),
            "build the FMUs with `make fmus`, or give --fmus DIR",
        )
    digest = sha256(path)
    folder = cache_root() / f"{path.stem if _PLAIN.fullmatch(path.stem) else 'fmu'}_{digest[:16]}"
    if (folder / "modelDescription.xml").is_file():
        return folder, digest
    part = Path(tempfile.mkdtemp(prefix=f".{digest[:8]}-", dir=folder.parent))
    try:
        with zipfile.ZipFile(path) as archive:
            archive.extractall(part)
        if not (part / "modelDescription.xml").is_file():
            raise AeroSloshError(f"{path.name} holds no modelDescription.xml", str(path), "give an FMI 2.0 FMU")
        try:
            os.rename(part, folder)
        except OSError:
            if (folder / "modelDescription.xml").is_file():
                return folder, digest  # another process was faster; its copy may be in use already
            shutil.rmtree(folder, ignore_errors=True)  # a damaged earlier copy
            os.rename(part, folder)
    except zipfile.BadZipFile:
        raise AeroSloshError(f"{path.name} is not a zip archive", str(path), "build it again with `make fmus`") from None
    except OSError as error:
        if not (folder / "modelDescription.xml").is_file():  # otherwise another process was faster
            raise AeroSloshError(
                f"The FMU cannot be unzipped: {error.strerror}",
                str(folder),
                "free space, or set XDG_CACHE_HOME",
            ) from None
    finally:
        shutil.rmtree(part, ignore_errors=True)
    return folder, digest
