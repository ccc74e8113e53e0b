"""C programs in an empty environment: no launcher, no preloaded library. What they must get, and what they may do."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import pytest
from host_jobs import JOBS, POINTS, clean, job, settings, table
from test_c_host import rows

EMPTY = {"PATH": "/usr/bin:/bin", "HOME": os.environ.get("HOME", "/")}
EMPTY |= {name: os.environ[name] for name in ("XDG_CACHE_HOME",) if name in os.environ}  # where compiled kernels are kept


def bare(words: list[str], timeout: float = 120.0, **more: str) -> subprocess.CompletedProcess[str]:
    """Run a program with nothing in its environment but a path, a home and `more`."""
    environment = {**EMPTY, **more}
    return subprocess.run(words, capture_output=True, text=True, errors="replace", timeout=timeout, env=environment)


@pytest.fixture(scope="session")
def words(unzipped: Callable[[str], Path], tmp_path_factory: pytest.TempPathFactory) -> Callable[..., list[str]]:
    """Name of an FMU, perhaps another folder of it → the words that have the C host do its job (without the host itself)."""
    place = tmp_path_factory.mktemp("tables")

    def get(name: str, folder: Path | None = None) -> list[str]:
        file = place / f"{name}.csv"
        file.write_text(table(name))
        return [str(folder or unzipped(name)), str(file), *settings(name)]

    return get


@pytest.mark.parametrize("how", ["exit", "unload"])
@pytest.mark.parametrize("name", JOBS)
def test_each_fmu(
    name: str,
    how: str,
    c_host: Path,
    words: Callable[..., list[str]],
    fmu: Callable[[str], Path],
    tool: Callable[..., list[list[str]]],
) -> None:
    """Numbers equal to those in Python, to the bit; an ordinary end, with and without dlclose; nothing said on the way."""
    done = bare([str(c_host), "--end", how, *words(name)])
    assert (done.returncode, done.stderr) == (0, "")
    assert rows(done.stdout, JOBS[name][2], f"{name}_1")[1:] == tool("direct_end", job(name, str(fmu(name))))


def test_all_fmus_in_one_process(
    c_host: Path, words: Callable[..., list[str]], fmu: Callable[[str], Path], tool: Callable[..., list[list[str]]]
) -> None:
    several = [word for name in [*JOBS, "structure"] for word in ["+", *words(name)]][1:]
    done = bare([str(c_host), "--end", "unload", *several])
    assert (done.returncode, done.stderr) == (0, "")
    for number, name in enumerate([*JOBS, "structure"], start=1):
        expected = tool("direct_end", job(name, str(fmu(name))))
        assert rows(done.stdout, JOBS[name][2], f"{name}_{number}")[1:] == expected, name


def test_thirty_ordinary_ends(c_host: Path, words: Callable[..., list[str]]) -> None:
    """The exit code is the host's own, each time."""
    ends = [bare([str(c_host), "--end", ("exit", "unload")[i % 2], *words("structure")]).returncode for i in range(30)]
    assert ends == [0] * 30


@pytest.mark.parametrize("odd", ["50% #é ü", "%41%zz", "a b+c&d=e;f", "日本", b"\xff latin"], ids=str)
def test_odd_folders(odd: str | bytes, c_host: Path, words: Callable[..., list[str]], unzipped: Callable[[str], Path],
                     tmp_path: Path) -> None:  # fmt: skip
    folder = tmp_path / os.fsdecode(odd)
    shutil.copytree(unzipped("structure"), folder, ignore=shutil.ignore_patterns("__pycache__"))
    done = bare([str(c_host), *words("structure", folder)])
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == POINTS + 1


# -- which Python


@pytest.fixture
def portable(unzipped: Callable[[str], Path], tmp_path: Path) -> Path:
    """The structure as it is built, before it is installed: without the path of a Python."""
    folder = tmp_path / "portable"
    shutil.copytree(unzipped("structure"), folder, ignore=shutil.ignore_patterns("__pycache__", "python.txt"))
    return folder


def test_python_on_path(c_host: Path, words: Callable[..., list[str]], portable: Path) -> None:
    first = str(Path(sys.executable).parent)
    done = bare([str(c_host), *words("structure", portable)], PATH=f"{first}:/usr/bin:/bin")
    assert (done.returncode, done.stderr) == (0, "")


