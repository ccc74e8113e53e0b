"""The Python interface on section + thin airfoil: points, boundaries, sweeps; the same numbers as the command's."""

from __future__ import annotations

import json
import math
from pathlib import Path

import numpy as np
import pytest

import aeroslosh as ae
from aeroslosh.master.base.errors import AeroSloshError
from support import theory
from support.processes import called

SHORT = {"steps_per_cycle": 200, "forced_cycles": 1.0, "free_cycles": 3.0}


@pytest.fixture(scope="module")
def case() -> ae.Case:
    return ae.Case.isogai_a().replace(
        flow={"mach": 0.3}, flutter=SHORT, coupling={"scheme": "implicit"}, output={"pictures": False, "fields": False}
    )


def test_a_case_is_never_changed_and_says_what_does_not_fit(case: ae.Case) -> None:
    other = case.replace(flow={"mach": np.float64(0.4)}, slosh={"model": "ems"})
    assert (case["flow.mach"], other["flow.mach"], other["slosh.model"]) == (0.3, 0.4, "ems")
    assert (
        other == case.changed({"flow.mach": 0.4, "slosh.model": "ems"}) and other != case and hash(case) == hash(case.replace())
    )
    with pytest.raises(ae.AeroSloshError, match=r"(?s)flow\.mach = 7.*0\.05 to 0\.98"):
        case.replace(flow={"mach": 7.0})
    with pytest.raises(ae.AeroSloshError, match=r"(?s)Unknown key 'flow\.mack'.*flow\.mach"):
        case.changed({"flow.mack": 0.4})
    with pytest.raises(ae.AeroSloshError, match=r"(?s)Unknown table 'flwo'.*flow"):
        case.replace(flwo={"mach": 0.4})
    assert "isogai_a" in ae.Case.names() and "isogai_a" in repr(case)


def test_a_saved_case_is_the_same_case(case: ae.Case, tmp_path: Path) -> None:
    case.save(tmp_path / "mine.toml")
    assert ae.Case.load(tmp_path / "mine.toml") == case


