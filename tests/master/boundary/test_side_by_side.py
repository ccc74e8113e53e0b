"""A boundary by several processes: the numbers, files and lines of one; what is kept when one of them or all of it is ended."""

from __future__ import annotations

import json
import os
import pickle
import re
import signal
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from scipy.io import netcdf_file

import aeroslosh as ae
from aeroslosh.master.api import side_by_side
from aeroslosh.master.base.errors import AeroSloshError, ComponentError, InternalError
from aeroslosh.master.boundary.search import BoundaryPoint
from aeroslosh.master.sweeps.one_mach import MachJob, Solved
from aeroslosh.master.sweeps.workers import Events
from support.paths import CASES
from support.processes import COMMAND, Done, called, started, until
from support.swept import alive, children, without_cost

MACHS = ("0.3", "0.35", "0.4")
FEW = ("--set", "boundary.tolerance=0.03", "--set", "boundary.V_f_range=[1.0, 4.0]", "--set", "flutter.steps_per_cycle=72")
# fails in the sweeps, which take 700 steps, and in no march: there is no linear model, and marches begin at the neighbour's V_f
NO_MODEL = (
    "--no-pictures",
    "--set",
    "flow.airfoil=FAIL 500",
    "--set",
    "flutter.free_cycles=4.0",
    "--set",
    "flutter.forced_cycles=1.0",
)
LONG = (*FEW, "--set", "flutter.steps_per_cycle=900", "--no-pictures", "--workers", "2")


def boundary(out: Path, fmus: Path, *more: str) -> Done:
    """The command in this process; its workers have their own."""
    return called(*words(out, fmus, *more))


def words(out: Path, fmus: Path, *more: str) -> list[str]:
    """The command line, without the program."""
    return ["boundary", str(CASES / "isogai_a.toml"), "--out", str(out), "--fmus", str(fmus), "--mach", *MACHS, *more]


def result(out: Path) -> dict[str, Any]:
    """result.json."""
    return dict(json.loads((out / "result.json").read_text()))


def left(out: Path) -> dict[str, Any]:
    """All that a boundary left: files, numbers, histories bit by bit, lines of the log without times."""
    found: dict[str, Any] = {path.name: None for path in out.iterdir()}
    found["result.json"] = without_cost(result(out)) | {"provenance": None}
    for path in out.glob("*.nc"):
        with netcdf_file(str(path), "r", mmap=False) as file:
            found[path.name] = {name: np.array(v[:]).tobytes() for name, v in file.variables.items()}
    found |= {path.name: path.read_bytes() for path in out.glob("*.csv")}
    found["run.log"] = timeless((out / "run.log").read_text())
    return found


def timeless(text: str) -> list[str]:
    """Lines without dates and seconds, and without what follows from where they were computed: the double whose copy of a shared
    module a process loaded first stands in a traceback."""
    apart = "cost  ", "run folder", '  File "'
    lines = [line for line in text.splitlines() if not any(word in line for word in apart)]
    return [re.sub(r"^\d{4}-\S+ +|,? +[\d.]+ s$", "", line) for line in lines]


@pytest.mark.parametrize(
    "more", [("--no-pictures",), NO_MODEL, ("--method", "linear")], ids=["both", "no linear model", "linear"]
)
def test_any_number_of_workers_leaves_the_same(flutter_fmus: Path, tmp_path: Path, more: tuple[str, ...]) -> None:
    """Numbers, files and the order of lines; on the terminal too. Without a linear model a search begins where its neighbour
    crossed."""
    done = [boundary(tmp_path / n, flutter_fmus, *FEW, *more, "--workers", n) for n in ("1", "2")]
    assert done[0].returncode == done[1].returncode == 0, done
    one, two = left(tmp_path / "1"), left(tmp_path / "2")
    assert one.keys() == two.keys()
    for name in one:
        assert one[name] == two[name], name
    assert timeless(done[0].stdout) == timeless(done[1].stdout)
    told = [[line for line in timeless(d.stderr) if not re.match(" +(M 0|Mach numbers)", line)] for d in done]
    assert told[0] == told[1]


