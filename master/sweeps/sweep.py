"""A sweep: every point of a plan computed once, kept for good, whatever ends the master.

A point is finished when its file lies under its own name; then its row is written. Between the two a kill loses nothing: the next
master finds the file and enters it. Only the master writes, and one master at a time holds the folder's lock.
  case.toml       the resolved case with its [sweep]
  ledger.sqlite   every point with its outcome (module `ledger`); ledger.lock says who is at work
  points/*.nc     a file a point, named by its id (module `point_file`)
  sweep.csv, .png results as a table and a picture, sweep.log what the master said"""

from __future__ import annotations

import contextlib
import dataclasses
import datetime
import fcntl
import hashlib
import json
import os
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from ..base import files as base_files
from ..base.disk import FULL
from ..base.errors import AeroSloshError, ExitCode
from ..results import point_file
from . import jobs
from .jobs import Job, Probe, Product
from .ledger import Damaged, Ledger, move_aside
from .plan import Plan
from .workers import Events

LOCK = "ledger.lock"
TRIES = 2  # a point whose worker died is computed once more


class Pool(Protocol):
    """Whoever computes jobs: local workers, or a cluster."""

    @property
    def name(self) -> str:
        """For the user."""

    @property
    def size(self) -> int:
        """Points computed at a time."""

    @property
    def room(self) -> int:
        """Jobs it would take now."""

    def prepare(self, jobs: Sequence[Job]) -> list[Probe]:
        """Compile what these jobs need; what their first steps cost."""

    def add(self, job: Job) -> None:
        """Put a job into the queue."""

    def wait(self, seconds: float) -> Events[Job, Product]:
        """Wait until something happens, at most so long."""

    def close(self) -> None:
        """End all work; what is being computed is lost."""


@contextmanager
def locked(folder: Path) -> Iterator[None]:
    """Hold the sweep folder against other masters. Raises AeroSloshError where another holds it or it cannot be written."""
    path = folder / LOCK
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise unwritable(error, folder) from None
    try:
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            try:
                who = json.loads(os.pread(handle, 4096, 0))
                holder = f"process {who['pid']} on {who['host']} since {who['since']}"
            except (ValueError, KeyError, TypeError):
                holder = "another process"
            remedy = "wait until it has ended, or give another folder with --out"
            raise AeroSloshError(f"Another sweep is at work in this folder: {holder}", str(folder), remedy) from None
        since = datetime.datetime.now().astimezone().isoformat(timespec="seconds")
        text = json.dumps({"pid": os.getpid(), "host": platform.node(), "since": since})
        with contextlib.suppress(OSError):  # only what the message above says depends on it
            os.ftruncate(handle, 0)
            os.pwrite(handle, text.encode(), 0)
        yield
    finally:
        os.close(handle)


@dataclass
class Store:
    """The folder of a sweep with its ledger. `say` tells the user what was found and mended."""

    folder: Path
    ledger: Ledger
    say: Callable[[str], None]
    total: int = 0

    @classmethod
    def open(cls, folder: Path, say: Callable[[str], None]) -> Store:
        """The ledger of a folder that is locked; a damaged one is moved aside and replaced by an empty one."""
        path = folder / "ledger.sqlite"
        try:
            (folder / "points").mkdir(exist_ok=True)
            base_files.remove_parts(folder)
            base_files.remove_parts(folder / "points")
            try:
                return cls(folder, Ledger(path), say)
            except Damaged as damage:
                aside = move_aside(path)
                say(f"{damage.what}; moved to {aside.name}, a new one is made from the points' files")
                return cls(folder, Ledger(path), say)
        except OSError as error:
            raise unwritable(error, folder) from None

    def close(self) -> None:
        """Close the ledger."""
        self.ledger.close()

    def file(self, label: str) -> Path:
        """The netCDF file of a point."""
        return self.folder / "points" / f"{label}.nc"

    def enter(self, plan: Plan, versions: dict[str, str]) -> None:
        """Make the ledger that of `plan`: new points are entered as pending. Raises AeroSloshError where the folder holds points
        that are none of the plan's: naming what changed."""
        known, about = {row.id for row in self.ledger.rows()}, self.ledger.about()
        planned = {p.id for p in plan.points}
        strange = known - planned
        if not known:
            strange = {path.stem for path in self.folder.glob("points/*.nc")} - planned
        if strange:
            what = f"{len(strange)} of its {len(known) or len(strange)} points are no points of this case"
            remedy = "take the case and FMUs it began with (its case.toml holds the case), or start a new sweep with --out"
            raise AeroSloshError(f"The sweep changed: {what}{_changes(plan, about)}", str(self.folder), remedy)
        if known and len(planned) > len(known):
            self.say(f"{len(planned) - len(known)} points are new")
        old = {k: v for k, v in about.get("versions", {}).items() if versions.get(k) != v}
        if old:
            said = ", ".join(f"{k} {v} (now {versions.get(k)})" for k, v in old.items())
            self.say(f"note: earlier points were computed with {said}")
        self.total = len(plan.points)
        self.ledger.add(plan.points)
        self.ledger.describe(plan, versions)

    def mend(self) -> None:
        """Enter files whose row a kill left out; compute again what has no whole file."""
        adopted, broken = 0, []
        for row in self.ledger.rows():
            path = self.file(row.id)
            if row.status in ("done", "failed"):
                if not path.is_file() or _sha256(path) != row.sha256:
                    broken.append(row.id)
                    self.say(f"point {row.id}: its file is {'damaged' if path.is_file() else 'gone'}; it is computed again")
            elif path.is_file():
                try:
                    record = point_file.read(path)
                except AeroSloshError as error:
                    self.say(f"point {row.id}: {error.what}; it is computed again")
                    continue
                if record.id == row.id:
                    self.ledger.finish(record, path.name, _sha256(path))
                    adopted += 1
        self.ledger.reopen(broken)
        if adopted:
            self.say(f"{adopted} finished points entered from their files")

    def retry(self) -> int:
        """Failed points are to be computed again, their files go; returns how many."""
        failed = [row.id for row in self.ledger.rows("failed")]
        self.ledger.reopen(failed)
        for label in failed:
            self.file(label).unlink(missing_ok=True)
        return len(failed)

    def keep(self, product: Product) -> None:
        """Put a product onto the disk: its file, then its row. Raises OSError, AeroSloshError."""
        path = self.file(product.record.id)
        base_files.write(path, product.netcdf)
        self.ledger.finish(product.record, path.name, hashlib.sha256(product.netcdf).hexdigest())

    def left(self, plan: Plan) -> list[Job]:
        """Jobs of the points not finished, in the plan's order."""
        rows = {row.id: row for row in self.ledger.rows("pending", "running")}
        return [Job(p.id, plan.kind, p.case, p.overrides, p.files, rows[p.id].attempts + 1) for p in plan.points if p.id in rows]

    def write(self, name: str, content: bytes) -> None:
        """Another file of the folder. Raises AeroSloshError."""
        try:
            base_files.write(self.folder / name, content)
        except OSError as error:
            raise _explained(error, self) from None


