"""Colours that everybody tells apart, maps that rise evenly, words on every axis, legends off the data."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from matplotlib import colormaps
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from aeroslosh.master.base import vtk
from aeroslosh.master.boundary.search import BoundaryPoint, sample
from aeroslosh.master.flutter.march import March
from aeroslosh.master.fmi.table_drive import Table
from aeroslosh.master.pictures import (
    amplitude_overlay,
    boundary,
    canvas,
    envelope,
    look,
    mach_field,
    march,
    modes,
    overlay,
    sweep,
    table,
)
from support.fields import flow

# Machado, Oliveira and Fernandes 2009, doi 10.1109/TVCG.2009.113, severity 1.0, on linear sRGB
BLIND = {
    "protanopia": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deuteranopia": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritanopia": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
XYZ = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]])


def linear(colours: Any) -> np.ndarray:
    """sRGB → linear, shape (n, 3)."""
    c = np.atleast_2d(np.asarray(colours, dtype=float))
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def lab(light: np.ndarray) -> np.ndarray:
    """CIE L*a*b* (D65) of linear sRGB, shape (n, 3)."""
    t = np.clip(light, 0.0, None) @ XYZ.T / (0.95047, 1.0, 1.08883)
    f = np.where(t > (6 / 29) ** 3, np.cbrt(t), t / (3 * (6 / 29) ** 2) + 4 / 29)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def seen(colours: Any, by: str) -> np.ndarray:
    """CIE L*a*b* as an eye sees it."""
    return lab(np.clip(linear(colours) @ np.array(BLIND[by]).T, 0.0, 1.0)) if by else lab(linear(colours))


@pytest.mark.parametrize("eye", ["", *BLIND])
def test_signs_of_a_map_are_told_apart_by_every_eye(eye: str) -> None:
    colours = seen(look.signed(201), eye)
    for share in (0.15, 0.3, 0.6, 1.0):  # of the largest value
        below, above = colours[round(100 * (1 - share))], colours[round(100 * (1 + share))]
        assert np.linalg.norm(below - above) > (30.0 if eye == "tritanopia" else 40.0) * share


def test_maps_rise_evenly_in_lightness() -> None:
    signed = lab(linear(look.signed(201)))[:, 0]
    np.testing.assert_allclose(signed, signed[::-1], atol=1.5)  # neither sign is the heavier
    steps = np.diff(signed[:101])
    assert steps.min() > 0.0 and steps.max() < 1.6 * steps.mean()
    even = np.diff(lab(linear(colormaps[look.EVEN](np.linspace(0, 1, 64))[:, :3]))[:, 0])
    assert even.min() > 0.0 and even.max() < 2.0 * even.mean()


@pytest.mark.parametrize("eye", ["", *BLIND])
def test_verdicts_and_crossings_are_told_apart_by_colour_or_shape(eye: str) -> None:
    for colours, marks in ((look.VERDICTS, look.MARKS), (look.CROSSINGS, look.CROSSING_MARKS)):
        for a, b in itertools.combinations(colours, 2):
            assert marks[a] != marks[b]
    growing, damped = (seen(to_rgb(look.VERDICTS[v]), eye)[0] for v in ("flutter", "damped"))
    assert np.linalg.norm(growing - damped) > 40.0


@pytest.fixture
def drawn(monkeypatch: pytest.MonkeyPatch) -> Iterator[list[Figure]]:
    """The figures that the pictures make."""
    figures: list[Figure] = []
    real = canvas.subplots

    def subplots(*words: Any, **options: Any) -> tuple[Figure, Any]:
        figure, axes = real(*words, **options)
        figures.append(figure)
        return figure, axes

    monkeypatch.setattr(canvas, "subplots", subplots)
    yield figures


def check(figure: Figure, titled: tuple[str, ...]) -> None:
    """Legends lie beside the axes, axes have words with units, the title tells `titled`."""
    figure.canvas.draw()
    axes = [a for a in figure.axes if a.get_visible() and a.get_label() != "<colorbar>"]
    legends = [*figure.legends, *(a.get_legend() for a in axes if a.get_legend() is not None)]
    for signs in legends:
        box = signs.get_window_extent()
        assert all(not box.overlaps(a.get_window_extent()) for a in axes)
    words = " ".join([figure.get_suptitle(), *(a.get_title() for a in axes)])
    assert all(word in words for word in titled), words
    for axis in figure.axes:
        for text in (axis.get_xlabel(), axis.get_ylabel()):
            assert not text or re.search(r"\[[^\]]+\]", text), text
            assert "_" not in text.split("$")[0], text  # a word of people, no key


def test_pictures_of_a_march(drawn: list[Figure], made_up: Callable[..., March], tmp_path: Path) -> None:
    of = made_up(growth=0.01)
    of.history["alpha_dot"] = np.gradient(of.history["alpha"], of.history["time"])
    of.fields = [(float(of.tau[-1 - 10 * n]), flow(tmp_path / "fields", 9 - n, 0.1)) for n in range(3, -1, -1)]
    march.histories(of, tmp_path / "h.png")
    march.phase(of, tmp_path / "p.png")
    mach_field.save(of, tmp_path / "m.png", 1.0, 0.0)
    for figure in drawn:
        check(figure, ("dry", "Mach 0.3", "V_f"))
    assert len(drawn) == 3 and len(drawn[0].legends) == 1


def test_pictures_of_a_boundary(drawn: list[Figure], made_up: Callable[..., March], tmp_path: Path) -> None:
    points = []
    for mach in (0.3, 0.4):
        marches = [made_up(V_f=0.5, growth=-0.01), made_up(V_f=0.7, growth=0.01)]
        points.append(BoundaryPoint(mach, [], [sample(m) for m in marches], "nothing", True, marches))
    boundary.draw(points, tmp_path / "b.png", None, "ems")
    check(drawn[-1], ("linear slosh (EMS)", "Mach 0.3 to 0.4", "V_f"))
    modes.draw(points[0], 0.4, 0.8, tmp_path / "v.png")
    check(drawn[-1], ("dry", "Mach 0.3", "V_f"))


@pytest.mark.parametrize("grid", [True, False])
def test_pictures_of_a_sweep(drawn: list[Figure], grid: bool) -> None:
    rows = [
        {"flutter.V_f": v, "slosh.fill_level": f, "mach": 0.7, "V_f": v, "slosh": "ems", "slosh_holds": f < 0.8}
        | {"growth_rate": v - f, "growth_rate_uncertainty": 1e-3, "verdict": "flutter" if v > f else "damped"}
        for v in (0.4, 0.6, 0.8)
        for f in (0.3, 0.5, 0.9)
    ]  # fmt: skip
    assert sweep.draw(rows, "point", ["slosh.fill_level", "flutter.V_f"], grid)
    check(drawn[-1], ("linear slosh (EMS)", "Mach 0.7", "$V_f$ = 0.4 to 0.8"))
    labels = [text.get_text() for signs in drawn[-1].legends for text in signs.get_texts()]
    assert sweep.DOUBTFUL in labels and drawn[-1].axes[0].get_xlabel() == "fill level (depth over tank height) [–]"


def test_a_key_without_words_of_its_own_gets_those_of_its_rule() -> None:
    assert look.words("slosh.tank_length") == "tank length [m]"
    assert look.words("flow.mean_alpha_deg") == "mean alpha [deg]"
    assert look.words("slosh.parameters.baffle_count") == "baffle count"


def test_panels_of_a_table_have_units(drawn: list[Figure], tmp_path: Path) -> None:
    times = np.linspace(0.0, 1.0, 11)
    driven = Table(times, ["h_dot"], np.sin(times)[:, None])
    columns = {"time": times, "force_x": times, "still": 0.0 * times}
    table.draw(tmp_path / "t.png", driven, columns, {"h_dot": "m/s", "force_x": "N"})
    titles = [a.get_title(loc="left") for a in drawn[-1].axes if a.get_visible()]
    assert titles == ["h dot [m/s]", "force x [N]"]


def test_the_sonic_line_is_smooth(tmp_path: Path) -> None:
    """On a ring of coarse cells whose Mach number falls with the distance from the middle, the line of 1 is a circle."""
    field = vtk.read(flow(tmp_path / "f", 1, 0.0, sonic=0.9, around=48, normal=24)).scaled(1.0, 0.0)
    x, y, mach = mach_field.smooth(field)
    _, axis = canvas.subplots()
    (path,) = axis.contour(x, y, mach, levels=[1.0]).get_paths()
    r = np.hypot(path.vertices[:, 0] - 0.5, path.vertices[:, 1])
    assert abs(r.mean() - 0.9) < 0.03 and np.ptp(r) < 0.01  # cells there are 0.1 wide
    turns = np.diff(np.unwrap(np.arctan2(*np.diff(path.vertices, axis=0).T[::-1])))
    assert np.abs(turns[np.abs(turns) < math.pi / 2]).max() < math.radians(12.0)  # no staircase


def test_limit_cycles_of_several_models(drawn: list[Figure], tmp_path: Path) -> None:
    points = [{"amplitude_deg": a, "growth_rate": g, "standard_error": 1e-4} for a, g in ((0.1, 0.01), (1.0, 0.02))]
    cycle = {"amplitude_deg": 0.3, "std_deg": 0.4, "stable": True, "slope": -0.01, "confirmed": "both"}
    held = {"V_f": 0.8, "cycles": [cycle, cycle | {"amplitude_deg": 2.0, "stable": False, "confirmed": ""}], "curve": points}
    rows = [{"V_f": 0.7, "cycles": [], "curve": [p | {"growth_rate": -0.01} for p in points]}, held]
    free = [{"V_f": 0.7, "cycles": [], "curve": []}, {"V_f": 0.8, "cycles": [], "curve": points}]
    amplitude_overlay.draw({"RBF": rows, "frozen": free}, "Limit cycles over $V_f$, Mach 0.8", tmp_path / "a.png")
    check(drawn[-1], ("Limit cycles", "Mach 0.8"))
    told = {text.get_text() for text in drawn[-1].legends[0].get_texts()}
    assert {"RBF", "frozen", "all motions marched grow", "all decay"} <= told
    low, high = drawn[-1].axes[0].get_ylim()
    assert 0.0 < low <= 0.1 and high >= 2.0


def test_pictures_of_several_boundaries_and_of_altitudes(drawn: list[Figure], tmp_path: Path) -> None:
    rows = [
        {
            "mach": m,
            "V_f": 1.0 - m / 2,
            "V_f_uncertainty": 0.01,
            "frequency": 0.9,
            "kind": "flutter",
            "direction": d,
            "slosh_holds": h,
        }
        for m, d, h in ((0.7, "onset", None), (0.8, "onset", False), (0.8, "recovery", None))
    ]
    overlay.draw({"dry": rows, "slosh (VOF)": rows[:1]}, tmp_path / "o.png")
    check(drawn[-1], ("dry against slosh (VOF)", "Mach 0.7 to 0.8", "V_f"))
    found = [
        {
            "altitude": 1000.0 * n,
            "mach": 0.6 + n / 50,
            "airspeed": 200.0 + n,
            "equivalent_airspeed": 190.0 - n,
            "onset": True,
            "fill": f,
        }
        for n in range(3)
        for f in (0.2, 0.8)
    ]
    assert envelope.draw(found, ["fill"], "ems", 0.0, 2000.0).startswith(b"\x89PNG")
    check(drawn[-1], ("linear slosh (EMS)",))
    assert {text.get_text() for text in drawn[-1].legends[0].get_texts()} == {
        f"fill {f}: flutters from here on" for f in (0.2, 0.8)
    }
