"""Who may import whom: the rooms of `master/` stand on floors, nobody looks up, and every module has one name.

The picture: docs/pictures/rooms.svg, drawn by docs/rooms.py, whose functions read the code here."""

from __future__ import annotations

import importlib.util
import json
import re
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import pytest

from support.paths import ROOT, TESTS
from support.processes import supported

# room → rooms of master that it may import. An edge that nothing needs any more leaves this table (there is a test).
MAY = {
    "base": "",
    "fmi": "base",
    "cosim": "base fmi",
    "case": "base fmi cosim",
    "analysis": "",
    "flutter": "base fmi cosim case analysis",
    "linear": "base fmi case analysis flutter",
    "boundary": "base cosim case analysis flutter linear",
    "results": "base fmi cosim case analysis flutter boundary",
    "pictures": "base fmi case flutter linear boundary results",
    "report": "base case cosim pictures results",
    "sweeps": "base fmi cosim case analysis flutter linear boundary results",
    "ssp": "base cosim case flutter results",
    "hosts": "base fmi pictures",
    "training": "base fmi case",
    "api": "base fmi cosim case analysis flutter boundary results pictures report sweeps",
    "paper": "base fmi case results pictures training api",
    "commands": "base fmi cosim case analysis flutter boundary results pictures sweeps ssp hosts training api paper",
    "cli": "base commands",
}
# Who of master knows components: what trains the network of slosh_rbf, what builds FMUs where there are none, what tries the
# FMUs' library in a program that is no Python, and figures of the paper that are of a component's parts (its grid, its equations,
# its excitation).
KNOWS_COMPONENTS = {"master.commands.train", "master.commands.train_violent", "master.fmi.installed", "master.hosts.bare"} | {
    f"master.paper.{name}" for name in ("fig8", "fig18", "fig19", "fig20", "surrogate", "tank")
}


def rooms_script() -> ModuleType:
    """docs/rooms.py as a module."""
    spec = importlib.util.spec_from_file_location("rooms", ROOT / "docs" / "rooms.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


rooms = rooms_script()
FOUND = rooms.every_import()
PAIRS = {(one.user, one.used) for one in FOUND}


def of_rooms() -> set[tuple[str, str]]:
    """Pairs of modules in different rooms of master."""
    here = {(user, used) for user, used in PAIRS if user.startswith("master.") and used.startswith("master.")}
    return {(user, used) for user, used in here if rooms.room(user) != rooms.room(used)}


def test_every_room_is_known_and_stands_on_one_floor() -> None:
    folders = {path.parent.name for path in (ROOT / "master").glob("*/__init__.py")} | {"cli"}
    floors = [name for floor in rooms.FLOORS for name in floor]
    assert folders == set(MAY) == set(floors) == set(rooms.WHAT) and len(floors) == len(MAY)


def test_the_table_allows_nothing_on_the_same_floor_or_above() -> None:
    level = {name: n for n, floor in enumerate(rooms.FLOORS) for name in floor}
    assert [(room, used) for room, may in MAY.items() for used in may.split() if level[used] >= level[room]] == []


@pytest.mark.parametrize("room", MAY)
def test_a_room_imports_what_it_may_and_the_table_no_more_than_that(room: str) -> None:
    mine = {(user, used) for user, used in of_rooms() if rooms.room(user) == room}
    assert {(user, used) for user, used in mine if rooms.room(used) not in MAY[room].split()} == set()
    assert {rooms.room(used) for _, used in mine} == set(MAY[room].split())


def test_there_is_no_circle_of_modules() -> None:
    """In fmus and master; a package that is imported for one of its modules is not counted as a user of the others."""
    users: dict[str, set[str]] = {}
    for user, used in PAIRS:
        users.setdefault(user, set()).add(used)
    done: set[str] = set()

    def follow(module: str, way: tuple[str, ...]) -> None:
        assert module not in way, " → ".join((*way[way.index(module) :], module))
        if module not in done:
            for used in sorted(users.get(module, ())):
                follow(used, (*way, module))
            done.add(module)

    for module in sorted(users):
        follow(module, ())
    assert len(done) > 100


def test_components_do_not_know_the_master_and_the_master_trains_them_alone() -> None:
    assert {pair for pair in PAIRS if pair[0].startswith("fmus") and pair[1].startswith("master")} == set()
    knowing = {user for user, used in PAIRS if user.startswith("master") and used.startswith("fmus")}
    assert knowing == KNOWS_COMPONENTS


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("from ..base import errors, files\n", {"master.base.errors", "master.base.files"}),
        ("from ..base.errors import show as s\n", {"master.base.errors"}),
        ("from . import log\n", {"master.fmi.log"}),
        ("from .. import cli\n", {"master.cli"}),
        ("import aeroslosh.fmus.kit.vtk\n", {"fmus.kit.vtk"}),
        ("from aeroslosh.master import cli\n", {"master.cli"}),
        ("def f():\n    if True:\n        from ..base import vtk\n", {"master.base.vtk"}),
        ("if TYPE_CHECKING:\n    from ..base import vtk\nelse:\n    from ..base import pvd\n", {"master.base.pvd"}),
        ("import os\nfrom numpy import linalg\n", set()),
    ],
)
def test_every_form_of_import_is_seen(tmp_path_factory: pytest.TempPathFactory, text: str, expected: set[str]) -> None:
    path = tmp_path_factory.mktemp("room") / "new.py"
    path.write_text(text)
    assert {one.used for one in rooms.imports("master.fmi.new", path, rooms.modules())} == expected


