"""Films of recorded fields on the page: their frames are pictures of these fields, and damage is told."""

from __future__ import annotations

import base64
import io
import re
from pathlib import Path

import numpy as np
from PIL import Image

from aeroslosh.master.pictures.tank_film import LIQUID
from aeroslosh.master.report import films
from support.fields import flow, tank


def frames(drawn: str) -> list[Image.Image]:
    """The pictures in a piece of a page."""
    return [
        Image.open(io.BytesIO(base64.b64decode(code))).convert("RGB")
        for code in re.findall(r"image/webp;base64,([\w+/=]+)", drawn)
    ]


def test_a_tank_is_shown_turning(tmp_path: Path) -> None:
    for n, angle in enumerate((0.0, 0.4)):
        tank(tmp_path / "fields", n + 1, angle, time=0.1 * n)
    drawn = films.of_folder(tmp_path, 1.0, 0.0, "slosh (VOF)")
    level, turned = (np.asarray(f, dtype=float) for f in frames(drawn))
    assert "t = 0.1000 s" in drawn and "Liquid in the tank, slosh (VOF)" in drawn and drawn.count("film-frame shown") == 1
    liquid = 255.0 * np.array(LIQUID(1.0)[:3])
    h, w = level.shape[:2]
    below, above = level[int(0.62 * h), w // 3], level[int(0.38 * h), w // 3]
    assert np.abs(below - liquid).max() < 20 and above.min() > 235
    assert np.abs(turned - level).max() > 100


def test_a_flow_is_shown_in_the_section_s_own_lengths(tmp_path: Path) -> None:
    for n in range(3):
        flow(tmp_path / "fields", n + 1, 0.1 * n)
    drawn = films.of_folder(tmp_path, 1.0, 0.0, "dry, Mach 0.8")
    assert len(frames(drawn)) == 3 and "white line: Mach 1" in drawn and "x/c [–]" in drawn
    picture = np.asarray(frames(drawn)[0], dtype=float)
    h, w = picture.shape[:2]
    assert picture[h // 2, w // 2].max() < 60  # the section covers its middle, x/c 0.5
    assert picture[h // 2, int(w * (1.3 + 0.5) / 2.0)].max() > 90  # r = 0.8: the sonic line passes here


def test_more_instants_than_can_be_shown_are_thinned_and_damage_is_told(tmp_path: Path) -> None:
    for n in range(30):
        tank(tmp_path / "fields", n + 1, 0.01 * n, time=0.1 * n)
    assert len(frames(films.of_folder(tmp_path, 1.0, 0.0, ""))) == 15
    (tmp_path / "fields" / "fields_000001.vts").write_text("<broken")
    told = films.of_folder(tmp_path, 1.0, 0.0, "")
    assert "cannot be shown" in told and not frames(told)
    assert films.of_folder(tmp_path / "none", 1.0, 0.0, "") == ""