def test_a_point_is_the_command_s(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    point = ae.point(case, V_f=2.4, fmus=flutter_fmus)
    assert point.verdict is ae.Verdict.FLUTTER and point.verdict == "flutter" and point.folder is None
    exact = theory.eigenvalues(case.core, 0.3, 2.4)[0]
    assert point.growth_rate == pytest.approx(exact.real, abs=3e-3) and point.frequency == pytest.approx(exact.imag, abs=3e-3)
    words = [f"flutter.{name}={value}" for name, value in SHORT.items()]
    done = called(
        "point", "isogai_a", "--mach", "0.3", "--vf", "2.4", "--fmus", flutter_fmus, "--json", "--no-pictures",
        "--out", tmp_path / "run", "--set", "coupling.scheme=implicit", *(word for text in words for word in ("--set", text)),
    )  # fmt: skip
    assert json.loads(done.stdout)["growth_rate"] == point.growth_rate
    opened = ae.open(tmp_path / "run")
    assert isinstance(opened, ae.Point) and opened.growth_rate == point.growth_rate and opened.case is not None
    assert opened.case["flutter.V_f"] == 2.4
    np.testing.assert_array_equal(opened.history.alpha.values, point.history.alpha.values)
    assert len(point.plot().axes) == 2


def test_a_history_has_units_and_coordinates(case: ae.Case, flutter_fmus: Path) -> None:
    history = ae.point(case, V_f=1.0, fmus=flutter_fmus).history
    assert history.alpha.dims == ("time",) and set(history.coords) == {"time", "tau"}
    assert (history.alpha.units, history.time.units, history.lift.units) == ("rad", "s", "N m-1")
    omega = history.attrs["omega_alpha"]
    np.testing.assert_allclose(history.tau, omega * history.time)


def test_a_folder_is_written_as_by_the_command(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    point = ae.point(case, V_f=1.0, fmus=flutter_fmus, folder=tmp_path / "run")
    assert point.folder == tmp_path / "run"
    assert {p.name for p in point.folder.iterdir()} == {"case.toml", "result.json", "history.nc", "run.log"}
    assert json.loads((point.folder / "result.json").read_text())["provenance"]["fmu_sha256"]["aero"]


def test_boundary_finds_the_exact_crossing(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    mine = case.replace(boundary={"V_f_range": [1.0, 4.0], "method": "march", "tolerance": 0.001}, flutter={"free_cycles": 5.0})
    found = ae.boundary(mine, mach=[0.3, 0.35], V_f=2.0, fmus=flutter_fmus, folder=tmp_path / "b")
    table = found.crossings
    assert list(table.mach) == [0.3, 0.35] and set(table.name) == {"onset"} and found.finished
    for mach, V_f in zip(table.mach, table.V_f, strict=True):
        assert V_f == pytest.approx(theory.crossings(mine.core, mach, 1.0, 4.0)[0][0], rel=5e-3)  # of 200 steps a period
    assert len(found.marches) >= 4 and set(found.marches.verdict) <= {"damped", "neutral", "flutter"}
    again = ae.open(tmp_path / "b")
    assert isinstance(again, ae.Boundary) and again.crossings.equals(table) and again.finished
    assert len(found.plot().axes) == 1 and found.modes().empty
    with pytest.raises(AeroSloshError, match=r"one of those searched: 0\.3, 0\.35"):
        found.modes(mach=0.4)
    with pytest.raises(AeroSloshError, match="one number"):
        found.modes([0.5, 1.0])  # type: ignore[arg-type]


def test_a_cancelled_boundary_returns_what_is_finished(case: ae.Case, flutter_fmus: Path) -> None:
    mine = case.replace(boundary={"V_f_range": [1.0, 4.0], "method": "march"}, flutter={"free_cycles": 5.0})
    seen: list[ae.Update] = []

    def enough(update: ae.Update) -> bool:
        seen.append(update)
        return not update.label.startswith("M 0.35")

    found = ae.boundary(mine, mach=[0.3, 0.35, 0.4], V_f=2.0, fmus=flutter_fmus, progress=enough)
    assert list(found.crossings.mach) == [0.3] and not found.finished and found.data["unfinished"] == [0.35, 0.4]
    assert any(u.total and u.done == u.total for u in seen) and any("steady flow" in u.text for u in seen)


def test_a_cancelled_point_raises(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    with pytest.raises(ae.Cancelled):
        ae.point(case, V_f=1.0, fmus=flutter_fmus, folder=tmp_path / "run", progress=lambda update: update.done < 20)
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_is_a_dataset_over_its_keys(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    grid = ae.sweep(
        case, {"flow.mach": np.array([0.4, 0.3]), "flutter.V_f": [1.0, 2.4]}, folder=tmp_path / "s", workers=2, fmus=flutter_fmus
    )
    assert dict(grid.sizes) == {"flow.mach": 2, "flutter.V_f": 2} and list(grid["flow.mach"].values) == [0.3, 0.4]
    one = ae.point(case, V_f=2.4, fmus=flutter_fmus)
    cell = grid.sel({"flow.mach": 0.3, "flutter.V_f": 2.4})
    assert float(cell.growth_rate) == pytest.approx(one.growth_rate, rel=1e-9) and str(cell.verdict.values) == "flutter"
    assert grid.growth_rate.units == "omega_alpha" and grid.attrs["finished"] == 4
    opened = ae.open(tmp_path / "s")
    assert opened.equals(grid)
    more = ae.sweep(case, {"flow.mach": [0.3, 0.4], "flutter.V_f": [1.0, 2.4]}, folder=tmp_path / "s", fmus=flutter_fmus)
    assert more.equals(grid)  # nothing is computed again: its times would differ


def test_a_sweep_that_asks_for_them_has_the_error_bars_of_a_point(case: ae.Case, flutter_fmus: Path) -> None:
    """Coarse companions, which a sweep leaves out by default."""
    one = ae.point(case, V_f=2.4, fmus=flutter_fmus)
    bare, asked = (
        ae.sweep(of, {"flutter.V_f": [2.4]}, workers=1, fmus=flutter_fmus)
        for of in (case, case.changed({"flutter.companion": True}))
    )
    assert float(asked.growth_rate_uncertainty[0]) == pytest.approx(one.growth_rate_uncertainty, rel=1e-6)
    assert 0.0 < float(bare.growth_rate_uncertainty[0]) < float(asked.growth_rate_uncertainty[0])


def test_lists_and_failures_are_points(case: ae.Case, flutter_fmus: Path) -> None:
    table = {"flutter.V_f": [1.0, 2.4, 2.0], "flow.airfoil": ["NACA 0012", "NACA 0012", "FAIL 30"]}
    found = ae.sweep(case, table, mode="list", workers=1, fmus=flutter_fmus)
    assert dict(found.sizes) == {"point": 3} and list(found["flutter.V_f"].values) == [1.0, 2.4, 2.0]
    assert list(found.status.values) == ["done", "done", "failed"] and found.cause.values[2]
    assert math.isnan(found.growth_rate.values[2]) or found.verdict.values[2] == "undetermined"


def test_what_is_wrong_is_said_before_anything_starts(case: ae.Case, flutter_fmus: Path, tmp_path: Path) -> None:
    with pytest.raises(ae.AeroSloshError, match=r"slosh\.model"):
        ae.point(case, slosh="slush", fmus=flutter_fmus)
    with pytest.raises(ae.AeroSloshError, match="FMU missing"):
        ae.point(case, fmus=tmp_path)
    with pytest.raises(ae.AeroSloshError, match="mode = 'cloud'"):
        ae.sweep(case, {"flow.mach": [0.3]}, mode="cloud", fmus=flutter_fmus)
    with pytest.raises(ae.AeroSloshError, match=r"no table\.key"):
        ae.sweep(case, {"mach": [0.3]}, fmus=flutter_fmus)
    with pytest.raises(ae.AeroSloshError):
        ae.open(tmp_path)
