"""The ledger of a sweep: every point with its outcome, in one SQLite file that only the master writes.

Rollback journal and full synchronisation: safe on network file systems too, where the write-ahead log is not. Each finished row
carries a checksum: damage inside a page that SQLite's own check cannot see is found as well. The points' files hold all that
the ledger holds of them, so a damaged ledger is moved aside and written anew."""

from __future__ import annotations

import dataclasses
import hashlib
import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base.errors import AeroSloshError, ExitCode
from ..results.point_file import Record
from .plan import Plan, Point

FORMAT = "1"
SCHEMA = """
CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT NOT NULL) WITHOUT ROWID;
CREATE TABLE points (
    id TEXT PRIMARY KEY, number INTEGER NOT NULL, overrides TEXT NOT NULL,
    status TEXT NOT NULL CHECK (status IN ('pending', 'running', 'done', 'failed')),
    determined INTEGER, result TEXT, file TEXT, sha256 TEXT, cause TEXT, traceback TEXT,
    attempts INTEGER NOT NULL DEFAULT 0, worker TEXT, cpu_seconds REAL, wall_seconds REAL, started REAL, finished REAL,
    checksum TEXT
) WITHOUT ROWID;
"""
CHECKED = "id, overrides, status, determined, result, file, sha256, cause, traceback, attempts"


@dataclass(frozen=True)
class Row:
    """One point as the ledger has it; see `point_file.Record`. `file` and `sha256` are of its netCDF file."""

    id: str
    number: int
    overrides: dict[str, Any]
    status: str
    determined: bool
    result: dict[str, Any] | None
    file: str
    sha256: str
    cause: str
    traceback: str
    attempts: int
    worker: str
    cpu_seconds: float
    wall_seconds: float


class Damaged(AeroSloshError):
    """The file is no whole ledger."""


class Ledger:
    """The ledger at `path`, made with its tables when there is none. Close it at the end.

    Raises Damaged for a file whose pages or rows are not what was written, AeroSloshError when it cannot be opened or written."""

    def __init__(self, path: Path) -> None:
        self.path = path
        try:
            if not path.exists() or not path.stat().st_size:
                _create(path)
            self._base = _connected(path)
            self._check()
        except sqlite3.Error as error:
            self.close()
            raise _explained(error, path) from None
        except AeroSloshError:
            self.close()
            raise

    def close(self) -> None:
        """Close the file."""
        if hasattr(self, "_base"):
            self._base.close()

    # what the sweep is

    def describe(self, plan: Plan, versions: dict[str, str]) -> None:
        """Note what the points are made of, to tell later what changed."""
        about = {"kind": plan.kind, "base": plan.base, "fmus": plan.fmus, "versions": versions}
        with self._changing() as base:
            rows = [(key, json.dumps(value, sort_keys=True)) for key, value in about.items()]
            base.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", rows)

    def about(self) -> dict[str, Any]:
        """What `describe` noted; empty for a new ledger."""
        rows = self._base.execute("SELECT key, value FROM meta WHERE key != 'format'").fetchall()
        return {key: json.loads(value) for key, value in rows}

    # points

    def add(self, points: Iterable[Point]) -> None:
        """Enter points not known yet as pending, and number all as they stand in the plan."""
        rows = [(p.id, p.index, json.dumps(p.overrides)) for p in points]
        with self._changing() as base:
            base.executemany(
                "INSERT INTO points (id, number, overrides, status) VALUES (?, ?, ?, 'pending') "
                "ON CONFLICT (id) DO UPDATE SET number = excluded.number",
                rows,
            )

    def rows(self, *statuses: str) -> list[Row]:
        """All points, or those of these statuses, in the plan's order."""
        marks = ", ".join("?" * len(statuses))
        names = [f.name for f in dataclasses.fields(Row)]
        found = self._base.execute(
            f"SELECT {', '.join(names)} FROM points {f'WHERE status IN ({marks})' if statuses else ''} ORDER BY number", statuses
        )
        return [_row(dict(zip(names, values, strict=True))) for values in found]

    def counts(self) -> dict[str, int]:
        """Points of each status."""
        found = dict(self._base.execute("SELECT status, count(*) FROM points GROUP BY status"))
        return {status: found.get(status, 0) for status in ("pending", "running", "done", "failed")}

    def start(self, starts: Sequence[tuple[str, str]]) -> None:
        """(id, worker) of points given out."""
        with self._changing() as base:
            base.executemany(
                "UPDATE points SET status = 'running', attempts = attempts + 1, worker = ?, checksum = NULL WHERE id = ?",
                [(worker, label) for label, worker in starts],
            )

    def finish(self, record: Record, file: str, sha256: str) -> None:
        """A point's outcome; its file lies on the disk already."""
        values = {
            "id": record.id,
            "overrides": json.dumps(record.overrides),
            "status": record.status,
            "determined": int(record.determined),
            "result": None if record.result is None else json.dumps(record.result, allow_nan=False),
            "file": file,
            "sha256": sha256,
            "cause": record.cause,
            "traceback": record.traceback,
            "attempts": record.attempts,
        }
        times = (record.worker, record.cpu_seconds, record.wall_seconds, record.started, record.finished)
        with self._changing() as base:
            base.execute(
                f"UPDATE points SET ({CHECKED}, worker, cpu_seconds, wall_seconds, started, finished, checksum) = "
                f"({', '.join('?' * 16)}) WHERE id = ?",
                (*values.values(), *times, _checksum(values.values()), record.id),
            )

    def reopen(self, labels: Sequence[str]) -> None:
        """These points are to be computed (again)."""
        with self._changing() as base:
            base.executemany(
                "UPDATE points SET status = 'pending', result = NULL, file = NULL, sha256 = NULL, cause = NULL, "
                "traceback = NULL, checksum = NULL WHERE id = ?",
                [(label,) for label in labels],
            )

    # inside

    @contextmanager
    def _changing(self) -> Iterator[sqlite3.Connection]:
        """One transaction, on the disk when it ends. Raises AeroSloshError when it cannot be."""
        try:
            self._base.execute("BEGIN IMMEDIATE")
            yield self._base
            self._base.execute("COMMIT")
        except sqlite3.Error as error:
            if self._base.in_transaction:
                self._base.execute("ROLLBACK")
            raise _explained(error, self.path) from None

    def _check(self) -> None:
        """Raises Damaged, or sqlite3.DatabaseError."""
        said = self._base.execute("PRAGMA integrity_check(1)").fetchone()[0]
        if said != "ok":
            raise Damaged(f"The ledger is damaged: {said}", str(self.path), "")
        found = self._base.execute("SELECT value FROM meta WHERE key = 'format'").fetchone()
        if found is None:
            raise Damaged("The ledger is damaged: no format", str(self.path), "")
        if found[0] != FORMAT:
            remedy = "go on with the version of aeroslosh that began this sweep, or start a new one with --out"
            raise AeroSloshError(f"The ledger has format {found[0]}, this version reads {FORMAT}", str(self.path), remedy)
        for label, checksum, *values in self._base.execute(
            f"SELECT id, checksum, {CHECKED} FROM points WHERE status IN ('done', 'failed')"
        ):
            if _checksum(values) != checksum:
                raise Damaged(f"The ledger is damaged: wrong checksum of point {label}", str(self.path), "")


