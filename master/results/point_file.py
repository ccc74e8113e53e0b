"""The netCDF file of one finished point: its histories and everything that the ledger says of it, guarded by a checksum.

A point's march has the names of a run's `history.nc`; the marches of a boundary have the prefixes m01_, m02_, … (netCDF-3 has
no groups). The attribute `point` holds the record as JSON, `content_sha256` the hash of it and of all values."""

from __future__ import annotations

import dataclasses
import hashlib
import io
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.io import netcdf_file

from ..base.errors import AeroSloshError
from ..flutter.march import March
from .history_writer import march_attributes, put_attributes, put_march


@dataclass(frozen=True)
class Record:
    """What is known of a finished point.

    status      "done" or "failed" (then `cause` and `traceback` say why)
    determined  whether there is a verdict, or a boundary within its tolerance
    result      what `aeroslosh point --json` (or boundary) prints; None when nothing was computed
    attempts    how often the point was started; `worker` who computed it
    started, finished   seconds since 1970"""

    id: str
    kind: str
    overrides: dict[str, Any]
    status: str
    determined: bool
    result: dict[str, Any] | None
    cause: str
    traceback: str
    attempts: int
    worker: str
    cpu_seconds: float
    wall_seconds: float
    started: float
    finished: float


def pack(record: Record, marches: Sequence[March], about: dict[str, Any]) -> bytes:
    """The file's content. `about`: provenance (`provenance.provenance`)."""
    buffer = io.BytesIO()
    file = netcdf_file(buffer, "w")
    for number, march in enumerate(marches, start=1):
        put_march(file, march, f"m{number:02d}_" if record.kind == "boundary" else "")
    attributes = march_attributes(marches[0]) if record.kind != "boundary" and marches else {"Conventions": "CF-1.8"}
    text = json.dumps(dataclasses.asdict(record), allow_nan=False)
    put_attributes(file, attributes | about | {"point": text, "content_sha256": _checksum(file, text)})
    file.flush()
    return buffer.getvalue()


def read(path: Path) -> Record:
    """The record in the file at `path`. Raises AeroSloshError for a file that is damaged or no point's."""
    try:
        with netcdf_file(str(path), "r", mmap=False) as file:
            text = file.point.decode("utf-8")
            whole = file.content_sha256.decode("ascii") == _checksum(file, text)
        record = Record(**json.loads(text))
    except Exception as error:  # scipy raises whatever a broken file makes of it: TypeError, ValueError, IndexError, …
        raise AeroSloshError(
            f"The point's file cannot be read: {error}", str(path), "--resume computes the point again"
        ) from None
    if not whole:
        raise AeroSloshError("The point's file is damaged (wrong checksum)", str(path), "--resume computes the point again")
    return record


def _checksum(file: netcdf_file, text: str) -> str:
    """SHA-256 over `text` and the names and values of all variables, as big-endian doubles."""
    digest = hashlib.sha256(text.encode("utf-8"))
    for name in sorted(file.variables):
        digest.update(name.encode())
        digest.update(np.ascontiguousarray(file.variables[name][:], dtype=">f8").tobytes())
    return digest.hexdigest()