def test_a_component_that_fails_is_the_outcome_of_its_mach_number(flutter_fmus: Path, tmp_path: Path) -> None:
    done = boundary(tmp_path / "b", flutter_fmus, *FEW, "--set", "flow.airfoil=FAIL 30", "--workers", "2")
    points = result(tmp_path / "b")["points"]
    assert done.returncode == 3 and [p["mach"] for p in points] == [0.3, 0.35, 0.4]
    assert all("told to fail" in p["outcome"] for p in points) and "| Traceback" in done.stderr
    assert result(tmp_path / "b")["unfinished"] == []


def test_a_killed_worker_costs_nothing_but_time(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "b"
    with started([*COMMAND, *words(out, flutter_fmus, *LONG)]) as process:
        assert process.stderr is not None
        until(lambda: "step" in process.stderr.readline() or " of " in process.stderr.readline())  # type: ignore[union-attr]
        os.kill(children(process.pid)[0], signal.SIGKILL)
        _, said = process.communicate(timeout=120)
    assert process.returncode == 0 and "worker ended by signal 9 (SIGKILL) while it computed Mach" in said, said
    assert [p["mach"] for p in result(out)["points"]] == [0.3, 0.35, 0.4] and result(out)["unfinished"] == []
    assert all(p["converged"] for p in result(out)["points"])


def test_interrupted_it_keeps_what_is_finished_and_ends_its_workers(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "b"
    with started([*COMMAND, *words(out, flutter_fmus, *LONG, "--quiet")]) as process:
        until(lambda: (out / "result.json").exists())
        workers = children(process.pid)
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    data = result(out)
    done = [p["mach"] for p in data["points"] if not p["outcome"].startswith("interrupted")]
    assert process.returncode == 130 and "Traceback" not in said, said
    assert done and sorted(done + data["unfinished"]) == [0.3, 0.35, 0.4] and data["unfinished"]
    assert f"{len(done)} of 3 Mach numbers are finished and kept; the others: --mach" in said
    assert workers and not any(map(alive, workers)) and not list(tmp_path.rglob(".*"))
    for p in data["points"]:
        assert len(list(out.glob(f"history_M{p['mach']:g}_*.nc"))) == len({round(m["V_f"], 4) for m in p["marches"]})


def test_a_callback_hears_of_every_mach_number_and_cancels(flutter_fmus: Path) -> None:
    case = ae.Case.isogai_a().replace(
        boundary={"V_f_range": [1.0, 4.0], "tolerance": 0.03, "companion": False},
        flutter={"steps_per_cycle": 72, "free_cycles": 30.0},
    )
    heard: list[ae.Update] = []
    whole = ae.boundary(case, mach=[0.3, 0.35, 0.4], fmus=flutter_fmus, workers=2, progress=heard.append)
    assert whole.finished and {u.label.partition(" V_f")[0] for u in heard} >= {"M 0.3", "M 0.35", "M 0.4", "Mach numbers"}
    assert [u.done for u in heard if u.label == "Mach numbers"] == [1, 2, 3]
    texts = [u.text for u in heard if u.text.startswith(("steady", "Mach"))]
    assert [t.split(":")[0] for t in texts] == [f"{w} {m}" for m in (0.3, 0.35, 0.4) for w in ("steady flow at Mach", "Mach")]
    cut = ae.boundary(
        case, mach=[0.3, 0.35, 0.4], fmus=flutter_fmus, workers=2, progress=lambda update: update.label != "Mach numbers"
    )
    assert len(cut.crossings) == 1 and len(cut.data["unfinished"]) == 2 and not cut.finished


class Scripted:
    """A pool whose workers die over the second Mach number, and that finishes the third before the first."""

    def __init__(self, *_: object) -> None:
        self.given: list[MachJob] = []
        self.answers: Iterator[Events[MachJob, Solved]] = self._play()

    def add(self, job: MachJob) -> None:
        self.given.append(job)

    def wait(self, seconds: float) -> Events[MachJob, Solved]:
        return next(self.answers)

    def close(self) -> None:
        pass

    def _play(self) -> Iterator[Events[MachJob, Solved]]:
        first, second, third = self.given
        yield Events(started=[(second, "a"), (third, "b")])
        yield Events(told=[(second, ("begin",)), (third, ("begin",))])
        yield Events(told=[(second, ("say", "of the second")), (third, ("say", "of the third"))])
        yield Events(products=[Solved(2, BoundaryPoint(third.mach, [], [], "done", True), 11, 2.0)])
        yield Events(lost=[(second, "worker ended by signal 9 (SIGKILL)\nits last words")])
        yield Events(told=[(second, ("begin",)), (second, ("say", "of the second"))])
        yield Events(lost=[(second, "worker ended by signal 9 (SIGKILL)\nits last words")])
        yield Events(told=[(first, ("begin",)), (first, ("say", "of the first"))])
        yield Events(products=[Solved(0, None, 12, 1.0)])  # wants to know where to start, and is told: nothing is before it
        assert self.given[-1].position == 0 and self.given[-1].start is not None
        yield Events(told=[(first, ("begin",)), (first, ("say", "of the first")), (first, ("say", "more of it"))])
        yield Events(products=[Solved(0, BoundaryPoint(first.mach, [], [], "done", True), 12, 3.0)])


def test_what_is_said_keeps_the_order_and_is_said_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """A worker's death twice is the outcome of its Mach number; a point is kept when it is done, told when it is its turn."""
    monkeypatch.setattr(side_by_side, "LocalPool", mock.MagicMock(__getitem__=lambda *_: Scripted))
    case = ae.Case.isogai_a().changed({"boundary.mach": [0.3, 0.35, 0.4]}).core
    said, kept, spent = list[str](), list[BoundaryPoint](), dict[int, float]()
    heard = side_by_side.Listener(
        said.append,
        lambda *_: None,
        lambda *_: None,
        kept.append,
        lambda p: said.append(p.outcome),
        lambda *_: None,
        spent.__setitem__,
    )
    points = side_by_side.SideBySide(case, {}, 2, heard, lambda place: None).run()
    assert [p.mach for p in points] == [0.3, 0.35, 0.4] and [p.mach for p in kept] == [0.4, 0.35, 0.3]
    failure = points[1].failure
    assert failure is not None and failure.code == 5 and "--mach 0.35" in failure.remedy and failure.traceback == "its last words"
    death = "failed: worker ended by signal 9 (SIGKILL) twice"
    assert said == ["of the first", "more of it", "done", "of the second", death, "of the third", "done"]
    assert spent == {11: 2.0, 12: 3.0}


@pytest.mark.parametrize("workers", ["0", "-1"])
def test_no_workers_are_refused(flutter_fmus: Path, tmp_path: Path, workers: str) -> None:
    done = boundary(tmp_path / "b", flutter_fmus, "--workers", workers)
    assert done.returncode == 2 and f"--workers {workers}" in done.stderr and "at least 1" in done.stderr
    with pytest.raises(AeroSloshError, match=r"workers = 1\.5"):
        ae.boundary("isogai_a", fmus=flutter_fmus, workers=1.5)  # type: ignore[arg-type]
    assert not list(tmp_path.iterdir())


def test_errors_travel_between_processes_whole() -> None:
    try:
        raise ZeroDivisionError("by nothing")
    except ZeroDivisionError as fault:
        errors: list[AeroSloshError] = [
            AeroSloshError("what", "where", "remedy"), ComponentError("what", "where", "remedy", "aero", 0.5, "trace"),
            InternalError(fault, "Mach 0.3"),
        ]  # fmt: skip
    for error in errors:
        error.add_note("a note")
        again = pickle.loads(pickle.dumps(error))
        assert type(again) is type(error) and str(again) == str(error) and vars(again) == vars(error)
