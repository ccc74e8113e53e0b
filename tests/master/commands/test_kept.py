"""What a boundary and a point keep when they are interrupted, killed, out of disk, or when something fails at one Mach number."""

from __future__ import annotations

import errno
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from aeroslosh.master import cli
from aeroslosh.master.base import files, interrupts
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.boundary import strategy as boundary_strategy
from aeroslosh.master.pictures import boundary as pictures_boundary
from aeroslosh.master.results import run_folder, summary
from support.paths import CASES
from support.processes import COMMAND, QUICK, started, until

MARCHED = (
    *QUICK[2:], "--vf", "2.3", "--set", "boundary.method=march", "--set", "boundary.tolerance=0.03",
)  # fmt: skip
LONG = ("--set", "flutter.free_cycles=12.0")
SIX = ("--mach", "0.3", "0.35", "0.4", "0.45", "0.5", "0.55")


def words(command: str, out: Path, fmus: Path, *more: str) -> list[str]:
    """The command line, without the program."""
    return [command, str(CASES / "isogai_a.toml"), "--out", str(out), "--fmus", str(fmus), *more]


def result(out: Path) -> dict[str, Any]:
    """result.json; at any moment it is whole."""
    return dict(json.loads((out / "result.json").read_text()))


def finished(out: Path) -> int:
    """Mach numbers in it."""
    return len(result(out)["points"]) if (out / "result.json").exists() else 0


def hidden(folder: Path) -> list[str]:
    """What is not to be left behind."""
    return [path.name for path in folder.rglob(".*")]


# boundary: signals


@pytest.mark.parametrize(("number", "code"), [(signal.SIGINT, 130), (signal.SIGTERM, 143)], ids=["SIGINT", "SIGTERM"])
def test_an_interrupted_boundary_keeps_what_is_finished(flutter_fmus: Path, tmp_path: Path, number: int, code: int) -> None:
    """Most of the time an FMU is at work then, whose code takes the interrupt for a failure of its own."""
    out = tmp_path / "b"
    with started([*COMMAND, *words("boundary", out, flutter_fmus, *MARCHED, *LONG, *SIX, "--quiet")]) as process:
        until(lambda: finished(out) >= 2)
        process.send_signal(number)
        output, said = process.communicate(timeout=60)
    data = result(out)
    done = [p for p in data["points"] if not p["outcome"].startswith("interrupted")]
    assert process.returncode == code and "Traceback" not in said and output == "", (process.returncode, said)
    assert 2 <= len(done) < 6 and all(p["V_f"] is not None for p in done), data["points"]
    left = [0.3, 0.35, 0.4, 0.45, 0.5, 0.55][len(done) :]
    assert data["unfinished"] == left
    assert f"{len(done)} of 6 Mach numbers are finished and kept; the others: --mach {' '.join(f'{m:g}' for m in left)}" in said
    assert not hidden(tmp_path)
    for p in data["points"]:
        assert len(list(out.glob(f"history_M{p['mach']:g}_*.nc"))) == len({round(m["V_f"], 4) for m in p["marches"]}) > 0


def test_a_killed_boundary_keeps_what_is_finished(flutter_fmus: Path, tmp_path: Path) -> None:
    out = tmp_path / "b"
    with started([*COMMAND, *words("boundary", out, flutter_fmus, *MARCHED, *LONG, *SIX, "--quiet")]) as process:
        until(lambda: finished(out) >= 2)
        process.kill()
        process.communicate()
    data = result(out)
    assert [p["mach"] for p in data["points"]] + data["unfinished"] == [0.3, 0.35, 0.4, 0.45, 0.5, 0.55]
    assert (out / "case.toml").is_file() and all(p["converged"] for p in data["points"])


def test_an_interrupted_point_says_what_became_of_its_folder(flutter_fmus: Path, tmp_path: Path) -> None:
    more = ("--mach", "0.3", "--no-pictures", "--set", "flutter.free_cycles=1000")
    with started([*COMMAND, *words("point", tmp_path / "p", flutter_fmus, *more)]) as process:
        assert process.stderr is not None
        until(lambda: "march at Mach" in process.stderr.readline())  # type: ignore[union-attr]
        process.send_signal(signal.SIGINT)
        _, said = process.communicate(timeout=60)
    assert process.returncode == 130 and "interrupted; the unfinished run folder was removed" in said
    assert "failed" not in said and "Traceback" not in said and list(tmp_path.iterdir()) == []