def test_python_of_the_variable(c_host: Path, words: Callable[..., list[str]], portable: Path) -> None:
    done = bare([str(c_host), *words("structure", portable)], AEROSLOSH_PYTHON=sys.executable, PATH="/nowhere")
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize(("python", "said"), [("/no/such/python3", "there is no such program"), ("/bin/true", "it does not run")])
def test_the_variable_is_never_passed_over(
    python: str, said: str, c_host: Path, words: Callable[..., list[str]], unzipped: Callable[[str], Path]
) -> None:
    done = bare([str(c_host), *words("structure")], AEROSLOSH_PYTHON=python)
    assert done.returncode == 3
    assert f"AEROSLOSH_PYTHON = {python}: {said}" in done.stderr and "Remedy: " in done.stderr


def test_no_python_at_all(c_host: Path, words: Callable[..., list[str]], portable: Path) -> None:
    done = bare([str(c_host), *words("structure", portable)], PATH="/nowhere")
    assert done.returncode == 3
    assert "no Python for this FMU: python3 on PATH is none: there is no such program" in done.stderr
    assert "Remedy: set AEROSLOSH_PYTHON" in done.stderr


def test_a_python_without_the_packages(c_host: Path, words: Callable[..., list[str]], portable: Path, tmp_path: Path) -> None:
    """Its name, what it lacks and what to do, before anything of it is loaded; in the log where there is one, else on stderr."""
    subprocess.run([sys.executable, "-m", "venv", "--without-pip", str(tmp_path / "bare")], check=True)
    path = f"{tmp_path / 'bare' / 'bin'}:/usr/bin:/bin"
    for log in ([], ["--log"]):
        done = bare([str(c_host), *log, *words("structure", portable)], PATH=path)
        assert done.returncode == 3
        assert "it has not the packages numpy" in done.stderr and "bare/bin/python3" in done.stderr
        assert "requirements.txt" in done.stderr and "fmi2Instantiate gave no instance" in done.stderr


def test_an_installed_path_that_is_gone_is_passed_over(c_host: Path, words: Callable[..., list[str]], portable: Path) -> None:
    (portable / "resources" / "python.txt").write_text("/gone/bin/python3\n")
    first = str(Path(sys.executable).parent)
    done = bare([str(c_host), *words("structure", portable)], PATH=f"{first}:/usr/bin:/bin")
    assert (done.returncode, done.stderr) == (0, "")


def test_a_preloaded_library_of_another_version_is_heeded(
    c_host: Path, words: Callable[..., list[str]], portable: Path, launch: list[str]
) -> None:
    """What is in the process decides which Python is taken: the installed one is passed over, that on PATH is of its version."""
    other = next((python for python in _others() if f"{sys.version_info[0]}.{sys.version_info[1]}" not in python), None)
    if other is None:
        pytest.skip("there is no other Python with a shared library here")
    (portable / "resources" / "python.txt").write_text(f"{other}\n")
    done = bare([*launch, str(c_host), *words("structure", portable)])
    assert (done.returncode, done.stderr) == (0, "")


def _others() -> list[str]:
    """Other Pythons of this machine, new enough and with a shared library, by their executables."""
    found = sorted(Path("/root/.pyenv/versions").glob("3.1[1-9].*/bin/python3")) if os.access("/root/.pyenv", os.R_OK) else []
    found += [Path(path) for name in ("3.11", "3.12", "3.13", "3.14", "3.15") if (path := shutil.which(f"python{name}"))]
    seen = {}
    for python in found:
        ask = "import sys, sysconfig; print(sys.version_info[:2], sysconfig.get_config_var('Py_ENABLE_SHARED'))"
        done = subprocess.run([str(python), "-c", ask], capture_output=True, text=True, env=clean())
        if done.returncode == 0 and done.stdout.strip().endswith(" 1"):
            seen.setdefault(done.stdout, str(python))
    return list(seen.values())


