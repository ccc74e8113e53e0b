"""`aeroslosh doctor`: what it says of a good installation, of a bad one, and of FMUs that fail or crash."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from host_jobs import ROOT, clean

from aeroslosh.fmus.kit import cache
from aeroslosh.master.hosts import bare, doctor, hosting


def run(*words: str, code: int, **environment: str) -> dict[str, Any]:
    """The command with --json."""
    done = subprocess.run(
        [sys.executable, "-m", "aeroslosh", "doctor", "--json", *words],
        capture_output=True,
        text=True,
        cwd=ROOT,
        env=clean(**environment),
        timeout=300,
    )
    assert done.returncode == code, done.stdout + done.stderr
    return dict(json.loads(done.stdout))


def topics(result: dict[str, Any], level: str) -> dict[str, str]:
    """Texts and remedies of the findings of a level, by topic."""
    return {row["topic"]: f"{row['text']} -> {row['remedy']}" for row in result["findings"] if row["level"] == level}


def changed(fmu: Path, target: Path, name: str, text: Callable[[str], str]) -> Path:
    """A copy of an FMU with a member whose name ends with `name` rewritten."""
    with zipfile.ZipFile(fmu) as old, zipfile.ZipFile(target, "w") as new:
        for member in old.namelist():
            data = old.read(member)
            new.writestr(member, text(data.decode()).encode() if member.endswith(name) else data)
    return target


def test_all_well(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """Every topic, the self-test's numbers, the line for other hosts."""
    shutil.copy(fmu("structure"), tmp_path)
    shutil.copy(fmu("slosh_ems"), tmp_path)
    result = run("--fmus", str(tmp_path), code=0)
    assert result["level"] in ("ok", "warning") and not topics(result, "problem")
    seen = {row["topic"] for row in result["findings"]}
    assert {"python", "libpython", "platform", "folders", "compiled", "packages", "structure", "slosh_ems"} <= seen
    library = hosting.libpython()
    assert result["environment_line"] == (hosting.line(library) if library else None)
    about = {key: value for row in result["findings"] if row["topic"] == "structure" for key, value in row.items()}
    assert about["ready_seconds"] > 0.0 and about["step_seconds"] > 0.0 and about["state_bytes"] > 500
    assert sum(row["topic"] == "structure" for row in result["findings"]) >= 3