SECOND = """
import os, signal, sys, time
from pathlib import Path
from aeroslosh.master.base import interrupts
signal.signal(signal.SIGINT, signal.default_int_handler)  # tests in the background have it ignored
interrupts.install()
left = Path(sys.argv[1])
interrupts.UNFINISHED.add(left)
try:
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(60)
except KeyboardInterrupt:
    if sys.argv[2] == "cleaned":
        left.rmdir()
    os.kill(os.getpid(), signal.SIGTERM)  # while it cleans up
    time.sleep(60)
"""


@pytest.mark.parametrize("how", ["cleaned", "not yet"])
def test_a_second_interrupt_ends_at_once_and_tells_what_is_left(tmp_path: Path, how: str) -> None:
    left = tmp_path / "b.part"
    left.mkdir()
    done = subprocess.run([sys.executable, "-c", SECOND, str(left), how], capture_output=True, text=True, timeout=30)
    wanted = f"left there unfinished: {left}" if how == "not yet" else "nothing unfinished is left"
    assert done.returncode == 143 and done.stderr.strip() == f"aeroslosh: interrupted again, ended at once; {wanted}"
    assert left.exists() is (how == "not yet")


def test_signals_that_are_ignored_stay_ignored() -> None:
    code = "import signal; from aeroslosh.master.base import interrupts; interrupts.install(); "
    code += "print(signal.getsignal(signal.SIGINT).name)"
    shell = ["sh", "-c", 'trap "" INT; exec "$@"', "sh", sys.executable, "-c", code]
    assert subprocess.run(shell, capture_output=True, text=True).stdout == "SIG_IGN\n"


# boundary: failures at one Mach number


@pytest.fixture
def failing(monkeypatch: pytest.MonkeyPatch) -> Callable[[float, Exception], None]:
    """Returns a function: let the strategy raise this at that Mach number, after its first march."""

    def fail(at: float, error: Exception) -> None:
        whole = boundary_strategy.Confirm.__call__

        def broken(self: boundary_strategy.Confirm, marcher: Any, mach: float, guess: float, slope: float | None) -> Any:
            if mach != at:
                return whole(self, marcher, mach, guess, slope)
            marcher(guess)
            raise error

        monkeypatch.setattr(boundary_strategy.Confirm, "__call__", broken)

    return fail


@pytest.mark.parametrize(
    ("error", "code"),
    [
        (ZeroDivisionError("float division by zero"), ExitCode.INTERNAL),
        (AeroSloshError("The steady flow did not converge"), ExitCode.INPUT),
    ],
)
def test_what_fails_at_one_mach_number_is_its_outcome(
    flutter_fmus: Path, tmp_path: Path, failing: Any, capsys: pytest.CaptureFixture[str], error: Exception, code: int
) -> None:
    failing(0.4, error)
    out = tmp_path / "b"
    assert cli.run(words("boundary", out, flutter_fmus, *MARCHED, "--mach", "0.3", "0.4", "0.5", "--quiet")) == code
    first, second, third = result(out)["points"]
    assert first["converged"] and third["converged"] and not second["converged"]
    assert second["outcome"].startswith("failed: ") and str(error).splitlines()[0] in second["outcome"]
    assert len(second["marches"]) == 1 and len(list(out.glob("history_M0.4_*.nc"))) == 1
    said = capsys.readouterr().err
    assert str(error).splitlines()[0] in said and ("Traceback" in said) is (code == ExitCode.INTERNAL)
    assert result(out)["unfinished"] == []


