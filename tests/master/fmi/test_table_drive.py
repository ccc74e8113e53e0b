"""Motion tables: what is read, what is refused and how the refusal reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.fmi import table_drive


def table(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "motion.csv"
    path.write_text(text)
    return path


def test_a_table_is_read_and_resampled(tmp_path: Path) -> None:
    read = table_drive.read(table(tmp_path, "# stand 3\nh, time, alpha\n0, 0, 1\n2, 0.5, 2\n\n4, 1.5, 3\n"))
    assert read.names == ["h", "alpha"]
    np.testing.assert_array_equal(read.times, [0, 0.5, 1.5])
    np.testing.assert_array_equal(read.values, [[0, 1], [2, 2], [4, 3]])
    finer = read.resampled(0.25)
    np.testing.assert_allclose(finer.times, np.arange(7) * 0.25)
    np.testing.assert_allclose(finer.values[:, 0], [0, 1, 2, 2.5, 3, 3.5, 4])


@pytest.mark.parametrize("ends", ["\n", "\r\n", "\r"])
def test_a_mark_in_front_is_no_part_of_a_name(tmp_path: Path, ends: str) -> None:
    path = tmp_path / "motion.csv"
    path.write_bytes(b"\xef\xbb\xbf" + ends.join(["time,h", "0,1", "1,2", ""]).encode())
    read = table_drive.read(path)
    assert read.names == ["h"] and read.times.tolist() == [0.0, 1.0] and read.values.tolist() == [[1.0], [2.0]]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time,h\n0,1\n", ["fewer than two rows"]),
        ("t,h\n0,1\n1,1\n", ["columns are t, h", "line 1", "'time'"]),
        ("time,h,h\n0,1,1\n1,1,1\n", ["every name once"]),
        ("time,h\n0,1\n1,one\n", ["h = 'one'", "line 3"]),
        ("time,h\n0,1\n1,nan\n", ["h = 'nan'", "line 3"]),
        ("time,h\n0,1\n1\n", ["1 values for 2 columns", "line 3"]),
        ("time,h\n0,1\n2,1\n\n1,1\n", ["time = 1 does not grow", "line 5"]),
    ],
)
def test_refusals_name_file_line_and_remedy(tmp_path: Path, text: str, words: list[str]) -> None:
    path = table(tmp_path, text)
    with pytest.raises(AeroSloshError) as caught:
        table_drive.read(path)
    for word in [*words, str(path)]:
        assert word in str(caught.value)


def test_output_is_whole_or_absent(tmp_path: Path) -> None:
    columns = {"time": np.array([0.0, 0.1]), "lift": np.array([1 / 3, 2.0])}
    table_drive.write(tmp_path / "sub" / "out.csv", columns)
    lines = (tmp_path / "sub" / "out.csv").read_text().split()
    assert lines[0] == "time,lift"
    assert [float(v) for v in lines[1].split(",")] == [0.0, 1 / 3]
    assert [p.name for p in (tmp_path / "sub").iterdir()] == ["out.csv"]


def test_rates_and_accelerations_left_out_are_derived() -> None:
    times = np.linspace(0.0, 2.0, 201)
    inputs = ["x", "x_dot", "x_ddot", "alpha", "alpha_dot", "alpha_ddot", "gain"]
    table = table_drive.Table(times, ["x", "gain"], np.column_stack([np.sin(4 * times), times]))
    full, derived = table_drive.completed(table, inputs)
    assert derived == ["x_dot", "x_ddot"]
    assert full.names == ["x", "gain", "x_dot", "x_ddot"]
    middle = slice(10, -10)
    np.testing.assert_allclose(full.values[middle, 2], 4 * np.cos(4 * times)[middle], atol=1e-5)
    np.testing.assert_allclose(full.values[middle, 3], -16 * np.sin(4 * times)[middle], atol=1e-3)
    given = table_drive.Table(times, ["x", "x_dot", "x_ddot"], np.zeros((201, 3)))
    assert table_drive.completed(given, inputs)[1] == []
    assert table_drive.completed(table, ["x", "gain"])[1] == []