def test_which_python_a_host_will_find(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """The one that the FMU was installed with, tried in a program that is no Python; without it, what that program was told."""
    shutil.copy(fmu("structure"), tmp_path)
    result = run("--fmus", str(tmp_path), code=0)
    (found,) = [row for row in result["findings"] if row["topic"] == "structure" and "host_python" in row]
    assert found["level"] == "ok" and found["host_python"].startswith(f"{sys.executable} 3.")
    folder = tmp_path / "unzipped"
    with zipfile.ZipFile(fmu("structure")) as archive:
        archive.extractall(folder)
    (folder / "resources" / "python.txt").unlink()
    (told,) = bare.findings("structure", folder, {"PATH": "/nowhere"})
    assert told.level == "warning" and "no Python for this FMU" in told.text and "AEROSLOSH_PYTHON" in told.remedy
    (folder / "resources" / "find_python.py").unlink()
    assert bare.findings("structure", folder) == []  # an FMU of another make


def test_fmus_that_crash_fail_and_lie(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """Each is a problem of its own, and the good one is still tested."""
    good = fmu("structure")
    shutil.copy(good, tmp_path / "good.fmu")
    changed(good, tmp_path / "crashing.fmu", "_slave.py", lambda text: "import os; os.abort()\n")
    changed(good, tmp_path / "lacking.fmu", "_slave.py", lambda text: "import nosuchpackage\n" + text)
    head = "    def restore(self, snapshot"
    nothing = f"{head}: object) -> None:\n        return\n\n    def _restore(self, snapshot"  # a state that restores nothing
    changed(good, tmp_path / "forgetful.fmu", "/structure/fmu.py", lambda text: text.replace(head, nothing))
    (tmp_path / "torn.fmu").write_bytes(good.read_bytes()[:5000])
    result = run("--fmus", str(tmp_path), code=3, XDG_CACHE_HOME=str(tmp_path / "cache"))
    problems = topics(result, "problem")
    assert set(problems) == {"crashing", "lacking", "forgetful", "torn"}
    assert "SIGABRT" in problems["crashing"]
    assert "cannot be instantiated" in problems["lacking"]
    assert "repeated from a saved state" in problems["forgetful"]
    assert "not a zip archive" in problems["torn"]
    assert "good" in topics(result, "ok")


def test_packages(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """What is missing and what is too old is a problem before anything runs."""
    wanted = "numpy>=99,<100\nnosuchpackage>=1\nscipy>=1.14,<2\n"
    changed(fmu("structure"), tmp_path / "a.fmu", "resources/requirements.txt", lambda text: wanted)
    result = run("--fmus", str(tmp_path), "--no-self-test", code=2)
    texts = [f"{row['level']}: {row['text']} -> {row['remedy']}" for row in result["findings"] if row["topic"] == "packages"]
    assert len(texts) == 3
    assert any(t.startswith("problem: numpy ") and "pip install 'numpy>=99,<100'" in t for t in texts)
    assert any(t.startswith("problem: nosuchpackage is missing; asked for by a") for t in texts)
    assert any(t.startswith("ok: scipy ") for t in texts)


@pytest.mark.parametrize(
    ("wanted", "version", "allowed"),
    [
        (">=2.0,<3", "2.4.6", True),
        (">=2.0,<3", "3.0", False),
        (">=2.0,<3", "1.26.4", False),
        (">=1.14", "1.14", True),
        ("==1.2.*", "1.2.7", True),
        ("==1.2.*", "1.3", False),
        ("!=1.2", "1.2.0", False),
        ("~=1.4.2", "1.4.9", True),
        ("~=1.4.2", "1.5.0", False),
        (">1.0,<=1.1", "1.1.0", True),
        ("", "0.1", True),
        ("<3", "3.0rc1", False),
    ],
)
def test_version_ranges(wanted: str, version: str, allowed: bool) -> None:
    """As pip reads them, of releases."""
    assert doctor.allows(wanted, version) is allowed


def test_folders(tmp_path: Path) -> None:
    """No FMUs, an odd temporary folder, which is nobody's trouble, caches that cannot be written."""
    odd = tmp_path / "50% #é"
    odd.mkdir()
    result = run("--fmus", str(tmp_path / "none"), code=2, TMPDIR=str(odd), XDG_CACHE_HOME="/dev/null", PYTHONHOME="")
    assert "make fmus" in topics(result, "problem")["FMUs"]
    warnings = topics(result, "warning")
    assert "50% #é" not in warnings.get("folders", "")
    assert "/dev/null/aeroslosh" in warnings["compiled"] and "XDG_CACHE_HOME" in warnings["compiled"]


def test_compile_cache_is_where_the_kernels_go(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """`doctor` says the folder without importing numba: it must stay the kit's."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert doctor.compile_cache_root() == cache.cache_root()
    (tmp_path / "aeroslosh" / "abc").mkdir(parents=True)
    (tmp_path / "aeroslosh" / "abc" / "flux.1.nbc").write_bytes(b"x" * 1000)
    (finding,) = doctor.compile_cache()
    assert (finding.level, finding.values["entries"], finding.values["bytes"]) == ("ok", 1, 1000)


def test_script_that_cannot_be_written(launch: list[str], tmp_path: Path) -> None:
    """A clear error, nothing left behind."""
    words = [sys.executable, "-m", "aeroslosh", "doctor", "--script", str(tmp_path / "none" / "start.sh")]
    done = subprocess.run(words, capture_output=True, text=True, cwd=ROOT, env=clean())
    assert done.returncode == 2 and "cannot be written" in done.stderr and "remedy" in done.stderr
    assert list(tmp_path.iterdir()) == []