def test_a_point_that_cannot_be_told_is_an_outcome_and_a_picture_that_fails_hides_nothing(
    flutter_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A number that JSON has not at one Mach number; a picture that cannot be drawn."""
    whole = summary.point_data

    def spoilt(point: Any) -> dict[str, Any]:
        return whole(point) | ({"slope": float("nan")} if point.mach == 0.3 and point.marches else {})

    def draw(*_: Any) -> None:
        raise ZeroDivisionError("the picture")

    monkeypatch.setattr(summary, "point_data", spoilt)
    monkeypatch.setattr(pictures_boundary, "draw", draw)
    out = tmp_path / "b"
    marched = [word for word in MARCHED if word != "--no-pictures"]
    with pytest.raises(ZeroDivisionError):
        cli.run(words("boundary", out, flutter_fmus, *marched, "--mach", "0.3", "0.4", "--quiet"))
    first, second = result(out)["points"]
    assert first["outcome"].startswith("failed: internal error: ValueError") and second["converged"]
    assert len(list(out.glob("history_M0.3_*.nc"))) > 1, "what was marched is kept"
    assert "0.400" in capsys.readouterr().out and not hidden(tmp_path)


# disks


def test_a_full_disk_keeps_the_mach_numbers_before(
    flutter_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The disk is full when the second Mach number's result is written."""
    write, out = files.write, tmp_path / "b"

    def full(path: Path, data: bytes) -> None:
        if path.name == "result.json" and path.exists():
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        write(path, data)

    monkeypatch.setattr(files, "write", full)
    with pytest.raises(AeroSloshError) as caught:
        cli.run(words("boundary", out, flutter_fmus, *MARCHED, "--mach", "0.3", "0.4", "0.5", "--quiet"))
    assert caught.value.code == ExitCode.INCOMPLETE and "The disk is full" in str(caught.value)
    assert "1 of 3 Mach numbers are finished and kept; the others: --mach 0.4 0.5" in str(caught.value)
    assert [p["mach"] for p in result(out)["points"]] == [0.3] and result(out)["unfinished"] == [0.4, 0.5]
    assert not hidden(tmp_path)


def test_full_disks_of_the_machine(flutter_fmus: Path, tmp_path: Path) -> None:
    """File systems of a few KiB where the user may mount some, else a limit on the size of a file: `boundary` fills its disk at
    some Mach number, `point` when it writes its history, and one has no room to begin."""
    lines = {
        "boundary": ("300k", words("boundary", tmp_path / "d" / "r", flutter_fmus, *MARCHED, *SIX, "--quiet")),
        "point": ("24k", words("point", tmp_path / "d" / "r", flutter_fmus, *QUICK, "--quiet")),
        "no room": ("4k", words("point", tmp_path / "d" / "r", flutter_fmus, *QUICK, "--quiet")),
    }
    mounts = (
        subprocess.run(["unshare", "-Urm", "mount", "-t", "tmpfs", "none", str(tmp_path)], capture_output=True).returncode == 0
    )
    for name, (size, line) in lines.items():
        disk = tmp_path / "d"
        disk.mkdir(exist_ok=True)
        look = f"echo code $?; cat {disk}/r/result.json; ls -A {disk} {disk}/r"
        if mounts:
            shell = ["unshare", "-Urm", "sh", "-c", f'mount -t tmpfs -o size={size} none {disk}; "$@"; {look}', "sh"]
        else:
            limit = {"boundary": 30_000, "point": 8_000, "no room": 1_000}[name]
            shell = ["sh", "-c", f'prlimit --fsize={limit} "$@"; {look}; rm -rf {disk}/r', "sh"]
        done = subprocess.run([*shell, *COMMAND, *line], capture_output=True, text=True)
        before, _, after = done.stdout.partition("code ")
        print(name, "on a small tmpfs" if mounts else "with RLIMIT_FSIZE", after[:2], done.stderr.splitlines()[:3])
        assert "Traceback" not in done.stderr and ".part" not in after, (name, done.stderr, after)
        if name == "no room":
            assert after.startswith("2\n") and "The output folder cannot be written" in done.stderr and not before
            continue
        assert after.startswith("5\n") and "The disk is full" in done.stderr, (name, done.stderr, after)
        if name == "point":
            assert "Mach 0.3" in before, "the verdict is told all the same"
        elif mounts:
            kept = json.JSONDecoder().raw_decode(after[after.index("{") :])[0]
            assert 0 < len(kept["points"]) < 6
            assert f"{len(kept['points'])} of 6 Mach numbers are finished and kept" in done.stderr


def test_two_runs_of_one_name_keep_both(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Another process publishes its run between a look and the rename, twice."""
    target, rename, others = tmp_path / "run", os.rename, iter("bc")

    def late(source: Path, aim: Path) -> None:
        if aim == target and (other := next(others, "")):
            aim.mkdir(exist_ok=True)
            (aim / "case.toml").write_text(other)
        rename(source, aim)

    monkeypatch.setattr(run_folder.os, "rename", late)
    with run_folder.RunFolder(target) as mine:
        mine.write_settings("a")
    texts = {path.parent.name: path.read_text() for path in tmp_path.glob("*/case.toml")}
    assert texts == {"run": "a", "run.001": "b", "run.002": "c"} and not interrupts.UNFINISHED
