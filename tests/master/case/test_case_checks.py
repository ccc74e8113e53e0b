"""What a case must say, what it may leave out and is told of, and units that cannot be."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from aeroslosh.fmus.tank.plausible import RULES
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.case import case as cases
from aeroslosh.master.case import checks, plausible
from aeroslosh.master.case.case import Case
from aeroslosh.master.training import case as training_case
from support.paths import ROOT

SECTION = {"elastic_axis": 0.35, "x_alpha": 0.2, "r2_alpha": 0.25, "frequency_ratio": 0.4, "mass_ratio": 75.0}
TANK = {
    "tank_length": 0.6, "tank_height": 0.2, "fill_level": 0.3, "tank_x": 0.0, "tank_y": 0.0, "liquid_density": 800.0,
    "liquid_viscosity": 2e-6,
}  # fmt: skip


def written(path: Path, leave_out: str = "", **tables: dict[str, object]) -> Path:
    """A whole case of a stranger's section, with more tables, less one key."""
    whole = {
        "section": {**SECTION},
        "flow": {"mach": 0.7, "airfoil": "NACA 0012"},
        "flutter": {"V_f": 0.3},
        "boundary": {"mach": [0.6, 0.7]},
    }
    for name, content in tables.items():
        whole[name] = {**whole.get(name, {}), **content}
    text = ""
    for name, content in whole.items():
        rows = {k: f'"{v}"' if isinstance(v, str) else v for k, v in content.items() if f"{name}.{k}" != leave_out}
        text += f"[{name}]\n" + "".join(f"{k} = {v}\n" for k, v in rows.items())
    path.write_text(text)
    return path


@pytest.mark.parametrize("command", ["point", "boundary"])
def test_an_empty_case_is_refused_with_all_that_is_missing(tmp_path: Path, command: str) -> None:
    (tmp_path / "empty.toml").write_text("")
    with pytest.raises(AeroSloshError) as caught:
        cases.load(tmp_path / "empty.toml", (), command)
    said = str(caught.value)
    assert caught.value.code == ExitCode.INPUT and "empty.toml" in said and "remedy" in said
    for name in checks.REQUIRED[command]:
        assert name in said
    assert "centre of mass aft of the elastic axis" in said


@pytest.mark.parametrize("name", [*checks.REQUIRED["point"], *checks.MOVING])
def test_each_required_key_is_asked_for_by_name_and_can_be_set(tmp_path: Path, name: str) -> None:
    liquid = {"slosh": {"model": "ems", **TANK}, "section": {"chord": 1.2}}
    path = written(tmp_path / "mine.toml", name, **liquid)
    with pytest.raises(AeroSloshError) as caught:
        cases.load(path, (), "point")
    assert caught.value.what.endswith(f"cannot do without: {name}")
    assert "mine.toml" in str(caught.value) and f"--set {name}=VALUE" in str(caught.value)
    whole = cases.load(written(tmp_path / "whole.toml", **liquid), (), "point")
    table, _, key = name.partition(".")
    case = cases.load(path, [f"{name}={getattr(getattr(whole, table), key)}"], "point")
    assert case.section == whole.section and case.slosh == whole.slosh and case.flow == whole.flow


def test_a_tank_is_asked_for_with_its_liquid_alone(tmp_path: Path) -> None:
    dry = written(tmp_path / "dry.toml")
    assert cases.load(dry, (), "point").slosh.model == "none"
    for model in ("frozen", "ems", "rbf", "vof"):
        with pytest.raises(AeroSloshError) as caught:
            cases.load(dry, [f"slosh.model={model}"], "point")
        missing = str(caught.value).splitlines()[0]
        assert "section.chord" in missing and "slosh.tank_length" in missing
        assert ("liquid_viscosity" in missing) == (model != "frozen")


def test_a_boundary_needs_no_flow_mach_and_a_point_no_boundary(tmp_path: Path) -> None:
    assert cases.load(written(tmp_path / "a.toml", "flow.mach"), (), "boundary").boundary.mach == [0.6, 0.7]
    assert cases.load(written(tmp_path / "b.toml", "boundary.mach"), (), "point").flow.mach == 0.7


@pytest.mark.parametrize("path", sorted((ROOT / "cases").glob("*.toml")), ids=lambda path: path.stem)
def test_the_cases_of_the_product_are_whole(path: Path) -> None:
    if path.stem in ("slosh_rbf", "slosh_violent"):
        training_case.load(path)
    elif path.stem != "tank_on_springs":
        swept = ("slosh.fill_level=0.5", "flutter.V_f=0.6") if path.stem == "fill_sweep" else ()
        case = cases.load(path, swept, "boundary" if path.stem == "isogai_a_boundary" else "point")
        assert not plausible.doubts(case)


def test_a_training_names_its_tank(tmp_path: Path) -> None:
    (tmp_path / "t.toml").write_text("[slosh]\ntank_length = 0.5\n")
    with pytest.raises(AeroSloshError, match=r"a training cannot do without: slosh\.tank_height, slosh\.fill_level"):
        training_case.load(tmp_path / "t.toml")