def begun(folder: Path) -> bool:
    """Whether there is a sweep in the folder."""
    return (folder / "ledger.sqlite").exists() or (folder / "points").is_dir()


def log(folder: Path, text: str) -> None:
    """A line in sweep.log; a full disk must not keep the user from reading it elsewhere."""
    stamp = datetime.datetime.now().isoformat(timespec="milliseconds")
    with contextlib.suppress(OSError), (folder / "sweep.log").open("a", encoding="utf-8") as file:
        file.write(f"{stamp}  {text}\n")


def run(
    plan: Plan,
    store: Store,
    pool: Pool,
    command: str,
    on_change: Callable[[dict[str, int]], None] = lambda counts: None,
    on_product: Callable[[Product], None] = lambda product: None,
) -> None:
    """Compute every point that is not finished. Raises AeroSloshError (INCOMPLETE when the disk is full)."""
    waiting = [dataclasses.replace(job, command=command) for job in store.left(plan)]
    tries = dict.fromkeys((job.id for job in waiting), 1)
    waiting.reverse()
    counts = store.ledger.counts()
    open_points = counts["pending"] = counts.pop("running") + counts["pending"]
    on_change(counts)
    try:
        while open_points:
            while waiting and pool.room > 0:
                pool.add(waiting.pop())
            events = pool.wait(1.0)
            for text in events.notes:
                store.say(text)
            if events.started:
                store.ledger.start([(j.id, worker) for j, worker in events.started])
            for lost, cause in events.lost:
                if tries[lost.id] < TRIES:
                    tries[lost.id] += 1
                    waiting.append(dataclasses.replace(lost, attempt=lost.attempt + 1))
                else:
                    head, _, words = cause.partition("\n")
                    events.products.append(jobs.failed(lost, f"{head} twice", words))
            for product in events.products:
                store.keep(product)
                open_points -= 1
                counts["pending"] -= 1
                counts[product.record.status] += 1
                on_product(product)
            on_change(counts)
    except OSError as error:
        raise _explained(error, store) from None
    except AeroSloshError as error:
        raise incomplete(error.what, error.remedy, store, error.code) from None


def incomplete(why: str, remedy: str, store: Store, code: ExitCode = ExitCode.INCOMPLETE) -> AeroSloshError:
    """What a user is told of a sweep that cannot go on."""
    kept = sum(1 for _ in store.folder.glob("points/*.nc"))
    remedy = remedy if "--resume" in remedy else f"{remedy}, then go on with --resume"
    return AeroSloshError(f"{why}: {kept} of {store.total} points are finished and kept", str(store.folder), remedy, code)


def unwritable(error: OSError, folder: Path) -> AeroSloshError:
    """What a user is told of a folder in which nothing can be begun."""
    return AeroSloshError(f"The sweep folder cannot be written: {error.strerror}", str(folder), "give another with --out")


def _explained(error: OSError, store: Store) -> AeroSloshError:
    """What a user is told when a file of the sweep cannot be written."""
    if error.errno in FULL:
        return incomplete(f"The disk is full ({error.strerror})", "free space", store)
    return incomplete(f"The sweep folder cannot be written: {error.strerror}", "make it writable", store)


def _changes(plan: Plan, about: dict[str, dict[str, str]]) -> str:
    """Which keys and FMUs differ from those noted in the ledger, as `: key old → new, …`; empty when none is known to."""
    said = []
    for what in ("base", "fmus"):
        old, new = about.get(what, {}), getattr(plan, what)
        for name in sorted(old.keys() | new.keys()):
            if name in old and name in new and old[name] != new[name]:
                said.append(f"{name} {old[name]} → {new[name]}" if what == "base" else f"{name}.fmu is another")
    if about and not said:
        said.append("sweep.parameters (or seed, samples) leave out points that it has")
    return f" ({', '.join(said)})" if said else ""


def _sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
