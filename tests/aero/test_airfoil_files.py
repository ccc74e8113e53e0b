"""Coordinate files as people have them: every way to write a section gives the section, or a sentence that says why not.

The sections are known (NACA formulas), so every form has an exact answer: the contour that the clean file gives.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from aeroslosh.fmus.aero.airfoil import AirfoilError, contour, section
from aeroslosh.fmus.aero.conformal import circle_map
from aeroslosh.fmus.aero.control import Settings
from aeroslosh.fmus.aero.march import Flow
from aeroslosh.fmus.aero.mesh import o_mesh

Sides = tuple[np.ndarray, np.ndarray]


def sides(code: str, a_side: int, base: float) -> Sides:
    """Upper side from the trailing edge to the nose, and lower side back, of a NACA section opened to a blunt base [chords]."""
    clean = contour(code)
    spline, last = CubicSpline(np.arange(len(clean)), clean), len(clean) - 1
    upper, lower = spline(np.linspace(0, last / 2, a_side)), spline(np.linspace(last / 2, last, a_side))
    upper[:, 1] += 0.5 * base * upper[:, 0]
    lower[:, 1] -= 0.5 * base * lower[:, 0]
    return upper, lower


def loop(s: Sides) -> np.ndarray:
    """Selig order: trailing edge, upper side, nose, lower side, trailing edge."""
    return np.vstack([s[0], s[1][1:]])


def text(points: np.ndarray, digits: int = 6) -> str:
    return "".join(f"{x:.{digits}f} {y:.{digits}f}\n" for x, y in points)


def middle(s: Sides) -> np.ndarray:
    return 0.5 * (s[0][0] + s[1][-1])


def dense_base(s: Sides) -> np.ndarray:
    """A file that begins in the middle of a base of many points."""
    at = np.linspace(0, 1, 9)[:, None]
    return np.vstack([middle(s) + at * (s[0][0] - middle(s)), loop(s)[1:-1], s[1][-1] + at * (middle(s) - s[1][-1])])


# every way to write a blunt base: what is written of the two sides
FORMS: dict[str, Callable[[Sides], np.ndarray]] = {
    "open": loop,
    "closed": lambda s: np.vstack([loop(s), s[0][:1]]),
    "from the middle of the base": lambda s: np.vstack([middle(s), loop(s), middle(s)]),
    "from the middle, not back": lambda s: np.vstack([middle(s), loop(s)]),
    "from the middle of a dense base": dense_base,
    "pinched to a point": lambda s: np.vstack([middle(s), loop(s)[1:-1], middle(s)]),
    "pinched, point not repeated": lambda s: np.vstack([middle(s), loop(s)[1:-1]]),
    "first point lost": lambda s: loop(s)[1:],
    "last point lost": lambda s: loop(s)[:-1],
    "last point lost, closed": lambda s: np.vstack([loop(s)[:-1], s[0][:1]]),
    "other sense": lambda s: loop(s)[::-1],
    "closed, other sense": lambda s: np.vstack([loop(s), s[0][:1]])[::-1],
    "from the nose": lambda s: np.vstack([s[1], s[0][:-1]]),
    "every point twice": lambda s: np.repeat(loop(s), 2, axis=0),
    "nose to tail, lower side first": lambda s: np.vstack([s[1], s[0][::-1]]),
    "tail to nose twice": lambda s: np.vstack([s[0], s[1][::-1]]),
}  # fmt: skip


def written(folder: Path, content: str | bytes) -> str:
    path = folder / "form.dat"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return str(path)


def distance(a: np.ndarray, b: np.ndarray) -> float:
    """Largest distance of points of a from the polygon b in y, chords, behind x/c 0.05."""
    worst = 0.0
    for half in (0, 1):
        p, q = (c[np.argmin(c[:, 0]) :] if half else c[np.argmin(c[:, 0]) :: -1] for c in (a, b))
        worst = max(worst, float(np.abs(np.interp(p[:, 0], *q.T) - p[:, 1])[p[:, 0] > 0.05].max()))
    return worst


@pytest.mark.parametrize("base", [0.0012, 0.0025, 0.008])
@pytest.mark.parametrize("form", FORMS)
def test_a_symmetric_section_has_no_lift_from_every_form_of_its_base(tmp_path: Path, form: str, base: float) -> None:
    for code, a_side in (("0012", 13), ("0012", 31), ("64A010", 81), ("0006", 31)):
        s = sides(code, a_side, base)
        clean = contour(written(tmp_path, text(loop(s))))
        found = contour(written(tmp_path, text(FORMS[form](s))))
        assert abs(circle_map(found).lift_coefficient(0.0)) < 1e-6, (code, a_side)
        assert distance(found, clean) < 2e-4 if a_side > 20 else 4e-4, (code, a_side)


@pytest.mark.parametrize("code", ["2412", "6409", "63A415"])
@pytest.mark.parametrize("form", FORMS)
def test_a_cambered_section_has_its_lift_from_every_form(tmp_path: Path, form: str, code: str) -> None:
    """Against the exact lift of the section by its formula: base and rounding of the file included, within 0.3 percent."""
    exact = circle_map(contour(code)).lift_coefficient(0.03)
    found = contour(written(tmp_path, text(FORMS[form](sides(code, 61, 0.0025)))))
    assert circle_map(found).lift_coefficient(0.03) == pytest.approx(exact, rel=3e-3)


@pytest.mark.parametrize("form", ["closed", "pinched to a point", "first point lost"])
def test_the_flow_about_a_symmetric_section_has_no_lift(tmp_path: Path, form: str) -> None:
    """Steady Euler flow on a small mesh at Mach 0.5 and no incidence: C_L within 1e-6 of 0, as from the clean file."""
    path = written(tmp_path, text(FORMS[form](sides("0012", 31, 0.0025))))
    flow = Flow(o_mesh(path, 96, 24, 25.0), 0.5, 0.25, Settings(steady_tolerance=1e-7, steady_iterations=5000))
    flow.solve_steady(0.0)
    assert abs(flow.coefficients.lift) < 1e-6


def test_a_sharp_edge_stays_sharp_in_every_form(tmp_path: Path) -> None:
    """Without a base nothing is carried on or closed: the forms give the points of the file."""
    s = sides("2412", 61, 0.0)
    for form in ("open", "pinched, point not repeated", "other sense", "from the nose", "tail to nose twice"):
        found = section(written(tmp_path, text(FORMS[form](s), 8)))
        assert "sharp trailing edge" in found.summary, form
        assert distance(found.contour, loop(s)) < 1e-7


def tab(thickness: float, ahead: float) -> np.ndarray:
    """NACA 0012 with a tail of the given thickness behind x/c 0.9, `ahead` times as thick at x/c 0.95."""
    upper, _ = sides("0012", 61, 0.0)
    x, y = upper.T
    tail = 0.5 * thickness * (1 - (1 - ahead) * np.sin(np.pi * np.clip((x - 0.9) / 0.1, 0, 1)))
    y = np.maximum(y, tail)
    return np.vstack([np.column_stack([x, y]), np.column_stack([x, -y])[::-1][1:]])


@pytest.mark.parametrize(("thickness", "ahead"), [(0.006, 0.93), (0.005, 0.8), (0.003, 1.0), (0.0045, 0.95)])
def test_a_wedge_that_would_cross_or_choke_a_thin_tail_is_kept_short(tmp_path: Path, thickness: float, ahead: float) -> None:
    points = tab(thickness, ahead)
    found = section(written(tmp_path, text(points, 12)))
    assert "closed over the last 5%" in found.summary
    fore = found.contour[:, 0] < 0.949
    assert distance(found.contour[fore], points) < 1e-9
    assert abs(circle_map(found.contour).lift_coefficient(0.0)) < 1e-6
    o_mesh(str(tmp_path / "form.dat"), 168, 48, 25.0)


CLEAN = text(loop(sides("2412", 41, 0.0025)))
ROWS = CLEAN.splitlines()


def every(change: Callable[[str, str], str]) -> str:
    return "\n".join(change(*row.split()) for row in ROWS) + "\n"


READ = {
    "a title": "NACA 2412\n" + CLEAN,
    "a title that is a number": "2412\n" + CLEAN,
    "a title and the number of points": f"NACA 2412\n{len(ROWS)}\n{CLEAN}",
    "two titles": "NACA 2412\nfrom the formula, 12.5 % thick\n" + CLEAN,
    "UTF-8 with a mark, no title": CLEAN.encode("utf-8-sig"),
    "UTF-16 with a mark": ("title\n" + CLEAN).encode("utf-16"),
    "UTF-16 without a mark": CLEAN.encode("utf-16-le"),
    "8-bit text": "Flügel\n".encode("latin-1") + CLEAN.encode(),
    "old Mac": CLEAN.replace("\n", "\r").encode(),
    "DOS with an end mark": (CLEAN.replace("\n", "\r\n") + "\x1a").encode(),
    "Fortran": every(lambda x, y: f"{float(x):.6E} {float(y):.6E}".replace("E", "D")),
    "commas": every(lambda x, y: f"{x},{y}"),
    "semicolons": every(lambda x, y: f"{x}; {y};"),
    "decimal commas": every(lambda x, y: f"{x}\t{y}".replace(".", ",")),
    "decimal commas, semicolons": every(lambda x, y: f"{x};{y}".replace(".", ",")),
    "a comment behind the first numbers": ROWS[0] + "  # upper corner\n" + "\n".join(ROWS[1:]),
    "words behind the first numbers": ROWS[0] + "  upper corner\n" + "\n".join(ROWS[1:]),
    "text after the last point": CLEAN + "\nsource: report 460\n12 points left out\n",
    "four numbers of an ISES file": "NACA 2412\n -2.0 3.0 -2.5 3.5\n" + CLEAN,
    "a constant third column": every(lambda x, y: f"{x} {y} 0.0"),
    "percent": every(lambda x, y: f"{100 * float(x):.4f} {100 * float(y):.4f}"),
    "mm, begun elsewhere": every(lambda x, y: f"{250 * float(x) + 35:.4f} {250 * float(y):.4f}"),
    "brackets": every(lambda x, y: f"({x}, {y}),"),
    "minus signs as printed": CLEAN.replace("-", "−"),
    "an end mark of MSES": CLEAN + "999.0 999.0\n",
}


@pytest.mark.parametrize("kind", READ)
def test_what_is_read(tmp_path: Path, kind: str) -> None:
    """The same contour as from the bare file, point for point."""
    clean = contour(written(tmp_path, CLEAN))
    found = section(written(tmp_path, READ[kind]))
    assert found.contour.shape == clean.shape
    np.testing.assert_allclose(found.contour, clean, atol=1e-6)
    assert f"{len(ROWS)} points" in found.summary


def lednicer(counts: str) -> str:
    s = sides("2412", 41, 0.0025)
    return f"title\n{counts}\n\n{text(s[0][::-1])}\n{text(s[1])}"


REFUSED = {
    "a first point spoilt": ("1.0O0000 0.001250\n" + CLEAN, ["line 1", "'1.0O0000 0.001250'"]),
    "numbers without a blank": ("1.000000-0.001250\n" + CLEAN, ["line 1", "not two numbers"]),
    "not a number": ("nan 0.1\n" + CLEAN, ["line 1", "'nan 0.1'"]),
    "a point spoilt at the end": (CLEAN + "1.000000 -0.0O1\n", [f"line {len(ROWS) + 1}", "not two numbers"]),
    "a lonely number": ("title\n7\n" + CLEAN, ["line 2", "a single number, 7", f"{len(ROWS)} points"]),
    "a title of two numbers": ("2412 100\n" + CLEAN, ["line 1", "'2412 100' is no point"]),
    "two elements": (CLEAN + "999.0 999.0\n" + CLEAN, [f"line {len(ROWS) + 1}", "second element", "one element a file"]),
    "two sections": ("first\n" + CLEAN + "second\n" + CLEAN, [f"line {len(ROWS) + 3}", "points again", "second"]),
    "three columns": (every(lambda x, y: f"{x} {y} {y}"), ["line 1", "3 numbers a line"]),
    "a column missing": (CLEAN + "0.5 0.1 0.2\n", [f"line {len(ROWS) + 1}"]),
    "counts that do not match": (lednicer("41 40"), ["line 2", "counts 41 + 40 do not match its 82 points"]),
    "counts that part it wrongly": (lednicer("40 42"), ["counts"]),
    "no text": (bytes(range(256)), ["no text"]),
    "y in percent": (every(lambda x, y: f"{x} {100 * float(y):.4f}"), ["no section along x"]),
    "x in percent": (every(lambda x, y: f"{100 * float(x):.4f} {y}"), ["thickness of 0.12%"]),
    "nose behind": (every(lambda x, y: f"{1 - float(x):.6f} {y}"), ["nose seems to be behind"]),
    "along y": (every(lambda x, y: f"{y} {x}"), ["no section along x"]),
    "turned by 15 degrees": (every(lambda x, y: f"{float(x):.6f} {float(y) - 0.27 * float(x):.6f}"), ["chord line 15"]),
    "the tail missing": ("\n".join(ROWS[8:-8]), ["open by"]),
    "one side short": ("\n".join(ROWS[8:]), ["not at the trailing edge"]),
    "one side a little short": ("\n".join(ROWS[5:]), ["given once and lies off the upper side"]),
    "a thick base": (text(loop(sides("2412", 41, 0.03))), ["open by 0.03"]),
    "upside down at the end": (text(loop(sides("2412", 41, -0.004))), ["crosses itself"]),
    "a step at the tail": ("1.0 0.012\n" + CLEAN, ["a step of 0.01"]),
    "points out of order": ("\n".join(ROWS[:20] + ROWS[30:19:-1] + ROWS[31:]), ["crosses itself", "line"]),
    "upper and lower side by turns": (text(np.stack(sides("0012", 41, 0.0), axis=1).reshape(-1, 2)), ["Remedy"]),
}  # fmt: skip


@pytest.mark.parametrize("kind", REFUSED)
def test_what_is_refused_and_why(tmp_path: Path, kind: str) -> None:
    content, words = REFUSED[kind]
    with pytest.raises(AirfoilError) as caught:
        contour(written(tmp_path, content))
    for word in ["form.dat", "Remedy", *words]:
        assert word in str(caught.value), str(caught.value)


def test_a_base_that_cannot_be_told_is_refused(tmp_path: Path) -> None:
    """Twelve even spaces a side: a corner lost, or a sharp edge given once, look the same."""
    x = np.linspace(0, 1, 13) ** 1.2
    y = np.interp(x, *contour("0012")[399::-1].T) + 0.00126 * x
    points = np.vstack([np.column_stack([x, y])[::-1], np.column_stack([x, -y])[1:-1]])
    with pytest.raises(AirfoilError, match="given once and lies off the upper side"):
        contour(written(tmp_path, text(points)))


def test_a_section_away_from_the_axis_is_moved_with_it(tmp_path: Path) -> None:
    clean = contour(written(tmp_path, CLEAN))
    found = section(written(tmp_path, every(lambda x, y: f"{x} {float(y) + 0.5:.6f}")))
    np.testing.assert_allclose(found.contour, clean, atol=1e-12)
    assert "moved by -0.5000 chords in y together with its axis" in found.summary


def test_the_summary_says_what_the_section_is(tmp_path: Path) -> None:
    said = section(written(tmp_path, CLEAN)).summary
    for word in ("form.dat: 81 points", "base 0.25% closed by a wedge over the chord", "camber +2.0", "leading-edge radius 1.4"):
        assert word in said, said
    assert "thickness 12.00% at x/c 0.30" in section("NACA 0012").summary


def test_twenty_thousand_points_need_little_memory(tmp_path: Path) -> None:
    points = FORMS["pinched to a point"](sides("2412", 10_000, 0.0025))
    path = written(tmp_path, text(points))
    tracemalloc.start()
    found = section(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 200e6
    assert f"{len(points)} points (" in found.summary
    exact = circle_map(contour("2412"))
    assert circle_map(found.contour).lift_coefficient(0.03) == pytest.approx(exact.lift_coefficient(0.03), rel=3e-3)
