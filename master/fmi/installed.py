"""Where the FMUs of this package are: named by the user, built beside a checkout, or built once into the user's cache."""

from __future__ import annotations

import functools
import hashlib
import os
import shutil
import sys
import tempfile
from pathlib import Path

from ..base.errors import AeroSloshError
from ..base.paths import PLACE
from . import unpack

SOURCES = PLACE / "aeroslosh" / "fmus"
CHECKOUT = PLACE / "dist" / "fmus"  # where `make fmus` puts them


def folder() -> Path:
    """AEROSLOSH_FMUS, else dist/fmus of a checkout in which they are built, else the place in the user's cache (`ensure`)."""
    if named := os.environ.get("AEROSLOSH_FMUS"):
        return Path(named)
    if (PLACE / "pyproject.toml").is_file() and any(CHECKOUT.glob("*.fmu")):
        return CHECKOUT
    return _cached()


def ensure(place: Path) -> None:
    """Build the FMUs into `place` where that is this package's own in the cache and holds none; leave any other alone.

    Raises AeroSloshError when they cannot be built."""
    if place.is_dir() or place != _cached():
        return
    from ...fmus.build import archive  # what a user of FMUs built before need not load

    print("aeroslosh: building the FMUs, once (about 20 s)", file=sys.stderr, flush=True)
    hidden = place
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        hidden = Path(tempfile.mkdtemp(prefix=".fmus_", dir=place.parent))
        for component in archive.components().values():
            archive.install(archive.build(component, hidden), Path(sys.executable))
        hidden.chmod(0o755)
        try:
            hidden.rename(place)
        except OSError:
            if not place.is_dir():  # another process was quicker
                raise
    except (archive.BuildError, OSError) as error:
        remedy = "set XDG_CACHE_HOME to a folder that can be written, or AEROSLOSH_FMUS to a folder of FMUs built elsewhere"
        raise AeroSloshError(f"The FMUs cannot be built: {error}", str(place), remedy) from None
    finally:
        if hidden != place:
            shutil.rmtree(hidden, ignore_errors=True)


def named(fmu: Path, place: Path | None = None) -> Path:
    """The file `fmu`, or the FMU of this package with that name, in `place` or where they are. Raises AeroSloshError for none."""
    if fmu.is_file():
        return fmu
    where = folder() if place is None else place
    if not fmu.suffix and fmu.name == str(fmu):
        ensure(where)
        if (path := where / f"{fmu.name}.fmu").is_file():
            return path
    known = ", ".join(sorted(p.stem for p in where.glob("*.fmu")))
    raise AeroSloshError(
        f"There is no FMU '{fmu}'", str(where), f"give the path of a .fmu file, or one of {known or 'none here'}"
    )


@functools.cache
def _cached() -> Path:
    """The folder named by the content of the FMUs' sources."""
    digest = hashlib.sha256()
    for path in sorted(p for p in SOURCES.rglob("*") if p.is_file() and "__pycache__" not in p.parts):
        digest.update(f"{path.relative_to(SOURCES).as_posix()}\0".encode() + path.read_bytes())
    return unpack.cache_root().parent / "built" / digest.hexdigest()[:16]
