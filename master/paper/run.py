"""Runs figures one after the other: what is finished is not computed again, one that fails does not stop the others."""

from __future__ import annotations

import csv
import importlib
import io
import json
import time
import traceback
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ..base import files
from ..base.errors import AeroSloshError, ExitCode
from .catalogue import FIGURES
from .outcome import read
from .work import Work, cpu_seconds

Make = Callable[[Work], Any]


@dataclass(frozen=True)
class Row:
    """What became of a figure: `verdict` as in claims.verdict, empty where it failed (`cause`); seconds of wall and CPU, those of
    the run that computed it; `kept`: computed by an earlier command."""

    figure: str
    verdict: str
    seconds: float
    cpu_seconds: float
    kept: bool = False
    cause: str = ""

    @property
    def word(self) -> str:
        """One word for tables."""
        return "failed" if self.cause else self.verdict.partition(":")[0]


def chosen(names: Sequence[str], everything: bool) -> list[str]:
    """The figures asked for, in the paper's order. Raises AeroSloshError for an unknown one and where none is asked for."""
    unknown = [name for name in names if name not in FIGURES]
    if unknown:
        raise AeroSloshError(f"There is no figure '{unknown[0]}'", "command line", f"one of {', '.join(FIGURES)}, or --all")
    if not names and not everything:
        raise AeroSloshError("No figure is named", "command line", "name some (aeroslosh paper --list), or give --all")
    return [name for name in FIGURES if everything or name in names]


def make_of(name: str) -> Make:
    """The function of a figure's module."""
    return importlib.import_module(f".{name}", __package__).make


def run(work: Work, names: Sequence[str], make: Callable[[str], Make] = make_of) -> list[Row]:
    """Compute those figures that `work.out` does not hold yet; the index is written after each of them.

    Raises KeyboardInterrupt with what is finished kept and told, OSError where the folder cannot be written."""
    work.out.mkdir(parents=True, exist_ok=True)
    rows: list[Row] = []
    key = work.key
    try:
        for name in names:
            rows.append(_one(work, name, key, make))
            index(work.out, key)
    except KeyboardInterrupt as stop:
        done = [row.figure for row in rows if not row.cause]
        stop.add_note(f"{len(done)} of {len(names)} figures are finished and kept in {work.out}; the same command goes on")
        raise
    return rows


def _one(work: Work, name: str, key: dict[str, Any], make: Callable[[str], Make]) -> Row:
    target = work.out / name
    found = None if work.fresh else read(target)
    if found is not None and found.get("key") == key:
        work.say(f"{name}: {found['verdict'].partition(':')[0]} (computed before)")
        return Row(name, found["verdict"], found["seconds"], found["cpu_seconds"], kept=True)
    work.say(f"{name}: {FIGURES[name]}")
    begin, cpu = time.perf_counter(), cpu_seconds()
    try:
        outcome = make(name)(work)
        spent = time.perf_counter() - begin, cpu_seconds() - cpu
        about = {"figure": name, "title": FIGURES[name], "key": key, "seconds": spent[0], "cpu_seconds": spent[1]}
        data = outcome.write(target, about)
    except OSError:
        raise
    except AeroSloshError as error:
        return _failed(work, name, begin, cpu, str(error), error.traceback)
    except Exception as error:
        return _failed(work, name, begin, cpu, f"{type(error).__name__}: {error}", traceback.format_exc())
    work.say(f"  {data['verdict']} ({spent[0]:.0f} s)")
    return Row(name, data["verdict"], *spent)


def _failed(work: Work, name: str, begin: float, cpu: float, cause: str, trace: str) -> Row:
    work.say(f"  failed: {cause}" + (f"\n{trace}" if trace else ""))
    return Row(name, "", time.perf_counter() - begin, cpu_seconds() - cpu, cause=cause)


def exit_code(rows: Sequence[Row]) -> ExitCode:
    """A figure that differs is a result; one that failed leaves the whole incomplete."""
    return ExitCode.INCOMPLETE if any(row.cause for row in rows) else ExitCode.OK


