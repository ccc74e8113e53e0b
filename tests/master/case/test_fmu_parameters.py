"""Parameters of the FMUs in a case: what reaches them, what is refused and with which words."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest

from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case import case as cases
from aeroslosh.master.case import fmu_parameters, fuel_tank
from aeroslosh.master.case.case import Case
from aeroslosh.master.flutter.setup import FlutterSetup
from aeroslosh.master.fmi.component import Component, ComponentError
from aeroslosh.master.sweeps import parameters, plan

HEAD = """\
section = { chord = 2, elastic_axis = -0.5, x_alpha = 1.8, r2_alpha = 3.48, frequency_ratio = 1, mass_ratio = 60 }
flow = { mach = 0.5, airfoil = "NACA 64A010" }
flutter = { V_f = 0.6 }
[slosh]
model = "vof"
tank_length = 0.5
tank_height = 0.15
fill_level = 0.5
tank_x = 0
tank_y = 0
liquid_density = 800
liquid_viscosity = 2e-6
"""
BAFFLES = HEAD + "[slosh.parameters]\nbaffle_count = 2\nbaffle_top = 0.4\n"


@pytest.fixture(scope="module")
def fmus(fmu: Callable[[str], Path]) -> dict[str, Path]:
    return {name: fmu(name) for name in ("aero", "structure", "slosh_ems", "slosh_vof")}


def loaded(tmp_path: Path, text: str, *overrides: str) -> Case:
    path = tmp_path / "tank.toml"
    path.write_text(text)
    return cases.load(path, overrides, "point")


def refused(tmp_path: Path, fmus: dict[str, Path], text: str, *overrides: str) -> str:
    case = loaded(tmp_path, text, *overrides)
    with pytest.raises(AeroSloshError) as caught:
        fmu_parameters.check(case, fmus)
    assert caught.value.code == ExitCode.INPUT and caught.value.remedy
    return str(caught.value)


def test_baffles_reach_the_tank(tmp_path: Path, fmus: dict[str, Path]) -> None:
    case = loaded(tmp_path, BAFFLES, "slosh.parameters.wall_layer=true", "slosh.parameters.cfl=0.4", "slosh.cells_x=40")
    fmu_parameters.check(case, fmus)
    tank = fuel_tank.Tank(case.slosh, fmus)
    try:
        assert tank.moving is not None
        for _ in range(2):  # as opened, and anew for a march
            found = [tank.moving.get(name) for name in ("baffle_count", "baffle_top", "wall_layer", "cfl", "cells_x")]
            assert found == [2, 0.4, True, 0.4, 40]
            tank.restart(0)
    finally:
        tank.close()


@pytest.mark.parametrize("shape", ["initial_wave=0.01", "initial_column=0.3"])
def test_a_wave_at_the_start_is_not_trimmed_out(tmp_path: Path, fmus: dict[str, Path], shape: str) -> None:
    """The trim is that of the level surface, whichever loads are wired."""
    for split in ("frozen", "none"):
        rest = []
        for start in ("initial_wave=0.0", shape):
            case = loaded(tmp_path, HEAD, f"slosh.split={split}", f"slosh.parameters.{start}", "slosh.tank_x=0.3")
            tank = fuel_tank.Tank(case.slosh, fmus)
            assert tank.moving is not None
            starts = tank.moving.get("moment")
            rest.append((*tank.rest, starts))
            tank.close()
        weight = 800.0 * 9.81 * 0.5 * 0.075
        assert rest[1][:2] == pytest.approx(rest[0][:2], abs=1e-3 * weight)
        assert abs(rest[1][2] - rest[0][2]) > 1e-2 * 0.3 * weight  # while the wave's own moment is not small


def test_baffles_through_the_surface_stiffen_the_liquid_at_rest(tmp_path: Path, fmus: dict[str, Path]) -> None:
    """Two of them make three tanks of a third of the length: rho g L^3 / 12 becomes a ninth of it."""
    found = []
    for extra in ("", "[slosh.parameters]\nbaffle_count = 2\n", "[slosh.parameters]\nbaffle_count = 2\nbaffle_top = 0.4\n"):
        tank = fuel_tank.Tank(loaded(tmp_path, HEAD + extra).slosh, fmus)
        found.append(tank.liquid.stiffness - tank.static_stiffness)
        tank.close()
    assert found[0] == pytest.approx(800.0 * 9.81 * 0.5**3 / 12.0) and found[1] == pytest.approx(found[0] / 9.0)
    assert found[2] == found[0]  # drowned ones let the surface stay level


RIBS = HEAD + '[slosh.parameters]\nribs = "x=0.05; x=-0.15 open=0.00:0.03,0.12:0.15"\n'


def test_ribs_reach_the_tank_and_closed_ones_stiffen_it(tmp_path: Path, fmus: dict[str, Path]) -> None:
    """Compartments of 0.3 and 0.2 of half a metre."""
    found = []
    for text in (HEAD, RIBS):
        case = loaded(tmp_path, text)
        fmu_parameters.check(case, fmus)
        tank = fuel_tank.Tank(case.slosh, fmus)
        found.append((tank.moving.get("ribs") if tank.moving else None, tank.liquid.stiffness - tank.static_stiffness))
        tank.close()
    assert [ribs for ribs, _ in found] == ["", "x=0.05; x=-0.15 open=0.00:0.03,0.12:0.15"]
    assert found[1][1] == pytest.approx(found[0][1] * (0.6**3 + 0.4**3))
    with pytest.raises(ComponentError, match=r"x=0.3 m lies outside the tank"):
        fuel_tank.Tank(loaded(tmp_path, RIBS.replace("x=0.05", "x=0.3")).slosh, fmus)


@pytest.mark.parametrize("model", ["ems", "frozen", "rbf"])
def test_models_without_ribs_refuse_them(tmp_path: Path, fmus: dict[str, Path], fmu: Callable[[str], Path], model: str) -> None:
    said = refused(tmp_path, fmus | {"slosh_rbf": fmu("slosh_rbf")}, RIBS, f"slosh.model={model}")
    assert "has no parameter 'ribs'" in said and "--set 'slosh.parameters={}'" in said


WRONG = [
    ("slosh", "ribs = 0.1", "ribs has the wrong type: 0.1", 'give a text in "quotes"'),
    ("slosh", "baffle_cout = 2", "slosh_vof.fmu has no parameter 'baffle_cout'", "did you mean 'baffle_count'?"),
    ("slosh", "baffle_count = 2.5", "baffle_count has the wrong type: 2.5", "give a whole number from 0 to 16"),
    ("slosh", 'baffle_count = "two"', 'wrong type: "two"', "give a whole number"),
    ("slosh", "baffle_count = true", "wrong type: true", "give a whole number"),
    ("slosh", "wall_layer = 1", "wrong type: 1", "give true or false"),
    ("slosh", "baffle_count = 17", "baffle_count = 17 is out of range", "from 0 to 16"),
    ("slosh", "cfl = 0.9", "cfl = 0.9 is out of range", "give a number from 0.01 to 0.5"),
    ("slosh", "max_step = -1.0", "max_step = -1.0 is out of range", "[s]"),
    ("slosh", "tank_length = 0.4", "the case sets tank_length itself", "give slosh.tank_length"),
    ("slosh", "motion_prediction = 1", "the case sets motion_prediction itself", "coupling.predictor_order"),
    ("slosh", "h = 0.1", "has no parameter 'h'", "those without a key of their own are"),
    ("aero", "mach = 0.7", "the case sets mach itself", "give flow.mach"),
    ("aero", "max_steps = 0.7", "aero.fmu has no parameter 'max_steps'", "did you mean 'max_step'?"),
    ("structure", "mass = 40.0", "the case sets mass itself", "give section.mass or section.mass_ratio"),
    ("structure", "omega_alpha = 40.0", "the case sets omega_alpha itself", "section.pitch_frequency"),
    ("structure", "trim_lift = 4.0", "the case sets trim_lift itself", "the trim is that of the steady flow"),
]


@pytest.mark.parametrize(("table", "line", "what", "remedy"), WRONG)
def test_refusals_name_file_line_and_key(
    tmp_path: Path, fmus: dict[str, Path], table: str, line: str, what: str, remedy: str
) -> None:
    said = refused(tmp_path, fmus, f"{HEAD}[{table}.parameters]\n# a remark\n{line}\n")
    name, _, value = line.partition(" = ")
    assert what in said and remedy in said and f"tank.toml, line 15, key {table}.parameters.{name}" in said
    override = f"{table}.parameters.{name}={value}"
    said = refused(tmp_path, fmus, HEAD, override)
    assert what in said and f"where:  --set {override}" in said


def test_every_parameter_has_its_one_place_and_the_page_names_it(fmus: dict[str, Path], fmu: Callable[[str], Path]) -> None:
    """A key of the case or a table of parameters; docs/cases.md has all of the latter and no others."""
    owners = {"aero": ["aero"], "structure": ["structure"], "slosh": ["slosh_ems", "slosh_rbf", "slosh_vof"]}
    page = (Path(__file__).parents[3] / "docs" / "cases.md").read_text().partition("names without a key of their own")[2]
    for table, names in owners.items():
        found: set[str] = set()
        for name in names:
            component = Component(fmu(name), name)
            found |= {v.name for v in component.variables.values() if v.causality == "parameter"}
            component.close()
        reserved = set(fmu_parameters.RESERVED[table])
        assert reserved - found <= {"model", "predictor", "split", "members", "seed"}
        row = next(line for line in page.splitlines() if line.startswith(f"| `[{table}.parameters]`"))
        folded = {re.sub(r"\d+", "N", name) for name in found - reserved}
        assert set(re.findall(r"`([a-zN_]+)`", row.split("|")[2].partition("(")[0])) == folded


def test_one_table_on_a_line_is_the_same(tmp_path: Path, fmus: dict[str, Path]) -> None:
    text = HEAD + "parameters = { baffle_count = 2, baffle_top = 1.5 }\n"
    assert "tank.toml, line 13, key slosh.parameters.baffle_top" in refused(tmp_path, fmus, text)
    case = loaded(tmp_path, text, "slosh.parameters={ baffle_count = 30 }")
    with pytest.raises(AeroSloshError, match=r"--set slosh\.parameters="):
        fmu_parameters.check(case, fmus)
    fmu_parameters.check(loaded(tmp_path, text, "slosh.parameters={}"), fmus)


def test_parameters_belong_to_the_model_chosen(tmp_path: Path, fmus: dict[str, Path]) -> None:
    said = refused(tmp_path, fmus, BAFFLES, "slosh.model=ems")
    assert "slosh_ems.fmu has no parameter 'baffle_count'" in said and "--set 'slosh.parameters={}'" in said
    fmu_parameters.check(loaded(tmp_path, BAFFLES, "slosh.model=none"), fmus)  # dry: no liquid, no baffles
    both = loaded(tmp_path, BAFFLES, "slosh.predictor=ems")
    known = Component(fmus["slosh_ems"], "slosh_ems")
    items = {item.name: int(item.value) for item in known.variables["limit"].declaredType.items}
    try:
        name = next(iter(items))
        both.slosh.parameters["limit"] = name
        fmu_parameters.check(both, fmus)  # the predictor's
        assert fuel_tank.parameters(both.slosh, known.variables)["limit"] == items[name]
        assert "baffle_count" not in fuel_tank.parameters(both.slosh, known.variables)
    finally:
        known.close()


def test_a_start_off_rest_is_a_disturbance(tmp_path: Path, fmus: dict[str, Path]) -> None:
    text = HEAD.replace("flutter = { V_f = 0.6 }", "flutter = { V_f = 0.6, forced_cycles = 0 }")
    with pytest.raises(AeroSloshError, match="Nothing disturbs"):
        loaded(tmp_path, text)
    fmu_parameters.check(loaded(tmp_path, text, "structure.parameters.initial_alpha=0.01"), fmus)
    with pytest.raises(AeroSloshError, match=r"structure\.parameters\.initial_h has no effect while the pitch is forced"):
        loaded(tmp_path, HEAD, "structure.parameters.initial_h=0.01")


def test_the_resolved_case_has_them(tmp_path: Path) -> None:
    case = loaded(tmp_path, BAFFLES, "aero.parameters.max_step=0.2")
    text = cases.dump(case)
    (tmp_path / "tank.toml").write_text(text)
    again = cases.load(tmp_path / "tank.toml", command="point")
    assert again == case and again.slosh.parameters == {"baffle_count": 2, "baffle_top": 0.4}
    assert cases.flat(case)["aero.parameters"] == {"max_step": 0.2}
    line = next(line for line in text.splitlines() if line.startswith("parameters = ") and "max_step" in line)
    assert "default" not in line


def test_sweeps_over_them(tmp_path: Path, fmus: dict[str, Path]) -> None:
    folder = tmp_path / "fmus"
    folder.mkdir()
    for path in fmus.values():
        shutil.copy(path, folder)

    def made(text: str) -> plan.Plan:
        path = tmp_path / "tank.toml"
        path.write_text(HEAD + text)
        case = cases.load(path)
        return plan.make(case, parameters.from_case(case, path), folder, str(path))

    listed = made('[sweep.parameters]\n"slosh.parameters.baffle_count" = [0, 1, 2]\n')
    assert [p.case.slosh.parameters for p in listed.points] == [{"baffle_count": n} for n in (0, 1, 2)]
    assert len({p.id for p in listed.points}) == 3
    bare = made("[sweep.parameters]\nslosh.parameters.baffle_count = [0, 1, 2]\n")
    assert [p.id for p in bare.points] == [p.id for p in listed.points]
    ranged = made('[sweep.parameters]\n"slosh.parameters.baffle_count" = { from = 0, to = 2, count = 3 }\n')
    assert [p.id for p in ranged.points] == [p.id for p in listed.points]
    real = made('[sweep.parameters]\n"slosh.parameters.cfl" = { from = 0.1, to = 0.5, count = 3 }\n')
    assert [p.case.slosh.parameters["cfl"] for p in real.points] == [0.1, 0.3, 0.5]
    with pytest.raises(AeroSloshError, match=r"baffle_count = 20 is out of range[\s\S]*point 2 of the sweep"):
        made('[sweep.parameters]\n"slosh.parameters.baffle_count" = [2, 20]\n')


@pytest.mark.parametrize(
    ("line", "says", "remedy"),
    [
        ('initial_file = "nowhere.csv"', "nowhere.csv cannot be read", "initial_file"),
        ("initial_wave = 0.2", "initial_wave = 0.2 m leaves the tank", "amplitude"),
        ("initial_column = 0.01", "initial_column = 0.01 m", "from 0.25 to 0.5 m"),
        ('ribs = "x=0.3"', "x=0.3 m lies outside the tank", "between -0.25 and 0.25 m"),
        ('ribs = "middle"', "ribs: 'middle'", "x in metres"),
        ("gas_pressure = 1.013", "gas_pressure = 1.013 Pa is hardly any gas", "1.013 bar are 101300 Pa"),
    ],
)
def test_what_the_tank_refuses_is_bad_input_before_the_steady_flow(
    tmp_path: Path, fmus: dict[str, Path], line: str, says: str, remedy: str
) -> None:
    """Exit code 2 with file, line, key and remedy, and no flow computed."""
    path, said = tmp_path / "tank.toml", []
    path.write_text(HEAD + "[slosh.parameters]\n" + line + "\n")
    with pytest.raises(AeroSloshError) as raised:
        FlutterSetup(cases.load(path), fmus, 0.5, say=said.append)
    error = raised.value
    assert error.code == ExitCode.INPUT and type(error) is AeroSloshError
    assert not [text for text in said if "steady flow" in text]
    assert says in error.what and remedy in str(error)
    assert f"tank.toml, line 14, key slosh.parameters.{line.split()[0]}" in error.where
