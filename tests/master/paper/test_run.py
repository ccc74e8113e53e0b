"""Figures one after the other: resume, failure of one, interrupts, the table, the command's words and exit codes."""

from __future__ import annotations

import csv
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.paper import outcome, run
from aeroslosh.master.paper.catalogue import FIGURES
from aeroslosh.master.paper.claims import at_most
from aeroslosh.master.paper.outcome import Outcome, Table
from aeroslosh.master.paper.work import MODELS, Work
from aeroslosh.master.pictures import canvas
from support.processes import called

NAMES = ["fig8", "fig10", "fig11"]


def blank() -> Any:
    """A picture."""
    figure, axis = canvas.subplots()
    axis.plot([0, 1], [0, 1])
    return figure


def made(value: float = 1.0) -> Outcome:
    """An outcome whose one claim is that the value is at most 1."""
    return Outcome(
        [at_most("value", "here", 1.0, value)], ["a condition"], {"data": Table(("x", "y"), [(1, value)])}, blank, ["a remark"]
    )


class Makers:
    """Counts what is computed; names in `wrong` raise."""

    def __init__(self, wrong: dict[str, BaseException] | None = None, value: float = 1.0) -> None:
        self.made: list[str] = []
        self.wrong, self.value = wrong or {}, value

    def __call__(self, name: str) -> Callable[[Work], Outcome]:
        def make(work: Work) -> Outcome:
            if name in self.wrong:
                raise self.wrong[name]
            self.made.append(name)
            return made(self.value)

        return make


@pytest.fixture
def work(tmp_path: Path) -> Work:
    """A folder, and one for FMUs that no figure here opens."""
    (tmp_path / "fmus").mkdir()
    return Work(tmp_path / "out", tmp_path / "fmus")


def test_a_finished_figure_is_kept_and_another_is_computed(work: Work) -> None:
    first, second = Makers(), Makers()
    run.run(work, NAMES[:1], first)
    rows = run.run(work, NAMES, second)
    assert first.made == NAMES[:1] and second.made == NAMES[1:]
    assert [row.kept for row in rows] == [True, False, False] and {row.word for row in rows} == {"agrees"}
    work.fresh = True
    run.run(work, NAMES, again := Makers())
    assert again.made == NAMES


def test_another_size_other_fmus_or_another_master_are_computed_anew(work: Work, monkeypatch: pytest.MonkeyPatch) -> None:
    run.run(work, NAMES[:1], Makers())
    work.small = True
    run.run(work, NAMES[:1], small := Makers())
    (work.fmus / f"{MODELS[0]}.fmu").write_bytes(b"another")
    run.run(work, NAMES[:1], other := Makers())
    monkeypatch.setattr("aeroslosh.master.paper.work.source_hash", lambda: "another" * 10)
    run.run(work, NAMES[:1], changed := Makers())
    assert small.made == other.made == changed.made == NAMES[:1]


def test_a_figure_with_a_file_missing_is_computed_anew(work: Work) -> None:
    run.run(work, NAMES[:1], Makers())
    (work.out / NAMES[0] / "data.csv").unlink()
    run.run(work, NAMES[:1], again := Makers())
    assert again.made == NAMES[:1] and (work.out / NAMES[0] / "data.csv").read_text() == "x,y\n1,1\n"


def test_one_that_fails_does_not_stop_the_others_and_makes_the_command_incomplete(work: Work) -> None:
    wrong = {"fig10": AeroSloshError("no flow", "there"), "fig8": ZeroDivisionError("ours")}
    rows = run.run(work, NAMES, Makers(wrong))
    assert [row.word for row in rows] == ["failed", "failed", "agrees"]
    assert "ZeroDivisionError" in rows[0].cause and "no flow" in rows[1].cause
    assert run.exit_code(rows) == ExitCode.INCOMPLETE and run.exit_code(rows[2:]) == ExitCode.OK
    assert "failed: no flow" in run.table(rows) and "2 failed, 1 agrees" in run.table(rows)
    assert not (work.out / "fig10").exists()
    again = run.run(work, NAMES, later := Makers())
    assert later.made == NAMES[:2] and run.exit_code(again) == ExitCode.OK


