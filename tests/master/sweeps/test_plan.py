"""Sweeps planned: which points come out of a case, what is refused before anything runs, what makes a point the same point."""

from __future__ import annotations

import itertools
import math
from pathlib import Path

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case import case as cases
from aeroslosh.master.sweeps import parameters, plan
from aeroslosh.master.sweeps.plan import Plan

HEAD = """\
section = { chord = 1, elastic_axis = -0.5, x_alpha = 1.8, r2_alpha = 3.48, frequency_ratio = 1, mass_ratio = 60 }
flow = { mach = 0.5, airfoil = "NACA 64A010" }
[flutter]
V_f = 0.6
"""
TANK = "[slosh]\ntank_length = 0.5\ntank_height = 0.15\nfill_level = 0.5\ntank_x = 0\ntank_y = 0\nliquid_density = 800\n"
TANK += "liquid_viscosity = 2e-6\n"


@pytest.fixture
def fmus(tmp_path: Path) -> Path:
    """A folder of files that pass for FMUs: a plan looks at their bytes alone."""
    folder = tmp_path / "fmus"
    folder.mkdir()
    for name in ("structure", "aero", "slosh_ems"):
        (folder / f"{name}.fmu").write_bytes(name.encode())
    return folder


def planned(folder: Path, fmus: Path, text: str, *overrides: str, name: str = "case") -> Plan:
    """The plan of a case file with `text`."""
    path = folder / f"{name}.toml"
    path.write_text(HEAD + text)
    case = cases.load(path, overrides)
    return plan.make(case, parameters.from_case(case, path), fmus, str(path))


def refused(folder: Path, fmus: Path, text: str, *overrides: str) -> str:
    """The message for a case file with `text`."""
    with pytest.raises(AeroSloshError) as caught:
        planned(folder, fmus, text, *overrides)
    assert caught.value.code == ExitCode.INPUT and caught.value.remedy
    return str(caught.value)


def test_a_grid_is_every_combination_the_last_key_fastest(tmp_path: Path, fmus: Path) -> None:
    text = '[sweep.parameters]\n"flow.mach" = [0.4, 0.5]\n"flutter.V_f" = { from = 0.4, to = 0.8, count = 5 }\n'
    made = planned(tmp_path, fmus, text)
    values = list(itertools.product([0.4, 0.5], [0.4, 0.5, 0.6, 0.7, 0.8]))  # 0.6, not 0.6000000000000001
    assert [tuple(p.overrides.values()) for p in made.points] == values
    assert [(p.case.flow.mach, p.case.flutter.V_f) for p in made.points] == values
    assert [p.index for p in made.points] == list(range(10)) and len({p.id for p in made.points}) == 10


def test_dotted_keys_need_no_quotes(tmp_path: Path, fmus: Path) -> None:
    quoted = planned(tmp_path, fmus, '[sweep.parameters]\n"flow.mach" = [0.4, 0.5]\n')
    bare = planned(tmp_path, fmus, "[sweep.parameters]\nflow.mach = [0.4, 0.5]\n")
    assert [p.id for p in quoted.points] == [p.id for p in bare.points]


def test_a_list_takes_values_together(tmp_path: Path, fmus: Path) -> None:
    text = '[sweep]\nmode = "list"\n[sweep.parameters]\n"section.x_alpha" = [1.0, 2.0]\n"section.r2_alpha" = [1.5, 4.5]\n'
    made = planned(tmp_path, fmus, text)  # x_alpha = 2 alone would not go with r2_alpha = 3.48
    assert [(p.case.section.x_alpha, p.case.section.r2_alpha) for p in made.points] == [(1.0, 1.5), (2.0, 4.5)]


def test_a_latin_hypercube_has_one_value_in_each_slice_and_is_repeatable(tmp_path: Path, fmus: Path) -> None:
    text = (
        f'[sweep]\nmode = "latin-hypercube"\nsamples = 16\nseed = 7\n{TANK}model = "ems"\n[sweep.parameters]\n'
        '"flutter.V_f" = { from = 0.1, to = 10, spacing = "log" }\n'
        '"slosh.modes" = { from = 1, to = 400 }\n"slosh.split" = ["frozen", "none"]\n'
    )
    made = planned(tmp_path, fmus, text)
    slices = sorted(int(8 * (math.log10(p.case.flutter.V_f) + 1.0)) for p in made.points)
    assert slices == list(range(16))
    assert all(isinstance(p.case.slosh.modes, int) for p in made.points)
    assert sum(p.case.slosh.split == "none" for p in made.points) == 8
    assert [p.id for p in planned(tmp_path, fmus, text).points] == [p.id for p in made.points]
    assert {p.id for p in planned(tmp_path, fmus, text, "sweep.seed=8").points}.isdisjoint({p.id for p in made.points})


def test_the_same_point_twice_is_one_point(tmp_path: Path, fmus: Path) -> None:
    made = planned(tmp_path, fmus, '[sweep.parameters]\n"flow.mach" = [0.4, 0.5, 0.4]\n')
    assert len(made.points) == 2 and made.repeated == 1


