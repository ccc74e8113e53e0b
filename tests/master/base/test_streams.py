"""The command with outputs that are closed, full, gone or of another encoding, and with names that are no UTF-8."""

from __future__ import annotations

import errno
import os
import subprocess
import sys
from pathlib import Path

import pytest

from aeroslosh.master import cli
from aeroslosh.master.base.errors import AeroSloshError

PRINTS = """
import sys
from aeroslosh.master import cli
def run(arguments):
    if "progress" in sys.argv:
        for _ in range(20000):
            print("progress", file=sys.stderr)
    print("the α of " + 2000 * "x", flush="flush" in sys.argv)
    open(sys.argv[1], "w").write("whole")
    return int(sys.argv[2])
cli.run = run
cli.main()
"""


def shell(line: str, tmp_path: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """`line` in a shell, where "$@" is a command that prints, writes a file, and ends with the code 0."""
    command = ["sh", "-c", line, "sh", sys.executable, "-c", PRINTS, str(tmp_path / "file"), *(words or ["0"])]
    given = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    return subprocess.run(command, capture_output=True, env={**given, **environment}, timeout=60)


@pytest.mark.parametrize(
    ("line", "why"),
    [
        ('"$@" >&-', "it is closed"),
        ('"$@" >/dev/full', "No space left on device"),
        ('("$@"; echo code $? >&2) | true', "whoever read it has gone"),
    ],
)
@pytest.mark.parametrize("words", [["0"], ["4"], ["0", "flush"]])
def test_a_result_that_cannot_be_printed_is_told(line: str, why: str, words: list[str], tmp_path: Path) -> None:
    done = shell(line, tmp_path, *words)
    said = done.stderr.decode()
    assert f"The result cannot be printed: {why}" in said and "remedy" in said and "Traceback" not in said, said
    at_once = "flush" in words or why == "it is closed"  # the command is told while it prints, before it has a code of its own
    code = 2 if at_once or words[0] == "0" else 4
    assert (f"code {code}" in said) if "code" in said else (done.returncode == code)
    assert at_once or (tmp_path / "file").read_text() == "whole"


@pytest.mark.parametrize("line", ['"$@" 2>&-', '"$@" 2>/dev/full', '{ "$@" 2>&1 >/dev/null; echo $? >"$4.code"; } | true'])
def test_progress_that_nobody_reads_ends_nothing(line: str, tmp_path: Path) -> None:
    done = shell(line.replace("$4", str(tmp_path / "file")), tmp_path, "0", "progress")
    if (code := tmp_path / "file.code").exists():
        assert code.read_text() == "0\n"
    assert done.returncode == 0 and (tmp_path / "file").read_text() == "whole"


@pytest.mark.parametrize(
    ("number", "code", "words"),
    [
        (errno.ENOSPC, 5, ["The disk is full", "/there/out.csv", "free space"]),
        (errno.EDQUOT, 5, ["The disk is full", "/there/out.csv"]),
        (errno.EROFS, 5, ["cannot be written: Read-only file system", "--out"]),
        (errno.EINVAL, 70, ["Traceback", "internal error"]),  # no fault of the disk
    ],
)
def test_what_a_disk_refuses_is_told_by_every_command(
    number: int, code: int, words: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refused(_: object) -> int:
        raise OSError(number, os.strerror(number), "/there/out.csv")

    monkeypatch.setattr(cli, "run", refused)
    assert cli._told(["drive"]) == code
    said = capsys.readouterr().err
    assert all(word in said for word in words) and ("Traceback" in said) is (code == 70)


def test_closed_streams_are_not_given_to_files(tmp_path: Path) -> None:
    """The first file opened would get the number of standard output, and whatever a library prints."""
    code = "from aeroslosh.master.base import streams\nstreams.guard()\nprint(open('{}', 'w').fileno(), file=open('{}', 'w'))"
    text = code.format(tmp_path / "a", tmp_path / "number")
    subprocess.run(["sh", "-c", '"$@" <&- >&- 2>&-', "sh", sys.executable, "-c", text], timeout=60)
    assert int((tmp_path / "number").read_text()) > 2


def test_a_locale_without_greek_gets_an_escape(tmp_path: Path) -> None:
    done = shell('"$@"', tmp_path, PYTHONIOENCODING="ascii", PYTHONUTF8="0")
    assert done.returncode == 0 and done.stdout.startswith(b"the \\u03b1 of x")


@pytest.mark.parametrize("where", ["--out", "case", "working directory", "--set"])
def test_names_that_are_no_utf8_are_refused(where: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    strange = os.fsdecode(os.fsencode(tmp_path) + b"/caf\xe9")
    os.mkdir(strange)
    monkeypatch.chdir(strange if where == "working directory" else tmp_path)
    words = ["point", f"{strange}/case.toml" if where == "case" else "case.toml"]
    words += ["--out", strange] if where == "--out" else ["--set", "flow.airfoil=\udce9"] if where == "--set" else []
    with pytest.raises(AeroSloshError) as caught:
        cli.run(words)
    assert caught.value.code == 2 and "A name is no UTF-8 text" in str(caught.value) and "\\xe9" in str(caught.value)
    str(caught.value).encode()


def test_imports_change_nothing_of_the_program_around() -> None:
    """Neither its environment nor how it draws."""
    code = (
        "import os, matplotlib; before = dict(os.environ); matplotlib.use('svg')\n"
        "import importlib, pkgutil, sys, aeroslosh.master\n"
        "for found in pkgutil.walk_packages(aeroslosh.master.__path__, 'aeroslosh.master.'):\n"
        "    importlib.import_module(found.name)\n"
        "from aeroslosh.master.pictures import canvas; canvas.subplots()[0].savefig(os.devnull, format='png')\n"
        "assert dict(os.environ) == before, set(os.environ.items()) ^ set(before.items())\n"
        "assert matplotlib.get_backend() == 'svg' and 'matplotlib.pyplot' not in sys.modules\n"
    )
    given = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=given, timeout=60)
    assert done.returncode == 0, done.stderr
