"""The ledger and the folder of a sweep: nothing finished is lost or computed twice, damage is found and mended."""

from __future__ import annotations

import json
import multiprocessing
import sqlite3
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.io import netcdf_file

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case.case import Case
from aeroslosh.master.results import point_file
from aeroslosh.master.results.point_file import Record
from aeroslosh.master.sweeps import sweep
from aeroslosh.master.sweeps.jobs import Job, Product, failed
from aeroslosh.master.sweeps.ledger import Damaged, Ledger
from aeroslosh.master.sweeps.plan import Plan, Point
from aeroslosh.master.sweeps.sweep import Store

VERSIONS = {"numpy": "2"}


def made(n: int, fill: str = "0.5") -> Plan:
    """A plan of `n` points."""
    points = tuple(Point(f"{i:016x}", i, {"flutter.V_f": 0.1 * i + 0.1}, Case(), {}) for i in range(n))
    return Plan("point", "grid", ("flutter.V_f",), points, {"slosh.fill_level": fill}, {"aero": "a" * 64}, 0)


def product(point: Point, attempt: int = 1) -> Product:
    """A finished point without a history."""
    record = Record(
        point.id, "point", point.overrides, "done", True, {"growth_rate": 1.0 / 3.0}, "", "", attempt, "w", 1.0, 2.0, 3.0, 4.0
    )
    return Product(record, point_file.pack(record, [], {"date": "today"}))


def opened(folder: Path, plan: Plan, said: list[str] | None = None) -> Store:
    """The store of a folder, with the plan entered and mended."""
    folder.mkdir(exist_ok=True)
    store = Store.open(folder, (said if said is not None else []).append)
    store.enter(plan, VERSIONS)
    store.mend()
    return store


@pytest.fixture
def half_done(tmp_path: Path) -> tuple[Path, Plan]:
    """A folder of 40 points, 20 of them finished."""
    plan, folder = made(40), tmp_path / "sweep"
    store = opened(folder, plan)
    for point in plan.points[:20]:
        store.ledger.start([(point.id, "w")])
        store.keep(product(point))
    store.close()
    return folder, plan


def test_what_is_kept_comes_back(half_done: tuple[Path, Plan]) -> None:
    folder, plan = half_done
    store = opened(folder, plan)
    assert store.ledger.counts() == {"pending": 20, "running": 0, "done": 20, "failed": 0}
    row = store.ledger.rows("done")[3]
    assert row.result == {"growth_rate": 1.0 / 3.0} and row.overrides == plan.points[3].overrides
    assert row.attempts == 1 and row.determined and point_file.read(folder / "points" / row.file).result == row.result
    assert [job.id for job in store.left(plan)] == [p.id for p in plan.points[20:]]


def test_a_point_that_was_running_is_pending_with_its_attempts(half_done: tuple[Path, Plan]) -> None:
    folder, plan = half_done
    store = opened(folder, plan)
    store.ledger.start([(plan.points[20].id, "w")])
    store.close()
    first, second = opened(folder, plan).left(plan)[:2]
    assert (first.attempt, second.attempt) == (2, 1)


def test_a_file_whose_row_was_not_written_is_entered(half_done: tuple[Path, Plan]) -> None:
    """A kill between the rename and the row."""
    folder, plan = half_done
    (folder / "points" / f"{plan.points[20].id}.nc").write_bytes(product(plan.points[20]).netcdf)
    (folder / "points" / f".{plan.points[21].id}.nc.part-1").write_bytes(b"half")
    said: list[str] = []
    store = opened(folder, plan, said)
    assert store.ledger.counts()["done"] == 21 and store.ledger.rows("done")[-1].attempts == 1
    assert said == ["1 finished points entered from their files"] and not list(folder.rglob(".*part*"))