def move_aside(path: Path) -> Path:
    """Rename a damaged ledger to `ledger.corrupt-001.sqlite`, …; returns its new path."""
    number = 1
    while (aside := path.with_name(f"{path.stem}.corrupt-{number:03d}{path.suffix}")).exists():
        number += 1
    os.rename(path, aside)
    journal = path.with_name(f"{path.name}-journal")
    if journal.exists():
        os.rename(journal, aside.with_name(f"{aside.name}-journal"))
    return aside


def _checksum(values: Iterable[Any]) -> str:
    """SHA-256 over a row's values."""
    return hashlib.sha256(json.dumps(list(values)).encode()).hexdigest()


def _row(values: dict[str, Any]) -> Row:
    for name in ("overrides", "result"):
        values[name] = json.loads(values[name]) if values[name] else None
    for name in ("file", "sha256", "cause", "traceback", "worker"):
        values[name] = values[name] or ""
    for name in ("cpu_seconds", "wall_seconds"):
        values[name] = values[name] or 0.0
    return Row(**values | {"determined": bool(values["determined"])})


def _connected(path: Path) -> sqlite3.Connection:
    """An open ledger, each statement its own transaction."""
    base = sqlite3.connect(path, isolation_level=None)
    base.execute("PRAGMA journal_mode=DELETE")
    base.execute("PRAGMA synchronous=FULL")
    return base


def _create(path: Path) -> None:
    """A new ledger with its tables, put in its place whole: whoever reads while a sweep starts sees none or all of it.

    Raises sqlite3.Error; AeroSloshError when the folder cannot be written."""
    new = path.with_name(f"{path.name}.{os.getpid()}.new")
    try:
        new.unlink(missing_ok=True)
        base = _connected(new)
        try:
            base.executescript(f"BEGIN; {SCHEMA} INSERT INTO meta VALUES ('format', '{FORMAT}'); COMMIT;")
        finally:
            base.close()
        os.replace(new, path)
    except OSError as error:
        raise AeroSloshError(
            f"The ledger cannot be written: {error.strerror}", str(path), "free space", ExitCode.INCOMPLETE
        ) from None
    finally:
        with suppress(OSError):
            new.unlink(missing_ok=True)


def _explained(error: sqlite3.Error, path: Path) -> AeroSloshError:
    """What a user is told of an error of SQLite."""
    name = getattr(error, "sqlite_errorname", "")
    if name.startswith(("SQLITE_CORRUPT", "SQLITE_NOTADB")) or "malformed" in str(error):
        return Damaged(f"The ledger is damaged: {error}", str(path), "")
    if name.startswith(("SQLITE_FULL", "SQLITE_IOERR")):
        return AeroSloshError(f"The ledger cannot be written: {error}", str(path), "free space", ExitCode.INCOMPLETE)
    if name.startswith("SQLITE_BUSY"):
        return AeroSloshError("Another program holds the ledger", str(path), "close it, then --resume", ExitCode.INCOMPLETE)
    return AeroSloshError(f"The ledger cannot be opened: {error}", str(path), "give another folder with --out")