KERNEL = re.compile(r"aeroslosh_[0-9a-f]{12}[._]")
NAMES = """
import importlib, json, os, sys
for name in json.loads(sys.argv[1]):
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name != "torch":  # which only training needs, and not every installation has
            raise
seen = {}
for name, module in list(sys.modules.items()):
    file = getattr(module, "__file__", None)
    if file and os.path.realpath(file).startswith(sys.argv[2] + os.sep):
        seen.setdefault(os.path.realpath(file), []).append(name)
print(json.dumps(seen))
"""


def test_no_file_is_loaded_under_two_names() -> None:
    """All modules in one process whose folder holds `master` and `fmus` too, as a checkout does."""
    wanted = ["aeroslosh", *(f"aeroslosh.{name}" for name in rooms.modules() if not name.endswith("__main__"))]
    words = [sys.executable, "-c", NAMES, json.dumps(wanted), str(ROOT)]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, env=supported())
    assert done.returncode == 0, done.stderr
    seen = {file: names for file, names in json.loads(done.stdout).items() if "/.venv/" not in file}
    # a kernel is compiled under the name of its content as well (fmus/kit/cache.py): FMUs share what was compiled
    plain = {file: [name for name in names if not KERNEL.match(name)] for file, names in seen.items()}
    assert [names for names in plain.values() if len(names) != 1 or not names[0].startswith("aeroslosh")] == []
    assert {Path(file).relative_to(ROOT).parts[0] for file in seen if seen[file] != plain[file]} <= {"fmus"}
    assert len(seen) > 0.9 * len(wanted)


def test_every_room_has_its_tests_under_its_name() -> None:
    """tests/master/<room>, or tests/<room> where the tests are of other people's tools; those of cli are with the commands."""
    tested = {path.parent for path in TESTS.rglob("test_*.py")}
    missing = [room for room in set(MAY) - {"cli"} if not {TESTS / "master" / room, TESTS / room} & tested]
    assert missing == []


def test_the_picture_is_of_this_code() -> None:
    assert rooms.DATA.read_text(encoding="utf-8") == rooms.table(rooms.edges(FOUND)), "run python docs/rooms.py"


def test_pages_and_comments_name_modules_and_tests_that_exist() -> None:
    word = re.compile(r"\b(?:tests|master|fmus|studies|benchmarks)/[\w/]+\.(?:py|csv|c)\b")
    told = [ROOT / "README.md", *(ROOT / "docs").glob("*.md")]
    for folder in ("master", "fmus", "studies", "benchmarks", "examples", "tests/support"):
        told += [path for ending in ("py", "md") for path in (ROOT / folder).rglob(f"*.{ending}")]
    named = {(path.relative_to(ROOT), name) for path in told for name in word.findall(path.read_text(encoding="utf-8"))}
    assert [(path, name) for path, name in named if not (ROOT / name).is_file()] == []
    assert len(named) > 20