def table(rows: Sequence[Row]) -> str:
    """Figure, verdict, seconds: for people."""
    wide = max(len(row.figure) for row in rows)
    lines = [f"{'figure':{wide}}  {'seconds':>7}  {'CPU':>6}  verdict"]
    for row in rows:
        text = f"failed: {row.cause.splitlines()[0]}" if row.cause else row.verdict
        kept = " (computed before)" if row.kept else ""
        lines.append(f"{row.figure:{wide}}  {row.seconds:7.1f}  {row.cpu_seconds:6.1f}  {text}{kept}")
    words = [row.word for row in rows]
    lines.append(", ".join(f"{words.count(word)} {word}" for word in dict.fromkeys(words)))
    return "\n".join(lines)


def write(out: Path, rows: Sequence[Row], key: dict[str, Any]) -> None:
    """paper.csv and paper.json: the rows of this command, and of figures that earlier ones with the same settings left. Raises
    OSError."""
    own = {row.figure: row for row in rows}
    for name, found in finished(out, key).items():
        own.setdefault(name, Row(name, found["verdict"], found["seconds"], found["cpu_seconds"], kept=True))
    rows = [own[name] for name in FIGURES if name in own]
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["figure", "verdict", "seconds", "cpu_seconds"])
    for r in rows:
        said = f"failed: {r.cause}" if r.cause else r.verdict
        writer.writerow([r.figure, said, f"{r.seconds:.1f}", f"{r.cpu_seconds:.1f}"])
    files.write(out / "paper.csv", text.getvalue().encode())
    files.write(out / "paper.json", (json.dumps(data(rows), indent=2, ensure_ascii=False) + "\n").encode())


def data(rows: Sequence[Row]) -> dict[str, Any]:
    """For JSON."""
    return {
        "figures": [
            {"figure": r.figure, "verdict": r.verdict or None, "failed": r.cause or None, "seconds": r.seconds,
             "cpu_seconds": r.cpu_seconds, "computed_before": r.kept} for r in rows
        ],
        "cpu_seconds": sum(r.cpu_seconds for r in rows),
    }  # fmt: skip


def finished(out: Path, key: dict[str, Any]) -> dict[str, dict[str, Any]]:
    """Figure → its data, of those in the folder `out` that were computed with `key`."""
    found = {name: read(out / name) for name in FIGURES}
    return {name: data for name, data in found.items() if data is not None and data.get("key") == key}


def index(out: Path, key: dict[str, Any]) -> None:
    """paper.md: every figure that is there, with picture, claims, conditions and remarks. Raises OSError."""
    there = finished(out, key)
    lines = ["# The paper's figures, computed here", "", "| figure | shows | verdict | CPU [s] |", "|---|---|---|---|"]
    lines += [
        f"| [{name}](#{name}) | {d['title']} | {d['verdict'].partition(':')[0]} | {d['cpu_seconds']:.0f} |"
        for name, d in there.items()
    ]
    for name, d in there.items():
        lines += [
            "",
            f"## {name}",
            "",
            f"What it shows: {d['title']}. Verdict: {d['verdict']}",
            "",
            f"![{d['title']}]({name}/picture.png)",
            "",
        ]
        lines += ["| claim | where | paper | ours | |", "|---|---|---|---|---|"]
        for c in d["claims"]:
            said = "agrees" if c["agrees"] else "differs" + (f": {c['why']}" if c["why"] else "")
            cells = (c["what"], c["source"], c["paper"], c["ours"], said)
            lines.append("| " + " | ".join(text.replace("|", "\\|") for text in cells) + " |")
        lines += ["", *(f"- {text}" for text in d["conditions"]), "", *(f"- {text}" for text in d["remarks"])]
        lines += ["", "Files: " + ", ".join(f"[{f}]({name}/{f})" for f in d["files"])]
    files.write(out / "paper.md", ("\n".join(lines) + "\n").encode())
