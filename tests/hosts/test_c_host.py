"""All five FMUs in a C program: the same numbers as in Python to the bit, its errors, its state, its end."""

from __future__ import annotations

import shlex
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from host_jobs import JOBS, clean, job, settings, table

from aeroslosh.master.hosts import hosting

MIDDLE = 5  # the row at which states are taken


def run(words: list[str], **options: object) -> subprocess.CompletedProcess[str]:
    """A program in a clean environment."""
    given = {"env": clean(), **options}
    return subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=300, **given)  # type: ignore[call-overload]


def rows(printed: str, outputs: list[str], instance: str) -> list[list[str]]:
    """What the C host printed of one instance, as tools.py prints it."""
    lines = [line.split() for line in printed.splitlines()]
    header = next(line[2:] for line in lines if line[0] == "#" and line[1] == instance)
    places = [header.index(name) + 1 for name in outputs]
    return [[float(line[place]).hex() for place in places] for line in lines if line[0] == instance]


@pytest.fixture
def words(c_host: Path, unzipped: Callable[[str], Path], tmp_path: Path) -> Callable[..., list[str]]:
    """Name of an FMU → the words that have the C host do its job (without the host itself)."""

    def get(name: str, text: str | None = None, *more: str) -> list[str]:
        file = tmp_path / f"{name}.csv"
        file.write_text(text or table(name))
        return [str(unzipped(name)), str(file), *settings(name), *more]

    return get


@pytest.mark.parametrize("name", JOBS)
def test_numbers_state_and_resume(
    name: str,
    c_host: Path,
    launch: list[str],
    words: Callable[..., list[str]],
    fmu: Callable[[str], Path],
    tool: Callable[..., list[list[str]]],
    tmp_path: Path,
) -> None:
    """With the launcher: numbers equal FMPy's; a rollback and a new process go on from a state as if nothing had been."""
    expected = tool("direct_end", job(name, str(fmu(name))))
    outputs, saved = JOBS[name][2], tmp_path / "state"
    kept = run([*launch, str(c_host), "--save", str(MIDDLE), str(saved), *words(name)])
    assert (kept.returncode, kept.stderr) == (0, "")
    assert rows(kept.stdout, outputs, f"{name}_1")[1:] == expected  # the first row is the start
    assert len({row[0] for row in expected[1:]}) > 5, "the job moves nothing"

    rolled = run([*launch, str(c_host), "--rollback", str(MIDDLE), *words(name)])
    assert (rolled.returncode, rolled.stdout) == (0, kept.stdout)

    resumed = run([*launch, str(c_host), "--resume", str(MIDDLE), str(saved), *words(name)])
    assert (resumed.returncode, rows(resumed.stdout, outputs, f"{name}_1")) == (0, expected[MIDDLE:])


def test_script_all_fmus_at_once(
    c_host: Path,
    launch: list[str],
    words: Callable[..., list[str]],
    fmu: Callable[[str], Path],
    tool: Callable[..., list[list[str]]],
    tmp_path: Path,
) -> None:
    """With the shell script of `aeroslosh doctor --script`: six instances of five FMUs in one process, from another folder."""
    script, elsewhere = tmp_path / "start host.sh", tmp_path / "elsewhere"
    elsewhere.mkdir()
    made = run([sys.executable, "-m", "aeroslosh", "doctor", "--script", str(script)], cwd=Path(__file__).parents[2])
    assert (made.returncode, made.stdout) == (0, f"{script}\n"), made.stderr
    several = [word for name in [*JOBS, "structure"] for word in ["+", *words(name)]][1:]
    done = run([str(script), str(c_host), *several], cwd=elsewhere)
    assert (done.returncode, done.stderr) == (0, "")
    for number, name in enumerate([*JOBS, "structure"], start=1):
        expected = tool("direct_end", job(name, str(fmu(name))))
        assert rows(done.stdout, JOBS[name][2], f"{name}_{number}")[1:] == expected, name


def test_environment_line(
    c_host: Path,
    launch: list[str],
    words: Callable[..., list[str]],
    fmu: Callable[[str], Path],
    tool: Callable[..., list[list[str]]],
) -> None:
    """With the line that `aeroslosh doctor` prints, in sh: two instances of one FMU and another FMU."""
    library = hosting.libpython()
    assert library is not None
    several = [*words("structure"), "+", *words("slosh_ems"), "+", *words("structure")]
    line = hosting.line(library)
    assert line.endswith("HOST ARGS")
    done = run(["sh", "-c", line.removesuffix("HOST ARGS") + shlex.join([str(c_host), *several])])
    assert (done.returncode, done.stderr) == (0, "")
    for number, name in enumerate(["structure", "slosh_ems", "structure"], start=1):
        assert rows(done.stdout, JOBS[name][2], f"{name}_{number}")[1:] == tool("direct_end", job(name, str(fmu(name))))


@pytest.mark.parametrize(
    ("setting", "change", "said"),
    [
        (
            "mass=-1",
            None,
            "fmi2Set: Discard: parameter 'mass' = -1.0 kg/m is outside its range",
        ),
        ("mass=60", (4, 1, "nan"), "fmi2SetReal: Discard: input 'lift' = nan is not a finite number"),
        ("mass=60", (4, 0, "0.0001"), "fmi2DoStep: Error: step size -"),
    ],
    ids=["parameter", "input", "step"],
)
def test_errors_reach_the_host(
    setting: str,
    change: tuple[int, int, str] | None,
    said: str,
    c_host: Path,
    launch: list[str],
    words: Callable[..., list[str]],
) -> None:
    """The FMU's own sentence with its remedy, the host's exit code 3, and what was computed before."""
    lines = [line.split(",") for line in table("structure").splitlines()]
    if change is not None:
        lines[1 + change[0]][change[1]] = change[2]
    done = run([*launch, str(c_host), *words("structure", "\n".join(",".join(line) for line in lines), setting)])
    assert done.returncode == 3, done.stderr
    assert said in done.stderr and "Remedy: " in done.stderr and len(done.stderr.splitlines()) == 1
    assert len(done.stdout.splitlines()) == (1 if change is None else 1 + change[0])


def test_spaces_and_relative_paths(
    c_host: Path, launch: list[str], fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]], tmp_path: Path
) -> None:
    """An FMU in a folder with spaces, named from beside it."""
    with zipfile.ZipFile(fmu("structure")) as archive:
        archive.extractall(tmp_path / "a folder" / "the wing")
    (tmp_path / "a folder" / "in put.csv").write_text(table("structure"))
    done = run([*launch, str(c_host), "the wing", "in put.csv", *settings("structure")], cwd=tmp_path / "a folder")
    assert (done.returncode, done.stderr) == (0, "")
    expected = tool("direct_end", job("structure", str(fmu("structure"))))
    assert rows(done.stdout, JOBS["structure"][2], "structure_1")[1:] == expected
