"""What programs hand over: arrays, tuples, paths, other tables; interrupts and callbacks at bad moments."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import xarray as xr

import aeroslosh as ae
from aeroslosh.master.results import by_value
from aeroslosh.master.results.run_folder import RunFolder

SHORT = {"steps_per_cycle": 100, "forced_cycles": 1.0, "free_cycles": 3.0}
TIME = np.linspace(0.0, 0.2, 21)


@pytest.fixture(scope="module")
def case() -> ae.Case:
    return ae.Case.isogai_a().replace(
        flow={"mach": 0.3},
        flutter=SHORT,
        boundary={"V_f_range": (1.0, 4.0), "method": "march"},
        output={"pictures": False, "fields": False},
    )


def test_what_a_case_gives_is_not_the_case(case: ae.Case) -> None:
    case["boundary.mach"].clear()
    case.settings["slosh.parameters"]["baffle_count"] = 3
    assert case["boundary.mach"] == [0.8, 0.825, 0.85] and case["slosh.parameters"] == {}


def test_numpy_tuples_and_paths_are_values(case: ae.Case, tmp_path: Path) -> None:
    other = case.replace(
        boundary={"mach": np.array([0.7, 0.8])},
        flow={"airfoil": tmp_path / "mine.dat"},
        slosh={"parameters": {"baffle_count": np.int64(2)}},
    )
    assert other["boundary.mach"] == [0.7, 0.8] and other["flow.airfoil"] == str(tmp_path / "mine.dat")
    assert other["slosh.parameters.baffle_count"] == 2
    other.save(tmp_path / "case.toml")
    assert ae.Case.load(tmp_path / "case.toml") == other
    assert case.changed({"slosh.parameters.baffle_count": 2})["slosh.parameters"] == {"baffle_count": 2}
    assert case.replace(flow={"mach": np.float32(0.5)})["flow.mach"] == 0.5


def test_keys_by_value_can_be_given_and_left_out() -> None:
    wing = ae.Case.load("wing_by_value")
    other = wing.replace(section={"inertia": None, "inertia_cg": 2.0})
    assert other["section.r2_alpha"] != wing["section.r2_alpha"] and other["section.inertia_cg"] == 2.0
    assert other.replace(section={"inertia_cg": None, "inertia": wing["section.inertia"]}) == wing
    with pytest.raises(ae.AeroSloshError, match=r"1500 mm is 1\.5 m"):
        wing.replace(section={"chord": 1500.0})


def test_what_is_no_case_is_said(case: ae.Case, flutter_fmus: Path) -> None:
    with pytest.raises(ae.AeroSloshError, match="is no case"):
        ae.point(3.0, fmus=flutter_fmus)  # type: ignore[arg-type]
    with pytest.raises(ae.AeroSloshError, match=r"flow = 0\.8 is no table"):
        case.replace(flow=0.8)  # type: ignore[arg-type]
    with pytest.raises(ae.AeroSloshError, match="mach = 'a'"):
        ae.boundary(case, mach="a", fmus=flutter_fmus)  # type: ignore[arg-type]
    with pytest.raises(ae.AeroSloshError, match="workers = -1"):
        ae.sweep(case, {"flow.mach": [0.3]}, workers=-1, fmus=flutter_fmus)


def test_unusual_values_are_warned_of_and_recorded(case: ae.Case, flutter_fmus: Path) -> None:
    with pytest.warns(UserWarning, match="static_temperature"):
        point = ae.point(case.replace(flow={"static_temperature": 80.0}), V_f=1.0, fmus=flutter_fmus)
    assert any("static_temperature" in text for text in point.data["warnings"]) and "section.chord" not in point.data["defaults"]


def test_lists_and_mixed_values_are_swept(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    orders = [["structure", "aero"], ["aero", "structure"]]
    found = ae.sweep(case, {"coupling.order": orders, "flutter.V_f": 1.0}, folder=tmp_path / "s", workers=1, fmus=flutter_fmus)
    assert dict(found.sizes) == {"coupling.order": 2, "flutter.V_f": 1} and (found.status == "done").all()
    assert list(found["coupling.order"].values) == ['["structure", "aero"]', '["aero", "structure"]']
    assert ae.open(tmp_path / "s").equals(found)
    mixed = ae.sweep(case, {"flutter.steps_per_cycle": ["auto", 100], "flutter.V_f": [1.0]}, workers=1, fmus=flutter_fmus)
    assert float(mixed.sel({"flutter.steps_per_cycle": 100}).steps.item()) == 400.0
    assert mixed["flutter.V_f"].units == "1" and mixed.airspeed.units == "m/s"


@pytest.mark.parametrize(
    ("table", "said"),
    [
        (
            {"time": pd.date_range("2024-01-01", periods=21, freq="10ms"), "x": TIME},
            r"'time' has shape \(21,\) and holds datetime",
        ),
        ({"time": TIME, "x": TIME + 1j}, "complex"),
        ({"time": TIME, "x": np.zeros((21, 2))}, r"'x' has shape \(21, 2\)"),
        ([1, 2], "A list is no table"),
        ({"time": [*TIME[:-1], np.inf], "x": TIME}, "'time' holds a number that is not finite"),
    ],
)
def test_tables_that_are_none_are_refused(table: object, said: str, fmu: Callable[[str], Path]) -> None:
    with pytest.raises(ae.AeroSloshError, match=said):
        ae.simulate(fmu("slosh_ems"), table)  # type: ignore[arg-type]


def test_other_shapes_of_the_same_table(fmu: Callable[[str], Path]) -> None:
    x = 0.002 * np.sin(9.0 * TIME)
    plain = ae.simulate(fmu("slosh_ems"), {"time": TIME, "x": x})
    frame = pd.DataFrame({"x": x}, index=pd.Index(TIME, name="time"))
    labelled = xr.Dataset({"x": ("time", x)}, coords={"time": TIME, "run": 3})
    assert ae.simulate(fmu("slosh_ems"), frame).equals(plain) and ae.simulate(fmu("slosh_ems"), labelled).equals(plain)
    alone = ae.simulate(fmu("slosh_ems"), {"time": TIME})
    assert float(abs(alone.force_x).max()) == 0.0


def test_a_step_fits_the_table(fmu: Callable[[str], Path]) -> None:
    table = {"time": TIME, "x": 0.01 * TIME}
    found = ae.simulate(fmu("slosh_ems"), table, step=0.13)
    assert found.time.values == pytest.approx([0.0, 0.1, 0.2])
    for step in (0.0, -1.0, "a", np.nan):
        with pytest.raises(ae.AeroSloshError, match="step = "):
            ae.simulate(fmu("slosh_ems"), table, step=step)  # type: ignore[arg-type]


def test_cancelling_on_the_message_of_a_mach_number_keeps_it(case: ae.Case, flutter_fmus: Path) -> None:
    found = ae.boundary(
        case, mach=[0.3, 0.35], V_f=2.4, fmus=flutter_fmus, progress=lambda u: np.bool_(not u.text.startswith("Mach 0.3:"))
    )
    assert list(found.outcomes) == [0.3] and found.data["unfinished"] == [0.35]


def test_what_a_callback_raises_is_the_caller_s(case: ae.Case, flutter_fmus: Path) -> None:
    def broken(update: ae.Update) -> None:
        raise ValueError("mine")

    for study in (ae.point, ae.boundary):
        with pytest.raises(ValueError, match="mine"):
            study(case, fmus=flutter_fmus, progress=broken)


def test_an_interrupt_while_a_mach_number_is_written_waits(
    case: ae.Case, flutter_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write, before = RunFolder.write_result, signal.getsignal(signal.SIGINT)

    def struck(self: RunFolder, data: dict) -> None:
        monkeypatch.setattr(RunFolder, "write_result", write)
        os.kill(os.getpid(), signal.SIGINT)
        write(self, data)

    monkeypatch.setattr(RunFolder, "write_result", struck)
    signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            ae.boundary(case, mach=[0.3, 0.35], V_f=2.4, fmus=flutter_fmus, folder=tmp_path / "b")
    finally:
        signal.signal(signal.SIGINT, before)
    kept = ae.open(tmp_path / "b")
    assert isinstance(kept, ae.Boundary) and list(kept.outcomes) == [0.3] and not kept.finished


def row(mach: float, margin: float | None, holds: bool | None = None) -> dict:
    """A Mach number of a boundary of a wing whose own V_f is 0.5."""
    stream = {
        "airspeed": 340.0 * mach,
        "equivalent_airspeed": 300.0 * mach,
        "dynamic_pressure": 7e4 * mach**2,
        "pressure_altitude": 0.0,
    }
    searched = {"V_f_searched_from": 0.2, "V_f_searched_to": 3.0}
    return {
        "mach": mach,
        "slosh_holds": holds,
        "crossings": [],
        "by_value": stream | searched | {"own_V_f": 0.5, "margin": margin},
    }


def test_a_matched_mach_number_lies_between_neighbours_that_have_margins() -> None:
    assert by_value.matched([row(0.70, 1.1), row(0.72, None), row(0.80, 0.9)]) == []
    assert by_value.matched([row(0.70, 1.1, True), row(0.80, 0.9, False)]) == []
    [found] = by_value.matched([row(0.60, None), row(0.70, 1.1), row(0.80, 0.9)])
    assert found["mach"] == pytest.approx(0.75) and found["onset"]
    [line] = by_value.matched_lines([row(0.70, 1.1), row(0.72, None), row(0.80, 1.05)])
    assert "2 of 3 Mach numbers have their lowest neutral V_f above" in line


def test_a_wing_outside_the_V_f_searched_is_said() -> None:
    far = row(0.7, None)
    far["by_value"]["V_f_searched_to"] = 0.4
    assert any("outside the V_f searched (0.2 to 0.4)" in line for line in by_value.point_lines(far))


def test_a_boundary_of_many_mach_numbers_has_no_one_speed() -> None:
    wing = ae.Case.load("wing_by_value").replace(flow={"altitude": None, "mach": 0.7}, flutter={"dynamic_pressure": 16000.0})
    with pytest.raises(ae.AeroSloshError, match=r"dynamic_pressure belongs to Mach 0\.7.* Mach 0\.74 too"):
        ae.boundary(wing, mach=[0.7, 0.74])
