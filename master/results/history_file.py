"""Reads the histories that runs leave (netCDF-3, written by `history_writer` and `point_file`), for comparisons and exports."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from ..base.errors import AeroSloshError


@dataclass(frozen=True)
class History:
    """One history. `values`: channel → (n,), in the file's order; `units`, `long_names`: channel → text, "" where there is none.

    name        the file's stem; with "_m01" and so on where a file holds several marches
    attributes  what the file says of itself: numbers, texts, and tables (`versions`, `fmu_sha256`, a sweep's `point`)
    """

    path: Path
    name: str
    values: dict[str, np.ndarray]
    units: dict[str, str]
    long_names: dict[str, str]
    attributes: dict[str, Any]

    @property
    def size(self) -> int:
        """Samples of a channel."""
        return next(iter(self.values.values())).size


def read(path: Path) -> list[History]:
    """The histories in a file, wholly in memory: one; one a march of a sweep's boundary; none of a point that failed at once.

    Marches in one file have channels and dimensions of their own, with prefixes m01_, m02_, …. Raises AeroSloshError.
    """
    about, groups = _opened(path)
    return [_history(path, prefix, content, about) for prefix, content in groups.items()]


def attributes(path: Path) -> dict[str, Any]:
    """What a file says of itself, also when it holds no history. Raises AeroSloshError."""
    return _opened(path)[0]


def find(path: Path) -> list[Path]:
    """The history files of a run folder or of a sweep's (its folder `points`), sorted, or the one file. Raises AeroSloshError."""
    if path.is_file():
        return [path]
    if not path.is_dir():
        raise AeroSloshError("There is no such run", str(path), "give a run folder, a sweep folder or a history (.nc)")
    found = sorted(path.glob("*.nc")) or sorted((path / "points").glob("*.nc"))
    if not found:
        raise AeroSloshError("The folder holds no history (.nc)", str(path), "give the folder that a run wrote")
    return found


def _opened(path: Path) -> tuple[dict[str, Any], dict[str, list[tuple[str, Any]]]]:
    """Attributes, and by prefix the names and variables of a file."""
    groups: dict[str, list[tuple[str, Any]]] = {}
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            about = {name: _attribute(value) for name, value in file._attributes.items()}
            for name, variable in file.variables.items():
                (dimension,) = variable.dimensions
                groups.setdefault(dimension.removesuffix("time"), []).append((name, variable))
            return about, groups
    except OSError as error:
        raise AeroSloshError(f"The history cannot be read: {error.strerror or error}", str(path), "give a .nc file") from None
    except Exception as error:  # scipy raises whatever a broken file makes of it: TypeError, ValueError, IndexError, KeyError
        remedy = "give a history that a run wrote, whole; run again where the file is cut off"
        raise AeroSloshError(f"The file is no netCDF-3 history: {error}", str(path), remedy) from None


def _history(path: Path, prefix: str, content: list[tuple[str, Any]], attributes: dict[str, Any]) -> History:
    named = {name.removeprefix(prefix): variable for name, variable in content}
    return History(
        path,
        f"{path.stem}_{prefix}".rstrip("_"),
        {name: np.array(v[:], dtype=float) for name, v in named.items()},
        {name: _text(getattr(v, "units", b"")) for name, v in named.items()},
        {name: _text(getattr(v, "long_name", b"")) for name, v in named.items()},
        attributes,
    )


def _text(value: Any) -> str:
    return value.decode("utf-8") if isinstance(value, bytes) else str(value)


def _attribute(value: Any) -> Any:
    """An attribute as Python has it: number, text, or the table that a text is JSON of."""
    if isinstance(value, bytes):
        text = value.decode("utf-8")
        try:
            return json.loads(text) if text.startswith("{") else text
        except json.JSONDecodeError:
            return text
    array = np.asarray(value)
    return array.item() if array.size == 1 else array.tolist()
