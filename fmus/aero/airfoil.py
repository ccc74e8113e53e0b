"""The section of a flow: a NACA name or a coordinate file becomes a closed contour, with what was done to it in words.

A contour is an array of shape (n, 2) in chords, in Selig order: trailing edge, upper side, leading edge, lower side, trailing
edge. Its first and last points are the same sharp trailing edge; the leading edge is at x = 0, the trailing edge at x = 1.
"""

from __future__ import annotations

import csv
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from . import airfoil_text
from .airfoil_order import apart, check_gaps, far_enough, loop
from .airfoil_shape import Shape, crossing, shape
from .airfoil_tail import closed, sides
from .airfoil_text import refuse
from .naca import AirfoilError, naca4, naca5, naca6a

Array = NDArray[np.float64]

_DENSE = 1000
"""More points than these are thinned out to what the mapping can use."""
_AWAY = 0.005
"""A section whose nose and trailing edge are both farther than this [chords] from y = 0, on one side, is moved there."""


@dataclass(frozen=True)
class Section:
    """name: as given; contour: shape (n, 2), chords; read: the file's points in the same axes, (m, 2), empty for a NACA name;
    summary: what it is and what was done to the file, one line."""

    name: str
    contour: Array
    read: Array
    summary: str


def contour(airfoil: str) -> Array:
    """Contour of a NACA name ("NACA 0012", "64A010") or of a coordinate file, shape (n, 2), chords.

    Raises AirfoilError for an unknown name, a missing or malformed file, a self-intersecting or too coarse contour.
    """
    return section(airfoil).contour


def section(airfoil: str) -> Section:
    """The section of a NACA name or of a coordinate file. Raises AirfoilError as `contour` does."""
    name = airfoil.strip()
    code = re.sub(r"^NACA[\s_-]*", "", name, flags=re.IGNORECASE).upper()
    if re.fullmatch(r"[0-9]{4}", code):
        return _named(f"NACA {code}", naca4(code))
    if re.fullmatch(r"[0-9]{5}", code):
        return _named(f"NACA {code}", naca5(code))
    if re.fullmatch(r"6[345]A[0-9]{3}", code):
        return _named(f"NACA {code}", naca6a(code))
    path = Path(name)
    try:
        found = bool(name) and path.is_file()
    except (OSError, ValueError):  # a name too long, or with a byte 0
        found = False
    if found:
        return from_file(path)
    raise AirfoilError(
        f"airfoil '{airfoil}': neither a NACA 4- or 5-digit name (0012, 23012), a NACA 6A name (64A010, 63A415) nor a readable "
        "coordinate file. Remedy: give one of these, a file by its full path"
    )


def from_file(path: Path) -> Section:
    """Section of a coordinate file (what is read: module `airfoil_text`; how it is closed: `airfoil_tail`).

    Raises AirfoilError naming file, line where there is one, what was seen and the remedy.
    """
    rows = airfoil_text.read(path)
    chain = loop(rows, path)
    chain = apart(chain)
    _check_crossing(chain.points, chain.lines, path, "the contour crosses itself")
    check_gaps(chain, path)
    found = sides(chain, path)
    points, over = closed(found, path)
    points = _thinned(points)
    _check_crossing(points, None, path, f"the contour crosses itself once its base of {found.base:.2%} is closed")
    nose, tail = points[np.argmin(points[:, 0])], points[0]
    aside = float(tail[1]) if nose[1] * tail[1] > 0 and min(abs(nose[1]), abs(tail[1])) > _AWAY else 0.0
    points = points - np.array([0.0, aside])
    measured = shape(points)
    _check_shape(measured, path)
    few = len(points) - 1 < 0.8 * len(chain.points) or len(chain.points) < 0.5 * chain.count
    said = [f"{chain.count} points" + (f" ({len(points) - 1} used, the others too close to them)" if few else "")]
    if found.base > 0:
        how = [f"base {found.base:.2%}", found.said] if found.said else [f"base {found.base:.2%}"]
        said.append(f"{', '.join(how)}{',' if found.said else ''} closed {over}")
    else:
        said.append("sharp trailing edge")
    said += chain.notes
    if abs(chain.chord - 1) > 1e-9 or abs(chain.start) > 1e-9:
        said.append(f"scaled from x {chain.start:g} to {chain.start + chain.chord:g}")
    if aside:
        said.append(f"moved by {-aside:+.4f} chords in y together with its axis")
    seen = np.column_stack([(rows.points[:, 0] - chain.start) / chain.chord, rows.points[:, 1] / chain.chord - aside])
    return Section(str(path), points, seen, f"{path.name}: {', '.join(said)}; {_measures(measured)}")


