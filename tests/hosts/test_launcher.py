"""The launcher and its environment: exit codes, signals, what is there stays, what is missing is said."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import sysconfig
from pathlib import Path

import pytest
from host_jobs import LAUNCH, ROOT, clean

from aeroslosh.master.hosts import hosting


def run(words: list[str], **environment: str) -> subprocess.CompletedProcess[str]:
    """The launcher with `words`."""
    return subprocess.run([*LAUNCH, *words], capture_output=True, text=True, env=clean(**environment), timeout=60)


def test_exit_codes_and_signals_are_those_of_the_program(launch: list[str]) -> None:
    """The launcher becomes the program."""
    assert run(["sh", "-c", "exit 7"]).returncode == 7
    assert run(["sh", "-c", "kill -TERM $$"]).returncode == -signal.SIGTERM
    done = run(["sh", "-c", 'printf "%s|" "$@"', "name", "two words", "--help", ""])
    assert (done.returncode, done.stdout) == (0, "two words|--help||")


def test_environment(launch: list[str]) -> None:
    """This Python's library and folder in front of what is there; nothing else is changed."""
    library, folder = str(hosting.libpython()), str(Path(sys.executable).parent)
    given = clean(LD_PRELOAD="libm.so.6", PATH="/usr/bin:/bin", PYTHONHOME="")
    given.pop("OPENBLAS_NUM_THREADS", None)  # which the command `aeroslosh` sets, and nothing else
    before = subprocess.run(["env"], capture_output=True, text=True, env=given).stdout
    printed = subprocess.run([*LAUNCH, "env"], capture_output=True, text=True, env=given).stdout
    after = dict(line.partition("=")[::2] for line in printed.splitlines() if "=" in line)
    wanted = dict(line.partition("=")[::2] for line in before.splitlines() if "=" in line)
    wanted |= {"LD_PRELOAD": f"{library}:libm.so.6", "PATH": f"{folder}:/usr/bin:/bin", "PYTHONPATH": str(ROOT)}
    del wanted["PYTHONHOME"]
    after.pop("_", None), wanted.pop("_", None)
    assert after == wanted
    twice = hosting.environment(Path(library), hosting.environment(Path(library), {"PATH": "/bin"}))
    assert (twice["LD_PRELOAD"], twice["PATH"]) == (library, f"{folder}:/bin"), "each once"


@pytest.mark.parametrize(
    ("words", "code", "said"),
    [
        ([], 2, "No program"),
        (["nosuchprogram"], 127, "nosuchprogram"),
        (["--fast", "sh"], 2, "--fast"),
        (["./file"], 126, "./file"),
    ],
)
def test_wrong_use(words: list[str], code: int, said: str, launch: list[str], tmp_path: Path) -> None:
    """One sentence with a remedy."""
    (tmp_path / "file").write_text("no program")
    done = subprocess.run([*LAUNCH, *words], capture_output=True, text=True, env=clean(), cwd=tmp_path, timeout=60)
    assert done.returncode == code
    assert said in done.stderr and "remedy: " in done.stderr and "Traceback" not in done.stderr


def test_imports_the_standard_library_alone() -> None:
    """Starting it costs what starting Python costs."""
    code = (
        "import sys, aeroslosh.master.hosts.launcher\n"
        "print(*{n.partition('.')[0] for n in sys.modules} - set(sys.stdlib_module_names) - {'__main__'})"
    )
    done = subprocess.run([sys.executable, "-S", "-c", code], capture_output=True, text=True, env=clean(PYTHONPATH=str(ROOT)))
    assert done.stdout.split() == ["aeroslosh"], done.stdout + done.stderr


def test_static_python(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    """A Python without a shared library: none is found, also not another Python's, and the launcher says what to do."""
    from aeroslosh.master.hosts import launcher

    ask = sysconfig.get_config_var
    static = {"INSTSONAME": "libpython3.11.a", "LIBDIR": str(tmp_path)}
    monkeypatch.setattr(sysconfig, "get_config_var", lambda name: static.get(name) or ask(name))
    monkeypatch.setattr(sys, "base_prefix", str(tmp_path))
    assert hosting.libpython() is None
    with pytest.raises(SystemExit) as stop:
        launcher.main(["sh"])
    assert stop.value.code == 2
    assert "--enable-shared" in capsys.readouterr().err
    monkeypatch.setattr(sys, "base_prefix", "/usr")
    assert "apt install libpython3" in hosting.missing_libpython()


def test_a_path_that_ld_preload_cannot_hold() -> None:
    """The loader splits it at spaces."""
    assert "split at spaces" in hosting.unloadable(Path("/opt/my python/libpython3.11.so"))
    assert not hosting.unloadable(Path("/opt/python/libpython3.11.so"))


def test_script(launch: list[str], tmp_path: Path) -> None:
    """The shell script does the same, passes words on, and refuses what is not there."""
    library = hosting.libpython()
    assert library is not None
    script = tmp_path / "start.sh"
    script.write_text(hosting.script(library))

    def start(*words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(["sh", str(script), *words], capture_output=True, text=True, env=clean(PATH=os.environ["PATH"]))

    done = start("sh", "-c", 'echo "$LD_PRELOAD"; command -v python3; printf "%s|" "$@"; exit 5', "name", "two words", "")
    assert done.returncode == 5
    assert done.stdout.splitlines() == [str(library), str(Path(sys.executable).parent / "python3"), "two words||"]
    assert start().returncode == 2
    missing = start("nosuchprogram")
    assert missing.returncode == 127 and "nosuchprogram" in missing.stderr
    script.write_text(hosting.script(Path("/nosuch/libpython3.so")))
    moved = start("sh")
    assert moved.returncode == 2 and "not there any more" in moved.stderr
