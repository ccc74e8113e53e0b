"""The wheel, installed outside the checkout: FMUs are built at first use, cases are known by name, nothing else is touched.

The packages it depends on are those of this environment (a .pth file names their folder; the checkout itself is not on it);
`make validate` installs them anew as well."""

from __future__ import annotations

import json
import os
import stat
import subprocess
import sys
import sysconfig
import tarfile
import venv
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from support.once import once
from support.paths import ROOT

QUICK = [
    "--set", "aero.cells_around=64", "--set", "aero.cells_normal=16", "--set", "flutter.free_cycles=2.0", "--set",
    "flutter.steps_per_cycle=48", "--no-pictures",
]  # fmt: skip
Run = subprocess.CompletedProcess[str]


def build(folder: Path, *flags: str) -> None:
    """A wheel or sdist of the checkout into `folder`."""
    code = f"from setuptools import build_meta as b; b.build_{flags[0]}({str(folder)!r})"
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout + done.stderr


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Path]:
    """A folder with a blank in its name, the wheel installed in an environment of its own there."""

    def fill(folder: Path) -> None:
        build(folder, "wheel")
        environment = folder / "some where" / "env"
        venv.create(environment, symlinks=True)
        packages = next((environment / "lib").glob("python3*")) / "site-packages"
        with zipfile.ZipFile(next(folder.glob("*.whl"))) as wheel:
            wheel.extractall(packages)
        (packages / "others.pth").write_text(sysconfig.get_path("purelib") + "\n")
        for path in [*packages.rglob("*"), packages]:  # an administrator's: nobody may write there
            path.chmod(path.stat().st_mode & ~(stat.S_IWUSR | stat.S_IWGRP | stat.S_IWOTH))

    yield once(tmp_path_factory, "wheel", fill)


def aeroslosh(place: Path, folder: Path, *words: str, home: str = "", code: int = 0) -> Run:
    """The command of the wheel, in `folder`, with nothing of this environment."""
    python = place / "some where" / "env" / "bin" / "python"
    environment = {"PATH": "/usr/bin:/bin", "TMPDIR": str(folder)} | ({"HOME": home} if home else {})
    done = subprocess.run([python, "-m", "aeroslosh", *words], cwd=folder, capture_output=True, text=True, env=environment)
    assert done.returncode == code, done.stdout + done.stderr
    return done


@pytest.fixture(scope="module")
def home(place: Path, tmp_path_factory: pytest.TempPathFactory) -> str:
    """A home folder in which the FMUs were built, by the first command that needs them; kernels come from this cache."""

    def fill(folder: Path) -> None:
        cache = folder / ".cache" / "aeroslosh"
        cache.mkdir(parents=True)
        mine = Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "aeroslosh"
        for kept in mine.iterdir() if mine.is_dir() else []:
            if len(kept.name) == 12 and kept.is_dir():
                (cache / kept.name).symlink_to(kept)
        done = aeroslosh(place, folder, "point", "isogai_a", *QUICK, "--json", home=str(folder))
        assert "building the FMUs, once" in done.stderr and json.loads(done.stdout)["verdict"]

    return str(once(tmp_path_factory, "home", fill))


def test_the_wheel_holds_everything_and_one_name(place: Path) -> None:
    with zipfile.ZipFile(next(place.glob("*.whl"))) as wheel:
        names = set(wheel.namelist())
    assert {name.split("/")[0].split("-")[0] for name in names} == {"aeroslosh"}
    wanted = [
        "fmus/slosh_rbf/weights/default.npz", "fmus/aero/naca6a.csv", "fmus/aero/airfoil_names.json", "fmus/aero/icon.png",
        "fmus/slosh_vof/reference/picture.svg", "fmus/slosh_ems/README.md", "cases/isogai_a.toml", "py.typed",
        "master/boundary/published.csv", "master/api/case.py",
    ]  # fmt: skip
    assert {f"aeroslosh/{name}" for name in wanted} <= names
    tracked = subprocess.run(
        ["git", "ls-files", "fmus", "master", "cases"], cwd=ROOT, capture_output=True, text=True
    ).stdout.split()
    assert {f"aeroslosh/{name}" for name in tracked} <= names


def test_the_sdist_builds_the_same_wheel(tmp_path: Path, place: Path) -> None:
    build(tmp_path, "sdist")
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path, filter="data")
    source = next(path for path in tmp_path.iterdir() if path.is_dir())
    code = f"from setuptools import build_meta as b; b.build_wheel({str(tmp_path)!r})"
    done = subprocess.run([sys.executable, "-c", code], cwd=source, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    mine, direct = (zipfile.ZipFile(next(folder.glob("*.whl"))) for folder in (tmp_path, place))
    with mine, direct:
        names = {n for n in direct.namelist() if not n.endswith("RECORD")}
        assert {n for n in mine.namelist() if not n.endswith("RECORD")} == names
        assert [n for n in names if mine.read(n) != direct.read(n)] == []


def test_sweep_boundary_and_run_in_an_empty_folder(place: Path, home: str, tmp_path: Path) -> None:
    small = [*QUICK, "--json", "--quiet"]
    found = json.loads(aeroslosh(place, tmp_path, "sweep", "isogai_a", "--grid", "flutter.V_f=0.5,0.7", *small, home=home).stdout)
    assert found["done"] == 2 and (tmp_path / "runs" / "isogai_a_sweep" / "sweep.csv").is_file()
    done = aeroslosh(place, tmp_path, "boundary", "isogai_a", "--mach", "0.8", "--method", "linear", *small, home=home)
    assert json.loads(done.stdout)["points"][0]["crossings"]
    aeroslosh(place, tmp_path, "run", "tank_on_springs", "--set", "run.end=0.5", "--no-pictures", "--quiet", home=home)
    assert "network" in aeroslosh(place, tmp_path, "train", "--help", home=home).stdout


def test_the_papers_figures_in_an_empty_folder(place: Path, home: str, tmp_path: Path) -> None:
    done = aeroslosh(place, tmp_path, "paper", "fig18", "fig20", "--coarse", "--json", home=home)
    assert [row["failed"] for row in json.loads(done.stdout)["figures"]] == [None, None]
    assert (tmp_path / "runs" / "paper" / "fig20" / "picture.png").is_file()


def test_doctor_finds_the_fmus(place: Path, home: str, tmp_path: Path) -> None:
    done = aeroslosh(place, tmp_path, "doctor", "--no-self-test", "--json", home=home)
    assert "by aero, slosh_vof, structure" in done.stdout  # read from the FMUs that were built


def test_without_a_home_the_temporary_folder_does(place: Path, tmp_path: Path) -> None:
    """A home that cannot be made: what is kept goes below the temporary folder, as for a second user of one installation."""
    done = aeroslosh(place, tmp_path, "run", "tank_on_springs", "--set", "run.end=0.1", "--no-pictures", home="/dev/null")
    assert "completed" in done.stdout and list(tmp_path.glob("aeroslosh-*/built/*/slosh_ems.fmu"))
