"""Two runs side by side: what counts as a difference, how large it is told to be and since when, what is refused."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from aeroslosh.master import cli
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.flutter.march import March
from aeroslosh.master.results import history_file, point_file
from aeroslosh.master.results.history_difference import difference
from aeroslosh.master.results.provenance import provenance
from support.processes import Done, called, command

Writer = Callable[..., Path]
Marcher = Callable[..., March]


@pytest.fixture
def compared(capsys: pytest.CaptureFixture[str]) -> Callable[..., tuple[int, dict[str, Any]]]:
    """Return a function: exit code and JSON of `aeroslosh compare`."""

    def run(*arguments: Any) -> tuple[int, dict[str, Any]]:
        code = cli.run(["compare", *map(str, arguments), "--json"])
        return code, json.loads(capsys.readouterr().out)

    return run


def named(entries: list[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    return {entry["name"]: entry for entry in entries}


def test_the_same_march_is_the_same_whatever_it_cost(point_run: Writer, made_up: Marcher, compared: Any) -> None:
    a, b = point_run("a", made_up(cpu=1.0)), point_run("b", made_up(cpu=3.0), about={"date": "2031-01-01", "command": "another"})
    code, said = compared(a, b)
    assert code == 0 and said["same"]
    assert said["histories"][0]["same"] and not said["results"] and not said["details"] and not said["settings"]
    assert named(said["cost"])["cost.cpu_seconds"]["ratio"] == 3.0
    assert set(named(said["provenance"])) == {"date", "command"}


def test_one_bit_counts_until_a_tolerance_is_given(point_run: Writer, made_up: Marcher, nudged: Marcher, compared: Any) -> None:
    march = made_up()
    last = march.tau.size - 1
    bit = float(np.spacing(march.history["lift"][last]))
    a, b = point_run("a", march), point_run("b", nudged(march, "lift", last, bit))
    code, said = compared(a, b)
    assert code == 1 and not said["same"] and not said["histories"][0]["same"]
    lift = named(said["histories"][0]["channels"])["lift"]
    assert 0.0 < lift["relative"] < 1e-15 and lift["first_departure"] is None
    assert compared(a, b, "--tolerance", 1e-12)[0] == 0


def test_a_departure_has_its_time_and_its_size(point_run: Writer, made_up: Marcher, nudged: Marcher, compared: Any) -> None:
    march = made_up()
    span = float(np.ptp(march.history["alpha"]))
    a, b = point_run("a", march), point_run("b", nudged(march, "alpha", 100, 0.01 * span))
    code, said = compared(a, b)
    told = said["histories"][0]
    alpha = named(told["channels"])["alpha"]
    assert code == 1 and told["axis"] == "time" and told["how"] == ""
    assert told["first_departure"] == alpha["first_departure"] == march.history["time"][100]
    np.testing.assert_allclose([alpha["relative"], alpha["largest"]], [0.01, 0.01 * span], rtol=0.02)
    assert {name for name, c in named(told["channels"]).items() if c["largest"]} == {"alpha"}
    assert compared(a, b, "--tolerance", 0.005)[0] == 1
    assert compared(a, b, "--tolerance", 0.02)[0] == 0


def test_results_settings_and_hashes_are_told_with_their_size(point_run: Writer, made_up: Marcher, compared: Any) -> None:
    a = point_run("a", made_up(growth=-0.01))
    hashes = {"structure": "a" * 64, "aero": "c" * 64}
    b = point_run(
        "b", made_up(growth=0.02, frequency=0.95), ["coupling.predictor_order=2", "section.chord=2"], {"fmu_sha256": hashes}
    )
    code, said = compared(a, b)
    assert code == 1
    settings, results = named(said["settings"]), named(said["results"])
    assert set(settings) == {"coupling.predictor_order", "section.chord"}
    assert settings["section.chord"]["unit"] == "m" and settings["section.chord"]["b"] == 2.0
    assert "fmu_sha256.aero" in named(said["provenance"]) and "fmu_sha256.structure" not in named(said["provenance"])
    assert (results["verdict"]["a"], results["verdict"]["b"]) == ("damped", "flutter")
    rate, frequency = results["growth_rate"], results["frequency"]
    np.testing.assert_allclose([rate["change"], rate["relative"]], [0.03, 0.03 / 0.95], rtol=1e-3)
    np.testing.assert_allclose(frequency["relative"], 0.05 / 0.95, rtol=1e-3)
    assert rate["significant"] and rate["sigmas"] > 2.0


def test_a_change_within_the_error_bars_is_not_significant(tmp_path: Path, compared: Any) -> None:
    for name, rate in (("a", 0.010), ("b", 0.012)):
        numbers = {"verdict": "flutter", "growth_rate": rate, "growth_rate_uncertainty": 0.002, "frequency": 0.8}
        (tmp_path / f"{name}.json").write_text(json.dumps(numbers))
    code, said = compared(tmp_path / "a.json", tmp_path / "b.json")
    assert code == 1
    assert said["results"][0]["sigmas"] == pytest.approx(2**-0.5) and said["results"][0]["significant"] is False


def test_settings_alone_make_no_difference(point_run: Writer, made_up: Marcher, compared: Any) -> None:
    code, said = compared(point_run("a", made_up()), point_run("b", made_up(), ["output.pictures=false"]))
    assert code == 0 and set(named(said["settings"])) == {"output.pictures"}


def test_other_grids_are_interpolated_and_said_to_be(point_run: Writer, made_up: Marcher) -> None:
    coarse, fine = (history_file.read(point_run(f"n{n}", made_up(steps_per_cycle=n)) / "history.nc")[0] for n in (80, 200))
    told = difference("history", coarse, fine)
    assert not told.same and "interpolated linearly at 481 common time" in told.how
    alpha = next(c for c in told.channels if c.name == "alpha")
    # at the coarse samples the fine one is interpolated: (omega dt)^2 / 8 of the amplitude at most
    assert 0.0 < alpha.relative < (0.9 * 2 * np.pi / 200) ** 2 / 8
    assert difference("history", fine, coarse).channels == told.channels
    assert told.differs(0.0) and told.differs(1e-6) and not told.differs(0.01)
    shorter = history_file.read(point_run("short", made_up(cycles=3)) / "history.nc")[0]
    told = difference("history", coarse, shorter)
    assert "first 241 samples" in told.how and told.compared == 241
    assert all(c.largest == 0.0 for c in told.channels) and told.differs(0.1)


def test_other_speeds_are_compared_at_equal_tau(point_run: Writer, made_up: Marcher) -> None:
    slow, fast = (history_file.read(point_run(f"v{v}", made_up(V_f=v)) / "history.nc")[0] for v in (0.5, 0.6))
    told = difference("history", slow, fast)
    assert told.axis == "tau" and "equal tau" in told.how
    # the steps are whole nanoseconds: their tau differ by 1e-7 of a step, over all of them 2e-5
    assert max(c.relative for c in told.channels if c.name in ("alpha", "h")) < 2e-5


def test_not_a_number_on_one_side_is_no_small_difference(
    point_run: Writer, made_up: Marcher, nudged: Marcher, compared: Any
) -> None:
    march = made_up()
    broken = nudged(march, "lift", 50, np.nan)
    code, said = compared(point_run("a", march), point_run("b", broken), "--tolerance", 0.5)
    lift = named(said["histories"][0]["channels"])["lift"]
    assert code == 1 and lift["relative"] is None and lift["first_departure"] == march.history["time"][50]
    assert compared(point_run("c", broken), point_run("d", broken))[0] == 0


def test_boundaries_are_compared_crossing_by_crossing(boundary_run: Writer, made_up: Marcher, compared: Any) -> None:
    a = boundary_run(
        "a",
        {0.8: [(0.80, 0.01, "onset"), (2.0, 0.01, "recovery"), (2.4, 0.01, "onset")], 0.85: [(0.5, 0.01, "onset")]},
        [made_up()],
    )
    b = boundary_run(
        "b",
        {0.85: [(0.5, 0.01, "onset")], 0.8: [(2.4, 0.01, "onset"), (2.0, 0.02, "recovery"), (0.81, 0.01, "onset")], 0.9: []},
        [made_up()],
    )
    code, said = compared(a, b)
    assert code == 1 and said["only_in_b"] == ["point Mach 0.9"] and not said["only_in_a"]
    (found,) = said["results"]
    assert (found["place"], found["name"]) == ("Mach 0.8, onset", "V_f")
    np.testing.assert_allclose([found["change"], found["sigmas"]], [0.01, 0.01 / np.hypot(0.01, 0.01)])
    assert not found["significant"]


def test_the_way_of_a_search_counts_to_the_bit_only(boundary_run: Writer, made_up: Marcher, compared: Any) -> None:
    found = {0.8: [(0.8, 0.01, "onset")]}
    a = boundary_run("a", found, [made_up(V_f=0.79), made_up(V_f=0.81)])
    b = boundary_run("b", found, [made_up(V_f=0.79), made_up(V_f=0.82), made_up(V_f=0.8)])
    code, said = compared(a, b)
    assert code == 1 and said["only_in_b"] == ["history history_Vf0.8000", "history history_Vf0.8200"]
    assert compared(a, b, "--tolerance", 1e-3)[0] == 0


def test_sweeps_are_matched_by_their_overrides(sweep_run: Writer, made_up: Marcher, compared: Any) -> None:
    marches = {v: made_up(V_f=v) for v in (0.4, 0.5, 0.6)}
    a = sweep_run("a", {**marches, 0.7: None})
    other = {0.7: None, 0.8: made_up(V_f=0.8), 0.5: made_up(V_f=0.5, growth=0.01), 0.4: marches[0.4]}
    b = sweep_run("b", other)
    code, said = compared(a, b)
    assert code == 1 and said["only_in_a"] == ["point flutter.V_f = 0.6"] and said["only_in_b"] == ["point flutter.V_f = 0.8"]
    assert said["points_apart"] == ["flutter.V_f = 0.5"]
    assert {entry["place"] for entry in said["results"]} == {"flutter.V_f = 0.5"}
    again = sweep_run("again", dict(reversed([*marches.items(), (0.7, None)])))
    assert compared(a, again)[0] == 0


def test_a_sweep_of_boundaries_is_compared_crossing_by_crossing(tmp_path: Path, made_up: Marcher, compared: Any) -> None:
    for name, V_f, marched in (("a", 0.80, 0.79), ("b", 0.82, 0.79), ("c", 0.80, 0.81)):
        for mach in (0.8, 0.85):
            at = V_f if mach == 0.8 else 0.5
            crossing = {"V_f": at, "V_f_uncertainty": 0.001, "frequency": 0.8, "direction": "onset"}
            result = {"points": [{"mach": mach, "converged": True, "crossings": [crossing]}]}
            overrides = {"flow.mach": mach}
            record = point_file.Record(f"{mach}", "boundary", overrides, "done", True, result, "", "", 1, "w", 1.0, 1.0, 0.0, 1.0)
            file = tmp_path / name / "points" / f"{mach}.nc"
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_bytes(point_file.pack(record, [made_up(V_f=marched)], provenance({})))
    code, said = compared(tmp_path / "a", tmp_path / "b")
    assert code == 1 and said["points_apart"] == ["flow.mach = 0.8"]
    assert [d["place"] for d in said["results"]] == ["flow.mach = 0.8, Mach 0.8, onset"]
    assert [h["name"] for h in said["histories"]] == ["flow.mach = 0.8_m01", "flow.mach = 0.85_m01"]
    code, said = compared(tmp_path / "a", tmp_path / "c")
    assert code == 1 and said["points_apart"] == ["flow.mach = 0.8", "flow.mach = 0.85"]
    assert compared(tmp_path / "a", tmp_path / "c", "--tolerance", 1e-3)[0] == 0


def test_runs_of_any_system_are_judged_by_their_end(tmp_path: Path, compared: Any) -> None:
    """What `aeroslosh run` leaves has no verdict; the last values are details of its history."""
    for name, outcome, last in (("a", "done", 1.0), ("b", "done", 1.0 + 1e-9), ("c", "failed", 1.0)):
        numbers = {"outcome": outcome, "end_time": 2.0, "last": {"tank.force_x": last}, "scheme": {"passes": 3}}
        (tmp_path / f"{name}.json").write_text(json.dumps(numbers))
    assert compared(tmp_path / "a.json", tmp_path / "b.json")[0] == 1
    assert compared(tmp_path / "a.json", tmp_path / "b.json", "--tolerance", 1e-6)[0] == 0
    code, said = compared(tmp_path / "a.json", tmp_path / "c.json", "--tolerance", 1e-6)
    assert code == 1 and said["kind"] == "run" and [d["name"] for d in said["results"]] == ["outcome"]


def test_solver_channels_count_to_the_bit_only(point_run: Writer, made_up: Marcher, nudged: Marcher, compared: Any) -> None:
    march = made_up()
    a, b = point_run("a", march), point_run("b", nudged(march, "subiterations", 10, 1.0))
    assert compared(a, b)[0] == 1
    code, said = compared(a, b, "--tolerance", 1e-9)
    assert code == 0 and named(said["scheme"])["mean_subiterations"]["ratio"] == pytest.approx(4 / 3, rel=0.01)


def test_people_read_the_judgement_first(
    point_run: Writer, made_up: Marcher, nudged: Marcher, capsys: pytest.CaptureFixture[str]
) -> None:
    march = made_up()
    a = point_run("a", march)
    b = point_run("b", nudged(march, "alpha", 100, 1e-4), ["coupling.predictor_order=2"])
    assert cli.run(["compare", str(a), str(b)]) == 1
    said = capsys.readouterr().out.splitlines()
    assert said[2] == "DIFFERENT"
    assert said[3].split() == ["settings", "coupling.predictor_order", "auto", "→", "2"]
    assert any(line.startswith("  alpha: ") and "of its range" in line and "apart since t = " in line for line in said)
    assert not any(line.startswith("  lift: ") for line in said)
    cli.run(["compare", str(a), str(b), "--all"])
    assert "  lift: the same" in capsys.readouterr().out
    assert cli.run(["compare", str(a), str(a)]) == 0
    assert "SAME to the bit, cost apart" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("what", "says"),
    [
        ("missing", ["There is no such run", "remedy"]),
        ("empty", ["holds no result.json"]),
        ("history", ["different kinds", "is a point", "a history"]),
        ("cut", ["is no netCDF-3 history", "cut off"]),
        ("json", ["The result cannot be read", "result.json"]),
        ("tolerance", ["--tolerance -1", "from 0"]),
    ],
)
def test_bad_input_is_refused(point_run: Writer, made_up: Marcher, tmp_path: Path, what: str, says: list[str]) -> None:
    a, b = point_run("a", made_up()), point_run("b", made_up())
    more: list[str] = []
    if what == "empty":
        (tmp_path / what).mkdir()
    if what in ("missing", "empty"):
        b = tmp_path / what
    elif what == "history":
        b = b / "history.nc"
    elif what == "cut":
        whole = (b / "history.nc").read_bytes()
        (b / "history.nc").write_bytes(whole[: len(whole) // 2])
    elif what == "json":
        (b / "result.json").write_text("{")
    else:
        more = ["--tolerance", "-1"]
    with pytest.raises(AeroSloshError) as caught:
        cli.run(["compare", str(a), str(b), *more])
    assert caught.value.code == ExitCode.INPUT
    for part in says:
        assert part in str(caught.value)


def test_a_repeated_run_is_the_same_and_another_predictor_is_not(
    fmu: Callable[[str], Path], tmp_path: Path, compared: Any
) -> None:
    """Real marches on a small mesh: two in processes of their own, one from the record in this process, to the same bits."""
    for name in ("structure", "aero"):
        shutil.copy(fmu(name), tmp_path)
    small = ["aero.cells_around=64", "aero.cells_normal=16", "flutter.free_cycles=1.5", "flutter.forced_cycles=1"]
    small += ["flutter.max_free_cycles=1.5", "flutter.steps_per_cycle=72"]

    def point(run: Callable[..., Done], name: str, case: str | Path, *overrides: str) -> Path:
        words = [word for o in overrides for word in ("--set", o)]
        words += ["--no-pictures", "--quiet", "--out", str(tmp_path / name)]
        done = run("point", case, "--fmus", tmp_path, *words)
        assert done.returncode in (0, 4), done.stderr  # so short a march may have no verdict
        return tmp_path / name

    case = "cases/isogai_a.toml"
    first, again = point(command, "first", case, *small), point(command, "again", case, *small)
    # the record alone is enough
    repeated = point(called, "repeated", first / "case.toml")
    other = point(called, "other", first / "case.toml", "coupling.predictor_order=0")
    for run in (again, repeated):
        code, said = compared(first, run)
        assert code == 0 and said["histories"][0]["same"] and not said["results"] and not said["details"] and not said["settings"]
        assert set(named(said["provenance"])) <= {"command", "date"}
    code, said = compared(first, other)
    assert code == 1 and set(named(said["settings"])) == {"coupling.predictor_order"}
    assert named(said["results"])["growth_rate"]["relative"] > 1e-3
    assert said["histories"][0]["first_departure"] > 0.0 and said["histories"][0]["how"] == ""