def test_a_figure_that_differs_is_a_result(work: Work) -> None:
    rows = run.run(work, NAMES[:1], Makers(value=2.0))
    assert rows[0].verdict == "differs: value: 2, paper at most 1" and run.exit_code(rows) == ExitCode.OK


def test_an_interrupt_keeps_what_is_done_and_says_how_much(work: Work) -> None:
    with pytest.raises(KeyboardInterrupt) as stop:
        run.run(work, NAMES, Makers({"fig11": KeyboardInterrupt()}))
    assert "2 of 3 figures are finished" in "".join(stop.value.__notes__)
    assert outcome.read(work.out / "fig10") is not None and "fig10" in (work.out / "paper.md").read_text()
    assert [path.name for path in work.out.glob(".*")] == []
    run.run(work, NAMES, later := Makers())
    assert later.made == ["fig11"]


def test_a_picture_that_fails_leaves_nothing_half(work: Work) -> None:
    bad = made()
    bad.draw = lambda: 1 / 0  # type: ignore[assignment, return-value]
    with pytest.raises(ZeroDivisionError):
        bad.write(work.out / "fig8", {})
    assert list(work.out.glob("*")) == [] == list(work.out.glob(".*"))


def test_tables_and_index_hold_what_was_found(work: Work) -> None:
    rows = run.run(work, NAMES[:2], Makers(value=2.0))
    run.write(work.out, rows[:1], work.key)  # the other one is there from before
    with (work.out / "paper.csv").open() as stream:
        told = list(csv.DictReader(stream))
    assert [row["figure"] for row in told] == NAMES[:2] and told[0]["verdict"] == rows[0].verdict
    assert json.loads((work.out / "paper.json").read_text())["figures"][1]["verdict"] == rows[1].verdict
    index = (work.out / "paper.md").read_text()
    assert "| value | here | at most 1 | 2 | differs |" in index and "a condition" in index and "a remark" in index
    assert "![" in index and (work.out / "fig8" / "picture.png").stat().st_size > 1000


def test_what_figures_share_is_computed_once_and_again_when_fresh(work: Work) -> None:
    asked: list[int] = []

    def compute() -> list[float]:
        asked.append(1)
        return [1.5]

    assert work.shared("one", compute) == work.shared("one", compute) == [1.5] and len(asked) == 1
    later = Work(work.out, work.fmus, fresh=True)
    assert later.shared("one", compute) == later.shared("one", compute) == [1.5] and len(asked) == 2


def test_names_are_checked_and_come_in_the_papers_order() -> None:
    assert run.chosen(["fig11", "fig8"], False) == ["fig8", "fig11"] and run.chosen([], True) == list(FIGURES)
    with pytest.raises(AeroSloshError, match="no figure 'fig9'"):
        run.chosen(["fig9"], False)
    with pytest.raises(AeroSloshError, match="No figure is named"):
        run.chosen([], False)


def test_every_figure_has_its_module() -> None:
    assert all(callable(run.make_of(name)) for name in FIGURES)
    assert {f"fig{n}" for n in (8, *range(10, 26))} | {"table1"} <= set(FIGURES)


def test_the_command_lists_refuses_computes_and_keeps(tmp_path: Path, flutter_fmus: Path) -> None:
    words = ["paper", "--fmus", flutter_fmus, "--out", tmp_path / "p"]
    assert called("paper", "--list").stdout.split()[0] == "fig8" and "table1" in called("paper", "--list").stdout
    assert json.loads(called("paper", "--list", "--json").stdout) == FIGURES
    assert called(*words, "fig9").returncode == ExitCode.INPUT and called(*words).returncode == ExitCode.INPUT
    assert called(*words, "fig18", "--workers", "0").returncode == ExitCode.INPUT and not (tmp_path / "p").exists()
    done = called(*words, "fig18", "fig19")
    assert done.returncode == ExitCode.OK and "2 differs" in done.stdout and (tmp_path / "p" / "paper.csv").is_file()
    told = json.loads(called(*words, "fig18", "--json").stdout)
    assert told["figures"][0]["computed_before"] is True
    failed = called(*words, "fig19", "fig23", "--json")  # there is no slosh_vof.fmu in that folder
    assert failed.returncode == ExitCode.INCOMPLETE
    assert [bool(row["failed"]) for row in json.loads(failed.stdout)["figures"]] == [False, True]