def test_the_id_is_what_the_point_is_made_of_and_nothing_else(tmp_path: Path, fmus: Path) -> None:
    text = '[sweep.parameters]\n"flow.mach" = [0.4]\n'
    first = planned(tmp_path, fmus, text).points[0].id
    assert planned(tmp_path, fmus, text, name="other").points[0].id == first
    assert planned(tmp_path, fmus, text, "output.pictures=false", "boundary.tolerance=0.01").points[0].id == first
    assert planned(tmp_path, fmus, text, "flow.mach=0.7").points[0].id == first  # swept: the case's own value does not matter
    assert planned(tmp_path, fmus, text, "flutter.V_f=0.61").points[0].id != first
    assert planned(tmp_path, fmus, text, "sweep.command=boundary").points[0].id != first
    (fmus / "aero.fmu").write_bytes(b"another")
    assert planned(tmp_path, fmus, text).points[0].id != first


def test_an_airfoil_file_counts_by_its_content(tmp_path: Path, fmus: Path) -> None:
    text = '[sweep.parameters]\n"flow.airfoil" = ["foil.dat", "NACA 0012"]\n'
    ids = []
    for place, content in (("a", "1 0"), ("b", "1 0"), ("b", "1 1")):
        folder = tmp_path / place
        folder.mkdir(exist_ok=True)
        (folder / "foil.dat").write_text(content)
        made = planned(folder, fmus, text)
        assert Path(made.points[0].case.flow.airfoil) == folder / "foil.dat" and "airfoil" in made.points[0].files
        ids.append(made.points[0].id)
    assert ids[0] == ids[1] != ids[2]


def test_flow_mach_sweeps_the_mach_number_of_a_boundary(tmp_path: Path, fmus: Path) -> None:
    made = planned(tmp_path, fmus, '[sweep]\ncommand = "boundary"\n[sweep.parameters]\n"flow.mach" = [0.4, 0.5]\n')
    assert [p.case.boundary.mach for p in made.points] == [[0.4], [0.5]]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("", ["has no parameters", "--grid flow.mach"]),
        ('[sweep.parameters]\n"flow.machh" = [0.4]\n', ["line 6", "Unknown key 'machh'", "did you mean 'mach'"]),
        ('[sweep.parameters]\n"flaw.mach" = [0.4]\n', ["line 6", "flaw.mach", "did you mean 'flow'"]),
        ('[sweep.parameters]\n"mach" = [0.4]\n', ["line 6", "no table.key"]),
        ('[sweep.parameters]\n\n"flow.mach" = [0.4, 3.0]\n', ["line 7", "flow.mach = 3.0", "out of range"]),
        ('[sweep.parameters]\n"flow.mach" = []\n', ["line 6", "no values"]),
        ('[sweep.parameters]\n"flow.mach" = 0.4\n', ["line 6", "list of values or a range"]),
        ('[sweep.parameters]\n"flow.mach" = { from = 0.4, to = 0.8 }\n', ["line 6", "no count"]),
        ('[sweep.parameters]\n"flow.mach" = { from = 0.8, to = 0.4, count = 3 }\n', ["line 6", "from < to"]),
        ('[sweep.parameters]\n"flow.mach" = { from = 0.4, to = 0.8, count = 1 }\n', ["line 6", "count = 1"]),
        ('[sweep.parameters]\n"flow.mach" = { from = 0.4, to = 0.8, cuont = 3 }\n', ["line 6", "cuont", "did you mean 'count'"]),
        ('[sweep.parameters]\n"slosh.tank_x" = { from = 0, to = 1, count = 3, spacing = "log" }\n', ["starts above 0"]),
        ('[sweep.parameters]\n"boundary.tolerance" = [0.1]\n', ["changes nothing", "boundary"]),
        ('[sweep.parameters]\n"output.pictures" = [true]\n', ["changes nothing"]),
        ('[sweep.parameters]\n"section.x_alpha" = [1.0, 2.0]\n', ["point 2", "section.x_alpha = 2.0", "not positive"]),
        (f'{TANK}[sweep.parameters]\n"slosh.model" = ["ems", "vof"]\n', ["slosh_vof.fmu", "make fmus"]),
        ('[sweep]\nmode = "list"\n[sweep.parameters]\n"flow.mach" = [0.4]\n"flutter.V_f" = [0.4, 0.5]\n', ["as many values"]),
        ('[sweep]\nmode = "grit"\n', ["line 6", "available: grid, list, latin-hypercube"]),
        (
            '[sweep.parameters]\n"flow.mach" = { from = 0.4, to = 0.8, count = 1000 }\n'
            '"flutter.V_f" = { from = 1, to = 2, count = 101 }\n',
            ["101,000 points", "at most"],
        ),
    ],
)
def test_refusals_name_place_and_remedy(tmp_path: Path, fmus: Path, text: str, says: list[str]) -> None:
    message = refused(tmp_path, fmus, text)
    for part in says:
        assert part in message, message


def test_the_command_line_says_the_same() -> None:
    listed = parameters.from_words("flow.mach=0.7,0.8", "--grid")
    assert listed.values == (0.7, 0.8) and listed.where == "--grid flow.mach=0.7,0.8"
    spread = parameters.from_words("slosh.damping_ratio=0.001:0.1:3:log", "--grid")
    assert (spread.low, spread.high, spread.count, spread.log) == (0.001, 0.1, 3, True)
    assert parameters.from_words("slosh.model=ems, frozen", "--grid").values == ("ems", "frozen")
    for bad in (
        "flow.mach",
        "flow.mach=",
        "flow.mach=a:b",
        "flow.mach=1:2:3:4:5",
        "flow.mach=0.4:0.8:2.5",
        "flow.mach=0.4:0.2:3",
    ):
        with pytest.raises(AeroSloshError) as caught:
            parameters.from_words(bad, "--grid")
        assert "--grid" in str(caught.value) and caught.value.remedy