def write_csv(path: Path, found: Section, surface: Array) -> None:
    """File points and mesh surface, shape (n, 2), chords, as a table: what, x, y. For pictures.

    Raises AirfoilError where the file cannot be written.
    """
    parts = (("file", found.read), ("contour", found.contour), ("mesh", surface))
    try:
        with path.open("w", encoding="utf-8", newline="") as file:
            table = csv.writer(file)
            table.writerow(("what", "x", "y"))
            table.writerows((what, repr(float(x)), repr(float(y))) for what, points in parts for x, y in points)
    except OSError as error:
        raise AirfoilError(f"section_file '{path}' cannot be written ({error.strerror}). Remedy: a folder that exists") from None


def _named(name: str, points: Array) -> Section:
    return Section(name, points, np.empty((0, 2)), f"{name} by its formula, sharp trailing edge; {_measures(shape(points))}")


def _measures(s: Shape) -> str:
    """Thickness, camber, nose radius and chord line in words."""
    bow = f"camber {s.camber:+.2%} at x/c {s.camber_at:.2f}" if abs(s.camber) > 5e-5 else "no camber"
    tilt = f", chord line at {np.degrees(s.chord_line):+.2f} deg to the x axis" if abs(s.chord_line) > np.radians(0.05) else ""
    return f"thickness {s.thickness:.2%} at x/c {s.thickness_at:.2f}, {bow}, leading-edge radius {s.nose_radius:.2%}{tilt}"


def _thinned(points: Array) -> Array:
    """The contour of a dense file without the points that the mapping does not need: of more than 1,000 those stay that are
    farther apart than 400 cosine stations a side. Closer ones carry the file's rounding as a wavy surface."""
    nose, n = int(np.argmin(points[:, 0])), len(points)
    if n <= _DENSE:
        return points
    x = np.clip(points[:, 0], 0.0, 1.0)
    least = np.pi / 400 * np.sqrt(x * (1 - x)) + 1e-4
    keep = far_enough(points, nose, least)
    return points[keep]


def _check_crossing(points: Array, lines: NDArray[np.int64] | None, path: Path, what: str) -> None:
    met = crossing(points)
    if met is None:
        return
    first, second = (f"x/c {points[k, 0]:.4f}" + ("" if lines is None else f" (line {lines[k]})") for k in met)
    refuse(path, f"{what}, between {first} and {second}", "check order and duplicates of the points")


def _check_shape(s: Shape, path: Path) -> None:
    """Refuse what is no section: sides that meet, a thickness or an inclination out of all proportion."""
    if s.least <= 0:
        refuse(path, f"no thickness at x/c {s.least_at:.3f}", "upper side above the lower one all along")
    if not 0.008 < s.thickness < 0.6:
        refuse(path, f"a thickness of {s.thickness:.2%}", "x and y in the same unit, between 0.8 and 60 percent thick")
    if abs(s.chord_line) > np.radians(10):
        refuse(path, f"a chord line {np.degrees(s.chord_line):.1f} degrees off the x axis",
               "coordinates along the chord, the incidence as mean_alpha")  # fmt: skip