@pytest.mark.parametrize("python", _others())
def test_other_pythons_are_started(
    python: str, c_host: Path, words: Callable[..., list[str]], portable: Path, tmp_path: Path
) -> None:
    """What they have no packages for, a stand-in does: this is about the library and Python's C API, not about numpy."""
    slave = next((portable / "resources").glob("*_slave.py"))
    slave.write_text(STAND_IN)
    (portable / "resources" / "requirements.txt").write_text("")
    done = bare([str(c_host), "--end", "unload", *words("structure", portable)], AEROSLOSH_PYTHON=python)
    assert (done.returncode, done.stderr) == (0, "")
    assert len(done.stdout.splitlines()) == POINTS + 1


STAND_IN = '''
import sys, sysconfig
class SLAVE:
    """What the library calls, with no package at all."""
    def __init__(self, instance_name, resources, visible):
        self.log_queue, self.vars, self.values, self.time = [], range(1000), {}, 0.0
        assert sys.flags.utf8_mode == 1 and sys.flags.ignore_environment == 1 and sys.prefix
    def get(self, vrs): return [self.values.get(vr, 0.0) for vr in vrs]
    def set(self, vrs, values): self.values.update(zip(vrs, values))
    def do_step(self, time, step_size):
        self.time = time + step_size
        return True
    get_real = get_integer = get_boolean = get
    def get_string(self, vrs): return [""] * len(vrs)
    set_real = set_integer = set_boolean = set_string = set
    def setup_experiment(self, *_): pass
    def terminate(self): pass
    enter_initialization_mode = exit_initialization_mode = terminate
    def _get_fmu_state(self): return dict(self.values)
    def _set_fmu_state(self, state): self.values = dict(state)
    def _fmu_state_to_bytes(self, state): return b"{}"
    def _fmu_state_from_bytes(self, data): return {}
'''

# -- what a host may do, and what it must not


@pytest.fixture(scope="session")
def abuse(tmp_path_factory: pytest.TempPathFactory, unzipped: Callable[[str], Path]) -> Callable[..., list[str]]:
    """FMU, mode and numbers → the words that start abuse.c."""
    compiler = shutil.which("cc")
    if compiler is None:
        pytest.skip("no C compiler `cc`")
    program = tmp_path_factory.mktemp("abuse") / "abuse"
    source = Path(__file__).with_name("abuse.c")
    options = ["-std=c11", "-O1", "-g", "-Wall", "-Wextra", "-Werror"]
    subprocess.run([compiler, *options, str(source), "-o", str(program), "-ldl", "-lpthread", "-lm"], check=True)

    def get(name: str, *mode: object, folder: Path | None = None) -> list[str]:
        return [str(program), *_library(folder or unzipped(name), name, True), *map(str, mode)]

    return get


def _library(folder: Path, name: str, references: bool) -> list[str]:
    """Path, URI and GUID of an FMU, and the references of its Real inputs and outputs."""
    root = ElementTree.parse(folder / "modelDescription.xml").getroot()
    reals = {
        causality: ",".join(
            v.attrib["valueReference"]
            for v in root.iter("ScalarVariable")
            if v.attrib["causality"] == causality and v.find("Real") is not None
        )
        for causality in ("input", "output")
    }
    words = [str(folder / "binaries" / "linux64" / f"{name}.so"), (folder / "resources").as_uri(), root.attrib["guid"]]
    return [*words, *reals.values()] if references else words


@pytest.mark.parametrize("mode", [("threads", 8), ("fork",), ("reload", 5)], ids=lambda mode: mode[0])
def test_it_is_left_alone(mode: tuple[object, ...], abuse: Callable[..., list[str]]) -> None:
    done = bare(abuse("structure", *mode))
    assert (done.returncode, done.stdout, done.stderr) == (0, "ended\n", "")


def test_interrupt_is_the_hosts(abuse: Callable[..., list[str]]) -> None:
    """SIGINT ends the program as if there were no Python in it."""
    done = bare(abuse("structure", "interrupt"))
    assert (done.returncode, done.stdout) == (-signal.SIGINT, "")


def test_two_copies_in_one_process(abuse: Callable[..., list[str]], unzipped: Callable[[str], Path], tmp_path: Path) -> None:
    """Their instances and states are their own."""
    shutil.copytree(unzipped("structure"), tmp_path / "copy", ignore=shutil.ignore_patterns("__pycache__"))
    done = bare(abuse("structure", "copies", *_library(tmp_path / "copy", "structure", False)))
    assert (done.returncode, done.stdout) == (0, "ended\n")


