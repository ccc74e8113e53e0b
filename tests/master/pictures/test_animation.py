"""Tank pictures: what is read, what is drawn where, what is refused; `drive --fields` and `animate` through the command line."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

from aeroslosh.fmus.kit.vtk import turned
from aeroslosh.master.base import vtk
from aeroslosh.master.base.errors import AeroSloshError
from aeroslosh.master.pictures import tank_film
from support.fields import tank
from support.processes import called


def test_what_is_written_is_read(tmp_path: Path) -> None:
    field = vtk.read(tank(tmp_path, 3, math.pi / 6, 0.5, 1.0 / 3.0))
    assert field.whole["TimeValue"] == [1.0 / 3.0]
    foot, tip = field.whole["baffles"]
    np.testing.assert_allclose(tip - foot, [0.14 * math.sin(math.pi / 6), 0.14 * math.cos(math.pi / 6), 0.0], rtol=1e-15)
    # the west end of the floor goes up, nose-up
    c, s = math.cos(math.pi / 6), math.sin(math.pi / 6)
    np.testing.assert_allclose([field.x[0, 0], field.y[0, 0]], [0.5 - 0.2 * c - 0.1 * s, 0.2 * s - 0.1 * c], atol=1e-7)
    assert field.cells["volume_fraction"].shape == (10, 20)


def test_files_come_in_the_order_of_their_numbers(tmp_path: Path) -> None:
    for number in (12, 3, 1_000_000):
        tank(tmp_path, number)
    (tmp_path / "surface_000003.vtp").write_text("")
    assert [path.name for path in tank_film.find(tmp_path)] == ["fields_000003.vts", "fields_000012.vts", "fields_1000000.vts"]


def test_liquid_gas_walls_and_baffles_have_their_colours(tmp_path: Path) -> None:
    """Pixels of a tank pitched by 30 degrees, read back at points of the tank."""
    field = tank_film.read(tank(tmp_path, 1, math.pi / 6, time=0.25))
    figure, axes = plt.subplots(figsize=(6, 6), dpi=100)
    tank_film.draw(axes, field, np.array([-0.3, 0.3, -0.3, 0.3]), "fields_000001")
    figure.canvas.draw()
    pixels = np.asarray(figure.canvas.buffer_rgba())[..., :3].astype(int)  # type: ignore[attr-defined]

    def colour(x: float, y: float) -> np.ndarray:
        at = axes.transData.transform(turned(np.array(x), np.array(y), math.pi / 6)[:2])
        return pixels[pixels.shape[0] - 1 - round(at[1]), round(at[0])]

    for x in (-0.15, -0.05, 0.15):
        red, _, blue = colour(x, -0.05)
        assert blue > red + 80, "liquid is blue"
        assert colour(x, 0.05).min() > 240, "gas is white"
    assert colour(0.05, -0.02).max() < 90, "a baffle is dark"
    assert colour(0.05, 0.06).min() > 240, "no baffle above its tip"
    assert colour(0.0, 0.1).max() < 110, "a wall is dark"
    assert np.all(colour(0.0, 0.13) > 250), "nothing outside"
    assert axes.get_title() == "t = 0.2500 s"
    plt.close(figure)


def test_an_animation_has_a_frame_for_each_file(tmp_path: Path) -> None:
    files = [tank(tmp_path / "fields", n, 0.1 * n, time=0.1 * n) for n in range(4)]
    written = tank_film.animate(files, tmp_path / "sub" / "film.gif", 25, tmp_path / "pictures")
    assert [path.name for path in written] == ["film.gif", *(f"fields_{n:06d}.png" for n in range(4))]
    with Image.open(written[0]) as film:
        assert film.n_frames == 4  # type: ignore[attr-defined]
        assert film.info["duration"] == 40
        frames = []
        for n in range(4):
            film.seek(n)
            frames.append(np.asarray(film.convert("L"), dtype=int))
    for one, other in pairwise(frames):
        assert np.abs(one - other).max() > 100
        # and the margins stay where they are
        np.testing.assert_array_equal(one[-3:], other[-3:])
    # whole or not at all
    assert sorted(path.name for path in (tmp_path / "sub").iterdir()) == ["film.gif"]
    assert len(list((tmp_path / "pictures").iterdir())) == 4


def test_a_tank_that_travels_is_followed(tmp_path: Path) -> None:
    def windows(step: float) -> np.ndarray:
        return tank_film.windows(np.array([tank_film.box(vtk.read(tank(tmp_path, n, aft=step * n))) for n in range(4)]))

    near, far = windows(0.1), windows(1.0)
    np.testing.assert_array_equal(near, np.tile(near[0], (4, 1)))
    assert near[0, 0] < -0.2 < 0.5 < near[0, 1]
    np.testing.assert_allclose(np.diff(far[:, 0]), 1.0, rtol=1e-6)
    np.testing.assert_allclose(far[:, 1] - far[:, 0], far[0, 1] - far[0, 0], rtol=1e-6)
    assert far[0, 1] - far[0, 0] < 0.6


def test_refusals_name_the_file_and_the_remedy(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    good = [tank(tmp_path / "good", 1)]
    broken = tmp_path / "broken" / "fields_000001.vts"
    broken.parent.mkdir()
    broken.write_text("no XML")
    out = tmp_path / "film.gif"
    cases: list[tuple[Callable[[], object], list[str]]] = [
        (lambda: tank_film.find(tmp_path / "nowhere"), ["no such folder", "nowhere"]),
        (lambda: tank_film.find(tmp_path / "empty"), ["no files fields_<number>.vts", "--fields"]),
        (lambda: tank_film.animate([broken], out), ["cannot be read", str(broken)]),
        (lambda: tank_film.animate([tank(tmp_path / "wing", 1, cells="mach")], out), ["no volume_fraction", "slosh FMU"]),
        (lambda: tank_film.animate(good, out, 0), ["--fps 0", "1 to 50"]),
        (lambda: tank_film.animate(good, tmp_path / "film.mp4"), ["film.mp4", ".gif"]),
    ]
    for attempt, words in cases:
        with pytest.raises(AeroSloshError) as caught:
            attempt()
        for word in words:
            assert word in str(caught.value)
    assert not out.exists()


def test_drive_writes_fields_and_animate_draws_them(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    motion = tmp_path / "motion.csv"
    t = 0.02 * np.arange(10)
    motion.write_text("time,h,h_dot,h_ddot\n" + "".join(f"{s},{0.1 * s**2},{0.2 * s},0.2\n" for s in t))
    (tmp_path / "fields").mkdir()
    (tmp_path / "fields" / "fields_000777.vts").write_text("of an earlier run")
    (tmp_path / "fields" / "fields_of_mine.vts").write_text("the user's own")
    common = ["--input", str(motion), "--set", "cells_x=32", "--set", "cells_y=16", "--no-pictures", "--json"]
    done = called("drive", str(fmu("slosh_vof")), *common, "--fields", "4", "--set", "initial_wave=0.01")
    assert done.returncode == 0, done.stderr
    report = json.loads(done.stdout)
    with Path(report["files"][0]).open() as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == 10
    assert float(rows[0]["wave_height_west"]) > 9e-3
    names = ["fields_000000.vts", "fields_000004.vts", "fields_000008.vts"]
    assert sorted(path.name for path in (tmp_path / "fields").iterdir()) == [*names, "fields_of_mine.vts"]
    last = vtk.read(tmp_path / "fields" / names[-1])
    np.testing.assert_allclose(last.whole["TimeValue"], t[8], rtol=1e-12)
    np.testing.assert_allclose(last.y[0], -0.075 - 0.1 * t[8] ** 2, rtol=1e-6)
    # a folder of one's own
    mine = tmp_path / "mine"
    done = called("drive", str(fmu("slosh_vof")), *common, "--fields", "9", "--set", f"field_folder={mine}")
    assert done.returncode == 0, done.stderr
    assert sorted(path.name for path in mine.iterdir()) == ["fields_000000.vts", "fields_000009.vts"]
    done = called("animate", str(tmp_path / "fields"), "--json")
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["frames"] == 3
    assert (tmp_path / "fields" / "animation.gif").stat().st_size > 5000
    done = called("animate", str(tmp_path))
    assert done.returncode == 2
    assert "remedy:" in done.stderr


def test_fields_of_an_fmu_without_them_are_refused(fmu: Callable[[str], Path], tmp_path: Path) -> None:
    motion = tmp_path / "motion.csv"
    motion.write_text("time,lift\n0,0\n1,1\n")
    done = called("drive", str(fmu("structure")), "--input", str(motion), "--fields", "1")
    assert done.returncode == 2
    assert "structure writes no fields" in done.stderr
    done = called("drive", str(fmu("structure")), "--input", str(motion), "--fields", "0")
    assert done.returncode == 2
    assert "--fields 0" in done.stderr
    # and without --fields nothing is asked of it
    assert called("drive", str(fmu("structure")), "--input", str(motion), "--no-pictures").returncode == 0
    assert not (tmp_path / "fields").exists()