def test_a_reader_never_sees_half_a_new_ledger(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every statement of the making is a moment at which another program may look: the file has its tables, or is not there."""
    path = tmp_path / "ledger.sqlite"
    seen: list[str] = []

    def look(statement: str) -> None:
        if not path.exists():
            return seen.append("nothing")
        tables = {name for (name,) in real(path).execute("SELECT name FROM sqlite_master")}
        return seen.append("whole" if {"meta", "points"} <= tables else "half")

    real = sqlite3.connect

    def watched(*words: Any, **options: Any) -> sqlite3.Connection:
        base = real(*words, **options)
        if options:  # the ledger's own connections
            base.set_trace_callback(look)
        return base

    monkeypatch.setattr(sqlite3, "connect", watched)
    Ledger(path).close()
    assert set(seen) == {"nothing", "whole"} and [p.name for p in tmp_path.iterdir()] == ["ledger.sqlite"]


@pytest.mark.parametrize("damage", ["page", "head", "row", "cut", "empty"])
def test_a_damaged_ledger_is_moved_aside_and_made_anew(half_done: tuple[Path, Plan], damage: str) -> None:
    folder, plan = half_done
    path = folder / "ledger.sqlite"
    content = bytearray(path.read_bytes())
    assert len(content) >= 5 * 4096
    if damage == "page":
        content[3 * 4096 : 4 * 4096] = np.random.default_rng(1).bytes(4096)
    elif damage == "head":
        content[:16] = b"no database here"
    elif damage == "row":  # a digit of a result: the pages are sound
        place = content.rindex(b"0.333333333333333")
        content[place + 2] = ord("4")
    elif damage == "cut":
        content = content[: 2 * 4096 + 100]
    path.write_bytes(content if damage != "empty" else b"")
    said: list[str] = []
    store = opened(folder, plan, said)
    assert store.ledger.counts()["done"] == 20
    assert {row.attempts for row in store.ledger.rows("done")} == {1}
    if damage != "empty":  # SQLite takes a file of no bytes for a new one
        assert (folder / "ledger.corrupt-001.sqlite").read_bytes() == bytes(content)
        assert "ledger is damaged" in said[0] and "ledger.corrupt-001.sqlite" in said[0]
    assert "20 finished points entered" in said[-1]


@pytest.mark.parametrize("damage", ["bit", "cut", "gone"])
def test_a_damaged_point_is_computed_again_and_no_other(half_done: tuple[Path, Plan], damage: str) -> None:
    folder, plan = half_done
    path = folder / "points" / f"{plan.points[7].id}.nc"
    content = bytearray(path.read_bytes())
    content[len(content) // 2] ^= 1
    if damage == "gone":
        path.unlink()
    else:
        path.write_bytes(content if damage == "bit" else content[:-50])
    said: list[str] = []
    store = opened(folder, plan, said)
    assert [job.id for job in store.left(plan)] == [plan.points[i].id for i in (7, *range(20, 40))]
    assert store.left(plan)[0].attempt == 2
    assert plan.points[7].id in said[0] and "computed again" in said[0]


def test_a_damaged_point_without_a_row_is_not_entered(half_done: tuple[Path, Plan]) -> None:
    folder, plan = half_done
    (folder / "ledger.sqlite").unlink()
    path = folder / "points" / f"{plan.points[7].id}.nc"
    path.write_bytes(path.read_bytes().replace(b"0.333333333333333", b"0.433333333333333"))
    said: list[str] = []
    assert opened(folder, plan, said).ledger.counts()["done"] == 19
    assert "wrong checksum" in said[0]


def test_a_checksum_covers_the_histories(tmp_path: Path) -> None:
    (tmp_path / "a.nc").write_bytes(product(made(1).points[0]).netcdf)
    with netcdf_file(str(tmp_path / "a.nc"), "a") as file:
        file.createDimension("time", 3)
        file.createVariable("alpha", "f8", ("time",))[:] = 1.0
    with pytest.raises(AeroSloshError, match="checksum"):
        point_file.read(tmp_path / "a.nc")


def test_a_changed_case_is_refused_by_name_and_more_points_are_welcome(half_done: tuple[Path, Plan]) -> None:
    folder, plan = half_done
    other = Plan(
        "point", "grid", plan.names, (Point("f" * 16, 0, {}, Case(), {}),), {"slosh.fill_level": "0.6"}, {"aero": "b"}, 0
    )
    with pytest.raises(AeroSloshError) as caught:
        opened(folder, other)
    assert "slosh.fill_level 0.5 → 0.6" in str(caught.value) and "aero.fmu is another" in str(caught.value)
    with pytest.raises(AeroSloshError, match=r"sweep\.parameters"):
        opened(folder, made(30))
    said: list[str] = []
    store = opened(folder, made(50), said)
    assert said == ["10 points are new"] and store.ledger.counts() == {"pending": 30, "running": 0, "done": 20, "failed": 0}


def test_failed_points_are_data_until_they_are_retried(tmp_path: Path) -> None:
    plan = made(3)
    store = opened(tmp_path / "sweep", plan)
    point = plan.points[1]
    store.ledger.start([(point.id, "w")])
    store.keep(failed(Job(point.id, "point", Case(), point.overrides, {}), "worker ended by signal 9 twice", "w"))
    row = store.ledger.rows("failed")[0]
    assert row.cause == "worker ended by signal 9 twice" and point_file.read(store.file(point.id)).cause == row.cause
    store.close()
    store = opened(tmp_path / "sweep", plan)
    assert len(store.left(plan)) == 2
    assert store.retry() == 1 and len(store.left(plan)) == 3 and store.left(plan)[1].attempt == 2
    store.close()
    assert len(opened(tmp_path / "sweep", plan).left(plan)) == 3  # a kill does not take the wish back


def test_a_full_disk_leaves_the_ledger_as_it_was(half_done: tuple[Path, Plan]) -> None:
    folder, plan = half_done
    store = opened(folder, plan)
    base: sqlite3.Connection = store.ledger._base
    base.execute(f"PRAGMA max_page_count = {base.execute('PRAGMA page_count').fetchone()[0]}")
    finished = 20
    with pytest.raises(AeroSloshError) as caught:
        for point in plan.points[20:]:
            store.keep(product(point))
            finished += 1
    assert caught.value.code == ExitCode.INCOMPLETE and "full" in str(caught.value)
    store.close()
    assert opened(folder, plan).ledger.counts()["done"] == finished + 1  # the last one's file was there before its row


def _hold(folder: Path, pipe: object) -> None:
    with sweep.locked(folder):
        pipe.send("held")  # type: ignore[attr-defined]
        pipe.recv()  # type: ignore[attr-defined]


def test_a_second_master_is_refused_and_told_who_is_there(tmp_path: Path) -> None:
    ours, theirs = multiprocessing.Pipe()
    other = multiprocessing.get_context("fork").Process(target=_hold, args=(tmp_path, theirs))
    other.start()
    assert ours.recv() == "held"
    with pytest.raises(AeroSloshError) as caught, sweep.locked(tmp_path):
        pass
    assert f"process {other.pid} on " in str(caught.value) and caught.value.code == ExitCode.INPUT
    assert json.loads((tmp_path / "ledger.lock").read_text())["pid"] == other.pid
    other.kill()  # a killed master holds nothing
    other.join()
    with sweep.locked(tmp_path):
        pass


def test_another_format_is_refused(tmp_path: Path) -> None:
    Ledger(tmp_path / "ledger.sqlite").close()
    base = sqlite3.connect(tmp_path / "ledger.sqlite")
    base.execute("UPDATE meta SET value = '99' WHERE key = 'format'")
    base.commit()
    with pytest.raises(AeroSloshError, match="format 99") as caught:
        Ledger(tmp_path / "ledger.sqlite")
    assert not isinstance(caught.value, Damaged) and (tmp_path / "ledger.sqlite").exists()