def test_defaults_are_told_in_one_line_and_marked_in_the_resolved_case(tmp_path: Path) -> None:
    case = cases.load(written(tmp_path / "mine.toml"), ["section.damping_ratio_h=0.01"], "point")
    told, defaults = checks.told(case, "point"), checks.defaults(case, "point")
    assert "\n" not in told and told.startswith(f"{len(defaults)} keys at their default: section.chord = 1 m")
    assert "flow.static_pressure = 101325 Pa" in told and "damping_ratio_h" not in told and "[flutter]" in told
    assert defaults["flow.static_temperature"] == 288.15 and "flutter.free_cycles" in defaults
    # neither what the command does not read nor what belongs to another model or scheme
    assert not {"slosh.tank_length", "coupling.max_iterations", "boundary.tolerance", "output.fields"} & set(defaults)
    assert "flow.mach" not in checks.defaults(cases.load(written(tmp_path / "b.toml", "flow.mach")), "boundary")
    text = cases.dump(case)
    assert (
        "chord = 1.0  # default: chord" in text and "x_alpha = 0.2  # centre" in text and "damping_ratio_h = 0.01  # str" in text
    )
    everything = tmp_path / "again.toml"
    everything.write_text(text)
    assert cases.load(everything, (), "point") == cases.load(written(tmp_path / "again.toml"), ["section.damping_ratio_h=0.01"])


def test_a_case_made_in_code_has_its_defaults() -> None:
    checks.complete(Case(), "point", "")
    cases.apply_override(Case(), "section.x_alpha=1.7")


def test_a_missing_key_is_said_before_what_the_default_would_break(tmp_path: Path) -> None:
    """r2_alpha 0.25 with another section's x_alpha of 1.8 is no error of the writer's."""
    with pytest.raises(AeroSloshError, match=r"cannot do without: section\.x_alpha"):
        cases.load(written(tmp_path / "mine.toml", "section.x_alpha"), (), "point")


UNITS = [
    ("slosh.liquid_viscosity", 2.0, "2 cSt (mm2/s) is 2e-06 m2/s"),
    ("slosh.liquid_viscosity", 0.6, "6e-07"),
    ("slosh.gas_viscosity", 14.8, "1.48e-05"),
    ("slosh.liquid_density", 0.8, "0.8 g/cm3 is 800 kg/m3"),
    ("slosh.liquid_density", 8e5, "800"),
    ("slosh.tank_length", 600.0, "600 mm is 0.6 m"),
    ("slosh.tank_height", 200.0, "200 mm is 0.2 m"),
    ("slosh.tank_height", 20.0, "chords"),
    ("slosh.tank_x", 300.0, "300 mm is 0.3 m"),
    ("slosh.gravity", 981.0, "981 cm/s2 is 9.81 m/s2"),
    ("slosh.surface_tension", 25.0, "0.025"),
    ("slosh.gas_density", 1200.0, "not below"),
    ("section.chord", 1200.0, "1200 mm is 1.2 m"),
    ("flow.static_pressure", 1.013, "101300 Pa"),
    ("flow.static_temperature", 15.0, "288.15 K"),
]


@pytest.mark.parametrize(("name", "value", "says"), UNITS)
def test_units_that_cannot_be_are_refused_with_what_was_meant(tmp_path: Path, name: str, value: float, says: str) -> None:
    path = written(tmp_path / "mine.toml", slosh={"model": "vof", **TANK}, section={"chord": 1.2})
    with pytest.raises(AeroSloshError) as caught:
        cases.load(path, [f"{name}={value}"], "point")
    said = str(caught.value)
    assert caught.value.code == ExitCode.INPUT and name in said and f"{value:g}" in said and says in said and "remedy" in said


@pytest.mark.parametrize(
    ("name", "value", "says"),
    [
        ("slosh.liquid_viscosity", 1e-3, "a dynamic viscosity of 0.001 Pa s is 1.25e-06 m2/s"),
        ("slosh.liquid_viscosity", 0.02, "0.02 St (cm2/s) is 2e-06"),
        ("slosh.tank_height", 2.0, "more than half the chord"),
        ("slosh.tank_length", 3.0, "longer than the chord"),
        ("slosh.liquid_density", 30.0, "unusual"),
        ("flow.static_pressure", 101.3, "101.3 kPa is 101300 Pa"),
        ("flow.static_pressure", 1013.0, "1013 hPa (mbar) is 101300 Pa"),
        ("section.mass_ratio", 0.1, "times the section"),
    ],
)
def test_what_is_unusual_is_told(tmp_path: Path, name: str, value: float, says: str) -> None:
    path = written(tmp_path / "mine.toml", slosh={"model": "ems", **TANK}, section={"chord": 1.2})
    assert not plausible.doubts(cases.load(path))
    assert any(
        name.split(".")[1] in doubt or "section" in doubt for doubt in plausible.doubts(cases.load(path, [f"{name}={value}"]))
    )
    assert says in " ".join(plausible.doubts(cases.load(path, [f"{name}={value}"])))


def test_the_case_refuses_what_the_fmus_refuse() -> None:
    assert {name.partition(".")[2] for name in plausible.LIQUID} == set(RULES)
    for name, rule in plausible.LIQUID.items():
        own = RULES[name.partition(".")[2]]
        assert (rule.unit, *rule.possible) == (own.unit, own.least, own.most)


def test_a_tank_that_is_not_used_is_not_judged(tmp_path: Path) -> None:
    assert cases.load(written(tmp_path / "dry.toml", slosh={"liquid_density": 0.8}), (), "point").slosh.liquid_density == 0.8


def test_an_airfoil_file_of_a_whole_case_is_found(tmp_path: Path) -> None:
    shutil.copy(written(tmp_path / "mine.toml", flow={"airfoil": "foil.dat"}), tmp_path / "again.toml")
    (tmp_path / "foil.dat").write_text("1 0\n0 0\n1 0\n")
    assert cases.load(tmp_path / "again.toml", (), "point").flow.airfoil == str(tmp_path / "foil.dat")
