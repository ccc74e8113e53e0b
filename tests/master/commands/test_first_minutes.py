"""What somebody new meets: the version, completion in a shell, a case to fill in, progress on a narrow terminal."""

from __future__ import annotations

import dataclasses
import os
import pty
import re
import shutil
import subprocess
import sys
import termios
import tomllib
from pathlib import Path

import pytest

from aeroslosh.master.base import terminal
from aeroslosh.master.case import case as cases
from aeroslosh.master.case import checks, template
from aeroslosh.master.case.case import TABLES, Case
from aeroslosh.master.commands import HELP
from support.processes import called, supported


def test_the_version_is_said() -> None:
    done = called("--version")
    assert done.returncode == 0 and re.fullmatch(r"aeroslosh \d+\.\d+\S* \(Python \d+\.\d+\.\d+\)\n", done.stdout)


@pytest.mark.skipif(shutil.which("bash") is None, reason="no bash")
@pytest.mark.parametrize(
    ("line", "expected"),
    [
        (["bou"], {"boundary"}),
        (["point", "--ma"], {"--mach"}),
        (["point", "isog"], {"isogai_a", "isogai_a_boundary"}),
        (["export", "pa"], {"parquet"}),
        (["completion", ""], {"bash", "zsh", "fish"}),
        (["init", "--s"], {"--slosh"}),
    ],
)
def test_bash_completes(line: list[str], expected: set[str]) -> None:
    script = called("completion", "bash").stdout
    words = " ".join(f"'{word}'" for word in ["aeroslosh", *line])
    ask = f"{script}\nCOMP_WORDS=({words}); COMP_CWORD={len(line)}; _aeroslosh; printf '%s\\n' \"${{COMPREPLY[@]}}\""
    done = subprocess.run(["bash", "-c", ask], capture_output=True, text=True)
    found = {word for word in done.stdout.split() if not (line[-1] == "" and word.startswith("-"))}
    assert done.stderr == "" and found == expected


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_every_command_is_in_every_script(shell: str) -> None:
    script = called("completion", shell).stdout
    assert all(re.search(rf"\b{name}\b", script) for name in HELP) and f"completion {shell}" in script
    program = shutil.which(shell)
    if program:  # which is not on every machine
        assert subprocess.run([program, "-n"], input=script, text=True, capture_output=True).returncode == 0


@pytest.mark.parametrize("model", ["none", "frozen", "ems", "rbf", "vof"])
def test_a_case_to_fill_in_is_whole(tmp_path: Path, model: str) -> None:
    file = tmp_path / "mine.toml"
    done = called("init", file, "--slosh", model)
    assert done.returncode == 0 and str(file) in done.stdout
    for command in ("point", "boundary"):
        case = cases.load(file, command=command)
        assert case.slosh.model == model
    assert case.given == {*checks.REQUIRED["point"], *checks.REQUIRED["boundary"]} | (
        set() if model == "none" else {*(checks.TANK if model == "frozen" else checks.MOVING), "slosh.model"}
    )


def test_a_case_to_fill_in_has_every_key_with_its_default_and_says_what_it_may_be() -> None:
    text = template.text("mine")
    lines = [re.sub(r"^#(?=\w+ = \S)", "", line) for line in text.splitlines()]
    opened = tomllib.loads("\n".join(line for line in lines if not line.startswith("#")))
    for table, kind in TABLES.items():
        for f in dataclasses.fields(kind):
            default = getattr(getattr(Case(), table), f.name)
            assert re.search(rf"^#?{f.name} =", text, re.MULTILINE), f.name
            if default is not None and f"{table}.{f.name}" not in template.EXAMPLE:
                assert opened[table][f.name] == default, f.name
    flat = " ".join(text.replace("\n#", " ").split())
    assert "freestream Mach number: a number from 0.05 to 0.98" in flat
    assert "structure carries" in flat and 'subiterations a step: a whole number or "auto" from 1' in flat
    assert "density of the gas above it: a number from 0 [kg/m3]" in flat and max(map(len, text.splitlines())) <= 130


def test_a_case_to_fill_in_replaces_nothing(tmp_path: Path) -> None:
    file = tmp_path / "mine.toml"
    file.write_text("mine")
    done = called("init", file)
    assert done.returncode == 2 and "there already" in done.stderr and file.read_text() == "mine"
    done = called("init", tmp_path / "mine.txt")
    assert done.returncode == 2 and "mine.txt.toml" in done.stderr


LIVE = """
from types import SimpleNamespace as S
from aeroslosh.master.cosim.progress import Progress
from aeroslosh.master.sweeps.progress import SweepProgress
parts = [S(name=name, cpu=1.0) for name in ("structure", "aerodynamics", "slosh", "slosh_predictor")]
p = Progress()
p.start("M 0.825 V_f 0.6123456")
p.watch(999999, 1000000, S(components=parts))
p._shown = 0.0
p.watch(1000000, 1000000, S(components=parts))
p.beside("M 0.8", 1, 2, "  3 of 16 done   " + "   ".join(f"M 0.{n} V_f 0.61  10/525" for n in range(70, 78)))
p.say("over")
s = SweepProgress(False)
s.workers, s.expected = 2, 86400.0
s.show({"pending": 100000, "done": 100000, "failed": 12345})
s.say("over")
"""


@pytest.mark.parametrize("columns", [80, 40])
def test_progress_never_wraps(columns: int) -> None:
    """What is drawn over itself stays on one line of the terminal, the last column free."""
    ours, theirs = pty.openpty()
    termios.tcsetwinsize(theirs, (24, columns))
    done = subprocess.Popen([sys.executable, "-c", LIVE], stderr=theirs, stdout=subprocess.DEVNULL, env=supported())
    os.close(theirs)
    said = b""
    try:
        while more := os.read(ours, 4096):
            said += more
    except OSError:  # the other end is closed
        pass
    os.close(ours)
    assert done.wait() == 0
    drawn = [part for part in re.split(r"[\r\n]+", said.decode()) if part]
    assert len(drawn) >= 6 and any("of 200000" in part or "100000 of" in part for part in drawn)
    assert max(map(len, drawn)) < columns
    assert any(part.rstrip().endswith("…") for part in drawn)


def test_a_line_that_fits_stays_as_it_is() -> None:
    assert terminal.fitted("abc", 80) == "abc" and terminal.fitted("x" * 80, 80) == "x" * 78 + "…"
    assert terminal.fitted("abcdef", 4) == "ab…"
