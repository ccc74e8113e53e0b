"""What exports hold: every number exactly, units and provenance, fields with their times; what is refused."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.kit.vtk import line, structured_grid
from aeroslosh.master import cli
from aeroslosh.master.base import pvd
from aeroslosh.master.base.errors import AeroSloshError, ExitCode
from aeroslosh.master.flutter.march import March
from aeroslosh.master.results import export, history_file, point_file
from aeroslosh.master.results.provenance import provenance
from support.processes import called

Writer = Callable[..., Path]
Marcher = Callable[..., March]


def fields(folder: Path, *numbers: int, times: bool = False) -> Path:
    """Field files of two by two cells as the FMUs write them, the surface's beside them; times: number / 100 s inside."""
    folder.mkdir(parents=True, exist_ok=True)
    points = np.zeros((3, 3, 3))
    points[..., 1], points[..., 0] = np.meshgrid(range(3), range(3), indexing="ij")
    for n in numbers:
        told = {"TimeValue": np.array([n / 100])} if times else None
        structured_grid(folder / f"fields_{n:06d}.vts", points, {"mach": np.ones((2, 2))}, told)
        line(folder / f"surface_{n:06d}.vtp", points[0], {"pressure_coefficient": np.zeros(2)})
    return folder


def test_csv_is_exact_and_says_what_it_holds(point_run: Writer, made_up: Marcher, capsys: pytest.CaptureFixture[str]) -> None:
    march = made_up()
    run = point_run("a", march, ["coupling.predictor_order=2"])
    assert cli.run(["export", "csv", str(run), "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    table, metadata = (Path(name) for name in said["files"])
    assert (table, said["samples"]) == (run / "history.csv", march.tau.size)
    read = np.genfromtxt(table, delimiter=",", names=True)
    assert list(read.dtype.names or ()) == list(march.history)
    for name, values in march.history.items():
        np.testing.assert_array_equal(read[name], values)
    about = json.loads(metadata.read_text())
    columns = {c["name"]: c for c in about["tableSchema"]["columns"]}
    assert about["url"] == "history.csv" and columns["alpha"]["schema:unitText"] == "rad"
    assert "nose-up" in columns["alpha"]["dc:description"]
    (note,) = about["notes"]
    assert note["fmu_sha256"]["aero"] == "b" * 64 and note["verdict"] == "damped" and "predictor_order = 2" in note["case"]


def test_parquet_is_exact_and_says_what_it_holds(point_run: Writer, made_up: Marcher, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    march = made_up()
    assert (
        cli.run(["export", "parquet", str(point_run("a", march) / "history.nc"), "--out", str(tmp_path / "x" / "y.parquet")]) == 0
    )
    table = parquet.read_table(tmp_path / "x" / "y.parquet")
    assert table.column_names == list(march.history)
    for name, values in march.history.items():
        np.testing.assert_array_equal(table[name].to_numpy(), values)
    assert table.schema.field("h").metadata[b"unit"] == b"m"
    assert json.loads(table.schema.metadata[b"aeroslosh"])["versions"]["numpy"] == np.__version__


def test_parquet_without_pyarrow_names_the_remedy(point_run: Writer, made_up: Marcher, monkeypatch: pytest.MonkeyPatch) -> None:
    run = point_run("a", made_up())
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    with pytest.raises(AeroSloshError, match=r"pip install 'aeroslosh\[parquet\]'") as caught:
        cli.run(["export", "parquet", str(run)])
    assert caught.value.code == ExitCode.INPUT and not list(run.glob("*.parquet*"))


def test_every_march_of_a_sweep_is_a_file(sweep_run: Writer, made_up: Marcher, tmp_path: Path) -> None:
    run = sweep_run("s", {0.5: made_up(V_f=0.5), 0.6: made_up(V_f=0.6), 0.7: None})
    assert cli.run(["export", "csv", str(run), "--out", str(tmp_path / "tables")]) == 0
    assert sorted(path.name for path in (tmp_path / "tables").glob("*.csv")) == [f"{n:016x}.csv" for n in range(2)]
    with pytest.raises(AeroSloshError, match="2 histories for one file"):
        cli.run(["export", "csv", str(run), "--out", str(tmp_path / "one.csv")])


@pytest.mark.parametrize("form", ["csv", "parquet"])
def test_points_without_histories_are_said_to_have_none(sweep_run: Writer, form: str) -> None:
    """Points that failed at once; a boundary of a linear model leaves such files too."""
    run = sweep_run("s", {0.5: None, 0.6: None})
    with pytest.raises(AeroSloshError, match="None of its points has a history"):
        cli.run(["export", form, str(run)])
    assert not [*run.rglob("*.csv"), *run.rglob("*.parquet")]


def test_the_marches_of_a_boundary_in_one_file_are_told_apart(tmp_path: Path, made_up: Marcher) -> None:
    marches = [made_up(V_f=0.5), made_up(V_f=0.6, cycles=4)]
    record = point_file.Record("id", "boundary", {}, "done", True, {}, "", "", 1, "w", 1.0, 1.0, 0.0, 1.0)
    (tmp_path / "p.nc").write_bytes(point_file.pack(record, marches, provenance({})))
    assert cli.run(["export", "csv", str(tmp_path / "p.nc")]) == 0
    for name, march in zip(("p_m01", "p_m02"), marches, strict=True):
        read = np.genfromtxt(tmp_path / f"{name}.csv", delimiter=",", names=True)
        np.testing.assert_array_equal(read["alpha"], march.history["alpha"])


def test_fields_get_their_times_from_the_history(point_run: Writer, made_up: Marcher) -> None:
    """Of a run older than its collection: the aero FMU numbers its files by steps."""
    march = made_up()
    run = point_run("a", march)
    fields(run / "fields", 100, 120)
    assert cli.run(["export", "vtk", str(run)]) == 0
    time = march.history["time"]
    names = [f"{kind}_{n:06d}.{end}" for n in (100, 120) for kind, end in (("fields", "vts"), ("surface", "vtp"))]
    expected = [(time[n], run / "fields" / name) for n, name in zip((100, 100, 120, 120), names, strict=True)]
    assert pvd.read(run / "fields.pvd") == expected
    # what the collection says is kept: a second export, of the moved folder, without its history
    moved = run.rename(run.with_name("moved"))
    (moved / "history.nc").unlink()
    assert [t for t, _ in export.fields(moved)] == [time[n] for n in (100, 120, 100, 120)]


def test_the_time_in_a_file_counts_for_its_surface_too(tmp_path: Path) -> None:
    liquid = fields(tmp_path / "run" / "fields" / "slosh", 4, 8, times=True)
    fields(tmp_path / "run" / "fields", 8, times=True)
    found = export.fields(tmp_path / "run")
    assert [time for time, path in found if path.parent == liquid] == [0.04, 0.08, 0.04, 0.08]
    path, times, files = export.to_vtk(tmp_path / "run", tmp_path / "elsewhere" / "film.pvd", copy=True)
    assert (times, files) == (2, 6)
    copies = [file for _, file in pvd.read(path)]
    assert all(file.is_file() and file.is_relative_to(tmp_path / "elsewhere") for file in copies) and len(set(copies)) == 6
    parts = {line.split('part="')[1][0] for line in path.read_text().splitlines() if "part=" in line}
    assert parts == {"0", "1", "2", "3"}


def test_drive_leaves_a_collection_with_the_times_of_its_rows(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    """The aero FMU writes no field of the first row and no time into its files."""
    motion = tmp_path / "motion.csv"
    motion.write_text("time,alpha\n1.0,0\n1.001,0.001\n1.003,0.001\n1.004,0.001\n1.006,0.001\n")
    words = ["drive", str(fmu("aero")), "--input", str(motion), "--fields", "2", "--json"]
    words += ["--no-pictures", "--set", "cells_around=64", "--set", "cells_normal=16"]
    done = called(*words)
    assert done.returncode == 0, done.stderr
    assert [Path(name).name for name in json.loads(done.stdout)["files"]] == ["motion_aero.csv", "fields", "fields.pvd"]
    told = [(time, path.name) for time, path in pvd.read(tmp_path / "fields.pvd")]
    assert told == [
        (1.003, "fields_000002.vts"), (1.003, "surface_000002.vtp"), (1.006, "fields_000004.vts"), (1.006, "surface_000004.vtp")
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["csv", "RUN/none"], ["There is no such run", "remedy"]),
        (["csv", "RUN/run.log"], ["no netCDF-3 history"]),
        (["csv", "RUN/fields"], ["holds no history"]),
        (["csv", "RUN", "--out", "RUN/run.log/x.csv"], ["cannot be written", "--out"]),
        (["vtk", "RUN"], ["wrote no fields", "output.fields = true"]),
        (["vtk", "RUN/history.nc"], ["no such run folder"]),
    ],
)
def test_bad_input_is_refused(point_run: Writer, made_up: Marcher, arguments: list[str], says: list[str]) -> None:
    run = point_run("a", made_up())
    (run / "fields").mkdir()
    with pytest.raises(AeroSloshError) as caught:
        cli.run(["export", *(word.replace("RUN", str(run)) for word in arguments)])
    assert caught.value.code == ExitCode.INPUT
    for part in says:
        assert part in str(caught.value)


def test_fields_of_which_nothing_tells_the_time_are_refused(tmp_path: Path) -> None:
    fields(tmp_path / "run" / "fields", 3)
    with pytest.raises(AeroSloshError, match="Nothing tells the time"):
        export.fields(tmp_path / "run")
    with pytest.raises(AeroSloshError, match=r"end it in \.pvd"):
        export.to_vtk(fields(tmp_path / "timed", 3, times=True), tmp_path / "film.vtk")


def test_a_broken_field_file_is_told(tmp_path: Path) -> None:
    path = fields(tmp_path, 3, times=True) / "fields_000003.vts"
    path.write_text(path.read_text()[:200])
    with pytest.raises(AeroSloshError, match="cannot be read"):
        export.fields(tmp_path)


def test_attributes_and_units_are_read_back(point_run: Writer, made_up: Marcher) -> None:
    march = made_up()
    (read,) = history_file.read(point_run("a", march) / "history.nc")
    assert (read.name, read.size, read.units["h_over_b"]) == ("history", march.tau.size, "1")
    assert read.attributes["V_f"] == march.scales.V_f and read.attributes["release_index"] == 0
    assert read.attributes["fmu_sha256"] == {"structure": "a" * 64, "aero": "b" * 64}
    np.testing.assert_array_equal(read.values["lift"], march.history["lift"])