@pytest.mark.parametrize("name", ["structure", "slosh_vof"])
def test_any_call_with_any_argument(name: str, abuse: Callable[..., list[str]]) -> None:
    done = bare(abuse(name, "fuzz", 1, 200_000 if name == "structure" else 5_000), 300.0)
    assert (done.returncode, done.stdout[-6:]) == (0, "ended\n"), done.stdout[-500:] + done.stderr[-2000:]


@pytest.mark.validation
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", JOBS)
def test_any_call_with_any_argument_for_longer(name: str, seed: int, abuse: Callable[..., list[str]]) -> None:
    done = bare(abuse(name, "fuzz", 7 + seed, 200_000), 3000.0)
    assert (done.returncode, done.stdout[-6:]) == (0, "ended\n"), done.stdout[-500:] + done.stderr[-2000:]


def test_memory_is_flat(abuse: Callable[..., list[str]]) -> None:
    """Instances that step, save, fail and go leave nothing."""
    done = bare(abuse("structure", "many", 2000))
    assert done.returncode == 0, done.stdout
    early, late = map(int, done.stdout.split()[:2])
    assert late - early < 1000, f"1800 instances left {late - early} kB"


@pytest.mark.validation
@pytest.mark.parametrize("name", ["structure", "slosh_ems"])
def test_memory_is_flat_over_ten_thousand(name: str, abuse: Callable[..., list[str]]) -> None:
    done = bare(abuse(name, "many", 10_000), 1200.0)
    early, late = map(int, done.stdout.split()[:2])
    assert late - early < 2000, f"9000 instances left {late - early} kB"


def test_valgrind_finds_nothing_of_ours(abuse: Callable[..., list[str]], tmp_path: Path) -> None:
    """No access to what is not its own, no block lost; Python itself is not looked at."""
    valgrind = shutil.which("valgrind") or "/usr/bin/valgrind"
    if not os.access(valgrind, os.X_OK):
        pytest.skip("valgrind is not installed")
    report = tmp_path / "report.xml"
    options = ["--quiet", "--xml=yes", f"--xml-file={report}", "--num-callers=40", "--leak-check=full"]
    # with malloc for each object, valgrind sees one that is used after it was given back
    done = bare([valgrind, *options, *abuse("structure", "fuzz", 3, 1500)], 400.0, PYTHONMALLOC="malloc")
    assert done.returncode == 0, done.stdout + done.stderr
    ours = []
    for error in ElementTree.parse(report).getroot().iter("error"):
        stack = [Path(frame.findtext("obj", "")).name for frame in error.iter("frame")]
        lost = error.findtext("kind", "").startswith("Leak")
        # a leak is ours where our code asked for the block, an access where our code is on the way at all
        if "structure.so" in (stack[:2] if lost else stack):
            ours.append(ElementTree.tostring(error, encoding="unicode"))
    assert not ours, ours[0]


def test_two_versions_of_one_fmu(
    c_host: Path, words: Callable[..., list[str]], unzipped: Callable[[str], Path], tmp_path: Path
) -> None:
    """Another version is another module: each answers with its own code."""
    other = tmp_path / "other"
    with zipfile.ZipFile(_other_version(tmp_path)) as archive:
        archive.extractall(other)
    done = bare([str(c_host), *words("structure"), "+", *words("structure", other)], AEROSLOSH_PYTHON=sys.executable)
    assert (done.returncode, done.stderr) == (0, "")
    energy = {}
    for number in (1, 2):
        energy[number] = [float.fromhex(row[0]) for row in rows(done.stdout, ["energy"], f"structure_{number}")]
    assert energy[2] == [2.0 * value for value in energy[1]] and energy[1][-1] > 0.0


def _other_version(place: Path) -> Path:
    """The structure with its energy twice."""
    from aeroslosh.fmus.build import archive as build

    root = place / "fmus"
    shutil.copytree(build.ROOT, root, ignore=shutil.ignore_patterns("__pycache__"))
    face = root / "structure" / "fmu.py"
    text = face.read_text()
    assert "self.energy = " in text
    face.write_text(text.replace("self.energy = ", "self.energy = 2.0 * "))
    return build.build(root / "structure", place, check=False, root=root)
