"""Airfoil contours against published ordinates; coordinate files, good and bad."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from aeroslosh.fmus.aero.airfoil import AirfoilError, contour


def upper(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Upper side from nose to tail."""
    nose = int(np.argmin(points[:, 0]))
    return points[nose::-1, 0], points[nose::-1, 1]


def write(path: Path, points: np.ndarray, head: str = "a section\n") -> str:
    path.write_text(head + "\n".join(f"{x:.8f} {y:.8f}" for x, y in points) + "\n")
    return str(path)


# NACA Report 903 (Loftin 1948), ordinates of the NACA 64A010 in percent chord
REPORT_903 = [
    (2.5, 1.688), (5, 2.327), (10, 3.199), (20, 4.272), (30, 4.837), (40, 4.995), (50, 4.684), (60, 4.021),
    (70, 3.127), (80, 2.103),
]  # fmt: skip


@pytest.mark.parametrize(("station", "ordinate"), REPORT_903)
def test_64a010_has_the_published_ordinates(station: float, ordinate: float) -> None:
    x, y = upper(contour("NACA 64A010"))
    assert np.interp(station / 100, x, y) == pytest.approx(ordinate / 100, abs=1.2e-4)


@pytest.mark.parametrize("name", ["63A008", "64a006", "NACA 65A012"])
def test_6a_thickness_is_the_one_named(name: str) -> None:
    _, y = upper(contour(name))
    assert 2 * y.max() == pytest.approx(int(name[-2:]) / 100, rel=1e-4)


def test_4_digit_section_is_the_formula() -> None:
    x, y = upper(contour("0012"))
    exact = 0.6 * (0.2969 * np.sqrt(0.3) - 0.1260 * 0.3 - 0.3516 * 0.3**2 + 0.2843 * 0.3**3 - 0.1036 * 0.3**4)
    assert np.interp(0.3, x, y) == pytest.approx(exact, abs=2e-6)


# Abbott and von Doenhoff, Theory of Wing Sections (1959), app. III: ordinates of the NACA 23012 in percent chord
TABLE_23012 = [
    (5, 4.91, -2.26), (10, 6.43, -2.92), (15, 7.19, -3.50), (20, 7.50, -3.97), (30, 7.55, -4.46), (40, 7.14, -4.48),
    (50, 6.41, -4.17), (60, 5.47, -3.67), (70, 4.36, -3.00), (80, 3.08, -2.16),
]  # fmt: skip


@pytest.mark.parametrize(("station", "above", "below"), TABLE_23012)
def test_23012_has_the_published_ordinates(station: float, above: float, below: float) -> None:
    points = contour("NACA 23012")
    nose = int(np.argmin(points[:, 0]))
    assert np.interp(station / 100, points[nose::-1, 0], points[nose::-1, 1]) == pytest.approx(above / 100, abs=6e-4)
    assert np.interp(station / 100, points[nose:, 0], points[nose:, 1]) == pytest.approx(below / 100, abs=6e-4)


@pytest.mark.parametrize(("code", "moment"), [("23001", None), ("43001", None), ("23101", 0.0), ("24101", 0.0), ("22101", 0.0)])
def test_5_digit_mean_line_has_its_design_lift_and_moment(code: str, moment: float | None) -> None:
    """Thin-airfoil theory at the ideal angle: C_l = pi A_1 is 0.15 times the first digit; a reflexed line has no moment."""
    points = contour(code)
    nose = int(np.argmin(points[:, 0]))
    theta = (np.arange(20000) + 0.5) * np.pi / 20000
    x = 0.5 * (1 - np.cos(theta))
    upper_y, lower_y = np.interp(x, *points[nose::-1].T), np.interp(x, *points[nose:].T)
    slope = np.gradient(0.5 * (upper_y + lower_y), x)
    a1, a2 = (2 * np.mean(slope * np.cos(n * theta)) for n in (1, 2))
    assert np.pi * a1 == pytest.approx(0.15 * int(code[0]), rel=0.04)
    if moment is not None:
        assert np.pi / 4 * (a2 - a1) == pytest.approx(moment, abs=0.004)


def test_camber_of_2412_and_of_the_6a_mean_line() -> None:
    points = contour("2412")
    x, y = upper(points)
    lower = points[int(np.argmin(points[:, 0])) :]
    middle = 0.5 * (np.interp(0.4, x, y) + np.interp(0.4, lower[:, 0], lower[:, 1]))
    assert middle == pytest.approx(0.02, abs=1e-4)
    # a = 0.8 (modified) for C_l = 1 has its highest point at 6.65 percent (NASA TM 4741, fig. 2)
    points = contour("64A406")
    x, y = upper(points)
    lower = points[int(np.argmin(points[:, 0])) :]
    middle = 0.5 * (y + np.interp(x, lower[:, 0], lower[:, 1]))
    assert middle.max() == pytest.approx(0.4 * 0.0665, rel=0.01)


def test_selig_and_lednicer_files_give_the_same_section(tmp_path: Path) -> None:
    points = contour("64A010")[::8]
    points = np.vstack([points, contour("64A010")[-1]]) if points[-1, 0] != 1.0 else points
    nose = int(np.argmin(points[:, 0]))
    selig = contour(write(tmp_path / "selig.dat", points))
    top, bottom = points[nose::-1], points[nose:]
    lednicer = tmp_path / "lednicer.dat"
    rows = np.vstack([top, bottom])
    write(lednicer, rows, head=f"title\n{len(top)}. {len(bottom)}.\n\n")
    np.testing.assert_allclose(contour(str(lednicer)), selig, atol=1e-8)


def test_blunt_trailing_edge_and_size_are_normalised(tmp_path: Path) -> None:
    points = contour("0012").copy()
    nose = int(np.argmin(points[:, 0]))
    points[:nose, 1] += 0.001 * points[:nose, 0]
    points[nose:, 1] -= 0.001 * points[nose:, 0]
    closed = contour(write(tmp_path / "blunt.dat", 3.0 * points + np.array([5.0, 0.0])))
    np.testing.assert_allclose(closed, contour("0012"), atol=1e-7)


def crossed(points: np.ndarray) -> np.ndarray:
    points = points.copy()
    points[20:40] = points[20:40][::-1]
    return points


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (crossed, "crosses itself"),
        (lambda p: p[:10], "10 points"),
        (lambda p: p[len(p) // 4 :], "not at the trailing edge"),
        (lambda p: p + np.column_stack([0 * p[:, 0], (np.arange(len(p)) < len(p) // 2) * 0.1 * p[:, 0]]), "open by"),
    ],
    ids=["self-intersecting", "too few", "no trailing edge", "open"],
)  # fmt: skip
def test_bad_files_are_refused_with_file_and_remedy(tmp_path: Path, change: object, words: str) -> None:
    name = write(tmp_path / "bad.dat", change(contour("0012")[::5]))  # type: ignore[operator]
    with pytest.raises(AirfoilError) as caught:
        contour(name)
    assert words in str(caught.value)
    assert "bad.dat" in str(caught.value)
    assert "Remedy" in str(caught.value)


def test_a_word_among_the_numbers_is_named_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "word.dat").write_text("name\n1.0 0.0\n0.9 oops\n")
    with pytest.raises(AirfoilError, match=r"line 3: '0.9 oops'"):
        contour(str(tmp_path / "word.dat"))


@pytest.mark.parametrize("name", ["66A010", "NACA 0000", "20012", "03012", "21112", "64A030", "2012x", "/nowhere/file.dat"])
def test_unknown_names_are_refused(name: str) -> None:
    with pytest.raises(AirfoilError, match="Remedy"):
        contour(name)
